"""The ruler: records whose truth is known, made by others' code, and marks of what is said of them.

What belongs here: what a record with its truth consists of, asking the diagnosis through the public
interface, marks, tables. What does not: making records (``protocols``, ``third_party``).
"""
