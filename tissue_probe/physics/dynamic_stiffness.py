"""Stiffness of tissue at the motion's frequency: what laws beside it may share with it.

What belongs here: dividing it between Kelvin-Voigt tissue and such a law. What does not: the laws.
"""

from collections.abc import Mapping


def of_branch(frequency: float, rate: float) -> complex:
    """Dynamic stiffness of a Maxwell branch over its spring's [-].

    ``frequency`` is angular [rad/s], ``rate`` that of relaxation [1/s].
    """
    return 1j * frequency / (1j * frequency + rate)


def handed_over(
    frequency: float, found: Mapping[str, float], known: complex, unit: complex, share: float
) -> tuple[float, dict[str, float]]:
    """Return a law's strength, and the tissue's stiffness and damping, as stiff together as found.

    Parameters
    ----------
    frequency : float
        Angular frequency of the motion [rad/s].
    found : mapping of str to float
        The tissue's ``stiffness`` [N/m] and ``damping`` [N s/m], among others.
    known : complex
        Dynamic stiffness of the law as found [N/m].
    unit : complex
        The same of the law that is proposed, over its strength; neither part negative.
    share : float
        Of the greatest strength that leaves the tissue neither stiffness nor damping below 0 [-].
    """
    whole = found["stiffness"] + 1j * frequency * found["damping"] + known
    strength = share * min(whole.real / unit.real, whole.imag / unit.imag)
    return strength, beside(frequency, found, known, strength * unit)


def beside(
    frequency: float, found: Mapping[str, float], known: complex, other: complex
) -> dict[str, float]:
    """Return the tissue's stiffness and damping that make up for another law; either may be < 0.

    Parameters
    ----------
    frequency : float
        Angular frequency of the motion [rad/s].
    found : mapping of str to float
        The tissue's ``stiffness`` [N/m] and ``damping`` [N s/m], among others.
    known, other : complex
        Dynamic stiffness of the law as found, and of the one that is proposed [N/m].
    """
    rest = found["stiffness"] + 1j * frequency * found["damping"] + known - other
    return {"stiffness": rest.real, "damping": rest.imag / frequency}
