"""The workbench beside a running suite: what its pages hear, what they may ask, what it costs."""

from __future__ import annotations

import asyncio
import json
import os
import re
import signal
import socket
import subprocess
import sys
from contextlib import contextmanager

import numpy as np
import pytest
import websockets
from std_msgs.msg import Header

from conftest import PATIENCE, activate, driver, estimator, stage_on_tissue
from tissue_probe.mapping.chart import Chart
from tissue_probe.mapping.posterior.posterior_map import map_of
from tissue_probe.mapping.site_result import SiteResult, sites_of
from tissue_probe.mapping.verdict import CellVerdict
from tissue_probe.nodes.map_messages import inclusions_message, results_message, surface_cloud
from tissue_probe.nodes.qos import LATCHED
from tissue_probe.signals import Leaving
from tissue_probe.workbench.messages import unpack_message


@contextmanager
def workbench(folder, *options: str):
    """A server that listens; yields its address, port and token."""
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        port = found.getsockname()[1]
    command = [sys.executable, "-m", "tissue_probe", "workbench", "--no-browser", "--live"]
    process = subprocess.Popen(
        [*command, "--port", str(port), *options],
        env={**os.environ, "XDG_STATE_HOME": str(folder)},
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        token = re.search(r"token=(\S+)", process.stdout.readline())[1]
        yield process, port, token
    finally:
        process.terminate()
        process.wait(30)
        process.stdout.close()


def page(port, token):
    """Open a page's socket."""
    return websockets.connect(
        f"ws://127.0.0.1:{port}/socket",
        origin=f"http://127.0.0.1:{port}",
        additional_headers={"Cookie": f"tissue_probe_{port}={token}"},
        max_size=None,
    )


async def until(line, condition):
    """Hear messages until one fulfils a condition; return its head and arrays."""
    async with asyncio.timeout(PATIENCE):
        while True:
            message = await line.recv()
            told = (
                (json.loads(message), {}) if isinstance(message, str) else unpack_message(message)
            )
            if condition(*told):
                return told


async def asked(line, number, **more):
    await line.send(json.dumps({"id": number, **more}))
    head, _ = await until(line, lambda head, arrays: head.get("id") == number)
    return head


def listener(process) -> int:
    """The process that listens for a server."""
    children = subprocess.run(
        ["ps", "--ppid", str(process.pid), "-o", "pid=,args="], capture_output=True, text=True
    ).stdout.splitlines()
    (found,) = (line for line in children if "watching" in line)
    return int(found.split()[0])


def test_pages_hear_samples_estimates_and_faults_and_command_the_driver(session, tmp_path):
    running = session(driver(), stage_on_tissue(), estimator("robust_ekf"))

    async def steps(port, token):
        async with page(port, token) as line:
            for number, name in enumerate(("configure", "start")):
                said = await asked(line, number, do="command", command=name)
                assert said.get("ok") == f"{name}: done", said
            _, arrays = await until(line, lambda head, arrays: "robust_ekf.stiffness" in arrays)
            assert arrays["force"].size == arrays["time"].size > 0
            assert arrays["robust_ekf.stiffness"].size == arrays["robust_ekf.time"].size > 0
            said = await asked(line, 5, do="command", command="excite", given={"frequency": 1e6})
            assert "refused" in said
            said = await asked(line, 6, do="command", command="emergency_stop")
            assert "ok" in said
            head, _ = await until(line, lambda head, arrays: head.get("live", {}).get("fault"))
            assert head["live"]["fault"]

    with workbench(tmp_path, "--allow-commands") as (_, port, token):
        asyncio.run(steps(port, token))
    del running


def test_a_listener_that_is_stopped_costs_no_node_a_sample(session, tmp_path):
    running = session(driver(), stage_on_tissue(), estimator("robust_ekf"))
    activate(running)

    async def hears(port, token):
        async with page(port, token) as line:
            said = await asked(line, 1, do="command", command="stop")
            assert "`allow_commands`" in said["refused"]
            await until(line, lambda head, arrays: "force" in arrays)

    def counts():
        told = running.health["/probe/robust_ekf"]
        return int(told["samples received"]), int(told["samples lost"])

    with workbench(tmp_path) as (process, port, token):
        asyncio.run(hears(port, token))
        stopped = listener(process)
        os.kill(stopped, signal.SIGSTOP)
        try:
            running.wait_until(lambda: "/probe/robust_ekf" in running.health, "health", PATIENCE)
            before, lost = counts()
            running.wait_until(lambda: counts()[0] > before + 10_000, "samples", PATIENCE)
            assert counts()[1] == lost
        finally:
            os.kill(stopped, signal.SIGCONT)
        asyncio.run(hears(port, token))


def test_pages_hear_the_map_as_the_mapper_tells_it(session, tmp_path):
    x, y = (each.ravel() for each in np.meshgrid(np.arange(5) / 100.0, np.arange(5) / 100.0))
    k = 450.0 + 4.0 * np.random.default_rng(1).standard_normal(x.size)
    k[12] = 1100.0
    results = [
        SiteResult(n, 0, n, (a, b, 0.0), (0.0, 0.0, 1.0), value, 5.0, 1.0, 4.0, 0.1,
                   CellVerdict.MEASURED, Leaving.TOLD_ENOUGH)
        for n, (a, b, value) in enumerate(zip(x, y, k, strict=True))
    ]  # fmt: skip
    chart = Chart.of(sites_of(results))
    found, header = map_of(chart.sites), Header(frame_id="stage")
    running = session()
    messages = {
        "sites": results_message(header, results),
        "inclusions": inclusions_message(header, found, chart.places),
        "stiffness_cloud": surface_cloud(header, found, chart.places),
    }
    for name, message in messages.items():
        running.node.create_publisher(type(message), f"/probe/{name}", LATCHED).publish(message)

    async def hears(port, token):
        async with page(port, token) as line:
            return await until(
                line,
                lambda head, arrays: (
                    "mean" in arrays
                    and head["live_map"]["inclusions"]
                    and head["live_map"]["sites"]
                ),
            )

    with workbench(tmp_path) as (_, port, token):
        head, arrays = asyncio.run(hears(port, token))
    told = head["live_map"]
    assert [each["stiffness"] for each in told["sites"]] == pytest.approx(list(k))
    assert told["inclusions"][0]["x"] == pytest.approx(found.inclusions[0].x)
    assert told["inclusions"][0]["boundary_95"]
    mean = arrays["mean"].reshape(arrays["y"].size, arrays["x"].size)
    known = np.isfinite(found.surface.mean)
    rows, columns = (np.flatnonzero(known.any(axis=axis)) for axis in (1, 0))
    expected = found.surface.mean[np.ix_(rows, columns)]
    np.testing.assert_allclose(mean, expected, rtol=1e-6)
