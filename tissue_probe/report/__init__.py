"""The report of an improvement: one HTML page that a colleague can read without us, off line.

Contents: the data of the page (``contents``) and how it is set (``page``, the template).
"""
