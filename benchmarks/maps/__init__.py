"""How right the map is: phantoms that share nothing with it, and what it says of them.

Contents: tissues, palpated in numbers; marks.
"""
