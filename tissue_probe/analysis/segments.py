"""The stretches of measurements that are fitted: evenly spaced, without a hole, long enough.

Contents: which parts, and the sentence on those left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tissue_probe.analysis.choices import Course, Starts
from tissue_probe.analysis.measurements import Measurements, ReadRecording
from tissue_probe.diagnosis.advice.driver_command import coil_gain
from tissue_probe.diagnosis.inspection.coarse_response import coarse_response, regressors
from tissue_probe.diagnosis.inspection.information import (
    ENOUGH_DEVIATION,
    FEWEST_IN_RESIDUAL,
    stiffness_deviation,
)
from tissue_probe.diagnosis.observation.measurement import Measurement
from tissue_probe.diagnosis.observation.noise import FAINT_NOISE, UNKNOWN_NOISE
from tissue_probe.diagnosis.observation.resampling import AS_MEASURED, Resampling
from tissue_probe.physics.response import Between
from tissue_probe.quantities import FORCE, Quantity
from tissue_probe.recording.clocks.lowpass import filter_block
from tissue_probe.recording.clocks.stretches import (
    Stretch,
    cut_known,
    dwell_blocks,
    unknown_runs,
)
from tissue_probe.recording.errors import RecordingError
from tissue_probe.signals import NANOSECONDS, BoolArray, Channel, FloatArray, OwnTimes, SampleBlock


@dataclass(frozen=True)
class Segment:
    """Evenly spaced samples without a hole.

    Attributes
    ----------
    source : str
        Which file, and which part of it.
    position, force : array, shape (n,)
        Displacement of the coil [m]; load-cell force [N], positive in compression; finite.
    command : array, shape (n,)
        Voltage commanded to the coil [V]; NaN where it is not known.
    measured : array of bool, shape (n,)
        Which samples are as they were measured, and not filled in.
    sample_period : float
        [s].
    starts : Starts
        As the user says.
    run : str
        Which file.
    begins : float
        Time of the first sample after the file's first that is used [s].
    time_doubt : float
        By how much position and force may be apart in time [s].
    noise : array, shape (m,), optional
        White noise of variance 1, resampled as the force was; None where that was not.
    own : OwnTimes, optional
        The samples as they were before they were resampled.
    notes : tuple of str
        How it was read, in sentences; those on a file stand with its first segment.
    course : Course
        How the force goes on between its samples, as the user says.
    input2 : Channel, optional
        A further channel of the file.
    stamp : int
        Of the first sample [ns since the epoch].
    """

    source: str
    position: FloatArray
    force: FloatArray
    command: FloatArray
    measured: BoolArray
    sample_period: float
    starts: Starts
    run: str = ""
    begins: float = 0.0
    time_doubt: float = 0.0
    noise: FloatArray | None = None
    own: OwnTimes | None = None
    notes: tuple[str, ...] = ()
    course: Course = "auto"
    input2: Channel | None = None
    stamp: int = 0

    def measurement(self, output: Quantity) -> Measurement:
        """Return it as models of this output are compared with it.

        Samples at uneven times keep these, but where the force feels noise of the position, which
        drives, or a force drives: noise of the input is counted at even times only.
        """
        even = self._even(output)
        if self.own is None or output is not FORCE or _feels_noise(even):
            return even
        own = self.own
        return replace(
            even,
            position=own.position,
            force=own.force,
            used=np.ones(own.force.size, dtype=bool),
            noise=UNKNOWN_NOISE,
            resampling=AS_MEASURED,
            at=own.time - own.time[0],
            input2=self._second(own.stamp, own.time),
        )

    def _even(self, output: Quantity) -> Measurement:
        return Measurement(
            self.position,
            self.force,
            self.sample_period,
            self.starts == "at-rest",
            used=self.measured,
            output=output,
            coil_gain=coil_gain(self.position, self.command),
            notes=self.notes,
            source=self.source,
            run=self.run,
            begins=self.begins,
            time_doubt=self.time_doubt,
            resampling=AS_MEASURED if self.noise is None else Resampling(self.noise),
            between=None if self.course == "auto" else Between[self.course],
            input2=self._second(self.stamp, self._times),
        )

    @property
    def _times(self) -> FloatArray:
        """Time of each sample after the first [s]."""
        return np.arange(self.force.size, dtype=np.float64) * self.sample_period

    def _second(self, stamp: int, offsets: FloatArray) -> FloatArray | None:
        """Return the further channel at times after a stamp."""
        return None if self.input2 is None else self.input2.at(stamp, offsets)


def _feels_noise(measurement: Measurement) -> bool:
    """Whether the force feels noise of the position, by a first look at how it answers to it.

    Noise from sample to sample has speeds and accelerations that go with the sampling rate.
    """
    noise = measurement.position_noise
    if not noise:
        return False
    period = measurement.sample_period
    told = coarse_response(regressors(measurement.position, measurement.force, period))
    answers = told.stiffness, told.damping / period, told.mass / period**2
    return noise * max(map(abs, answers)) > FAINT_NOISE * measurement.noise.own


def segments(
    measured: Measurements,
    starts: Starts = "auto",
    site: int | None = None,
    lowpass: float | None = None,
    course: Course = "auto",
) -> list[Segment]:
    """Cut measurements into segments where samples are missing.

    Pieces too short to tell the stiffness are left out where a file has others. Only a file's first
    segment starts at rest, if the user says so.

    Parameters
    ----------
    measured : Measurements
        As read.
    starts : {"auto", "at-rest", "moving"}
        Whether the probe had been at rest before the first sample of each file.
    site : int, optional
        Only the dwells at this site of a scan.
    lowpass : float, optional
        Take out of position and force alike all that is faster [Hz].
    course : {"auto", "smooth", "straight", "held", "jumping"}
        How a force that drives goes on between two samples; ``auto`` tells it from the record.

    Raises
    ------
    RecordingError
        If a file has no sample that is known, too few of them, or no such site.
    """
    found = [one for part in measured.parts for one in _segments(part, starts, site, lowpass)]
    return [replace(each, course=course) for each in found]


def _segments(
    part: ReadRecording, starts: Starts, site: int | None, lowpass: float | None
) -> list[Segment]:
    blocks = dwell_blocks(part.recording, site)
    cut = [cut_known(block) for block in blocks]
    stretches = [stretch for found, _ in cut for stretch in found]
    if not stretches:
        raise RecordingError(f"{part.name} has no sample whose position and force are both known")
    check_enough(part.name, max(map(len, stretches)))
    known = [found for found, _ in cut]
    told = [
        *part.notes,
        *_told_unknown(part.name, blocks, known),
        *_told_pieces(part.name, stretches),
    ]
    chosen = [stretch for stretch in stretches if _is_long(stretch)] or stretches
    found = []
    for number, piece in enumerate(chosen):
        stretch = piece if lowpass is None else filter_block(piece, lowpass)
        every = round(stretch.sample_period / piece.sample_period)
        rested: Starts = starts if piece is stretches[0] or starts != "at-rest" else "moving"
        numbered = f", part {number + 1}" if len(chosen) > 1 else ""
        found.append(
            Segment(
                f"{part.name}{numbered}",
                stretch.position,
                stretch.force,
                stretch.command,
                piece.measured[::every],
                stretch.sample_period,
                rested,
                part.name,
                (stretch.stamp - chosen[0].stamp) / NANOSECONDS,
                part.recording.time_doubt,
                part.recording.noise if lowpass is None else None,
                _own(part, piece) if lowpass is None else None,
                tuple(told) if number == 0 else (),
                input2=part.recording.input2,
                stamp=stretch.stamp,
            )
        )
    return found


def _own(part: ReadRecording, piece: Stretch) -> OwnTimes | None:
    """Return the samples of a piece at their own times; None where these are even."""
    own = part.recording.own
    return None if own is None else own.between(piece.stamp, piece.end)


def check_enough(name: str, count: int) -> None:
    """Refuse a recording whose longest stretch of samples is too short.

    Raises
    ------
    RecordingError
        If it is shorter than ``FEWEST``.
    """
    if count < FEWEST_IN_RESIDUAL:
        raise RecordingError(
            f"{name} has {count} samples without a gap, which tell nothing; give at least "
            f"{FEWEST_IN_RESIDUAL}"
        )


def _is_long(block: SampleBlock) -> bool:
    """Whether a piece tells the stiffness by itself, as a whole recording must."""
    return stiffness_deviation(block.position, block.force, block.sample_period) < ENOUGH_DEVIATION


def _told_unknown(
    name: str, blocks: Sequence[SampleBlock], known: Sequence[Sequence[Stretch]]
) -> list[str]:
    """Name samples that were filled in, and those unknown for longer."""
    told = []
    filled = sum(int((~stretch.measured).sum()) for found in known for stretch in found)
    if filled:
        told.append(
            f"{name}: {filled} samples of the even grid lie in gaps: filled in by a cubic spline, "
            "and left out of the fit"
        )
    runs = [
        (stop - first, block.stamps[first])
        for block, found in zip(blocks, known, strict=True)
        for first, stop in unknown_runs(block, found)
    ]
    if runs:
        longest, stamp = max(runs, key=lambda run: run[0])
        begun = (stamp - blocks[0].stamp) / NANOSECONDS
        told.append(
            f"{name}: {sum(count for count, _ in runs)} samples in "
            f"{len(runs)} run{'s' if len(runs) > 1 else ''} are not known, {longest} of them "
            f"{begun:.4g} s after the first sample; cut out there"
        )
    return told


def _told_pieces(name: str, stretches: Sequence[Stretch]) -> list[str]:
    """Say how much was left out with pieces that are too short."""
    sizes = [len(stretch) for stretch in stretches]
    kept = [len(stretch) for stretch in stretches if _is_long(stretch)]
    if not 0 < len(kept) < len(sizes):
        return []
    short = len(sizes) - len(kept)
    pieces = "1 piece between gaps is" if short == 1 else f"{short} pieces between gaps are"
    return [f"{name}: {pieces} too short to be used; {sum(kept)} of {sum(sizes)} samples remain"]
