"""From the discs of single frames to discs with velocity, age and confidence."""
