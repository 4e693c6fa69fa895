"""How far a recording reaches."""

from __future__ import annotations

from dataclasses import dataclass

from tissue_probe.physics.scale import Scale

#: The slowest rate at which a branch relaxes, times a record's duration: it gives way by a quarter
#: then, and one that is slower is as good as a spring, or as a zero of the force that moves.
SLOWEST_RELAXATION = 0.3


@dataclass(frozen=True)
class Extent:
    """How far a recording reaches: an effect needs it to propose where a search begins.

    ``duration`` [s]; ``indentation`` [m] (half the coil's travel), ``depth`` [m] (the farthest that
    it goes) and ``speed`` [m/s] (largest); ``force`` [N] (standard deviation); ``pull`` [N]
    (largest force in tension); ``step`` [m] (smallest difference between two positions, 0 where
    there is no common one); ``tensions`` [N] (the peaks of the tension in the tissue, if it never
    let go of the tip; largest first); ``left_at`` [rad/s] (angular frequency at which a fitted
    model leaves most; 0 where that is not known).
    """

    duration: float
    indentation: float
    depth: float
    speed: float
    force: float
    pull: float
    step: float
    tensions: tuple[float, ...] = ()
    left_at: float = 0.0

    @property
    def frequency(self) -> float:
        """Angular frequency of the motion [rad/s]: of the sine as fast and as wide."""
        return self.speed / self.indentation

    def over(self, scale: Scale) -> Extent:
        """Return the same in units of which a scale says how large they are."""
        return Extent(
            duration=self.duration / scale.time,
            indentation=self.indentation / scale.length,
            depth=self.depth / scale.length,
            speed=self.speed / scale.of("m/s"),
            force=self.force / scale.force,
            pull=self.pull / scale.force,
            step=self.step / scale.length,
            tensions=tuple(each / scale.force for each in self.tensions),
            left_at=self.left_at * scale.time,
        )
