"""Names by which columns are known: this suite's own, and those of testing machines.

Contents: tables of names, to which a laboratory's may be added.
"""

OWN_NAMES = {"time": ("t", "time"), "position": ("u", "position"), "force": ("F", "force")}
"""This suite's names of the columns; in SI units, and positive in compression."""

USUAL_NAMES = {
    "time": (
        "time", "time stamp", "timestamp", "elapsed time", "running time", "test time", "scan time",
        "step time", "x value", "zeit", "testzeit", "prüfzeit", "temps", "tiempo", "tempo",
    ),
    "position": (
        "position", "pos", "displacement", "disp", "extension", "compressive extension",
        "crosshead", "stroke", "compressive displacement", "axial displacement", "indentation",
        "indentation depth", "depth", "travel", "tip", "tip position", "weg", "standardweg",
        "traversenweg",
    ),
    "force": (
        "force", "load", "compressive load", "axial force", "axial load", "normal force",
        "kraft", "standardkraft",
    ),
}  # fmt: skip
"""Their names on testing machines and in laboratories, in lower case, words apart by blanks."""

SWEEP = (
    "storage modulus",
    "loss modulus",
    "storage",
    "loss",
    "g'",
    "g''",
    "e'",
    "e''",
    "tan delta",
)
"""Columns of a frequency sweep: no samples over time, but results at each frequency."""

ROTARY = ("Nm", "mNm", "N m", "mN m", "N*m", "N.m", "N·m", "rad", "mrad", "deg", "°", "degrees")
"""Units of torques and angles."""
