"""Model files, phantoms and calibrations with bytes changed: read, or refused in words."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tissue_probe.configuration import stock_configuration
from tissue_probe.devices.calibration import Calibration
from tissue_probe.physics.composition import Composition
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.physics.model_file import load, save
from tissue_probe.physics.phantom import Phantom

READERS = {"model": load, "phantom": Phantom.load, "calibration": Calibration.load}
WORDS = (
    b"&a ", b"*a", b"<<: ", b"!!int ", b"!!python/object/apply:os.system [false]", b".nan",
    b"1e400", b"null", b"[]", b"{}", b"[[", b"- ", b"? ", b": ", b"0x" + 400 * b"f", b"2026-13-45",
    b"file: own.py", b"name: own", b"\n", b"\x00", b"\xff", b"\\uD800", b'"\\uD800"', b"true",
)  # fmt: skip


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> dict[str, bytes]:
    """A sound file of each kind."""
    composition = Composition(effects=(EFFECTS["cubic_stiffening"],))
    path = tmp_path_factory.mktemp("whole") / "model.yaml"
    save(path, composition, {entry.name: entry.default for entry in composition.values}, {})
    stock = {name: stock_configuration(f"{name}.yaml") for name in ("phantom", "calibration")}
    return {name: path.read_bytes() for name, path in {"model": path, **stock}.items()}


changes = st.lists(
    st.tuples(st.floats(0, 1), st.integers(0, 30), st.sampled_from(WORDS) | st.binary(max_size=6)),
    min_size=1,
    max_size=4,
)


@pytest.mark.parametrize("name", READERS)
@given(changes)
@settings(max_examples=150, suppress_health_check=list(HealthCheck))
def test_a_corrupted_file_is_read_or_refused_in_words_and_runs_nothing(
    name, whole, tmp_path_factory, made
):
    content, path = whole[name], tmp_path_factory.getbasetemp() / f"{name}_corrupted.yaml"
    ran = path.with_name("ran")
    path.with_name("own.py").write_text(f"open({str(ran)!r}, 'w')")
    for place, taken, word in made:
        at = round(place * len(content))
        content = content[:at] + word + content[at + taken :]
    path.write_bytes(content)
    told = str(path)
    try:
        READERS[name](path)
    except ValueError as error:
        told = str(error)
    assert told.startswith(str(path))
    assert len(told) < len(str(path)) + 2000
    assert not ran.exists()
