"""A fixed set of records, and what the diagnosis says of each: so a change shows what it changes.

What belongs here: the records, asking, comparing with an earlier result, tables. What does not:
how often the diagnosis is right of all records of a kind (``ruler``, ``diagnosis``): those sets are
larger, and drawn.
"""
