"""The stream of samples, cut into windows that are tested, and its last seconds, for a diagnosis.

Contents: the samples that are kept, where a window may begin, when one is due.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from tissue_probe.monitoring.settings import MonitorSettings
from tissue_probe.monitoring.tested_model import TestedModel, load_tested_model
from tissue_probe.monitoring.window_test import Tested, WindowTest
from tissue_probe.signals import PalpationSite, Phase, SampleBlock

#: Fewest samples to a window: above its band there must be enough to tell the noise.
FEWEST = 64


class Monitor:
    """Tests windows of a stream.

    A window holds consecutive samples of one dwell: none lost, each finite, no announcement of a
    site between them. Where sites are announced, only samples within a dwell are tested: on the way
    from site to site the tip is lifted, which no model of one contact holds for.

    Parameters
    ----------
    settings : MonitorSettings
        Which model, windows and chance.

    Attributes
    ----------
    settings : MonitorSettings
        As given, with the model under test.
    model : TestedModel
        That model.
    untested : str
        Why the latest samples are in no window; empty where they are.
    """

    def __init__(self, settings: MonitorSettings) -> None:
        self.untested = ""
        self.take_model(settings, load_tested_model(settings))
        self._blocks: deque[SampleBlock] = deque()
        self._count = self._fresh = 0
        self._sites: list[PalpationSite] = []
        self._dwells = True

    def take_model(self, settings: MonitorSettings, model: TestedModel) -> None:
        """Test windows by another model from now on, also on the samples that are kept.

        Parameters
        ----------
        settings : MonitorSettings
            They name the model.
        model : TestedModel
            As ``load_tested_model`` returns it; compiled here, where no process has before.
        """
        _ = model.composition.kernel
        self.settings, self.model = settings, model
        self._test = WindowTest(model, settings)

    def announce(self, site: PalpationSite) -> None:
        """Note a site; it holds for the samples from its stamp on."""
        self._sites.append(site)

    def take(self, block: SampleBlock) -> Tested | None:
        """Take the next samples; return the test of the window that ends with them, if one is due.

        A block is in a window as a whole, or not at all.
        """
        self._pass_sites(block)
        if reason := self._why_not(block):
            self.untested = reason
            self._restart()
            return None
        if self._blocks and not _goes_on(self._blocks[-1], block):
            self._restart()
        self.untested = ""
        self._blocks.append(block)
        self._count += len(block)
        self._fresh += len(block)
        self._let_go(block.sample_period)
        return self._tested(block.sample_period)

    def last(self) -> SampleBlock | None:
        """Return the last samples of the present dwell, at most ``kept`` seconds; None without."""
        return _join_blocks(self._blocks) if self._blocks else None

    def _restart(self) -> None:
        self._blocks.clear()
        self._count = self._fresh = 0

    def _pass_sites(self, block: SampleBlock) -> None:
        """Begin anew, with the model's own values, at an announcement before the block's end."""
        end = block.stamp + round(1e9 * len(block) * block.sample_period)
        while self._sites and self._sites[0].stamp < end:
            self._dwells = self._sites.pop(0).phase == Phase.DWELL
            self._restart()
            self._test.forget()

    def _why_not(self, block: SampleBlock) -> str:
        if not self._dwells:
            return "the tip is between two sites"
        if not (np.isfinite(block.position).all() and np.isfinite(block.force).all()):
            return "samples are not finite: look at the cables of encoder and load cell"
        if self.settings.window < FEWEST * block.sample_period:
            return (
                f"a window of {self.settings.window:g} s has fewer than {FEWEST} samples: give a "
                "longer window"
            )
        return ""

    def _let_go(self, period: float) -> None:
        """Let go of blocks that are older than the samples that are kept."""
        most = round(self.settings.kept / period)
        while self._count - len(self._blocks[0]) >= most:
            self._count -= len(self._blocks.popleft())

    def _tested(self, period: float) -> Tested | None:
        window, step = (round(t / period) for t in (self.settings.window, self.settings.step))
        if self._fresh < step or self._count < window:
            return None
        self._fresh = 0
        whole = _join_blocks(self._blocks)
        begin = len(whole) - window
        stamp = whole.stamp + round(1e9 * begin * period)
        return self._test.test(stamp, whole.position[begin:], whole.force[begin:], period)


def _goes_on(before: SampleBlock, block: SampleBlock) -> bool:
    alike = abs(block.sample_period / before.sample_period - 1.0) < 1e-6
    return alike and block.sequence == before.sequence + len(before)


def _join_blocks(blocks: Sequence[SampleBlock]) -> SampleBlock:
    first = blocks[0]
    channels = (
        np.concatenate([getattr(block, name) for block in blocks])
        for name in ("position", "force", "command")
    )
    return SampleBlock(first.stamp, first.sequence, first.sample_period, *channels)
