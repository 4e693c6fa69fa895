"""``python -m benchmarks laws``: how often each newer law is named, false alarms, and the time.

The library before is part of the benchmark: what is newer is measured beside it in the same run.
"""
