"""The workflow from measurements to an answer: what scripts, notebooks and the command line call.

Contents: one module for each question (read, compare, diagnose, improve, estimate, map, simulate),
results that show themselves, and the sentences in which they speak.
"""
