"""The two files a person writes: the profile (hardware) and the mission."""
