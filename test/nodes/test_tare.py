"""The force's zero is taken in free air alone, and a recording tells what it was."""

from __future__ import annotations

import numpy as np
import pytest
from lifecycle_msgs.msg import Transition
from std_srvs.srv import Trigger

from conftest import (
    activate,
    ask,
    change_state,
    collect,
    deactivate,
    driver,
    stage_on_tissue,
)
from tissue_probe.analysis.raw import find_calibration, raw_counts, raw_volts, recalibrate
from tissue_probe.configuration import stock_configuration
from tissue_probe.devices.calibration import Calibration
from tissue_probe.nodes.conversions import samples_from_message
from tissue_probe.nodes.session import NodeProcess, Session
from tissue_probe.recording.bags.reader import read_recording
from tissue_probe.signals import join
from tissue_probe_msgs.msg import ProbeSamples

STOCK = Calibration.load(stock_configuration("calibration.yaml"))
MEASURED = STOCK.changed(
    force_per_volt=1.9,
    force_offset_volts=0.25,
    force_polarity="tension",
    position_per_count=-1e-7,
)


def tare(running) -> Trigger.Response:
    return ask(running, Trigger, "/probe/tare")


def test_the_zero_is_taken_off_in_free_air_and_the_bag_gives_the_raw_volts_back(bag, tmp_path):
    MEASURED.save(tmp_path / "probe.yaml")
    driver_process = driver(
        simulated__force_zero=0.7, calibration_file=str(tmp_path / "probe.yaml")
    )
    recorder = NodeProcess("recorder", "recorder", parameters={"output": str(bag)})
    with Session([driver_process, recorder]) as running:
        blocks = collect(running.node, ProbeSamples, "/probe/samples")
        running.activate({"/probe/driver": 2})
        running.wait_until(lambda: len(blocks) > 300, "samples in free air")
        answer = tare(running)
        assert answer.success, answer.message
        assert float(answer.message.split()[0]) == pytest.approx(0.7, abs=0.002)
        told = len(blocks)
        running.wait_until(lambda: len(blocks) > told + 300, "tared samples")
        deactivate(running)

    recording = read_recording(bag)
    embedded = find_calibration(recording)
    assert embedded.changed(tares=()) == MEASURED
    tared = recording.stamps >= embedded.tares[0].stamp
    assert recording.force[~tared][-2000:].mean() == pytest.approx(0.7, abs=0.005)
    assert recording.force[tared][200:2200].mean() == pytest.approx(0.0, abs=0.005)
    # 0.7 N, on a cell of 1.9 N/V that falls from 0.25 V when it is compressed: before and after.
    volts = raw_volts(recording)
    for part in (volts[~tared][-2000:], volts[tared][200:2200]):
        assert part.mean() == pytest.approx(0.25 - 0.7 / 1.9, abs=0.003)
    counts = raw_counts(recording)
    assert np.abs(counts - np.rint(counts)).max() < 1e-6  # the simulated encoder steps by 0.1 um
    again = recalibrate(recording, MEASURED)
    assert np.abs(again.force - recording.force).max() < 1e-12
    assert np.abs(again.position - recording.position).max() < 1e-15


def test_it_is_refused_in_contact_and_the_force_stays_as_it_was(session):
    running = session(driver(simulated__force_zero=0.7), stage_on_tissue())
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    activate(running)
    running.wait_until(lambda: len(blocks) > 300, "samples in contact")
    answer = tare(running)
    assert not answer.success
    assert "the probe is in contact: it feels 4" in answer.message
    del blocks[:]
    running.wait_until(lambda: len(blocks) > 100, "samples afterwards")
    force = join(samples_from_message(block) for block in blocks)[0].force
    assert force[:1000].mean() == pytest.approx(0.7, abs=0.15)


def test_it_is_refused_with_the_coil_off_where_contact_cannot_be_told(session):
    """As it is off for the weights of a calibration, too."""
    running = session(driver(excitation__amplitude=0.0))
    blocks = collect(running.node, ProbeSamples, "/probe/samples")
    activate(running)
    running.wait_until(lambda: len(blocks) > 300, "samples at rest")
    answer = tare(running)
    assert not answer.success
    assert "the coil does not move" in answer.message
    assert not any(any(block.command) for block in blocks)


def test_it_is_refused_while_nothing_is_measured(session):
    running = session(driver())
    assert "not configured" in tare(running).message
    activate(running)
    deactivate(running)
    answer = tare(running)
    assert not answer.success
    assert "no samples come: activate the driver" in answer.message


def test_a_wrong_calibration_file_is_told_when_the_driver_is_configured(session, tmp_path):
    (tmp_path / "probe.yaml").write_text("force_per_volt: 2.0\n")
    running = session(driver(calibration_file=str(tmp_path / "probe.yaml")))
    assert not change_state(running, Transition.TRANSITION_CONFIGURE)
    running.wait_until(
        lambda: "probe.yaml: date is missing" in running.whole_log("driver"), "its reason"
    )
