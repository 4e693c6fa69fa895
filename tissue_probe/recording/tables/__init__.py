"""The meaning of a table's columns: signals, sites, corners, pairs of points."""
