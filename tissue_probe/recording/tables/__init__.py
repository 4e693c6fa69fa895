"""What the columns of a table mean: signals, sites, corners, pairs of points."""
