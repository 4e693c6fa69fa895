"""What a model leaves: the noise below it, tests of the rest, and where in a record it stands out.

Contents: measured minus predicted output as mere signals.
"""
