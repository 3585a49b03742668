"""The third dimension of the fast simulation: heights of vehicles and obstacles, climb and sink, contact in space."""
