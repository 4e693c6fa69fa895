"""``make hidden-effect-live`` in a short form: without the monitor, and one record."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture
def example(monkeypatch):
    monkeypatch.syspath_prepend(EXAMPLES)
    import hidden_effect_live

    yield hidden_effect_live
    sys.modules.pop("hidden_effect_live")


@pytest.mark.slow
@pytest.mark.crowded
@pytest.mark.timeout(300)
def test_a_hidden_effect_is_found_and_the_new_model_leaves_noise_only(example, tmp_path, capsys):
    result = example.run("cubic_stiffening", tmp_path, records=1, monitored=False)
    assert result.effects[0] == "cubic_stiffening"
    told = capsys.readouterr().out
    before, after = map(float, re.search(r"rms: (\S+) before, (\S+) with", told).groups())
    assert before > 3.0
    assert 0.8 < after < 1.2
    assert (tmp_path / "innovations.png").read_bytes().startswith(b"\x89PNG")


def test_an_effect_that_is_not_there_is_told(example, tmp_path):
    with pytest.raises(example.SessionError, match="there is no effect magic; there are "):
        example.run("magic", tmp_path)
