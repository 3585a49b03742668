"""What happens when something fails: one table, and the state machine that obeys it."""
