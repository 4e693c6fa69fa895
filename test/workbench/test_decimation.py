"""Few samples that look like all of them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tissue_probe.workbench.decimation import dots, lines
from tissue_probe.workbench.messages import pack_message, unpack_message

SIGNALS = hnp.arrays(np.float64, st.integers(2, 3000), elements=st.floats(-1e6, 1e6))


@given(SIGNALS, st.integers(1, 400), st.data())
def test_each_column_of_pixels_keeps_its_lowest_and_highest(signal, pixels, data):
    first = data.draw(st.integers(0, signal.size - 2))
    stop = data.draw(st.integers(first + 2, signal.size))
    numbers, drawn = lines({"y": signal}, first, stop, pixels)
    part, seen = signal[first:stop], drawn["y"]
    assert seen.size == numbers.size <= max(2 * pixels, part.size)
    assert (np.diff(numbers) > 0).all()
    assert first <= numbers[0] <= numbers[-1] <= stop
    if part.size <= 2 * pixels:
        np.testing.assert_array_equal(seen, part)
        return
    edges = first + np.arange(pixels + 1) * part.size // pixels
    for column in range(pixels):
        inside = signal[edges[column] : edges[column + 1]]
        assert sorted(seen[2 * column : 2 * column + 2]) == [inside.min(), inside.max()]


@given(SIGNALS, st.integers(1, 60), st.integers(1, 60))
def test_dots_colour_the_same_pixels_as_all_points(y, wide, high):
    x = np.sin(np.arange(y.size))
    limits = (-1.0, 1.0, float(y.min()), max(float(y.max()), float(y.min()) + 1.0))

    def pixels(x, y):
        column = np.clip((x + 1.0) / 2.0 * wide, 0, wide - 1).astype(int)
        row = np.clip((y - limits[2]) / (limits[3] - limits[2]) * high, 0, high - 1).astype(int)
        return set(zip(column.tolist(), row.tolist(), strict=True))

    few_x, few_y = dots(x, y, limits, (wide, high))
    assert few_x.size <= wide * high
    assert pixels(few_x, few_y) == pixels(x, y)


@given(
    st.dictionaries(st.text(max_size=5), st.none() | st.floats() | st.text(max_size=20)),
    st.lists(hnp.arrays(st.sampled_from([np.float32, np.float64, np.uint16]), st.integers(0, 9))),
)
def test_a_message_holds_what_was_put_into_it(head, arrays):
    named = {f"a{number}": array for number, array in enumerate(arrays)}
    told, found = unpack_message(pack_message({"head": head}, named))
    for name, value in told["head"].items():
        known = head[name]
        assert value == (None if isinstance(known, float) and not np.isfinite(known) else known)
    assert list(found) == list(named)
    for name, array in named.items():
        np.testing.assert_array_equal(found[name], array)
