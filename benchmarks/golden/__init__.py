"""A fixed set of records, and what the diagnosis says of each: so a change shows what it changes.

Contents: the records, asking, comparing with an earlier result, tables.
"""
