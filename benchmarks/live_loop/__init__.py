"""A robot's arm in MuJoCo, and how well its force sensor is identified: `live_loop`."""
