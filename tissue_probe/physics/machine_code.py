"""Machine code of generated functions, kept on disk and called without Numba.

What belongs here: from a module's compiled functions to an object file, and back to functions.
What does not: what is in the functions (``program``), where files lie (``compiled``).

Numba takes most of a second to be imported and to find its own compiled functions again, half of it
for linear algebra that no kernel uses. Who finds an object file here needs LLVM and ctypes only.
The code is faster, too: Numba optimises each function as one that anybody may call, and counts
references to arrays; here only the entries remain visible, and the rest is optimised into them.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import llvmlite
import llvmlite.binding as llvm

from tissue_probe.physics import compiled


@dataclass(frozen=True)
class MachineCode:
    """Functions in this process.

    Attributes
    ----------
    addresses : mapping of int
        Where each entry begins: a C function of the signature that its module gives it.
    facts : mapping
        What the module says of itself.
    engine : object
        Keeps the functions in memory.
    """

    addresses: Mapping[str, int]
    facts: Mapping[str, Any]
    engine: llvm.ExecutionEngine


_loaded: dict[Path, MachineCode] = {}


def load(name: str, write: Callable[[], str], facts: tuple[str, ...]) -> MachineCode:
    """Return the functions of a generated module, compiled first where no earlier process has.

    Parameters
    ----------
    name, write
        Of the module, as for ``compiled.module``. Its entries are what it makes by ``cfunc``.
    facts : tuple of str
        Names of constants of the module that are kept with the code, of types that JSON knows.
    """
    path = compiled.place(f"{name}_{_host()}", ".o")
    if path not in _loaded:
        machine = _machine()
        if not path.exists():
            module = compiled.module(name, write)
            told = {fact: getattr(module, fact) for fact in facts}
            compiled.replace(path, _compile(module, machine, told))
        _loaded[path] = _link(path.read_bytes(), machine)
    return _loaded[path]


def _machine() -> llvm.TargetMachine:
    """Return this machine's processor, as LLVM sees it."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=_features(), opt=3, codemodel="jitdefault", jit=True
    )


def _features() -> str:
    return llvm.get_host_cpu_features().flatten()


@cache
def _host() -> str:
    """Eight hexadecimal digits that stand for the processor and the compiler."""
    told = f"{llvm.get_host_cpu_name()} {_features()} {llvmlite.__version__}"
    return hashlib.sha256(told.encode()).hexdigest()[:8]


def _compile(module: ModuleType, machine: llvm.TargetMachine, facts: dict[str, Any]) -> bytes:
    """Return an object file of a module's entries, after a line of JSON that says what is in it."""
    from numba.core.ccallback import CFunc  # only where something has to be compiled

    entries = {name: entry for name, entry in vars(module).items() if isinstance(entry, CFunc)}
    names = {name: entry.native_name for name, entry in entries.items()}
    code = _joined([entry.inspect_llvm() for entry in entries.values()])
    for function in code.functions:
        if not function.is_declaration and function.name not in names.values():
            function.linkage = "internal"
    options = llvm.create_pipeline_tuning_options(speed_level=3)
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(code, builder)
    _check_calls(module, code)
    head = json.dumps({"entries": names, "facts": facts})
    return head.encode() + b"\n" + machine.emit_object(code)


def _joined(texts: list[str]) -> llvm.ModuleRef:
    first, *others = (llvm.parse_assembly(text) for text in texts)
    for other in others:
        first.link_in(other)
    return first


def _check_calls(module: ModuleType, code: llvm.ModuleRef) -> None:
    """Raise RuntimeError where code calls what only a process with Numba in it has.

    That is its runtime, for arrays that are made and for exceptions. LLVM would end the process.
    """
    here = ctypes.CDLL(None)
    declared = [function.name for function in code.functions if function.is_declaration]
    unknown = [n for n in declared if not n.startswith("llvm.") and not hasattr(here, n)]
    if unknown:
        raise RuntimeError(f"{module.__name__} calls {', '.join(unknown)}")


def _link(content: bytes, machine: llvm.TargetMachine) -> MachineCode:
    head, _, code = content.partition(b"\n")
    told = json.loads(head)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    addresses = {
        entry: engine.get_function_address(name) for entry, name in told["entries"].items()
    }
    return MachineCode(addresses, told["facts"], engine)
