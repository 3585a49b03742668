"""Planning: strategies and evader policies as pure, seeded functions of observations; `registry` makes them by name."""
