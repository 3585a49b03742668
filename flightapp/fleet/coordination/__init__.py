"""Who closes in from where and when, decided by the leader, and when all agree that the evader is captured. Free of I/O."""
