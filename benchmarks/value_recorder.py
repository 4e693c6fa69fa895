"""The recorder as it was when it recorded each estimate four times: whole, and number by number.

Contents: the other side of a comparison (``live``).
"""

from __future__ import annotations

from tissue_probe.nodes import recorder
from tissue_probe.nodes.repeats import SINGLE_VALUES, repeats


def _repeats_but_for_values(topics):
    return {topic for topic in repeats(topics) if not topic.endswith(SINGLE_VALUES)}


if __name__ == "__main__":
    recorder.repeats = _repeats_but_for_values
    raise SystemExit(recorder.main())
