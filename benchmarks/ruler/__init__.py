"""The ruler: records whose truth is known, made by others' code, and marks of what is said of them.

Contents: what a record with its truth consists of, asking the diagnosis through the public
interface, marks, tables.
"""
