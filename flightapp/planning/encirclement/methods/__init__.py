"""How a pursuer chooses its goal: one small file a method, all within the same safety cell."""
