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
import gc
import hashlib
import importlib
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
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


def loaded() -> int:
    """Return how many modules' functions this process has."""
    return len(_loaded)


def load(
    name: str,
    write: Callable[[], str],
    facts: tuple[str, ...],
    sources: tuple[str, ...] = compiled.ALL,
    beside: Callable[[Mapping[str, Any]], str] = lambda _: "",
) -> MachineCode:
    """Return the functions of a generated module, compiled first where no earlier process has.

    Parameters
    ----------
    name, write, sources
        Of the module, as for ``compiled.module``. Its entries are what it makes by ``cfunc``.
    facts : tuple of str
        Names of constants of the module that are kept with the code, of types that JSON knows.
    beside : callable
        Returns, of these constants, the name of a module that calls entries by their names, and
        whose own are entries too; or nothing.
    """
    path = _object(name, lambda: compiled.module(name, write, sources), facts, sources)
    if path not in _loaded:
        machine, (told, *codes) = _machine(), _read(path)
        if other := beside(told["facts"]):
            short = other.rpartition(".")[2]
            more, code = _read(_object(short, lambda: importlib.import_module(other), (), sources))
            told["entries"] += more["entries"]
            codes.append(code)
        _loaded[path] = _link(told, codes, machine)
    return _loaded[path]


def _object(
    name: str, module: Callable[[], ModuleType], facts: tuple[str, ...], sources: tuple[str, ...]
) -> Path:
    """Return where a module's object file is, written first where no earlier process has."""
    path = compiled.place(f"{name}_{_host()}", ".o", sources)
    if not path.exists():
        with _keeping_garbage():
            made = module()
            told = {fact: getattr(made, fact) for fact in facts}
            compiled.replace(path, _compile(made, told))
    return path


@contextmanager
def _keeping_garbage() -> Iterator[None]:
    """Look for no garbage meanwhile: Numba makes objects by the million, and keeps most."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _read(path: Path) -> tuple[dict[str, Any], bytes]:
    """Return what the first line of an object file's JSON tells, and the object file."""
    head, _, code = path.read_bytes().partition(b"\n")
    return json.loads(head), code


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


def _compile(module: ModuleType, facts: dict[str, Any]) -> bytes:
    """Return an object file of a module's entries, after a line of JSON that says what is in it."""
    from numba.core.ccallback import CFunc  # only where something has to be compiled

    entries = {name: entry for name, entry in vars(module).items() if isinstance(entry, CFunc)}
    texts = []
    for name, entry in entries.items():
        text = llvm.parse_assembly(entry.inspect_llvm())
        text.get_function(entry.native_name).name = name
        texts.append(text)
    code = _joined(texts)
    for function in code.functions:
        if not function.is_declaration and function.name not in entries:
            function.linkage = "internal"
    machine = _machine()
    options = llvm.create_pipeline_tuning_options(speed_level=3)
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(code, builder)
    _check_calls(module, code)
    head = json.dumps({"entries": list(entries), "facts": facts})
    return head.encode() + b"\n" + machine.emit_object(code)


def _joined(modules: list[llvm.ModuleRef]) -> llvm.ModuleRef:
    first, *others = modules
    for other in others:
        first.link_in(other)
    return first


def _check_calls(module: ModuleType, code: llvm.ModuleRef) -> None:
    """Raise RuntimeError where code calls what only a process with Numba in it has.

    That is its runtime, for arrays that are made and for exceptions. LLVM would end the process.
    """
    here, linked = ctypes.CDLL(None), getattr(module, "LINKED", ())
    declared = [function.name for function in code.functions if function.is_declaration]
    wanted = [n for n in declared if not n.startswith("llvm.") and n not in linked]
    unknown = [n for n in wanted if not hasattr(here, n)]
    if unknown:
        raise RuntimeError(f"{module.__name__} calls {', '.join(unknown)}")


def _link(told: dict[str, Any], codes: list[bytes], machine: llvm.TargetMachine) -> MachineCode:
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    for code in codes:
        engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    addresses = {entry: engine.get_function_address(entry) for entry in told["entries"]}
    return MachineCode(addresses, told["facts"], engine)
