"""What the world does, in symbols, and the compiled code made from the symbols.

What belongs here: the equations of instrument and tissue, their discretisation, the generation of
code from them. What does not: estimating anything from measurements (``estimation``).
"""
