"""Generated code kept on disk, compiled by Numba once and found again by later processes.

Contents: where generated modules live and how they are found.
"""

from __future__ import annotations

import getpass
import hashlib
import importlib.util
import os
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import ModuleType

PACKAGE = Path(__file__).parent.parent

ALL_SOURCES = ("physics/**/*.py", "estimation/**/*.py")


def module(
    name: str, write: Callable[[], str], sources: tuple[str, ...] = ALL_SOURCES
) -> ModuleType:
    """Import a generated module, generating it first where no earlier process has.

    Numba finds a compiled function again only by its module's name and file, so both are the same
    in every process: ``tissue_probe_<name>_<fingerprint>`` below ``$TISSUE_PROBE_CACHE``, by
    default ``~/.cache/tissue_probe``. The fingerprint is that of the source which generates code,
    so that changed equations never meet kernels compiled from the old ones.

    Parameters
    ----------
    name : str
        Letters, digits and underscores; stands for everything the code depends on.
    write : callable
        Returns the module's source text; called only where the module is not on disk.
    sources : tuple of str
        Which sources, as patterns below the package, take part in the generation.
    """
    path = place(name, ".py", sources)
    full_name = path.stem
    if full_name not in sys.modules:
        if not path.exists():
            replace(path, write().encode())
        spec = importlib.util.spec_from_file_location(full_name, path)
        if spec is None or spec.loader is None:
            raise ImportError(f"{path} is no Python file")
        sys.modules[full_name] = importlib.util.module_from_spec(spec)
        try:
            spec.loader.exec_module(sys.modules[full_name])
        except BaseException:
            del sys.modules[full_name]
            raise
    return sys.modules[full_name]


def place(name: str, ending: str, sources: tuple[str, ...] = ALL_SOURCES) -> Path:
    """Return the path of the code generated under a name; its folder exists afterwards."""
    return _folder() / f"tissue_probe_{name}_{fingerprint(sources)}{ending}"


@cache
def fingerprint(sources: tuple[str, ...] = ALL_SOURCES) -> str:
    """Twelve hexadecimal digits that change with any source that takes part in the generation."""
    digest = hashlib.sha256()
    for pattern in sources:
        for path in sorted(PACKAGE.glob(pattern)):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def _folder() -> Path:
    """Return where generated modules are kept, made where it is not there yet."""
    home = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "tissue_probe"
    chosen = os.environ.get("TISSUE_PROBE_CACHE")
    folder = Path(chosen) if chosen else home
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        folder = Path(tempfile.gettempdir()) / f"tissue_probe_{getpass.getuser()}"
        folder.mkdir(exist_ok=True)
    return folder


def replace(path: Path, content: bytes) -> None:
    """Write a file in one motion, so that a process started meanwhile never sees half of it."""
    handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
    with os.fdopen(handle, "wb") as file:
        file.write(content)
    os.replace(temporary, path)
