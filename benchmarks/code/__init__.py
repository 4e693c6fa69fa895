"""How large and how tangled the code of the diagnosis is: numbers that may fall as it is rebuilt.

Contents: counts that need the source only.
"""
