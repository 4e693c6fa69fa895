"""Names of the tissues that a tip presses on; apart from their laws, which need SymPy."""

from __future__ import annotations

from typing import Literal

TissueName = Literal["kelvin_voigt", "maxwell", "standard_linear_solid", "generalized_maxwell"]
"""Table I of the paper (``physics.tissues``)."""
