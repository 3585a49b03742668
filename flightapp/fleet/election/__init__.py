"""Who speaks for the fleet where one voice is needed: a leader for a term, elected by a majority of the configured roster.

`core` decides and is free of I/O; `beacon` is what members tell each other; `timing` the durations and the rule between them;
`memory` what must survive a restart; `model` explores what the core can do.
"""
