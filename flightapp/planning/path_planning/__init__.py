"""Ways past known obstacles in three dimensions: path planners as peers behind one interface, and what makes of a path a flight.

Positions are local NED in m. Nothing here reads a clock: budgets are iterations, and a caller's own stop condition.
"""
