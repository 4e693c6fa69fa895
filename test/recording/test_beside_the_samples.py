"""What stands beside the samples is used or refused, never dropped: every reader, each kind of it.

A cell of the grid is read rightly, to the spline's error, or refused in a sentence; the table
says which. What a format cannot hold is not in it.
"""

import numpy as np
import pytest
from h5py import File
from nptdms import ChannelObject, TdmsWriter
from pyarrow import Table, field, float64, parquet, schema
from scipy.io import savemat

import tissue_probe as tp
from benchmarks.written_tables import xlsx

RATE, COUNT, LATE = 250.0, 1000, 0.037
TIME = np.arange(COUNT) / RATE
BEGIN = np.datetime64("2026-03-02T09:15:20", "us")


def motion(time):
    return 1e-3 * (2.0 + np.sin(2 * np.pi * 2.0 * time) + 0.4 * np.sin(2 * np.pi * 5.3 * time))


def force(time):
    return 320.0 * motion(time) + 6.0 * (motion(time + 1e-6) - motion(time - 1e-6)) / 2e-6


def text(path, rows, header, *, above=(), mark=",", end="\n"):
    lines = [mark.join(f"{value:.9g}" for value in row) for row in rows]
    path.write_text("\n".join([*above, *header, *lines]) + end)


def tdms(path, channels):
    with TdmsWriter(path) as writer:
        writer.write_segment(
            [ChannelObject("Run", name, values, told) for name, values, told in channels]
        )


def lvm(path, *, x_columns, tags, names, rows):
    head = ["LabVIEW Measurement", "Separator\tTab", f"X_Columns\t{x_columns}", "Date\t2026/03/02"]
    told = [f"{tag}\t{one}\t{other}" for tag, (one, other) in tags.items()]
    above = [*head, "***End_of_Header***", "", "Channels\t2", *told, "***End_of_Header***"]
    blank = [""] if x_columns == "No" else []  # the header names X_Value all the same
    path.write_text("\n".join([*above, names, *("\t".join([*blank, *row]) for row in rows), ""]))
    return path


def spelt(*columns):
    return [tuple(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]


def workbook(path, **sheets):
    def cell(value):
        if isinstance(value, str):
            return f'<c t="inlineStr"><is><t>{value}</t></is></c>'
        return f"<c><v>{value!r}</v></c>"

    rows = {
        name: [f"<row>{''.join(map(cell, row))}</row>" for row in rows]
        for name, rows in sheets.items()
    }
    xlsx(path, rows)


def rows_of(time=TIME):
    return np.column_stack([time, motion(time), force(time)]).tolist()


# Starts that differ.


def start_csv(path):
    """Each channel with its own column of times; which counts must be said."""
    text(path, zip(TIME, motion(TIME), TIME + LATE, force(TIME + LATE), strict=True),
         ["Time,Position [m],Time,Force [N]"])  # fmt: skip


def start_lvm_columns(path):
    columns = TIME, 1e3 * motion(TIME), TIME + LATE, force(TIME + LATE)
    lvm(path, x_columns="Multi", tags={"Y_Unit_Label": ("mm", "N")},
        names="X_Value\tStroke\tX_Value\tLoad\tComment", rows=spelt(*columns))  # fmt: skip


def start_lvm_header(path):
    step, clock = f"{1 / RATE:.6f}", ("09:15:20.5", f"09:15:{20.5 + LATE:.6f}")
    tags = {"Y_Unit_Label": ("mm", "N"), "Date": ("2026/03/02",) * 2, "Time": clock,
            "X0": ("0.0", "0.0"), "Delta_X": (step, step)}  # fmt: skip
    lvm(path, x_columns="No", tags=tags, names="X_Value\tStroke\tLoad\tComment",
        rows=spelt(1e3 * motion(TIME), force(TIME + LATE)))  # fmt: skip


def start_lvm_of_one_column(path):
    """Its only column of times belongs to the first channel."""
    step = f"{1 / RATE:.6f}"
    tags = {"Y_Unit_Label": ("mm", "N"), "Date": ("2026/03/02",) * 2, "Delta_X": (step, step),
            "Time": ("09:15:20.5",) * 2, "X0": ("0.0", f"{LATE}")}  # fmt: skip
    lvm(path, x_columns="One", tags=tags, names="X_Value\tStroke\tLoad\tComment",
        rows=spelt(TIME, 1e3 * motion(TIME), force(TIME + LATE)))  # fmt: skip


def start_lvm_relative_columns(path):
    """Each column of times counts from when its channel began."""
    tags = {"Y_Unit_Label": ("mm", "N"), "Date": ("2026/03/02",) * 2,
            "Time": ("09:15:20.5", f"09:15:{20.5 + LATE:.6f}")}  # fmt: skip
    columns = TIME, 1e3 * motion(TIME), TIME, force(TIME + LATE)
    lvm(path, x_columns="Multi", tags=tags, names="X_Value\tStroke\tX_Value\tLoad\tComment",
        rows=spelt(*columns))  # fmt: skip


def _start_tdms(path, of_position, of_force, *others):
    step = {"wf_increment": 1 / RATE}
    tdms(path, [("Stroke", motion(TIME), {**step, **of_position, "unit_string": "m"}),
                ("Load", force(TIME + LATE), {**step, **of_force, "unit_string": "N"}),
                *others])  # fmt: skip


def start_tdms_of_one_offset(path):
    _start_tdms(path, {}, {"wf_start_offset": LATE})


def start_tdms_of_one_date(path):
    _start_tdms(path, {}, {"wf_start_time": BEGIN})


def start_tdms_beside_times(path):
    _start_tdms(path, {}, {"wf_start_offset": LATE}, ("Time", TIME, {"unit_string": "s"}))


def start_tdms(path):
    late = BEGIN + np.timedelta64(round(1e6 * LATE), "us")
    step = {"wf_increment": 1 / RATE}
    tdms(path, [
        ("Stroke", motion(TIME), {**step, "wf_start_time": BEGIN, "unit_string": "m"}),
        ("Load", force(TIME + LATE), {**step, "wf_start_time": late, "unit_string": "N"}),
    ])  # fmt: skip


def start_hdf5(path):
    with File(path, "w") as file:
        for name, times, values in (("position", TIME, motion), ("force", TIME + LATE, force)):
            file[f"{name}/time"], file[f"{name}/value"] = times, values(times)


def start_mat(path):
    savemat(path, {"position_time": TIME, "position": motion(TIME),
                   "force_time": TIME + LATE, "force": force(TIME + LATE)})  # fmt: skip


# Rates that differ: the position is told more seldom than the force.


def rate_csv(path):
    """A blank where the position is not updated."""
    moved = [f"{u:.9g}" if row % 5 == 0 else "" for row, u in enumerate(motion(TIME))]
    rows = zip(TIME, moved, force(TIME), strict=True)
    path.write_text("\n".join(["t,u,F", *(f"{t:.9g},{u},{f:.9g}" for t, u, f in rows)]) + "\n")


def rate_lvm(path):
    tags = {"Y_Unit_Label": ("mm", "N"), "Delta_X": (f"{2 / RATE:.6f}", f"{1 / RATE:.6f}")}
    moved = [f"{1e3 * u:.9g}" for u in motion(TIME[::2])] + [""] * (COUNT // 2)
    lvm(path, x_columns="No", tags=tags, names="X_Value\tStroke\tLoad\tComment",
        rows=list(zip(moved, (f"{f:.9g}" for f in force(TIME)), strict=True)))  # fmt: skip


def rate_tdms(path):
    tdms(path, [
        ("Stroke", motion(TIME[::2]), {"wf_increment": 2 / RATE, "unit_string": "m"}),
        ("Load", force(TIME), {"wf_increment": 1 / RATE, "unit_string": "N"}),
    ])  # fmt: skip


def rate_arrays(path):
    np.savez(path, t=TIME, u=motion(TIME[::2]), F=force(TIME))


def rate_mat(path):
    savemat(path, {"t": TIME, "u": motion(TIME[::2]), "F": force(TIME)})


def rate_hdf5(path):
    with File(path, "w") as file:
        file["t"], file["u"], file["F"] = TIME, motion(TIME[::2]), force(TIME)


# Units that differ: the position in millimetres, told beside the samples; and one of no use.


def unit_csv(path):
    text(path, zip(TIME, 1e3 * motion(TIME), force(TIME), strict=True), ["t,u,F", "s,mm,N"])


def unit_lvm(path):
    lvm(path, x_columns="One", tags={"Y_Unit_Label": ("mm", "N")},
        names="X_Value\tStroke\tLoad\tComment",
        rows=spelt(TIME, 1e3 * motion(TIME), force(TIME)))  # fmt: skip


def unit_lvm_unknown(path):
    lvm(path, x_columns="One", tags={"Y_Unit_Label": ("mm", "Volts")},
        names="X_Value\tStroke\tLoad\tComment",
        rows=spelt(TIME, 1e3 * motion(TIME), force(TIME)))  # fmt: skip


def unit_tdms(path):
    step = {"wf_increment": 1 / RATE}
    tdms(path, [("Stroke", 1e3 * motion(TIME), {**step, "unit_string": "mm"}),
                ("Load", force(TIME), {**step, "unit_string": "N"})])  # fmt: skip


def unit_tdms_unknown(path):
    step = {"wf_increment": 1 / RATE}
    tdms(path, [("Stroke", motion(TIME), {**step, "unit_string": "m"}),
                ("Load", force(TIME), {**step, "unit_string": "V"})])  # fmt: skip


def _unit_hdf5(path, unit):
    with File(path, "w") as file:
        file["t"], file["u"], file["F"] = TIME, 1e3 * motion(TIME), force(TIME)
        file["u"].attrs["units"] = unit


def unit_hdf5(path):
    _unit_hdf5(path, "mm")


def unit_hdf5_unknown(path):
    _unit_hdf5(path, "furlong")


def _unit_parquet(path, unit):
    columns = [field("t", float64()), field("u", float64(), metadata={"unit": unit}),
               field("F", float64())]  # fmt: skip
    arrays = [TIME, 1e3 * motion(TIME), force(TIME)]
    parquet.write_table(Table.from_arrays(arrays, schema=schema(columns)), path)


def unit_hdf5_array(path):
    _unit_hdf5(path, "mm")
    with File(path, "a") as file:
        del file["u"].attrs["units"]
        file["u"].attrs["Units"] = np.array([b"mm"])


def unit_named_otherwise(path):
    text(path, zip(TIME, 1e6 * motion(TIME), force(TIME), strict=True),
         ["t,Position_um,F", "s,mm,N"])  # fmt: skip


def unit_parquet(path):
    _unit_parquet(path, "mm")


def unit_parquet_unknown(path):
    _unit_parquet(path, "furlong")


def unit_xlsx(path):
    rows = np.column_stack([TIME, 1e3 * motion(TIME), force(TIME)]).tolist()
    workbook(path, data=[["t", "u", "F"], ["s", "mm", "N"], *rows])


# A second block.


def _blocks(path, second):
    header = ["Time, s\tPosition, mm\tLoad, N"]
    lines = ["\t".join(row) for row in spelt(TIME, 1e3 * motion(TIME), force(TIME))]
    anew = [f"{t:.9g}\t{1e3 * u:.9g}\t{f:.9g}" for t, u, f in second]
    path.write_text("\n".join([
        "<Machine File>", "<DATA>", *header, *lines[:200], "<END DATA>", "", "<Wait>",
        "Axis:\tPosition (z)", "Rate\t100\t200", "<DATA>", *header, *anew, "<END DATA>", "",
    ]))  # fmt: skip


def block_csv(path):
    """Times begin anew with each block."""
    _blocks(path, [(t - TIME[200], u, f) for t, u, f in rows_of()[200:]])


def block_csv_going_on(path):
    _blocks(path, rows_of()[200:])


def block_csv_of_another_kind(path):
    """A table of other columns below the samples."""
    rows = [",".join(row) for row in spelt(TIME, motion(TIME), force(TIME))]
    below = ["", "cycle,peak", "1,0.5", "2,0.6", ""]
    path.write_text("\n".join(["t,u,F", *rows, *below]))


def block_csv_without_text(path):
    """The header comes again by itself, in capitals."""
    rows = [",".join(row) for row in spelt(TIME, motion(TIME), force(TIME))]
    anew = [",".join(row) for row in spelt(TIME[:800], motion(TIME[200:]), force(TIME[200:]))]
    path.write_text("\n".join(["Time [s],Position [m],Force [N]", *rows[:200],
                               "TIME [S],POSITION [M],FORCE [N]", *anew, ""]))  # fmt: skip


def block_csv_with_numbered_text(path):
    """Between the blocks stand words with as many numbers as a row has cells."""
    block_csv_without_text(path)
    path.write_text(path.read_text().replace("TIME [S]", "Step,2,3\nDuration,5\nTIME [S]"))


def _block_lvm_of(path, second, clock):
    tags = {"Date": ("2026/03/02",) * 2, "Time": ("09:15:20.5",) * 2, "Y_Unit_Label": ("mm", "N"),
            "Delta_X": ("0.004", "0.004")}  # fmt: skip
    names = "X_Value\tStroke\tLoad\tComment"
    rows = spelt(TIME, 1e3 * motion(TIME), force(TIME))
    lvm(path, x_columns="One", tags=tags, names=names, rows=rows[:200])
    tags |= {"Y_Unit_Label": second, "Time": (clock,) * 2}
    told = [f"{tag}\t{one}\t{other}" for tag, (one, other) in tags.items()]
    more = ["", "Channels\t2", *told, "***End_of_Header***", names]
    anew = [
        ("\t".join(row)) for row in spelt(TIME[:800], 1e3 * motion(TIME[200:]), force(TIME[200:]))
    ]
    with path.open("a") as file:
        file.write("\n".join([*more, *anew, ""]))


def block_lvm_of_other_units(path):
    _block_lvm_of(path, ("um", "N"), "09:15:21.3")


def block_lvm_by_its_clock(path):
    _block_lvm_of(path, ("mm", "N"), "09:15:21.3")


def block_lvm_with_comments(path):
    unit_lvm(path)
    lines = path.read_text().split("\n")
    lines[-300] += "\ta remark"
    path.write_text("\n".join(lines))


def block_lvm(path):
    tags = {"Y_Unit_Label": ("mm", "N"), "X0": ("0.0", "0.0"), "Delta_X": ("0.004", "0.004")}
    names = "X_Value\tStroke\tLoad\tComment"
    rows = spelt(TIME, 1e3 * motion(TIME), force(TIME))
    lvm(path, x_columns="One", tags=tags, names=names, rows=rows[:200])
    told = [f"{tag}\t{one}\t{other}" for tag, (one, other) in tags.items()]
    more = ["", "Channels\t2", *told, "***End_of_Header***", names]
    with path.open("a") as file:
        file.write("\n".join([*more, *("\t".join(row) for row in rows[200:]), ""]))


def block_xlsx(path):
    header = ["t", "u", "F"]
    rows = rows_of()
    workbook(path, data=[header, *rows[:200], ["pause"], [], header, *rows[200:]])


def block_xlsx_sheets(path):
    header, rows = ["t", "u", "F"], rows_of()
    workbook(path, one=[header, *rows[:200]], two=[header, *rows[200:]])


def block_tdms(path):
    told = {"wf_increment": 1 / RATE, "unit_string": "m"}
    with TdmsWriter(path) as writer:
        for group, part in (("Step 1", TIME[:200]), ("Step 2", TIME[200:])):
            writer.write_segment([ChannelObject(group, "Stroke", motion(part), told),
                                  ChannelObject(group, "Load", force(part), told)])  # fmt: skip


def block_hdf5(path):
    with File(path, "w") as file:
        for group, part in (("one", TIME[:200]), ("two", TIME[200:])):
            file[f"{group}/t"], file[f"{group}/u"], file[f"{group}/F"] = (
                part, motion(part), force(part))  # fmt: skip


def block_mat(path):
    savemat(path, {each: {"t": part, "u": motion(part), "F": force(part)}
                   for each, part in (("one", TIME[:200]), ("two", TIME[200:]))})  # fmt: skip


# A last row half written.


def half_cell(path):
    text(path, rows_of()[:-1], ["t,u,F"], end="\n3.996,0.002")


def half_number(path):
    text(path, rows_of()[:-1], ["t,u,F"], end="\n3.996,0.0021345,0.")


def half_lvm(path):
    unit_lvm(path)
    path.write_bytes(path.read_bytes()[:-14])


def _cut(path, write):
    write(path)
    path.write_bytes(path.read_bytes()[:-900])


def half_xlsx(path):
    _cut(path, unit_xlsx)


def half_parquet(path):
    _cut(path, unit_parquet)


def half_hdf5(path):
    _cut(path, unit_hdf5)


def half_npy(path):
    np.save(path, np.array(rows_of()))
    path.write_bytes(path.read_bytes()[:-9])


def half_npz(path):
    _cut(path, rate_arrays)


def half_mat(path):
    _cut(path, rate_mat)


USUAL = {"force_polarity": "compression"}
NAMED = {**USUAL, "position": "Stroke", "force": "Load"}
GRID = [
    (start_csv, "csv", USUAL, "several columns that may be the time|columns called Time"),
    (start_lvm_columns, "lvm", NAMED, None),
    (start_lvm_header, "lvm", NAMED, None),
    (start_lvm_of_one_column, "lvm", NAMED, "X_Value tells one time for all; write the file with"),
    (start_lvm_relative_columns, "lvm", NAMED, None),
    (start_tdms, "tdms", NAMED, None),
    (start_tdms_of_one_offset, "tdms", NAMED, None),
    (start_tdms_of_one_date, "tdms", NAMED, "and not when the other does"),
    (start_tdms_beside_times, "tdms", NAMED, "begins 37 ms after Run/Stroke, and the column"),
    (start_hdf5, "h5", {**USUAL, "position": "position/value", "force": "force/value",
                        "position_unit": "m", "force_unit": "N"}, "several columns that may be"),
    (start_mat, "mat", USUAL, "does not say which column is the time"),
    (rate_csv, "csv", USUAL, None),
    (rate_lvm, "lvm", NAMED, None),
    (rate_tdms, "tdms", NAMED, None),
    (rate_arrays, "npz", USUAL, "columns must have one length"),
    (rate_mat, "mat", USUAL, "columns must have one length"),
    (rate_hdf5, "h5", USUAL, "columns must have one length"),
    (unit_csv, "csv", USUAL, None),
    (unit_lvm, "lvm", NAMED, None),
    (unit_lvm_unknown, "lvm", NAMED, "Load, the force, is in 'Volts' as the file says"),
    (unit_tdms, "tdms", NAMED, None),
    (unit_tdms_unknown, "tdms", NAMED, "Load, the force, is in 'V' as the file says"),
    (unit_hdf5, "h5", USUAL, None),
    (unit_hdf5_array, "h5", USUAL, None),
    (unit_named_otherwise, "csv", USUAL, "is in um by its name, and in mm by the unit beside it"),
    (unit_hdf5_unknown, "h5", USUAL, "u, the position, is in 'furlong' as the file says"),
    (unit_parquet, "parquet", USUAL, None),
    (unit_parquet_unknown, "parquet", USUAL, "u, the position, is in 'furlong' as the file says"),
    (unit_xlsx, "xlsx", USUAL, None),
    (block_csv, "txt", USUAL, None),
    (block_csv_going_on, "txt", USUAL, None),
    (block_csv_of_another_kind, "csv", USUAL, "no row of the table, and rows follow"),
    (block_csv_without_text, "csv", USUAL, None),
    (block_csv_with_numbered_text, "csv", USUAL, None),
    (block_lvm, "lvm", NAMED, None),
    (block_lvm_by_its_clock, "lvm", NAMED, None),
    (block_lvm_of_other_units, "lvm", NAMED, "has the Y_Unit_Label um, N, and the first mm, N"),
    (block_lvm_with_comments, "lvm", NAMED, None),
    (block_xlsx, "xlsx", USUAL, None),
    (block_xlsx_sheets, "xlsx", USUAL, "several columns that may be the"),
    (block_tdms, "tdms", NAMED, "several columns Stroke"),
    (block_hdf5, "h5", USUAL, "several columns that may be the"),
    (block_mat, "mat", USUAL, "several columns that may be the"),
    (half_cell, "csv", USUAL, None),
    (half_number, "csv", USUAL, None),
    (half_lvm, "lvm", NAMED, None),
    (half_xlsx, "xlsx", USUAL, "damaged archive"),
    (half_parquet, "parquet", USUAL, "not a Parquet file"),
    (half_hdf5, "h5", USUAL, "not an HDF5 file"),
    (half_npy, "npy", USUAL, "not a NumPy file"),
    (half_npz, "npz", USUAL, "damaged archive"),
    (half_mat, "mat", USUAL, "not a MATLAB file"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("write", "suffix", "how", "refusal"), GRID, ids=[cell[0].__name__ for cell in GRID]
)
def test_it_is_used_or_refused(tmp_path, write, suffix, how, refusal):
    path = tmp_path / f"recorded.{suffix}"
    write(path)
    if refusal:
        with pytest.raises(tp.TissueProbeError, match=refusal):
            tp.read(path, **how)
        return
    read = tp.read(path, **how)
    known = np.flatnonzero(np.isfinite(read.position) & np.isfinite(read.force))
    assert known.size >= COUNT - 20
    # A spline has no slope beyond its ends to lean on. Times may begin where the force does.
    inner = known[30:-30]
    late = LATE if write.__name__.startswith("start") else 0.0
    at = read.time[inner] - read.time[0] + late + (read.time[0] if not late else 0.0)
    np.testing.assert_allclose(read.position[inner], motion(at), atol=5e-6)
    np.testing.assert_allclose(read.force[inner], force(at), atol=2e-3)


@pytest.mark.parametrize("write", [half_cell, half_number])
def test_a_row_that_is_cut_short_is_told(tmp_path, write):
    write(tmp_path / "cut.csv")
    read = tp.read(tmp_path / "cut.csv", **USUAL)
    assert read.time.size == COUNT - 1
    assert any(f"line {COUNT + 1}, the last, is cut short, and left out" in n for n in read.notes)


def test_blocks_are_told_with_their_length(tmp_path):
    block_csv(tmp_path / "blocks.txt")
    read = tp.read(tmp_path / "blocks.txt", **USUAL)
    note = next(each for each in read.notes if "blocks" in each)
    assert "2 blocks, of 200 and 800 rows" in note
    assert "the times of 1 block begin anew" in note


def test_a_table_above_the_samples_is_told_as_one(tmp_path):
    above = ["cycle,peak", "1,0.5", "2,0.6", ""]
    text(tmp_path / "two.csv", rows_of(), ["t,u,F"], above=above)
    read = tp.read(tmp_path / "two.csv", **USUAL)
    assert any("another table, in lines 2 to 3, is not read" in each for each in read.notes)


@pytest.mark.parametrize(
    "names",
    ["Time_S,Tip_mm,F", "Elapsed Time,Position (m),Force [N]", "Scan Time [s],Stroke_MM,Load (N)"],
)
def test_names_that_laboratories_give_are_known(tmp_path, names):
    size = 1e3 if "mm" in names.casefold() else 1.0
    text(tmp_path / "x.csv", zip(TIME, size * motion(TIME), force(TIME), strict=True), [names])
    read = tp.read(tmp_path / "x.csv", **USUAL)
    np.testing.assert_allclose(read.position, motion(TIME), atol=1e-9)


def test_a_column_may_be_told_by_its_number_though_it_has_a_name(tmp_path):
    text(tmp_path / "x.csv", rows_of(), ["a,b,c"])
    units = {"position_unit": "m", "force_unit": "N"}
    read = tp.read(tmp_path / "x.csv", time="1", position="2", force="3", **units, **USUAL)
    np.testing.assert_allclose(read.position, motion(TIME), atol=1e-9)


def test_numbers_count_all_columns_of_a_file_also_those_without_a_name(tmp_path):
    text(tmp_path / "x.csv", [(n, *row) for n, row in enumerate(rows_of())], [",a,b,c"])
    units = {"position_unit": "m", "force_unit": "N"}
    read = tp.read(tmp_path / "x.csv", time="a", position="3", force="4", **units, **USUAL)
    np.testing.assert_allclose(read.position, motion(TIME), atol=1e-9)
    assert any("position is b" in note for note in read.notes)


@pytest.mark.parametrize("sec", [lambda t: t + 0.5, lambda t: 1e10 + 1e9 * t, lambda t: -1e19 + t])
def test_seconds_that_are_none_are_refused(sec):
    whole, rest = np.floor(TIME), np.round(1e9 * (TIME % 1)).astype(np.int64)
    table = {"sec": sec(whole), "nanosec": rest, "u": motion(TIME), "F": force(TIME)}
    with pytest.raises(tp.TissueProbeError, match="no seconds and the nanoseconds beside them"):
        tp.read(table, **USUAL)


def test_a_line_longer_than_the_head_of_a_file_ends_nothing(tmp_path):
    text(tmp_path / "x.csv", rows_of(), ["t,u,F"], above=["# " + "x" * 50_000])
    assert tp.read(tmp_path / "x.csv", **USUAL).time.size == COUNT


def test_a_last_line_without_an_end_is_told(tmp_path):
    text(tmp_path / "x.csv", rows_of(), ["t,u,F"], end="")
    read = tp.read(tmp_path / "x.csv", **USUAL)
    assert any("the last, has no end; its last number may be cut" in n for n in read.notes)


def test_a_torque_and_an_angle_are_no_force_and_no_way(tmp_path):
    text(tmp_path / "x.csv", rows_of(), ["Time [s],Angle [rad],Torque [N m]"])
    named = {"position": "Angle [rad]", "force": "Torque [N m]", **USUAL}
    with pytest.raises(tp.TissueProbeError, match="is in rad, of a torque or an angle"):
        tp.read(tmp_path / "x.csv", **named)
    lever = {"position_unit": "0.05", "force_unit": "20"}
    assert tp.read(tmp_path / "x.csv", **named, **lever).position[0] == pytest.approx(1e-4)


def test_a_frequency_sweep_is_refused_as_one(tmp_path):
    text(tmp_path / "x.csv", rows_of(), ["Frequency (Hz),Storage modulus (Pa),Loss modulus (Pa)"])
    with pytest.raises(tp.TissueProbeError, match="is a frequency sweep, with Storage modulus"):
        tp.read(tmp_path / "x.csv", **USUAL)
