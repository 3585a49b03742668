"""Value types, frames, geodesy and the clock: what every other room may import."""
