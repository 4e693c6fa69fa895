"""Studies: many recordings, one row each, in one table."""
