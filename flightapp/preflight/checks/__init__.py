"""One check a file: a pure function of the facts. A new one is one file and one line in `checklist`."""
