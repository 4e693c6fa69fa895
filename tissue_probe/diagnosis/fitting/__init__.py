"""A composed model fitted to measurements by output error, with the tolerances of the rig.

Contents: the least-squares problem, the search, and the fit at its end.
"""
