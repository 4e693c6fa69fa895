"""A report of tissue that stiffens, made of signals from the tests' simulator."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import sympy
from specimen import Specimen, kelvin_voigt_residual, sine

from tissue_probe.diagnosis.residuals.all_tests import residual_tests
from tissue_probe.diagnosis.residuals.localise import localise
from tissue_probe.diagnosis.residuals.noise_floor import noise_floor
from tissue_probe.report.contents import (
    Report,
    ReportCandidate,
    ReportExcitation,
    ReportParameter,
    ReportSignals,
    ReportSource,
    ReportStep,
)

PERIOD = 5e-4
STIFFENING = Specimen(cubic=1e8, preload=1e-3)


def equations(stiffening: bool) -> tuple[str, ...]:
    """Return eq. 1 of the paper as SymPy writes it, with or without a cubic spring."""
    time = sympy.Symbol("t")
    m, k, beta, k3, k0, beta0 = sympy.symbols("m k beta k_3 k_0 beta_0")
    x, u, force = (sympy.Function(name)(time) for name in "xuF")
    tissue = k * x + beta * x.diff(time) + (k3 * x**3 if stiffening else 0)
    motion = sympy.Eq(
        m * x.diff(time, 2), k0 * (u - x) + beta0 * (u - x).diff(time) - tissue, evaluate=False
    )
    return (sympy.latex(motion), sympy.latex(sympy.Eq(force, k0 * (u - x), evaluate=False)))


STIFFNESS = ReportParameter("stiffness", "k", 800.31, 798.9, 801.7, "N/m")
DAMPING = ReportParameter("damping", r"\beta", 4.012, 3.994, 4.03, "N s/m")
CUBIC = ReportParameter("stiffening", "k_{3}", 1.0013e8, 0.9989e8, 1.0037e8, "N/m³")


@cache
def example() -> Report:
    """Return the report; its errors, regions and tests are computed from the signals."""
    position, tip, base, residual = kelvin_voigt_residual(STIFFENING, sine())
    _, _, final, measured = STIFFENING.measure(sine())
    noise = noise_floor(measured)
    judged = [localise(r, position, tip, PERIOD, noise) for r in (residual, measured - final)]
    tests = [residual_tests(r, position, PERIOD, noise) for r in (residual, measured - final)]
    errors = [float(np.sqrt(np.mean(r**2))) for r in (residual, measured - final)]
    steps = (
        ReportStep(
            "Kelvin-Voigt",
            "base model",
            equations(stiffening=False),
            (replace(STIFFNESS, value=1022.3, low=1020.9, high=1023.7), DAMPING),
            errors[0],
            1.02 * errors[0],
        ),
        ReportStep(
            "+ cubic_stiffening",
            "lowers the held-out error most",
            equations(stiffening=True),
            (STIFFNESS, DAMPING, CUBIC),
            errors[1],
            1.01 * errors[1],
        ),
    )
    ranking = (
        ReportCandidate(
            "cubic_stiffening",
            "stiffening",
            "the tissue's spring grows stiffer with depth, k3 x³",
            1.01 * errors[1],
            14210.0,
            (CUBIC,),
        ),
        ReportCandidate(
            "exponential_stiffening",
            "stiffening",
            "force grows exponentially with depth (Fung)",
            1.03 * errors[1],
            14195.0,
            indistinguishable=False,
        ),
        ReportCandidate(
            "coulomb_friction", "friction", "dry friction", 0.98 * errors[0], -3.2, settled=False
        ),
    )
    return Report(
        title="What the model of specimen 7 was missing",
        verdict="missing",
        summary=(
            "The tissue stiffens with depth: cubic_stiffening is missing.",
            f"With it, the error falls from {errors[0] / noise:.3g} to {errors[1] / noise:.3g} "
            "times the noise.",
        ),
        noise_floor=noise,
        steps=steps,
        ranking=ranking,
        signals=(
            ReportSignals(
                "run.mcap, fitted", PERIOD * np.arange(base.size), measured, base, final, *judged
            ),
        ),
        findings=("The encoder's steps of 0.1 µm are below the noise.",),
        base_tests=tests[0],
        final_tests=tests[1],
        excitations=(
            ReportExcitation(
                "A sweep would tell cubic from exponential stiffening.",
                "ros2 param set /probe/driver excitation.kind chirp",
                {"start": "1 Hz", "stop": "60 Hz"},
                ("Let the tip just touch.",),
            ),
        ),
        sources=(ReportSource("run.mcap", "fitted", "2.0 s at 2 kHz, compression positive"),),
        versions={"tissue_probe": "0.1.0", "numpy": np.__version__},
        created="2026-01-31 12:00",
        seconds=1.94,
    )
