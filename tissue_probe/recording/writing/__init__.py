"""Writing recordings, and tables of samples and estimates."""
