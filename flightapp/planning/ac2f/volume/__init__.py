"""AC2F with height: the planar pursuit flown past obstacles that end above or below the vehicle, up and down to the evader."""
