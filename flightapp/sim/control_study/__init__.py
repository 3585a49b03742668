"""`flightapp campaign control`: the controllers of the source and ours, the same flights in the same wind, side by side."""
