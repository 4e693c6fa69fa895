"""The report of an improvement: one HTML page that a colleague can read without us, off line.

What belongs here: what the page says (``contents``) and how it is set (``page``, the template).
What does not: finding it out (``diagnosis``), pictures for print (``figures``).
"""
