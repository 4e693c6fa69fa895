"""A table is found in a text however it is written, or refused in one sentence."""

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from tissue_probe.recording.any_file import read_any
from tissue_probe.recording.columns.open_columns import open_columns
from tissue_probe.recording.errors import RecordingError
from tissue_probe.recording.layout import Layout

ROWS = 300
TIME = np.arange(ROWS) * 1e-3
POSITION = 1e-3 * np.sin(2.0 * np.pi * 10.0 * TIME)
FORCE = 450.0 * POSITION

UNITS = {
    "position": {"m": 1.0, "mm": 1e-3, "µm": 1e-6, "nm": 1e-9},
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": 4.4482216152605, "gf": 9.80665e-3},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0},
}
PREAMBLES = [
    [],
    ["Results Table 1", ",Maximum Load (N)", "1,0.55", "", ""],
    ["LabVIEW Measurement", "Writer_Version\t2", "***End_of_Header***", ""],
    ["Prüfer: Müller", "Datum: 27.11.2026", ""],
    ["# a comment", "# another"],
]


@st.composite
def writings(draw):
    separator = draw(st.sampled_from([",", ";", "\t", " "]))
    decimal = draw(st.sampled_from([".", ","] if separator != "," else ["."]))
    return {
        "separator": separator,
        "decimal": decimal,
        "encoding": draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "cp1252"])),
        "end": draw(st.sampled_from(["\n", "\r\n", "\r"])),
        "quoted": draw(st.booleans()) if separator != " " else False,
        "preamble": draw(st.sampled_from(PREAMBLES)),
        "footer": draw(st.sampled_from([[], ["End of test"], ["", "stopped by hand"]])),
        "units": {role: draw(st.sampled_from(sorted(UNITS[role]))) for role in UNITS},
        "where": draw(st.sampled_from(["row", "bracket", "paren", "suffix"])),
        "again": draw(st.booleans()),
    }


def written(path, wrote):
    mark = wrote["separator"]
    units = wrote["units"]
    names = {"time": "Time", "position": "Extension", "force": "Load"}
    pattern = {"row": "{}", "bracket": "{}[{}]", "paren": "{}({})", "suffix": "{}_{}"}
    header = [pattern[wrote["where"]].format(names[role], units[role]) for role in names]
    columns = {"time": TIME, "position": POSITION, "force": FORCE}
    numbers = [columns[role] / UNITS[role][units[role]] for role in columns]

    def line(cells):
        return mark.join(f'"{cell}"' if wrote["quoted"] else cell for cell in cells)

    rows = [
        line([f"{value:.15e}".replace(".", wrote["decimal"]) for value in row])
        for row in zip(*numbers, strict=True)
    ]
    head = [line(header)]
    if wrote["where"] == "row":
        head.append(line([units[role] for role in columns]))
    if wrote["again"]:
        rows = rows[:100] + head + rows[100:]
    text = wrote["end"].join([*wrote["preamble"], *head, *rows, *wrote["footer"], ""])
    path.write_bytes(text.encode(wrote["encoding"]))
    return path, len(head)


@given(wrote=writings())
@settings(max_examples=25, deadline=None)
def test_a_true_table_reads_back_however_it_is_written(wrote, tmp_path_factory):
    path, header = written(tmp_path_factory.mktemp("t") / "x.txt", wrote)
    recording, notes = read_any(path, Layout(force_polarity="compression"))
    (block,) = recording.blocks
    assert block.sample_period == pytest.approx(1e-3)
    assert_allclose(block.position, POSITION, rtol=1e-12, atol=1e-18)
    assert_allclose(block.force, FORCE, rtol=1e-12, atol=1e-15)
    said = notes[0]
    if wrote["again"]:
        assert f"{header} row{'s' if header > 1 else ''} left out: line" in said
    if wrote["decimal"] == ",":
        assert "decimal commas" in said
    if wrote["footer"]:
        assert "below the table: line" in said


def text(path, *lines):
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def rows(mark=","):
    return [mark.join(f"{v:.6f}" for v in row) for row in zip(TIME, POSITION, FORCE, strict=True)]


@pytest.mark.parametrize(
    ("header", "row", "said"),
    [
        ("t,u,F", "0.3,0.1", "line 52: 2 cells, but the table has 3 columns"),
        ("t,u,F", "0.3,0.1,5,4", "line 52: 4 cells, but the table has 3 columns"),
        ("t,u,F", "0.3,0.1,heavy", "line 52: column F is 'heavy'; give a number"),
        ("t,u,F", "and now something else", "line 52: no row of the table, and rows follow"),
        ("t,u", None, "line 2 has 3 cells, the header names 2 columns"),
    ],
)
def test_a_row_that_does_not_fit_is_refused_with_its_line(header, row, said, tmp_path):
    lines = rows()
    if row:
        lines.insert(50, row)
    with pytest.raises(RecordingError) as raised:
        read_any(text(tmp_path / "x.csv", header, *lines), Layout())
    assert said in str(raised.value)


@pytest.mark.parametrize("comment", ["# a comment", "# of, three, cells", "% three blank cells"])
def test_a_comment_within_a_table_does_not_end_it(comment, tmp_path):
    """However many cells it may be cut into."""
    lines = rows()
    lines.insert(50, comment)
    recording, notes = read_any(text(tmp_path / "x.csv", "t,u,F", *lines), Layout())
    assert len(recording) == ROWS
    assert "1 row left out: line 52" in notes[0]


def test_a_time_that_comes_twice_is_told_with_its_line(tmp_path):
    """Lines count from the file's first, with the preamble, comments and blank lines."""
    lines = rows()
    lines[100] = lines[99]
    lines.insert(50, "# a comment")
    lines.insert(20, "")
    path = text(tmp_path / "x.csv", "a preamble", "", "t,u,F", *lines)
    with pytest.raises(RecordingError, match=r"line 106 \(t = 0\.099 s\): a time not later"):
        read_any(path, Layout())


def test_a_time_that_comes_twice_far_down_is_told_with_its_line(tmp_path):
    """Of a file of many blocks, whose rows were not kept as text."""
    count = 400_000
    lines = [f"{n * 1e-3:.3f},{n % 7},{n % 5}" for n in range(count)]
    lines[count - 1] = lines[count - 2]
    lines.insert(9, "")
    path = text(tmp_path / "x.csv", "t,u,F", *lines)
    with pytest.raises(RecordingError, match=rf"line {count + 2} "):
        read_any(path, Layout())


def test_commas_between_cells_and_within_numbers_are_refused(tmp_path):
    lines = [row.replace(".", ",") for row in rows()]
    with pytest.raises(RecordingError, match="are commas both between cells and within numbers"):
        read_any(text(tmp_path / "x.csv", "t,u,F", *lines), Layout())


def test_a_table_without_a_header_is_read_by_the_numbers_of_its_columns(tmp_path):
    path = text(tmp_path / "x.csv", *rows())
    with pytest.raises(RecordingError, match="no header line that names its columns: state which"):
        read_any(path, Layout())
    stated = Layout(
        position="2",
        force="3",
        time="1",
        position_unit="m",
        force_unit="N",
        force_polarity="compression",
    )
    assert_allclose(read_any(path, stated)[0].position, POSITION, atol=1e-6)


@pytest.mark.parametrize(
    "line", ["Position (z), mm", "Position (z) [mm]", "Position / mm", "Position in mm"]
)
def test_units_are_read_out_of_names_as_people_write_them(line, tmp_path):
    lines = ["\t".join((f"{t:.6f}", f"{1e3 * u:.9f}", f"{1e-3 * f:.12f}")) for t, u, f in zip(
        TIME, POSITION, FORCE, strict=True
    )]  # fmt: skip
    path = text(tmp_path / "x.txt", f"Time, s\t{line}\tLoad (kN)", *lines)
    recording, _ = read_any(path, Layout(force_polarity="compression"))
    assert_allclose(recording.position, POSITION, atol=1e-12)
    assert_allclose(recording.force, FORCE, atol=1e-9)


START = np.datetime64("2026-03-01T23:59:59.900", "ns")


@pytest.mark.parametrize(
    ("name", "times"),
    [
        ("time", [str(START + np.timedelta64(n, "ms")) for n in range(ROWS)]),
        ("time", [f"{START + np.timedelta64(n, 'ms')}Z".replace("T", " ") for n in range(ROWS)]),
        ("time", [str(START + np.timedelta64(n, "ms"))[11:] for n in range(ROWS)]),
        ("time", [str(START + np.timedelta64(n, "ms"))[14:] for n in range(ROWS)]),
        ("t", [str(1772409597000 + n) for n in range(ROWS)]),
        ("t", [str(1772409597_000000 + 1000 * n) for n in range(ROWS)]),
        ("t", [str(1772409597_000000000 + 1000000 * n) for n in range(ROWS)]),
        ("t", [f"{1772409597 + 1e-3 * n:.3f}" for n in range(ROWS)]),
        ("t_ms", [str(n) for n in range(ROWS)]),
        ("Time (min)", [f"{n / 60000:.12f}" for n in range(ROWS)]),
        ("t_us", [str((2**32 - 100_000 + 1000 * n) % 2**32) for n in range(ROWS)]),
    ],
)
def test_times_are_read_as_recorders_write_them(name, times, tmp_path):
    lines = [",".join((t, f"{u:.9f}", f"{f:.9f}")) for t, u, f in zip(
        times, POSITION, FORCE, strict=True
    )]  # fmt: skip
    (block,) = read_any(text(tmp_path / "x.csv", f"{name},u,F", *lines), Layout())[0].blocks
    assert len(block) == ROWS
    assert block.sample_period == pytest.approx(1e-3, rel=1e-6)


def test_whole_times_without_a_unit_are_refused_until_it_is_stated(tmp_path):
    lines = [f"{n},{u:.9f},{f:.9f}" for n, (u, f) in enumerate(zip(POSITION, FORCE, strict=True))]
    path = text(tmp_path / "x.csv", "t,u,F", *lines)
    with pytest.raises(RecordingError, match="counts whole numbers and tells no unit"):
        read_any(path, Layout())
    (block,) = read_any(path, Layout(time_unit="ms"))[0].blocks
    assert block.sample_period == pytest.approx(1e-3)


@pytest.mark.parametrize("time", ["0", "0.5", "1700000000"])
def test_times_that_stand_still_are_told(tmp_path, time):
    lines = [f"{time},{u:.9f},{f:.9f}" for u, f in zip(POSITION, FORCE, strict=True)]
    path = text(tmp_path / "x.csv", "t,u,F", *lines)
    with pytest.raises(RecordingError, match=r"time stands still: column t is .* in every row"):
        read_any(path, Layout())


@pytest.mark.parametrize("empty", ["u", "F"])
@pytest.mark.parametrize("value", ["nan", "inf", ""])
def test_a_column_without_a_number_is_named(tmp_path, empty, value):
    lines = [
        f"{t:.4f},{value if empty == 'u' else u},{value if empty == 'F' else f}"
        for t, u, f in zip(TIME, POSITION, FORCE, strict=True)
    ]
    path = text(tmp_path / "x.csv", "t,u,F", *lines)
    with pytest.raises(RecordingError, match=rf"column {empty}\b.*no number"):
        read_any(path, Layout())


def test_a_counter_that_wraps_is_counted_on_and_it_is_said(tmp_path):
    counts = np.rint(np.linspace(0.0, 1e5, ROWS) + 2e3 * np.sin(TIME * 60.0))
    wrapped = (counts + 2**15) % 2**16 - 2**15
    lines = [f"{t:.4f},{int(u)},{f:.6f}" for t, u, f in zip(TIME, wrapped, FORCE, strict=True)]
    path = text(tmp_path / "x.csv", "t,enc,F", *lines)
    recording, notes = read_any(path, Layout(position="enc", position_unit="1e-6"))
    assert_allclose(np.diff(recording.position), 1e-6 * np.diff(counts), atol=1e-12)
    assert "counter of 16 bits" in notes[0]


def test_a_held_position_is_thinned_and_its_doubt_kept(tmp_path):
    held = np.repeat(1e-3 * np.sin(2.0 * np.pi * 2.0 * TIME[::5]), 5)
    noise = 1e-3 * np.random.default_rng(2).standard_normal(ROWS)
    lines = [f"{t:.4f},{u:.9f},{f:.9f}" for t, u, f in zip(TIME, held, FORCE + noise, strict=True)]
    recording, notes = read_any(text(tmp_path / "x.csv", "t,u,F", *lines), Layout())
    (block,) = recording.blocks
    assert (len(block), block.sample_period) == (ROWS // 5, pytest.approx(5e-3))
    assert recording.time_doubt == pytest.approx(5e-3)
    assert "the position repeats old values" in notes[0]
    assert "the damping is known to the stiffness times that only" in notes[0]


def test_a_velocity_is_integrated_and_it_is_said(tmp_path):
    speed = 2.0 * np.pi * 10.0 * 1.0 * np.cos(2.0 * np.pi * 10.0 * TIME)  # mm/s
    lines = [f"{t:.4f},{v:.9f},{f:.9f}" for t, v, f in zip(TIME, speed, FORCE, strict=True)]
    path = text(tmp_path / "x.csv", "t,v,F", *lines)
    recording, notes = read_any(path, Layout(position="v", position_unit="mm/s"))
    assert_allclose(recording.position, POSITION, atol=2e-6)
    assert "is a velocity, integrated" in notes[0]


def test_a_name_without_its_unit_is_enough_to_name_a_column(tmp_path):
    path = text(tmp_path / "x.csv", "t,Fz (N),tip (m)", *rows())
    layout = Layout(position="tip", force="Fz", force_polarity="compression")
    assert_allclose(read_any(path, layout)[0].force, POSITION, atol=1e-6)


def test_a_unit_that_contradicts_the_files_own_is_taken_and_told(tmp_path):
    path = text(tmp_path / "x.csv", "Time (s),Fz (N),tip (m)", *rows())
    stated = Layout(force_polarity="compression", position="tip", force="Fz", position_unit="mm")
    recording, notes = read_any(path, stated)
    assert_allclose(recording.force, POSITION, atol=1e-6)
    assert "position is taken in mm, as `position_unit` states, and not in m" in notes[0]
    as_told = Layout(force_polarity="compression", position="tip", force="Fz", position_unit="m")
    assert "states" not in read_any(path, as_told)[1][0]


def test_two_columns_that_may_be_meant_are_refused(tmp_path):
    lines = [f"{row},1.0" for row in rows()]
    path = text(tmp_path / "x.csv", "Time (s),Stroke (mm),Load (N),Extension (mm)", *lines)
    with pytest.raises(RecordingError, match="several columns that may be the position: Stroke"):
        read_any(path, Layout(force_polarity="compression"))


def test_bursts_of_unknown_values_cost_their_own_samples(tmp_path):
    lines = [f"{line.split(',')[0]},," if n % 60 < 5 else line for n, line in enumerate(rows())]
    recording, _ = read_any(text(tmp_path / "x.csv", "t,u,F", *lines), Layout())
    assert np.isfinite(recording.position).sum() == sum(n % 60 >= 5 for n in range(ROWS))


@given(damage=st.data())
@settings(max_examples=30, deadline=None)
def test_no_damage_to_a_text_ends_otherwise_than_in_a_sentence(damage, tmp_path_factory):
    path, _ = written(tmp_path_factory.mktemp("t") / "x.csv", damage.draw(writings()))
    content = bytearray(path.read_bytes())
    for _ in range(damage.draw(st.integers(0, 5))):
        content[damage.draw(st.integers(0, len(content) - 1))] = damage.draw(st.integers(0, 255))
    path.write_bytes(content[: damage.draw(st.integers(0, len(content)))])
    with suppress(ValueError):  # a sentence; what is no ValueError would be a traceback
        read_any(path, Layout(force_polarity="compression"))


@given(content=st.binary(max_size=400))
@settings(max_examples=30, deadline=None)
def test_random_bytes_end_in_a_sentence(content, tmp_path_factory):
    path = tmp_path_factory.mktemp("t") / "x.csv"
    path.write_bytes(content)
    with suppress(RecordingError):
        columns = open_columns(path)
        columns.read(columns.names)
