"""What a physical effect declares: the contract of every file in this folder."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

TIP_POSITION, TIP_VELOCITY = sp.symbols("tip_position tip_velocity", real=True)


@dataclass(frozen=True)
class Parameter:
    """An unknown of an effect: its symbol, unit, and where it lies."""

    symbol: sp.Symbol
    unit: str
    default: float
    lower: float
    upper: float


@dataclass(frozen=True)
class Effect:
    """A force of the tissue on the tip, besides k x + beta x'.

    At zero strength (its first parameter) it reproduces the model without it exactly.

    Attributes
    ----------
    name, physics : str
        A name, and one line on what happens.
    parameters : tuple of Parameter
        What is to be estimated; the first is the effect's strength.
    force : Expr
        Force on the tip [N], positive against indentation, of tip position and velocity, the
        effect's states and its parameters.
    states : tuple of Symbol
        States of its own, besides the tip's.
    motion : tuple of Expr
        Their rates of change.
    assumptions, reference : str
        Where it holds, and where it comes from.
    """

    name: str
    physics: str
    parameters: tuple[Parameter, ...]
    force: sp.Expr
    states: tuple[sp.Symbol, ...] = ()
    motion: tuple[sp.Expr, ...] = ()
    assumptions: str = ""
    reference: str = ""
