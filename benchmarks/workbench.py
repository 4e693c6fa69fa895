"""The workbench in a real browser: how soon a picture follows an action, and what Live costs.

Contents: actions on the page, and their times.

Times are taken on the page, from the action to the first frame in which its picture is drawn.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import psutil
from rich.markup import escape
from rich.table import Table

EXAMPLES = Path(__file__).parents[1] / "examples"
#: How often each action is repeated; the median counts.
REPETITIONS = 7
#: Effects that are added: one that is nonlinear, one that is linear, one with many states.
ADDED = ("hertz_contact", "force_bias", "springpot")
#: Samples of the long record, and of that with a first picture.
LONG, SHORT = 1_000_000, 4_000
#: To reach, by the name of the result.
GOALS = {
    "first picture of a 2 s recording [s]": 1.5,
    "the same with a fitted model [s]": 1.5,
    "zoom in 10^6 samples [s]": 0.1,
    "slider to redraw [s]": 0.05,
    "Add to the next rung, known kernel [s]": 1.0,
    "Add to the next rung, new kernel [s]": 3.0,
    "live: server's processor time, one page [cores]": 0.15,
    "live: samples lost while the page is stopped": 0.0,
}
WAIT = 180_000  # ms


def measure(say: Callable[[str], None] = print) -> dict[str, float]:
    """Return each result by its name.

    Raises
    ------
    SystemExit
        If there is no Chromium.
    """
    path = shutil.which("chromium")
    if path is None:
        raise SystemExit("benchmarks: there is no chromium: apt-get install chromium")
    from playwright.sync_api import sync_playwright

    found: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as name, sync_playwright() as driver:
        folder = Path(name)
        browser = driver.chromium.launch(executable_path=path, args=["--no-sandbox"])
        say("a recording of 2 s is opened, played with, and a ladder is climbed")
        # A cache of its own: what is added for the first time has to be compiled.
        with _server(folder, TISSUE_PROBE_CACHE=str(folder / "cache")) as (address, _):
            found |= _short(browser, address, folder)
        say("a record of 10^6 samples is zoomed")
        long = folder / "long.npz"
        np.savez(long, **_record(LONG))
        with _server(folder, long, "--force-polarity", "compression") as (address, _):
            found |= _long(browser, address)
        browser.close()
        try:
            import rclpy  # noqa: F401
        except ModuleNotFoundError:
            say("there is no ROS: Live is not measured")
            return found
        say("a running suite is watched, and the page stopped for a minute")
        found |= _live(driver, path, folder)
    return found


def table(found: dict[str, float]) -> Table:
    """Return the results beside what they are to reach."""
    shown = Table(title="The workbench in Chromium", title_justify="left")
    for column in ("", "measured", "to reach"):
        shown.add_column(column, justify="right" if column else "left")
    for name, value in found.items():
        shown.add_row(escape(name), f"{value:.3g}", f"<= {GOALS[name]:g}")
    return shown


def _short(browser: Any, address: str, folder: Path) -> dict[str, float]:
    page = _page(browser, address)
    _until(page, "!document.querySelector('#status progress')")
    files = []
    for number in range(REPETITIONS):
        files.append(folder / f"short{number}.csv")
        columns = _record(SHORT, seed=number)
        np.savetxt(files[-1], np.column_stack([*columns.values()]), delimiter=",",
                   header="t,u,F", comments="")  # fmt: skip
    first, fitted = [], []
    for file in files:
        page.keyboard.press("1")
        for _ in range(page.locator("article").count()):
            page.locator("article [aria-label^=Take]").first.click()
        _until(page, "!document.querySelector('article')")
        begun = time.perf_counter()
        page.set_input_files("input.files", file)
        page.wait_for_selector(".work .plot .u-over")
        _until(page, f"document.querySelector('.column .head')?.innerText.includes({file.name!r})")
        first.append(time.perf_counter() - begun)
        page.wait_for_selector(".rung")
        page.wait_for_selector(".work .four .u-over")
        fitted.append(time.perf_counter() - begun)
        _until(page, "!document.querySelector('#status progress')")
    page.keyboard.press("2")
    page.wait_for_selector("[data-parameter=stiffness]")
    slid = [_timed(page, _SLIDE) for _ in range(3 * REPETITIONS)]
    page.keyboard.press("f")
    new = []
    _added(page, "cubic_stiffening")  # what integrates such models is compiled once for all
    _undone(page)
    for effect in ADDED:
        new.append(_added(page, effect))
        _undone(page)
    page.keyboard.press("r")
    page.wait_for_selector(".verdict")
    known = []
    for effect in ADDED:
        known.append(_added(page, effect))
        _undone(page)
    return {
        # The first of all compiles the model.
        "first picture of a 2 s recording [s]": median(first[1:]),
        "the same with a fitted model [s]": median(fitted[1:]),
        "slider to redraw [s]": median(slid),
        "Add to the next rung, known kernel [s]": max(known),
        "Add to the next rung, new kernel [s]": max(new),
    }


#: Moves a slider, and tells when the lines that follow are there and drawn [ms].
_SLIDE = """() => new Promise(async (done) => {
  const app = await import("/app.js");
  const slider = document.querySelector("[data-parameter=stiffness] input[type=range]");
  slider.value = String(400 + ((Number(slider.value) + 137) % 1200));
  const begun = performance.now();
  let heard = false;
  app.on("lines", () => {
    if (heard) return;
    heard = true;
    requestAnimationFrame(() => done(performance.now() - begun));
  });
  slider.dispatchEvent(new Event("input"));
})"""
#: The same of a zoom.
_ZOOM = """() => new Promise(async (done) => {
  const app = await import("/app.js");
  const from = Math.random() * 300, begun = performance.now();
  let heard = false;
  app.on("lines", () => {
    if (heard) return;
    heard = true;
    requestAnimationFrame(() => done(performance.now() - begun));
  });
  app.zoom({ from, to: from + 10 + Math.random() * 150 });
})"""


def _timed(page: Any, script: str) -> float:
    return float(page.evaluate(script)) / 1000.0


def _added(page: Any, effect: str) -> float:
    """Return the time from Add until the next rung stands on the ladder [s]."""
    begun = time.perf_counter()
    page.evaluate(
        f"import('/app.js').then((app) => app.act('add', {{ effect: {effect!r} }})); undefined"
    )
    _until(page, "document.querySelectorAll('.rung').length === 2")
    taken = time.perf_counter() - begun
    _until(page, "!document.querySelector('#status progress')")
    return taken


def _undone(page: Any) -> None:
    page.keyboard.press("u")
    _until(page, "document.querySelectorAll('.rung').length === 1")


def _long(browser: Any, address: str) -> dict[str, float]:
    page = _page(browser, address)
    page.wait_for_selector(".work .plot .u-over")
    _until(page, "!document.querySelector('#status progress')")
    page.wait_for_selector(".marks li")
    zoomed = [_timed(page, _ZOOM) for _ in range(3 * REPETITIONS)]
    return {"zoom in 10^6 samples [s]": median(zoomed)}


def _live(driver: Any, path: str, folder: Path) -> dict[str, float]:
    from tissue_probe.nodes.session import Session, simulation

    with Session(simulation(["robust_ekf"], folder / "run.mcap")) as running:
        running.activate({"/probe/driver": 2})
        with _server(folder, "--live") as (address, process):
            browser = driver.chromium.launch(executable_path=path, args=["--no-sandbox"])
            page = _page(browser, address)
            page.keyboard.press("7")
            page.wait_for_selector("text=robust ekf")
            _spin(running, 5.0)
            server = psutil.Process(process.pid)
            before = _used(server)
            _spin(running, 30.0)
            cores = (_used(server) - before) / 30.0
            lost = _lost(running)
            for each in psutil.Process().children(recursive=True):
                if "chrom" in each.name():
                    os.kill(each.pid, signal.SIGSTOP)
            _spin(running, 60.0)
            lost_stopped = _lost(running) - lost
            for each in psutil.Process().children(recursive=True):
                if "chrom" in each.name():
                    os.kill(each.pid, signal.SIGCONT)
            browser.close()
    return {
        "live: server's processor time, one page [cores]": cores,
        "live: samples lost while the page is stopped": lost_stopped,
    }


def _spin(running: Any, seconds: float) -> None:
    end = time.monotonic() + seconds
    running.wait_until(lambda: time.monotonic() > end, "the time", seconds + 10.0)


def _lost(running: Any) -> float:
    return sum(float(told.get("samples lost", 0)) for told in running.health.values())


def _used(server: psutil.Process) -> float:
    """Return the processor time of the server and of its process that listens [s]."""
    parts = [server, *server.children(recursive=True)]
    return sum(sum(each.cpu_times()[:2]) for each in parts)


@contextmanager
def _server(
    folder: Path, *arguments: object, **variables: str
) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    state = Path(tempfile.mkdtemp(dir=folder))
    process = subprocess.Popen(
        [sys.executable, "-m", "tissue_probe", "workbench", "--no-browser", *map(str, arguments)],
        env={**os.environ, **variables, "XDG_STATE_HOME": str(state)},
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        found = re.search(r"http://\S+", process.stdout.readline())
        if found is None:
            raise SystemExit("benchmarks: the workbench did not start")
        yield found[0], process
    finally:
        process.terminate()
        process.wait(30)


def _page(browser: Any, address: str) -> Any:
    page = browser.new_context(viewport={"width": 1920, "height": 1080}).new_page()
    page.set_default_timeout(WAIT)
    page.goto(address)
    page.wait_for_selector("#stage > *")
    return page


def _until(page: Any, condition: str) -> None:
    end = time.monotonic() + WAIT / 1000
    while not page.evaluate(condition):
        if time.monotonic() > end:
            raise SystemExit(f"benchmarks: waited in vain for {condition}")
        page.wait_for_timeout(5)


def _record(count: int, seed: int = 0) -> dict[str, Any]:
    """Return a sweep on Kelvin-Voigt tissue that stiffens with depth, quasi-static, at 2 kHz."""
    time_ = np.arange(count) / 2000.0
    period = count / 2000.0
    phase = 2 * np.pi * (1.0 * time_ + 10.0 * time_**2 / period)
    position = 1e-3 * np.sin(phase)
    rate = np.gradient(position, time_)
    force = 450.0 * position + 2e7 * position**3 + 2.0 * rate
    noise = np.random.default_rng(seed).standard_normal(count)
    return {"t": time_, "u": position, "F": force + 5e-3 * noise}
