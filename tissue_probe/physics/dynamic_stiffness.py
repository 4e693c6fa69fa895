"""Stiffness of tissue at the motion's frequency: effects beside it may share it.

Contents: dividing it between Kelvin-Voigt tissue and such a law.
"""

from collections.abc import Mapping


def of_branch(frequency: float, rate: float) -> complex:
    """Dynamic stiffness of a Maxwell branch over its spring's [-].

    ``frequency`` is angular [rad/s], ``rate`` that of relaxation [1/s].
    """
    return 1j * frequency / (1j * frequency + rate)


def together(frequency: float, found: Mapping[str, float], known: complex) -> complex:
    """Dynamic stiffness of tissue and a law beside it [N/m].

    Parameters
    ----------
    frequency : float
        Angular frequency of the motion [rad/s].
    found : mapping of str to float
        The tissue's ``stiffness`` [N/m] and ``damping`` [N s/m], among others.
    known : complex
        Dynamic stiffness of the law as found [N/m].
    """
    return found["stiffness"] + 1j * frequency * found["damping"] + known


def tissue_of(frequency: float, rest: complex) -> dict[str, float]:
    """Return stiffness and damping of tissue of a dynamic stiffness [N/m]; either may be < 0."""
    return {"stiffness": rest.real, "damping": rest.imag / frequency}


def hand_over(
    frequency: float, found: Mapping[str, float], known: complex, unit: complex, share: float
) -> tuple[float, dict[str, float]]:
    """Return a law's strength, and the tissue's stiffness and damping, as stiff together as found.

    Parameters
    ----------
    frequency, found, known
        As for ``together``.
    unit : complex
        Dynamic stiffness of the law that is proposed, over its strength; neither part negative.
    share : float
        Of the greatest strength that leaves the tissue neither stiffness nor damping below 0 [-].
    """
    whole = together(frequency, found, known)
    strength = share * min(whole.real / unit.real, whole.imag / unit.imag)
    return strength, tissue_of(frequency, whole - strength * unit)
