"""The program run in this process, and measurements to run it on, whose tissue is known exactly."""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np
import pytest

from tissue_probe import cli
from tissue_probe.physics import library
from tissue_probe.physics.effects import EFFECTS
from tissue_probe.signals import PalpationSite, Phase, SampleBlock

EPOCH = 1_700_000_000_000_000_000
PERIOD = 5e-4
MASS, K0, BETA0 = 0.04, 9700.0, 0.8


@pytest.fixture(autouse=True)
def pictures(sketched):
    """Nobody looks at the pictures of most runs."""


@dataclass
class Outcome:
    """How a run of the program ended, and what it printed."""

    status: int
    out: str
    err: str


@pytest.fixture
def run(monkeypatch, capsys, tmp_path):
    """Run ``tissue_probe`` with arguments in an empty folder, at 80 columns."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")

    def run(*arguments) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["tissue_probe", *map(str, arguments)])
        status = 0
        try:
            cli.main()
        except SystemExit as end:
            # As the interpreter does with what is no number.
            if isinstance(end.code, str):
                print(end.code, file=sys.stderr)
            status = 1 if isinstance(end.code, str) else end.code or 0
        out, err = capsys.readouterr()
        return Outcome(status, out, err)

    return run


@pytest.fixture
def fails(run):
    """Run the program, which must end with status 1 and one sentence; return that line.

    Lines before it tell how far the work had come.
    """

    def fails(*arguments) -> str:
        outcome = run(*arguments)
        assert outcome.status == 1
        assert outcome.err.endswith("\n")
        lines = [line for line in outcome.err.splitlines() if not line.startswith("... ")]
        assert len(lines) == 1
        assert lines[0].startswith("tissue_probe: ")
        return lines[0] + "\n"

    return fails


def palpate(time, stiffness, damping, amplitude=1e-3, frequency=10.0):
    """Return position [m] and force [N] of a tip that vibrates steadily: the exact solution.

    The coil is driven sinusoidally, so is the tip: x = H u with
    H = (k0 + i w beta0) / (k0 + k - m w^2 + i w (beta0 + beta)).
    """
    w = 2.0 * np.pi * frequency
    cell = K0 + 1j * w * BETA0
    u = amplitude * np.exp(1j * w * time)
    x = u * cell / (cell + stiffness + 1j * w * damping - MASS * w**2)
    return u.imag.copy(), K0 * (u - x).imag


@pytest.fixture
def csv(tmp_path):
    """Write two seconds on tissue of 450 N/m and 5 N s/m to a CSV file, compression positive."""

    def write(name="measured.csv", header="t,u,F", sign=1.0, begin=0.0, seconds=2.0):
        time = np.arange(round(seconds / PERIOD)) * PERIOD
        position, force = palpate(time, 450.0, 5.0)
        force += 0.005 * np.random.default_rng(1).standard_normal(time.size)
        position = np.round(position, 7)
        path = tmp_path / name
        rows = np.column_stack([begin + time, position, sign * force])
        np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt="%.17g")
        return path

    return write


#: Effects that are the library where a test is not of the library: every other would be compiled
#: and fitted beside them, with ten times the work.
FEW = (
    *("cubic_stiffening", "coulomb_friction", "force_bias", "force_lag"),
    *("mains_hum", "standard_linear_solid", "load_cell_stiffness_error"),
)


@pytest.fixture
def few(monkeypatch):
    """Let a few effects be the library, with those of the user's own."""
    whole = library.effects

    def effects(files=()):
        return {n: e for n, e in whole(files).items() if n in FEW or n not in EFFECTS}

    monkeypatch.setattr(library, "effects", effects)


SITES = {  # column and row: stiffness [N/m]
    (column, row): 450.0 * (2.5 if (column, row) == (1, 1) else 1.0)
    for row in range(4)
    for column in range(4)
}
DWELL = 0.3


@pytest.fixture(scope="session")
def scan(messages):
    """Blocks and sites of a scan of 4 x 4 sites 10 mm apart; that at (10, 10) mm is stiff."""
    generator = np.random.default_rng(2)
    samples = round(DWELL / PERIOD)
    blocks, sites = [], []
    for number, ((column, row), stiffness) in enumerate(SITES.items()):
        first = number * samples
        stamp = EPOCH + round(first * PERIOD * 1e9)
        place = (0.01 * column, 0.01 * row, 0.0)
        sites.append(PalpationSite(stamp, number, place, Phase.DWELL))
        position, force = palpate((first + np.arange(samples)) * PERIOD, stiffness, stiffness / 90)
        force += 0.005 * generator.standard_normal(samples)
        for begin in range(0, samples, 10):
            part = slice(begin, begin + 10)
            blocks.append(
                SampleBlock(
                    stamp=stamp + round(begin * PERIOD * 1e9),
                    sequence=first + begin,
                    sample_period=PERIOD,
                    position=position[part],
                    force=force[part],
                    command=850.0 * position[part],
                )
            )
    sites.append(PalpationSite(blocks[-1].end, len(SITES) - 1, place, Phase.LIFTED))
    return blocks, sites


@pytest.fixture
def bag(tmp_path, messages, record, scan):
    """Write the scan to an MCAP file, with other entries and metadata as given."""

    def write(name="run.mcap", more=(), metadata=None, lost=(), with_sites=True):
        blocks, sites = scan
        entries = [
            ("/probe/samples", messages.SAMPLES, block.stamp, messages.samples(block))
            for number, block in enumerate(blocks)
            if number not in lost
        ]
        if with_sites:
            entries += [
                ("/probe/palpation_site", messages.SITE, site.stamp, messages.site(site))
                for site in sites
            ]
        return record(tmp_path / name, [*entries, *more], metadata, chunk=500)

    return write
