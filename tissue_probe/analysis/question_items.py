"""All that may be asked of measurements, declared once.

From this the Python functions have their keywords and the documentation of these, the command line
its options, and the page its form. The meaning of a value (``question``, ``segments``) takes a
second to be imported, and is not here.
"""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

from tissue_probe.analysis.choices import COURSES, RIG_NAMES, START_CHOICES, TISSUE_NAMES
from tissue_probe.physics.rigs import OWN, name_rigs
from tissue_probe.quantities import FORCE

Kind = Literal["choice", "constants", "file", "files", "flag", "names", "number", "odds", "whole"]
"""A name of some, values by name, paths, yes or no, any names, and numbers."""


class Item(NamedTuple):
    """One thing that may be said of measurements.

    Attributes
    ----------
    name : str
        The keyword in Python.
    kind : str
        Which values it has.
    about : str
        One sentence, or two.
    default : object
        Where it is not said.
    choices : tuple of str
        Its values, where there are only some.
    else_ : str
        The value where none is given, in words.
    option : str
        On the command line, where it is called otherwise there.
    metavar : str
        How its value is written there.
    label : str
        In the page's form; empty where the page does not ask for it so.
    example : str
        A value, as it is written in the form.
    """

    name: str
    kind: Kind
    about: str
    default: Any = None
    choices: tuple[str, ...] = ()
    else_: str = ""
    option: str = ""
    metavar: str = ""
    label: str = ""
    example: str = ""


ITEMS = (
    Item(
        "site", "whole", "Site of a scan; each is another piece of tissue.", metavar="NUMBER",
    ),
    Item(
        "lowpass", "number",
        "Take faster parts out of position and force alike, and keep 2.5 samples a cycle of it.",
        metavar="HERTZ", label="low-pass [Hz]", example="none",
    ),
    Item(
        "starts", "choice", "Whether the probe rested before the first sample.", "auto",
        START_CHOICES, label="before the first sample",
    ),
    Item(
        "course", "choice",
        "How a force that drives goes on between two samples: smooth, straight, held (as a "
        "converter puts out a command) or jumping (smooth but for its jumps, which are at the "
        "samples); auto tells it from the record.",
        "auto", COURSES, option="input",
    ),
    Item(
        "rig", "choice",
        "How the instrument couples to the tissue; in "
        f"{name_rigs(lambda rig: rig.input is FORCE)} the force is the input, and the position is "
        "predicted.",
        choices=RIG_NAMES, else_=f"that of `model`; {OWN} in recordings of this suite", label="rig",
    ),
    Item(
        "tissue", "choice", "The model to begin with.", choices=TISSUE_NAMES,
        else_="that of `model`, else kelvin_voigt", label="tissue",
    ),
    Item(
        "model", "file",
        "Begin with this model.yaml, in place of rig and tissue: its values are fitted again, or "
        "held where they are compared.",
    ),
    Item(
        "known_rig", "flag", "Take the rig's constants as exactly known.", False,
        label="rig exactly known",
    ),
    Item(
        "constants", "constants",
        "A constant of the rig and its standard deviation (one; a number printed after +- is a 95 "
        "% interval), SI units, such as tip_mass=0.04+-0.001, or a known value of the tissue, such "
        "as stiffness=0; may be given several times.",
        option="constant", metavar="NAME=VALUE[+-SD]", label="known constants",
        example="tip_mass=.04+-.001",
    ),
    Item(
        "prior", "odds",
        "How many times as likely an effect, or one of a family, is missing as any other, before "
        "anything is measured, such as relaxation=10; may be given several times.",
        metavar="NAME=ODDS", label="prior odds", example="relaxation=10",
    ),
    Item(
        "effects", "files",
        "Python file with effects of your own; it is run. May be given several times.", (),
    ),
    Item(
        "without", "names",
        "Leave this effect out of those that are tried; may be given several times.", (),
        metavar="EFFECT",
    ),
)  # fmt: skip

#: By name.
ITEMS_BY_NAME = {each.name: each for each in ITEMS}
