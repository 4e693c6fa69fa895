"""The page on challenges tells everything that is hidden."""

from __future__ import annotations

import re
from pathlib import Path

from tissue_probe.challenge import SIMULATED_EFFECTS
from tissue_probe.challenge.series import SHARES
from tissue_probe.challenge.trajectory import DURATIONS

PAGE = (Path(__file__).parents[2] / "docs" / "challenge.md").read_text(encoding="utf-8")


def test_every_effect_excitation_and_choice_is_in_the_page():
    named = set(re.findall(r"`(\w+)`", PAGE))
    assert set(SIMULATED_EFFECTS) | set(DURATIONS) | set(SHARES) <= named
    shares = ", ".join(f"{100 * share:g}" for share in list(SHARES.values())[:-1])
    assert f"{shares} and {100 * list(SHARES.values())[-1]:g} %" in " ".join(PAGE.split())
    assert ", ".join(list(SHARES)) in " ".join(PAGE.split())
