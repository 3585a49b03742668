"""Planar geometry that strategies share: convex cells, half-planes, polygons, hulls. Points are (north, east) in m."""
