"""The instrument and the numerics: records that show whether these are told as tissue.

Contents: kinds of records whose truth is known, made by SciPy and closed forms alone, asking the
diagnosis through its public interface, marks, tables.
"""
