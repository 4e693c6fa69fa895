"""Recordings as a laboratory has them: tables on disk."""

from __future__ import annotations

from pathlib import Path

import numpy as np

RATE = 1000.0


def write(
    path: Path,
    stiffness: float,
    seed: int,
    samples: int = 1000,
    force: tuple[str, float] = ("F", 1.0),
) -> None:
    """Write samples of a spring with a damper, felt by a rigid probe, in SI units.

    ``force`` has its column's name, and how many of its unit make a newton.
    """
    t = np.arange(samples) / RATE
    u = 1e-3 * (1.0 - np.cos(2.0 * np.pi * 5.0 * t))
    v = np.gradient(u, t)
    noise = 2e-3 * np.random.default_rng(seed).standard_normal(samples)
    f = stiffness * u + 3.0 * v + noise
    name, per_newton = force
    f *= per_newton
    lines = (",".join(f"{each:.9f}" for each in row) for row in zip(t, u, f, strict=True))
    path.write_text(f"t,u,{name}\n" + "\n".join(lines) + "\n")


#: How the tables are read and asked about.
QUESTION = {"rig": "rigid_probe", "force_polarity": "compression"}
