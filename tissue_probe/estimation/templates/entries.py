# ruff: noqa: F821
"""How a kernel is called from outside: by a list of its arrays' addresses.

Never imported: this text becomes part of each kernel module. The addresses are those of
``constants``, ``memory``, ``position``, ``force`` and ``estimates``; the last three are long enough
for ``length`` samples, and only ``run_on`` uses them.
"""


@cfunc("void(CPointer(CPointer(float64)))", error_model="numpy")
def start_on(arrays):
    """Forget everything."""
    start(carray(arrays[0], CONSTANTS), carray(arrays[1], MEMORY))


@cfunc("void(CPointer(CPointer(float64)))", error_model="numpy")
def reopen_on(arrays):
    """Keep the estimates of the tissue."""
    memory = carray(arrays[1], MEMORY)
    reopen(carray(arrays[0], CONSTANTS), memory)
    interrupt(memory)


@cfunc("int64(CPointer(CPointer(float64)), int64, int64, int64)", error_model="numpy")
def run_on(arrays, length, begin, end):
    """Filter samples ``begin`` to ``end``, as far as there are any; return how many missed."""
    return run(
        carray(arrays[0], CONSTANTS),
        carray(arrays[1], MEMORY),
        carray(arrays[2], length),
        carray(arrays[3], length),
        carray(arrays[4], (11, length)),
        max(begin, 0),
        min(end, length),
    )
