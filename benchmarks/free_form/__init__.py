"""``python -m benchmarks free_form``: shapes of forces that no law explains, against the truth."""
