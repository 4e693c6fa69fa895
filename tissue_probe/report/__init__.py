"""The report of an improvement: one HTML page that a colleague can read without us, off line.

Contents: what the page says (``contents``) and how it is set (``page``, the template).
"""
