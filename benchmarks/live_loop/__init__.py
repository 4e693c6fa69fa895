"""A robot's arm that does what is told of, in MuJoCo, and how well it is told: `live_loop`."""
