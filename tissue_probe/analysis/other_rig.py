"""Whether measurements look like those of another rig than the one that is asked about.

Contents: trying the other rigs where no effect explains a record, and telling a command by its lack
of noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

from tissue_probe.analysis.choices import TissueName
from tissue_probe.analysis.question import ModelQuestion, question
from tissue_probe.analysis.segments import Segment
from tissue_probe.diagnosis.diagnosis import Diagnosis, fit_plainly
from tissue_probe.diagnosis.evidence.adequacy import leaves_only_noise
from tissue_probe.errors import TissueProbeError
from tissue_probe.physics.rigs import RIGS, name_rigs
from tissue_probe.quantities import FORCE, POSITION

EXPLAINS = "On another rig no effect is missing: the plain model of {0} explains these measurements"
COMMANDED = "The force is smooth to the last digits, as one that is commanded and not measured"
OTHER_RIG_ASKED = "; is the rig {0} (`rig` {0})?"


def other_rig(found: Diagnosis, asked: ModelQuestion, taken: Sequence[Segment]) -> str:
    """Say on which other rig the measurements make sense; nothing where none is seen.

    It is asked only of a model without effects, where nothing explains the measurements or the
    position is noisy and the force is not: then an effect may make up for the wrong rig.
    """
    own = asked.composition
    if own.effects:
        return ""
    driven = [each.measurement(POSITION) for each in taken]
    commanded = own.input is POSITION and all(each.is_commanded for each in driven)
    unexplained = found.verdict == "unexplained"
    if commanded and (unexplained or all(each.position_noise > 0.0 for each in driven)):
        return (COMMANDED + OTHER_RIG_ASKED).format(name_rigs(lambda rig: rig.input is FORCE))
    if not unexplained:
        return ""
    for rig in (rig for rig in RIGS.values() if rig is not own.rig):
        other = question(rig=rig, tissue=cast(TissueName, own.tissue))
        measurements = [each.measurement(other.composition.output) for each in taken]
        try:
            plain = fit_plainly(other.composition, measurements, other.instrument)
            if leaves_only_noise(plain):
                return (EXPLAINS + OTHER_RIG_ASKED).format(rig)
        except TissueProbeError:  # on that rig they make no sense
            continue
    return ""
