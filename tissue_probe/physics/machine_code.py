"""Machine code of generated functions, kept on disk.

Contents: from LLVM's text of functions to an object file, and back to functions.

Who finds an object file here needs LLVM and ctypes only. Of a text only the entries remain visible,
and the rest is optimised into them.
"""

from __future__ import annotations

import ctypes
import gc
import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import llvmlite.binding as llvm

from tissue_probe.physics import code_cache


@dataclass(frozen=True)
class Text:
    """Functions in LLVM's language.

    Attributes
    ----------
    code : str
        The text.
    entries : sequence of str
        Names of the functions that are to be called from outside.
    facts : mapping
        Facts kept with the code, of types that JSON knows.
    linked : sequence of str
        Names of functions that are called, and come from another text.
    """

    code: str
    entries: Sequence[str]
    facts: Mapping[str, Any]
    linked: Sequence[str] = ()


@dataclass(frozen=True)
class MachineCode:
    """Functions in this process.

    Attributes
    ----------
    addresses : mapping of int
        Where each entry begins: a C function.
    facts : mapping
        Those of the text.
    engine : object
        Keeps the functions in memory.
    """

    addresses: Mapping[str, int]
    facts: Mapping[str, Any]
    engine: llvm.ExecutionEngine


_loaded: dict[Path, MachineCode] = {}


def count_loaded() -> int:
    """Return of how many names this process has the functions."""
    return len(_loaded)


#: A name, and the function that writes the text kept under it.
Written = tuple[str, Callable[[], Text]]


def load(
    name: str,
    write: Callable[[], Text],
    sources: tuple[str, ...] = code_cache.ALL_SOURCES,
    beside: Callable[[Mapping[str, Any]], Written] | None = None,
) -> MachineCode:
    """Return the functions of a text, compiled first where no earlier process has.

    Parameters
    ----------
    name, sources
        As for ``code_cache.place``.
    write : callable
        Returns the text; called only where no machine code is on disk.
    beside : callable, optional
        Returns, of the text's facts, another text that calls entries by their names, and whose own
        are entries too.
    """
    path = _object(name, write, sources)
    if path not in _loaded:
        machine, (told, *codes) = _machine(), _read(path)
        if beside is not None:
            more, code = _read(_object(*beside(told["facts"]), sources))
            told["entries"] += more["entries"]
            codes.append(code)
        _loaded[path] = _link(told, codes, machine)
    return _loaded[path]


def _object(name: str, write: Callable[[], Text], sources: tuple[str, ...]) -> Path:
    """Return where a text's object file is, written first where no earlier process has."""
    path = code_cache.place(f"{name}_{_host()}", ".o", sources)
    if not path.exists():
        with _keeping_garbage():
            code_cache.replace(path, _compile(name, write()))
    return path


@contextmanager
def _keeping_garbage() -> Iterator[None]:
    """Look for no garbage meanwhile: who writes makes objects by the million, and keeps most."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _read(path: Path) -> tuple[dict[str, Any], bytes]:
    """Return the facts in an object file's first line of JSON, and the object file."""
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
    return str(llvm.get_host_cpu_features().flatten())


@cache
def _host() -> str:
    """Eight hexadecimal digits that stand for the processor and the compiler."""
    told = f"{llvm.get_host_cpu_name()} {_features()} {llvmlite.__version__}"
    return hashlib.sha256(told.encode()).hexdigest()[:8]


def _compile(name: str, text: Text) -> bytes:
    """Return an object file of a text's entries, after a line of JSON that describes it."""
    code = llvm.parse_assembly(text.code)
    for function in code.functions:
        if not function.is_declaration and function.name not in text.entries:
            function.linkage = "internal"
    machine = _machine()
    options = llvm.create_pipeline_tuning_options(speed_level=3)
    builder = llvm.create_pass_builder(machine, options)
    builder.getModulePassManager().run(code, builder)
    _check_calls(name, text, code)
    head = json.dumps({"entries": list(text.entries), "facts": dict(text.facts)})
    found: bytes = head.encode() + b"\n" + machine.emit_object(code)
    return found


def _check_calls(name: str, text: Text, code: llvm.ModuleRef) -> None:
    """Raise RuntimeError where code calls a function that only a process with Numba has.

    That is its runtime, for arrays that are made and for exceptions. LLVM would end the process.
    """
    here = _c_library()
    declared = [function.name for function in code.functions if function.is_declaration]
    wanted = [n for n in declared if not n.startswith("llvm.") and n not in text.linked]
    unknown = [n for n in wanted if not hasattr(here, n)]
    if unknown:
        raise RuntimeError(f"{name} calls {', '.join(unknown)}")


def _c_library() -> ctypes.CDLL:
    """Return the library of C's functions in this process: on Windows Python's own runtime."""
    return ctypes.CDLL("ucrtbase" if os.name == "nt" else None)


def _link(told: dict[str, Any], codes: list[bytes], machine: llvm.TargetMachine) -> MachineCode:
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    for code in codes:
        engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    addresses = {entry: engine.get_function_address(entry) for entry in told["entries"]}
    return MachineCode(addresses, told["facts"], engine)
