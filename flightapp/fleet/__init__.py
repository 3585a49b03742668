"""The fleet over Zenoh: shared state and operator commands."""
