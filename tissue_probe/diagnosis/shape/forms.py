"""Laws of one signal that are tried as a formula for a learnt function: the catalogue.

Contents: a law with its constants, and the list of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tissue_probe.signals import FloatArray

#: Values of a form's second constant that are tried, over its whole range.
STEPS = 25
#: Signals that a formula may be of.
SIGNALS = ("indentation", "velocity")
Law = Callable[[FloatArray, float], FloatArray]


@dataclass(frozen=True, eq=False)
class Form:
    """A law c f(s; a) of one signal s, which may have a second constant a.

    Attributes
    ----------
    name : str
        Of the form.
    text : str
        In Python's words: of ``s``, ``c`` and ``a``, with ``abs``, ``sign``, ``exp``, ``tanh``,
        ``sin``, ``max``.
    law : callable
        f of the signal and a.
    signals : tuple of str
        Which signals it is tried for.
    least, most : float
        Range of a: a number, or a share of the largest signal, or over the largest signal.
    of : str
        The kind of a: "" (none), "number", "length" (as the signal), "inverse".
    fixed : int
        How many more constants are in the law, each as it was found on the curve.
    """

    name: str
    text: str
    law: Law
    signals: tuple[str, ...] = SIGNALS
    least: float = 0.0
    most: float = 0.0
    of: str = ""
    fixed: int = 0

    @property
    def constants(self) -> int:
        """How many constants the record was asked for."""
        return 1 + bool(self.of) + self.fixed

    def values(self, largest: float) -> FloatArray:
        """Return the values of a that are tried for a signal that is at most so large."""
        if not self.of:
            return np.zeros(1)
        scale = {"number": 1.0, "length": largest, "inverse": 1.0 / largest}[self.of]
        return np.geomspace(self.least, self.most, STEPS) * scale

    def unit(self, signal: str) -> str:
        """Return the unit of a."""
        own = {"indentation": "m", "velocity": "m/s"}[signal]
        inverse = {"indentation": "1/m", "velocity": "s/m"}[signal]
        return {"number": "1", "length": own, "inverse": inverse, "": ""}[self.of]


def _powers(signal: str, usual: float) -> tuple[Form, Form]:
    """Return powers of a signal over a usual value of it, so that c is a force of usual size."""
    share = f"abs(s / {usual:g})**a"
    return (
        Form("power, odd", f"c * sign(s) * {share}",
             lambda s, a: np.sign(s) * np.abs(s / usual) ** a, (signal,), 0.2, 5.0, "number"),
        Form("power, even", f"c * {share}",
             lambda s, a: np.abs(s / usual) ** a, (signal,), 0.5, 6.0, "number"),
    )  # fmt: skip


FORMS = (
    *_powers("indentation", 1e-3),
    *_powers("velocity", 0.1),
    Form("exponential", "c * (exp(a * s) - 1)", lambda s, a: np.expm1(a * s),
         SIGNALS, 0.1, 10.0, "inverse"),
    Form("rational", "c * s / (1 + abs(s) / a)", lambda s, a: s / (1.0 + np.abs(s) / a),
         SIGNALS, 0.05, 20.0, "length"),
    Form("saturating", "c * tanh(s / a)", lambda s, a: np.tanh(s / a),
         SIGNALS, 0.01, 5.0, "length"),
    Form("beyond a depth", "c * max(s - a, 0)", lambda s, a: np.maximum(s - a, 0.0),
         ("indentation",), 0.05, 0.95, "length"),
    Form("direction", "c * sign(s)", lambda s, a: np.sign(s), ("velocity",)),
)  # fmt: skip
