"""``python -m benchmarks beside``: public data with published errors, and other tools beside ours.

The data are not part of this project: ``--data`` names the folder that they are in.
"""
