"""Each excitation keeps its amplitude, has its frequencies, and never jumps in phase."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from tissue_probe.excitation import (
    EXCITATIONS,
    Chirp,
    Multisine,
    Sine,
    SteppedSweep,
    parse_excitation,
)
from tissue_probe.settings import SettingsError

# Subnormal numbers have too few digits for any tolerance in shares.
amplitudes = st.floats(0.0, 10.0, allow_subnormal=False)
frequencies = st.floats(0.01, 100.0)


@st.composite
def sweeps(draw):
    start = draw(st.floats(0.01, 99.0))
    values = {
        "amplitude": draw(amplitudes),
        "start": start,
        "stop": draw(st.floats(start, 100.0, exclude_min=True)),
        "duration": draw(st.floats(0.01, 3600.0)),
    }
    if draw(st.booleans()):
        return Chirp(**values)
    return SteppedSweep(**values, steps=draw(st.integers(2, 1000)))


@st.composite
def multisines(draw):
    start = draw(st.floats(0.01, 60.0))
    spacing = draw(st.one_of(st.floats(0.1, 20.0), st.just(start), st.just(start / 3)))
    spacing = min(max(spacing, 0.1), 20.0)
    return Multisine(
        amplitude=draw(amplitudes),
        start=start,
        spacing=spacing,
        stop=start + spacing * draw(st.floats(1.01, min(30.0, (99.9 - start) / spacing))),
    )


excitations = st.one_of(
    st.builds(Sine, amplitude=amplitudes, frequency=frequencies), sweeps(), multisines()
)
times = st.lists(st.floats(0.0, 1e4), min_size=1, max_size=30).map(np.array)


@given(excitations, times)
@settings(max_examples=300, deadline=None)
def test_the_amplitude_is_never_exceeded(excitation, time):
    assert np.abs(excitation(time)).max() <= excitation.amplitude * (1.0 + 1e-9)


@given(multisines(), st.floats(0.0, 1e3))
@settings(max_examples=50, deadline=None)
def test_the_amplitude_of_a_multisine_is_not_exceeded_between_the_points_of_any_grid(
    excitation, begin
):
    fine = begin + np.arange(0.0, 2.0 / excitation.spacing, 1.0 / (500.0 * excitation.stop))
    assert np.abs(excitation(fine)).max() <= excitation.amplitude * (1.0 + 1e-9)


@pytest.mark.parametrize(
    "excitation",
    [
        Sine(amplitude=3.0),
        SteppedSweep(amplitude=3.0),
        Chirp(amplitude=3.0),
        Multisine(amplitude=3.0),
        Multisine(amplitude=3.0, start=1.0, spacing=2.0),  # odd harmonics
        Multisine(amplitude=3.0, start=1.25, spacing=1.0),  # repeats after four periods only
        Multisine(amplitude=3.0, start=0.5, stop=9.0, spacing=3.0),
    ],
    ids=repr,
)
def test_the_amplitude_is_reached(excitation):
    fine = np.arange(0.0, 12.0, 1e-4)
    assert np.abs(excitation(fine)).max() == pytest.approx(3.0, rel=2e-3)


@given(excitations, times, st.data())
@settings(max_examples=200, deadline=None)
def test_values_do_not_depend_on_what_was_asked_together_or_before(excitation, time, data):
    together = excitation(time)
    cut = data.draw(st.integers(0, time.size))
    in_blocks = np.concatenate([excitation(time[cut:])[::-1], excitation(time[:cut])[::-1]])[::-1]
    one_by_one = [float(excitation(each)) for each in time]
    tolerance = 1e-9 * excitation.amplitude
    assert in_blocks == pytest.approx(together, abs=tolerance)
    assert one_by_one == pytest.approx(together, abs=tolerance)


@given(sweeps(), st.floats(0.0, 100.0), st.integers(0, 50), st.floats(1e-7, 1e-4))
@settings(max_examples=300, deadline=None)
def test_sweeps_never_jump_in_phase(sweep, anywhere, boundary, step):
    # Anywhere, and where one frequency or one sweep gives way to the next.
    parts = sweep.steps if isinstance(sweep, SteppedSweep) else 1
    steepest = 2.0 * np.pi * sweep.stop * sweep.amplitude
    for middle in (anywhere, boundary * sweep.duration / parts, boundary * sweep.duration):
        before, after = sweep(np.array([middle - step / 2, middle + step / 2]).clip(0.0))
        # The phase of times up to 10^5 s is exact to 10^-8 revolutions or so.
        assert abs(after - before) <= steepest * step + 1e-6 * sweep.amplitude


def spectrum(excitation, rate=1000.0):
    """Return the amplitude at each whole frequency [Hz] over ten seconds."""
    samples = excitation(np.arange(10 * int(rate)) / rate)
    return 2.0 * np.abs(np.fft.rfft(samples))[::10] / samples.size


def test_a_sine_has_one_frequency():
    found = spectrum(Sine(amplitude=2.0, frequency=7.0))
    assert found[7] == pytest.approx(2.0)
    assert np.delete(found, 7).max() < 1e-9


def test_a_multisine_has_its_frequencies_equally_strong_and_no_others():
    found = spectrum(Multisine(amplitude=2.0, start=3.0, stop=13.5, spacing=2.0))
    inside = [3, 5, 7, 9, 11, 13]
    assert found[inside] == pytest.approx(np.full(6, found[3]))
    assert found[3] > 2.0 / 6  # stronger than sines that all peak at once
    assert np.delete(found, inside).max() < 1e-9


def test_a_multisine_ends_at_its_highest_frequency_however_that_is_rounded():
    found = spectrum(Multisine(start=0.1, stop=2.0, spacing=0.1).model_copy())
    assert found[2] > 0.05
    assert found[1] == pytest.approx(found[2])


def test_the_crest_factor_of_a_multisine_is_low():
    samples = Multisine(amplitude=1.0)(np.arange(0.0, 1.0, 1e-4))
    assert 1.0 / np.sqrt(np.mean(samples**2)) < 1.9  # 7.7 with equal phases


def frequency_at(excitation, time):
    """Return the frequency [Hz] at a time, from the zero crossings on either side."""
    fine = np.arange(max(0.0, time - 2.0), time + 2.0, 1e-5)
    signs = np.signbit(excitation(fine))
    rising = fine[1:][signs[:-1] & ~signs[1:]]
    after = np.searchsorted(rising, time)
    return 1.0 / np.diff(rising)[max(after - 1, 0)]


@pytest.mark.parametrize("offset", [0.0, 20.0])
def test_a_stepped_sweep_plays_each_frequency_equally_long_and_begins_again(offset):
    sweep = SteppedSweep(start=2.0, stop=20.0, duration=20.0, steps=10)
    for number in range(10):
        middle = offset + 2.0 * number + 1.0
        assert frequency_at(sweep, middle) == pytest.approx(2.0 + 2.0 * number, rel=1e-3)


@pytest.mark.parametrize("offset", [0.0, 50.0])
def test_the_frequency_of_a_chirp_rises_linearly_and_begins_again(offset):
    chirp = Chirp(start=10.0, stop=60.0, duration=50.0)
    for time in (10.0, 25.0, 40.0):
        assert frequency_at(chirp, offset + time) == pytest.approx(10.0 + time, rel=3e-3)


@pytest.mark.parametrize("sweep_type", [Chirp, SteppedSweep])
def test_a_sweep_begins_at_its_start_frequency_and_phase_zero(sweep_type):
    sweep = sweep_type(amplitude=2.0, start=5.0, stop=50.0, duration=1000.0)
    time = np.arange(0.0, 0.2, 1e-3)
    assert sweep(np.zeros(1)) == 0.0
    assert sweep(time) == pytest.approx(2.0 * np.sin(2 * np.pi * 5.0 * time), abs=0.02)


@pytest.mark.parametrize("kind", EXCITATIONS)
def test_an_excitation_is_read_back_from_its_description(kind):
    excitation = EXCITATIONS[kind](amplitude=0.7)
    assert parse_excitation(excitation.model_dump()) == excitation
    assert parse_excitation({"kind": kind, "amplitude": 0.7}) == excitation


@pytest.mark.parametrize(
    ("description", "said"),
    [
        ({}, "excitation.kind is None: give one of sine, stepped_sweep, chirp, multisine"),
        ({"kind": "square"}, "excitation.kind is 'square': give one of sine, stepped_sweep, "),
        ({"kind": ["sine"]}, "excitation.kind is ['sine']: give one of "),
        (
            {"kind": "sine", "frequency": 0.0},
            "excitation.frequency is 0.0: give a number from 0.01 to 100 [Hz]",
        ),
        (
            {"kind": "sine", "amplitude": "loud"},
            "excitation.amplitude is 'loud': give a number from 0 to 10",
        ),
        (
            {"kind": "chirp", "duration": float("nan")},
            "excitation.duration is nan: give a number above 0 to 3600 [s]",
        ),
        (
            {"kind": "stepped_sweep", "steps": 2.5},
            "excitation.steps is 2.5: give a whole number from 2 to 1000",
        ),
        (
            {"kind": "chirp", "start": 5.0, "stop": 4.0},
            "excitation.*: stop is 4 Hz; give one above start, 5 Hz",
        ),
        (
            {"kind": "multisine", "start": 5.0, "stop": 5.5},
            "excitation.*: stop is 5.5 Hz; give at least start + spacing, 6 Hz, so that there are "
            "two sines",
        ),
        (
            {"kind": "sine", "phase": 1.0},
            "there is no excitation.phase; there are amplitude, kind, frequency",
        ),
    ],
)
def test_a_wrong_description_is_refused_in_one_sentence(description, said):
    with pytest.raises(SettingsError) as raised:
        parse_excitation(description)
    assert str(raised.value).startswith(said)
    assert "\n" not in str(raised.value)


def test_an_excitation_cannot_be_changed_once_it_is_made():
    with pytest.raises(ValidationError):
        Sine().amplitude = 9.0


@pytest.mark.parametrize(
    "excitation",
    [
        Sine(frequency=7.3),
        SteppedSweep(start=2.0, stop=5.0, duration=4.0, steps=7),
        Chirp(start=1.0, stop=30.0, duration=10.0),
        Multisine(start=2.0, stop=9.0, spacing=0.5),
    ],
    ids=type,
)
def test_what_repeats_does_so_after_its_period_and_not_before(excitation):
    t = np.linspace(0.0, 20.0, 4001)
    values = excitation(t)
    np.testing.assert_allclose(excitation(t + excitation.period), values, atol=1e-9)
    assert np.abs(excitation(t + 0.5 * excitation.period) - values).max() > 0.1


@pytest.mark.parametrize(
    "excitation",
    [
        SteppedSweep(start=1.0, stop=2.0, duration=1.1),
        Chirp(start=1.0, stop=30.3, duration=1.0),
        Multisine(start=1.3, stop=9.0, spacing=0.5),
    ],
    ids=type,
)
def test_what_does_not_repeat_has_no_period(excitation):
    assert excitation.period is None
