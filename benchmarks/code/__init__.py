"""How large and how tangled the code of the diagnosis is: numbers that may fall as it is rebuilt.

What belongs here: counts that need the source only. What does not: what the code does (``golden``).
"""
