"""The workflow from measurements to an answer: what scripts, notebooks and the command line call.

What belongs here: one module for each question (read, compare, diagnose, improve, estimate, map,
simulate), results that show themselves, and the sentences in which they speak.
What does not: parsing of options and printing (``cli``), fits and verdicts (``diagnosis``), drawing
(``figures``), pages (``report``).
"""
