"""A composed model fitted to measurements by output error, with what is known of the rig.

Contents: the least-squares problem, the search, and what its end tells.
"""
