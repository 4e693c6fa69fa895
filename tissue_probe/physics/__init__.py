"""Physical laws in symbols, and the compiled code made from the symbols.

Contents: the equations of instrument and tissue, their discretisation, the generation of code from
them.
"""
