"""Functions in LLVM's language from Numba's Python.

Contents: from a module's compiled functions to LLVM's text.

Numba takes most of a second to be imported and to find its own compiled functions again, half of it
for linear algebra that no kernel uses. Machine code of its text needs no Numba, and is faster, too:
Numba optimises each function as one that anybody may call, and counts references to arrays.
"""

from __future__ import annotations

from types import ModuleType

import llvmlite.binding as llvm

from tissue_probe.physics.machine_code import Text


def text(module: ModuleType, facts: tuple[str, ...] = ()) -> Text:
    """Return the text of all that a module makes by ``cfunc``.

    Parameters
    ----------
    module : module
        May name in ``LINKED`` the functions that it calls and has not.
    facts : tuple of str
        Names of constants of the module that are kept with the code.
    """
    from numba.core.ccallback import CFunc  # only where something has to be compiled

    entries = {name: entry for name, entry in vars(module).items() if isinstance(entry, CFunc)}
    texts = []
    for name, entry in entries.items():
        one = llvm.parse_assembly(entry.inspect_llvm())
        one.get_function(entry.native_name).name = name
        texts.append(one)
    told = {fact: getattr(module, fact) for fact in facts}
    return Text(str(_joined(texts)), list(entries), told, getattr(module, "LINKED", ()))


def _joined(modules: list[llvm.ModuleRef]) -> llvm.ModuleRef:
    first, *others = modules
    for other in others:
        first.link_in(other)
    return first
