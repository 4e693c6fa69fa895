"""The one family of errors that tell a user something to mend.

What belongs here: the family, and its members that no package has to itself. What does not: members
that one package raises (``recording.errors``, ``settings``), faults of a running device.
"""

from __future__ import annotations


class TissueProbeError(ValueError):
    """Something that the user can mend; the message is a sentence: where, the fault, the remedy.

    A parameter is named in backticks, as Python knows it (`sample_rate`); the command line writes
    its option instead.
    """


class ParameterError(TissueProbeError):
    """A parameter has a value that it cannot have, or contradicts another one."""


class MeasurementError(TissueProbeError):
    """The samples, or the model together with them, are such that a fit would be worthless."""
