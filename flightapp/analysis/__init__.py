"""From the recordings of a run to numbers, a report and a picture."""
