"""One table over everything: all planners in all scenarios on the same seeds, flown bit by bit and resumed where it was cut."""
