"""How right the map is: phantoms that share nothing with it, and what it says of them.

What belongs here: tissues, palpated in numbers; marks. What does not: the map itself, of which only
``tissue_probe.map`` is known, and the project's own phantom, of which nothing is.
"""
