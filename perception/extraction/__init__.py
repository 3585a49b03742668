"""One depth frame -> the obstacles in it, and where it shows that there are none."""
