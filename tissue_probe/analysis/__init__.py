"""The workflow from measurements to an answer: scripts, notebooks and commands call it.

Contents: one module for each question (read, compare, diagnose, improve, estimate, map, simulate),
results that show themselves, and the sentences in which they speak.
"""
