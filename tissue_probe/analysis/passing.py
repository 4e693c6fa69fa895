"""A result as bytes, for another process of the same program on the same machine.

Machine code cannot be copied, and the symbols of an effect need not be: a model goes by the names
of its parts, and the reader finds its own. An effect that only one process knows, such as a learnt
shape, goes as it is.
"""

from __future__ import annotations

import io
import pickle
import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tissue_probe import quantities
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.rigs import RIGS, Rig
from tissue_probe.physics.scale import USUAL, Scale
from tissue_probe.quantities import Quantity

if TYPE_CHECKING:
    from tissue_probe.physics.effects import Effect

#: Where effects are of: without SymPy, which that takes a second to import, there are none.
_EFFECTS = "tissue_probe.physics.effects.effect"


def to_bytes(result: object) -> bytes:
    """Return a result, or anything that holds some, as bytes."""
    file = io.BytesIO()
    _Writer(file, protocol=pickle.HIGHEST_PROTOCOL).dump(result)
    return file.getvalue()


def from_bytes(data: bytes, effects: Sequence[str | Path] = ()) -> Any:
    """Return the object that ``to_bytes`` was given.

    Parameters
    ----------
    data : bytes
        Of a process of one's own.
    effects : sequence of path
        Python files with effects of the user's own, those that the other process had; they are run.

    Raises
    ------
    EffectError
        If a file of effects cannot be used.
    KeyError
        If it holds an effect of a file that is not named, which cannot go as it is.
    """
    return _Reader(io.BytesIO(data), effects).load()


@cache
def _write_effect(effect: Effect) -> str:
    return repr(effect.plain)


@cache
def _copy_effect(effect: Effect) -> bytes | None:
    """Return an effect as it is; None of one of the library, or where it holds a local function."""
    from tissue_probe.physics.effects import EFFECTS

    if effect.name in EFFECTS:
        return None
    try:
        return pickle.dumps(effect)
    except (AttributeError, TypeError, pickle.PicklingError):
        return None


class _Writer(pickle.Pickler):
    def persistent_id(self, obj: object) -> tuple[object, ...] | None:
        """Name an object that the reader has as well."""
        if isinstance(obj, Quantity):
            return ("quantity", obj.name)
        if isinstance(obj, Rig) and RIGS.get(obj.name) is obj:
            return ("rig", obj.name)
        if _EFFECTS in sys.modules and isinstance(obj, sys.modules[_EFFECTS].Effect):
            # As a whole, or in one of its forms: the library does not hold `plain`.
            return ("effect", *self._name_effect(obj))
        if isinstance(obj, Composition):
            return (
                "model",
                obj.rig,
                obj.tissue,
                tuple(map(self._name_effect, obj.effects)),
                obj.scale,
            )
        return None

    @staticmethod
    def _name_effect(effect: Effect) -> tuple[str, str | None, Scale, bytes | None]:
        as_written = effect.origin or effect
        written = None if effect.forms else _write_effect(as_written)
        return effect.name, written, effect.scale, _copy_effect(as_written)


class _Reader(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, effects: Sequence[str | Path]) -> None:
        super().__init__(file)
        self._files = tuple(map(Path, effects))

    def persistent_load(self, pid: Any) -> object:
        """Return the reader's own object of a name."""
        kind, *named = pid
        if kind == "quantity":
            return {q.name: q for q in (quantities.FORCE, quantities.POSITION)}[named[0]]
        if kind == "rig":
            return RIGS[named[0]]
        if kind == "effect":
            return self._effect(*named)
        rig, tissue, effects, scale = named
        found = Composition(rig, tissue, scale=scale)
        for each in effects:
            found = found.plus(self._effect(*each))
        return found

    def _effect(self, name: str, written: str | None, scale: Scale, copy: bytes | None) -> Effect:
        if not scale.is_usual:
            from tissue_probe.physics.effect_scale import resize_effect

            return resize_effect(self._effect(name, written, USUAL, copy), scale)
        known = _library(self._files).get(name)
        if known is not None and written is None:
            return known
        if known is not None and not known.forms and _write_effect(known) == written:
            return known
        forms = known.every_form if known is not None else ()
        found = next((form for form in forms if _write_effect(form) == written), None)
        if found is not None:
            return found
        if copy is None:
            raise KeyError(name)
        own: Effect = pickle.loads(copy)
        return own


_libraries: dict[tuple[tuple[Path, int], ...], dict[str, Effect]] = {}


def _library(files: tuple[Path, ...]) -> dict[str, Effect]:
    """Return the library with these files, run once for as long as they stay the same."""
    from tissue_probe.physics import library

    key = tuple((path, path.stat().st_mtime_ns) for path in files)
    if key not in _libraries:
        _libraries[key] = library.effects(files)
    return _libraries[key]
