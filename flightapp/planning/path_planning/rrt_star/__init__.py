"""RRT* with samples pushed out of obstacles by a potential field, and plain RRT* (specification of RRT*-APF, section 2.3)."""
