"""A robot's arm in MuJoCo: how well its force sensor, and what it touches, are identified."""
