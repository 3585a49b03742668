"""What a depth camera would see of a known scene: for tests, measurements and simulation."""
