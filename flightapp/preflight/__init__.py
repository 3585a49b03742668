"""Before arming: everything that must be true, each with reason and remedy. Facts are gathered once, checks only judge them."""
