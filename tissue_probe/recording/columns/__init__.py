"""Columns of numbers out of the files of any program.

What belongs here: one module a container, and finding the table in a text or a sheet.
What does not: what the columns mean (``table_file``), their units (``units``).
"""
