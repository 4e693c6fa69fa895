"""Studies: how fast many recordings are answered, and whether their statistics hold.

Contents: recordings of a simulator that shares nothing with the package, runs, sealed studies.
"""
