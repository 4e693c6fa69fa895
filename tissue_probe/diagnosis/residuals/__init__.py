"""What a model leaves: the noise below it, tests of the rest, and where in a record it stands out.

What belongs here: measured minus predicted output as mere signals. What does not: models that are
fitted (``fitting``), and which effect would explain the rest (``ranking``).
"""
