"""``python -m benchmarks``: measure, print, and keep as JSON.

Before and after a change of the diagnosis: ``golden`` says what is said of a fixed set of records,
``golden --against FILE`` what the change changed; ``code`` counts lines, constants, the worst
function and circles of imports.
"""

from __future__ import annotations

import os
from dataclasses import asdict
from enum import Enum
from itertools import chain
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from benchmarks import (
    daq,
    diagnosis,
    diagnosis_report,
    estimators,
    estimators_speed,
    filters,
    live,
    machine,
    offline,
    readers,
    reading,
    reading_bags,
    report,
    soak,
    start,
    workbench,
)
from benchmarks.beside import measure as beside
from benchmarks.code import measure as code
from benchmarks.free_form import measure as free_form
from benchmarks.golden import tables as golden_tables
from benchmarks.golden import told as golden
from benchmarks.instrument import groups as instrument_groups
from benchmarks.instrument import measure as instrument
from benchmarks.instrument import speed as instrument_speed
from benchmarks.instrument import tables as instrument_tables
from benchmarks.instrument import written_cases
from benchmarks.laws import measure as laws
from benchmarks.laws import tables as laws_tables
from benchmarks.laws.library import list_newer_laws
from benchmarks.maps import blocks, explore
from benchmarks.maps import measure as maps
from benchmarks.protocols import deal
from benchmarks.protocols.catalogue import PROTOCOLS
from benchmarks.ruler import marks
from benchmarks.ruler import tables as ruler_tables
from benchmarks.studies import measure as studies
from benchmarks.studies.speed import COUNT as STUDIED
from tissue_probe.challenge.trajectory import DURATIONS
from tissue_probe.nodes.session import SessionError

RESULTS = Path(__file__).parent / "results"
#: Where nobody else's nodes are heard, nor hear these.
DOMAIN = "87"
#: Of the noise; no test uses seeds from here on.
FIRST_SEED = 1000


class Part(str, Enum):
    """What to measure."""

    live = "live"
    offline = "offline"
    estimators = "estimators"
    speed = "speed"
    filters = "filters"
    diagnosis = "diagnosis"
    daq = "daq"
    soak = "soak"
    readers = "readers"
    reading = "reading"
    start = "start"
    protocols = "protocols"
    third_party = "third_party"
    instrument = "instrument"
    map = "map"
    explore = "explore"
    blocks = "blocks"
    workbench = "workbench"
    golden = "golden"
    code = "code"
    study = "study"
    live_loop = "live_loop"
    free_form = "free_form"
    beside = "beside"
    laws = "laws"
    all = "all"


#: Parts that print tables of their own, and parts that record nothing.
WITHOUT_BAG = (
    *(Part.reading, Part.start, Part.protocols, Part.third_party, Part.map, Part.workbench),
    *(Part.explore, Part.blocks, Part.golden, Part.code, Part.instrument, Part.study),
    *(Part.live_loop, Part.free_form, Part.beside, Part.laws),
)
OWN_TABLES = (Part.daq, Part.soak, Part.readers, *WITHOUT_BAG)


class Rig(str, Enum):
    """Whether a challenge's rig is the nominal one, or off within its tolerances."""

    exact = "exact"
    tolerant = "tolerant"


Hidden = Enum("Hidden", {name: name for name in diagnosis.HIDDEN}, type=str)
Excitation = Enum("Excitation", {name: name for name in DURATIONS}, type=str)
Group = Enum("Group", {name: name for name in (*instrument_groups.GROUPS, "speed")}, type=str)
STEPS = (
    *("free_air", "contact", "monitor", "wrong_estimates", "tolerant", "identify", "take_model"),
    "diagnose_beside",
)
Step = Enum("Step", {name: name for name in STEPS}, type=str)
Law = Enum("Law", {name: name for name in list_newer_laws()}, type=str)
Protocol = Enum("Protocol", {name: name for name in PROTOCOLS}, type=str)


def main(
    part: Annotated[Part, typer.Argument(help="What to measure.")] = Part.all,
    seconds: Annotated[
        float,
        typer.Option(min=1.0, help="Time of each measurement of `live`, `daq` and `readers` [s]."),
    ] = 60.0,
    minutes: Annotated[float, typer.Option(min=0.1, help="Time of `soak` [min].")] = 10.0,
    seeds: Annotated[
        int,
        typer.Option(
            min=1,
            help="Seeds of each row of `estimators` and `live_loop`; its minutes of the monitor.",
        ),
    ] = 20,
    sequences: Annotated[
        int, typer.Option(min=1, help="`filters`: random sequences that each filter gets.")
    ] = 5000,
    sequence_seed: Annotated[
        int, typer.Option(min=0, help="`filters`: seed of the first sequence.")
    ] = 0,
    count: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="`diagnosis`: recordings of one effect for each rig and excitation; there are a "
            "third as many of each other kind. `protocols`: records of each protocol with "
            "something hidden, and as many without. `third_party`: records of each effect, and "
            "twice as many without. `instrument`: records of each group. `study`: recordings. "
            "`laws`: clean records on each rig.",
            show_default=f"{diagnosis.COUNT}; of `study` {STUDIED}, of `laws` {laws.COUNT}",
        ),
    ] = None,
    first_seed: Annotated[
        int,
        typer.Option(
            min=diagnosis.FIRST_SEED,
            help="Of the challenges of `diagnosis`, of `protocols`, of `instrument`, of "
            "`free_form`, of `laws`.",
        ),
    ] = diagnosis.FIRST_SEED,
    rig: Annotated[
        list[Rig] | None, typer.Option(help="Of `diagnosis`, `laws`; both by default.")
    ] = None,
    excitations: Annotated[
        list[Excitation] | None, typer.Option(help="Of `diagnosis`; all by default.")
    ] = None,
    protocol: Annotated[
        list[Protocol] | None, typer.Option(help="Of `protocols`; all by default.")
    ] = None,
    phantoms: Annotated[
        int,
        typer.Option(min=3, help="`map`, `explore`: random phantoms (of each raster of sites)."),
    ] = 200,
    before: Annotated[
        str | None,
        typer.Option(
            metavar="REVISION",
            help="Beside which of git's revisions: of `start` (by default HEAD~1), and of the "
            "group `speed` of `instrument` (by default none).",
        ),
    ] = None,
    against: Annotated[
        Path | None,
        typer.Option(help="`golden`: an earlier result; what differs from it is printed."),
    ] = None,
    group: Annotated[
        list[Group] | None, typer.Option(help="Of `instrument`; all by default.")
    ] = None,
    step: Annotated[list[Step] | None, typer.Option(help="Of `live_loop`; all by default.")] = None,
    law: Annotated[list[Law] | None, typer.Option(help="Of `laws`; all by default.")] = None,
    cases: Annotated[
        Path | None,
        typer.Option(
            exists=True,
            file_okay=False,
            help="`instrument`: mark the recordings of this folder by the command line, instead.",
        ),
    ] = None,
    data: Annotated[
        Path | None,
        typer.Option(exists=True, file_okay=False, help="`beside`: the folder of public data."),
    ] = None,
    peer: Annotated[
        list[Path] | None,
        typer.Option(
            exists=True,
            dir_okay=False,
            help="`beside`: a Python that has jax-sysid, freq-statespace or mujoco[sysid]; several "
            "where each has an environment of its own.",
        ),
    ] = None,
    hide: Annotated[
        list[Hidden] | None, typer.Option(help="What `diagnosis` has to find; all by default.")
    ] = None,
) -> None:
    """Measure the live suite, the filters, and how often a hidden effect is named.

    `daq` counts the samples of the driver on a DAQ; `soak` holds the suite for long, to see what it
    keeps of memory, files and threads; `readers` adds readers of single samples until the driver
    sheds these; `reading` counts how files of others are read; `filters` whether any settings and
    any samples make a filter lose its numbers; `start` how long commands take to start, beside an
    earlier revision; `protocols` what the diagnosis says of records of laboratories, which share
    no code with it, and `third_party` of records by simulators of others (MuJoCo, scikit-fem,
    felupe); `instrument` whether the instrument and the numerics are told as tissue; `map` how
    right the map of sites is, `explore` that of sites which are chosen one by one, `blocks` both on
    finite elements; `workbench` how soon its page answers in a browser; `golden` what the diagnosis
    says of a fixed set of records, beside an earlier result; `code` how large and tangled the
    diagnosis' code is; `study` how fast many recordings are answered, and whether their statistics
    hold; `live_loop` how right a robot's force sensor is identified on an arm in MuJoCo, how right
    its contact, whether the monitor tells hidden effects, and minutes without any, how the filters
    fare on a rig that is off within its tolerances, whether an identification settles on the
    hidden effect, and what it costs and brings that filters take another model while they run;
    `free_form` learnt shapes on second records; `beside` public data with published errors, and
    other tools on them; `laws` how often each newer law of the library is named, and what it costs
    beside the library before. `all` leaves these twenty out.
    """
    os.environ.setdefault("ROS_DOMAIN_ID", DOMAIN)
    count = count or {Part.study: STUDIED, Part.laws: laws.COUNT}.get(part, diagnosis.COUNT)
    RESULTS.mkdir(exist_ok=True)
    bag = RESULTS / "run.mcap"
    results: dict[str, object] = {"machine": machine.describe()}
    earlier = golden_tables.read(against) if against else None
    batteries: dict[str, diagnosis.Battery] = {}
    try:
        if part == Part.daq:
            bag = RESULTS / "daq.mcap"
            results["daq"] = daq.measure(RESULTS, seconds)
            print(daq.sentence(results["daq"]))
        if part == Part.reading:
            results["reading"] = reading.measure()
            results["bags"] = reading_bags.measure()
            for table in (
                *reading.tables(results["reading"]),
                *reading_bags.tables(results["bags"]),
            ):
                Console().print(table)
        if part == Part.start:
            revision = before or "HEAD~1"
            results["start"] = start.measure(revision)
            Console().print(start.table(results["start"], revision))
        if part == Part.soak:
            bag = RESULTS / "soak.mcap"
            results["soak"] = soak.measure(RESULTS, minutes)
            Console().print(soak.table(results["soak"]))
        if part == Part.readers:
            results["readers"] = readers.measure(RESULTS, seconds)
            print(readers.sentence(results["readers"]))
        if part == Part.protocols:
            names = [each.value for each in protocol or Protocol]
            outcomes = marks.measure(deal.dealt(count, first_seed, names))
            results["protocols"] = [asdict(outcome) for outcome in outcomes]
            Console(width=150).print(*ruler_tables.tables("Records of laboratories", outcomes))
        if part == Part.third_party:
            # Heavy packages, which nothing else needs.
            from benchmarks.third_party import fem_records, mujoco_records

            makers = (mujoco_records, fem_records)
            dealt = chain.from_iterable(maker.dealt(count, first_seed) for maker in makers)
            outcomes = marks.measure(dealt)
            results["third_party"] = [asdict(outcome) for outcome in outcomes]
            Console(width=150).print(*ruler_tables.tables("Simulators of others", outcomes))
        if part == Part.instrument and cases is not None:
            written = written_cases.measure(cases)
            results["instrument_cases"] = [asdict(outcome) for outcome in written]
            Console(width=150).print(written_cases.table(written))
        elif part == Part.instrument:
            asked = [each.value for each in group or Group]
            drawn = [name for name in asked if name != "speed"]
            marked = instrument.measure(drawn, count, first_seed)
            results["instrument"] = [asdict(outcome) for outcome in marked]
            Console(width=150).print(*instrument_tables.tables(marked))
            if "speed" in asked:
                results["instrument_speed"] = instrument_speed.measure(before)
                Console().print(instrument_speed.table(results["instrument_speed"], before))
        if part == Part.map:
            found = maps.measure(phantoms)
            results["map"] = maps.kept(found)
            Console(width=150).print(*maps.shown(found))
        if part == Part.explore:
            explorations = explore.measure(phantoms)
            results["explore"] = explore.kept(explorations)
            Console(width=150).print(*explore.shown(explorations))
        if part == Part.blocks:
            elements = blocks.measured(RESULTS / "blocks")
            results["blocks"] = {
                name: [maps.known(asdict(one)) for one in each] for name, each in elements.items()
            }
            Console(width=150).print(blocks.shown(elements))
        if part == Part.workbench:
            results["workbench"] = workbench.measure()
            Console().print(workbench.table(results["workbench"]))
        if part == Part.golden:
            found = golden.measure()
            results[golden_tables.KEY] = golden_tables.kept(found)
            Console(width=150).print(*golden_tables.tables(found))
            if earlier is not None:
                Console(width=150).print(*golden_tables.differences(earlier, found))
        if part == Part.free_form:
            results["free_form"] = free_form.measure(first_seed)
        if part == Part.beside:
            if data is None:
                raise SystemExit("benchmarks: `beside` needs the public data: say where, by --data")
            compared = beside.measure(data, peer or [])
            results["beside"] = beside.kept(compared)
            Console(width=150).print(*beside.tables(compared))
            beside.write_page(compared)
        if part == Part.laws:
            asked_of = [each.value for each in law or Law], [each.value for each in rig or Rig]
            diagnosed = laws.measure(RESULTS, *asked_of, count, first_seed)
            results["laws"] = [asdict(outcome) for outcome in diagnosed]
            Console(width=150).print(*laws_tables.tables(diagnosed))
        if part == Part.code:
            sizes = code.measure()
            results["code"] = {name: asdict(size) for name, size in sizes.items()}
            Console(width=150).print(code.table(sizes))
        if part == Part.study:
            results["study"] = studies.measure(count)
            Console().print(*studies.tables(results["study"]))
        if part == Part.live_loop:
            # MuJoCo, which nothing else needs.
            from benchmarks.live_loop import (
                contact,
                diagnose_beside,
                free_air,
                identify,
                monitor,
                take_model,
                tolerant,
                wrong_estimates,
            )

            steps = [each.value for each in step or Step]
            if "free_air" in steps:
                marked_air = free_air.measure(seeds)
                results["live_loop"] = free_air.kept(marked_air)
                Console(width=190).print(free_air.table(marked_air))
            if "contact" in steps:
                pressed, simulated = contact.measure(seeds), contact.simulate()
                results["live_loop_contact"] = contact.kept(pressed, simulated)
                Console(width=190).print(*contact.tables(pressed, simulated))
            if "monitor" in steps:
                watched = monitor.measure(seeds)
                results["live_loop_monitor"] = monitor.kept(watched)
                Console(width=150).print(monitor.table(watched))
            if "wrong_estimates" in steps:
                sure = wrong_estimates.measure()
                results["live_loop_wrong_estimates"] = wrong_estimates.kept(sure)
                Console(width=150).print(wrong_estimates.table(sure))
            if "tolerant" in steps:
                marked = tolerant.measure(seeds)
                results["live_loop_tolerant"] = tolerant.kept(marked)
                Console(width=120).print(tolerant.table(marked))
            if "identify" in steps:
                identified = identify.measure(seeds)
                results["live_loop_identify"] = identify.kept(identified)
                Console(width=150).print(identify.table(identified))
            if "take_model" in steps:
                phases = take_model.measure(RESULTS)
                results["live_loop_take_model"] = take_model.kept(phases)
                Console(width=120).print(take_model.table(phases))
            if "diagnose_beside" in steps:
                beside_diagnoses = diagnose_beside.measure(RESULTS)
                results["live_loop_diagnose_beside"] = diagnose_beside.kept(beside_diagnoses)
                Console(width=120).print(diagnose_beside.table(beside_diagnoses))
        if part in (Part.live, Part.all):
            results["live"] = live.measure(RESULTS, seconds)
        if part in (Part.offline, Part.all):
            results["offline"] = offline.measure(bag)
        if part in (Part.estimators, Part.all):
            results["estimators"] = estimators.measure(range(FIRST_SEED, FIRST_SEED + seeds))
        if part in (Part.speed, Part.all):
            results["speed"] = estimators_speed.measure()
        if part == Part.filters:
            results["filters"] = filters.measure(sequences, sequence_seed)
        if part in (Part.diagnosis, Part.all):
            cells = (rig or Rig, excitations or Excitation, hide or Hidden)
            named = ([each.value for each in some] for some in cells)
            batteries = diagnosis.measure(count, first_seed, *named)
            results["diagnosis"] = diagnosis_report.results(batteries)
    except SessionError as error:
        raise SystemExit(f"benchmarks: {error}") from None
    except FileNotFoundError:
        raise SystemExit("benchmarks: nothing is recorded yet; measure `live` first") from None
    if part not in OWN_TABLES:
        report.show(results, Console())
    for table in diagnosis_report.tables(batteries):
        Console().print(table)
    if part not in WITHOUT_BAG and bag.exists():
        print(f"the recording is {bag}")
    print(f"kept in {report.keep(results, RESULTS)}")


if __name__ == "__main__":
    typer.run(main)
