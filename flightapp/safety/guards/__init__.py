"""The guards, one file a rule."""
