"""A composed model fitted to measurements by output error, with what is known of the rig.

What belongs here: the least-squares problem, the search, and what its end tells. What does not:
which effect is added (``ranking``), the equations (``physics``).
"""
