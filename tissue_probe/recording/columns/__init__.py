"""Columns of numbers out of the files of any program.

Contents: one module a container, and finding the table in a text or a sheet.
"""
