"""The desk without a browser: steps, undo, cancel, and the whole of it again."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import zipfile

import numpy as np
import pytest

import tissue_probe as tp
from served import EXAMPLES
from tissue_probe.studies.plan import StudyPlan
from tissue_probe.workbench import state
from tissue_probe.workbench.desk import Desk
from tissue_probe.workbench.desk_messages import desk as told_of
from tissue_probe.workbench.map_messages import raster
from tissue_probe.workbench.messages import as_json
from tissue_probe.workbench.notebook import notebook
from tissue_probe.workbench.opened_study import Studied, open_study
from tissue_probe.workbench.pages import Page
from tissue_probe.workbench.pictures import Pictures
from tissue_probe.workbench.question import StatedQuestion
from tissue_probe.workbench.refusal import RequestRefused
from tissue_probe.workbench.request_declarations import request
from tissue_probe.workbench.work import Work
from tissue_probe.workbench.workshop import Cancelled, Workshop

LAYOUT = {"force_polarity": "compression"}
OWN = """
import sympy as sp
from tissue_probe.physics.effects.effect import ELASTIC_DEPTH, Effect, Parameter
GAIN = Parameter(sp.Symbol("third_gain", real=True), "N/m^3", 1e7, -1e12, 1e12)
THIRD = Effect("third", "stiffening", "a cubic of one's own", (GAIN,),
               force=GAIN.symbol * ELASTIC_DEPTH**3)
"""


@pytest.fixture(scope="module")
def run():
    """Do steps on a new desk; one worker serves all, since it takes seconds to start."""
    with asyncio.Runner() as runner:
        workshop = runner.run(made())
        yield lambda steps: runner.run(steps(Desk(workshop, workshop)))
        runner.run(workshop.close())


def asked_for(name, **more):
    return request({"id": 1, "do": name, **more})[1]


async def made():
    return Workshop()


async def with_ladder(desk):
    desk.asked = StatedQuestion({"rig": "compliant_probe", "starts": "at-rest"})
    opened = [
        await desk.open(EXAMPLES / name, LAYOUT) for name in ("sweep.csv", "sweep_second.csv")
    ]
    await desk.use(opened[0].number, opened[1].number)
    await desk.add("hertz_contact")


def errors(desk):
    return [(r.added, r.compared.rmse, r.second.rmse) for r in desk.rungs]


@pytest.fixture(scope="module")
def climbed(run, tmp_path_factory):
    """What a ladder of two rungs is, its state in one file, and the same desk made of that."""
    folder = tmp_path_factory.mktemp("desk")

    async def steps(desk):
        await with_ladder(desk)
        path = folder / f"kept{state.STATE_ENDING}"
        path.write_bytes(state.pack_state(desk))
        again = Desk(desk.reading, desk.fitting)
        await state.restore(again, state.unpack_state(path, folder / "again"))
        return desk, again, path

    return run(steps)


def test_the_error_falls_to_the_noise_on_both_recordings(climbed):
    desk, _, _ = climbed
    base, rung = desk.rungs
    assert rung.compared.rmse < 1.1 * rung.compared.noise < base.compared.rmse / 5
    assert rung.second.rmse < 1.1 * rung.second.noise


def test_the_whole_state_in_one_file_gives_the_same_desk(climbed):
    desk, again, _ = climbed
    for one, other in zip(errors(desk), errors(again), strict=True):
        assert one[0] == other[0]
        assert one[1:] == pytest.approx(other[1:], rel=1e-6)
    assert [f.layout for f in again.files.values()] == [LAYOUT, LAYOUT]
    assert again.asked == desk.asked


def test_a_state_that_is_none_or_points_elsewhere_harms_nothing(climbed, tmp_path):
    _, _, path = climbed
    bad = tmp_path / f"bad{state.STATE_ENDING}"
    bad.write_bytes(b"PK\x03\x04 and no more")
    with pytest.raises(RequestRefused, match="no state"):
        state.unpack_state(bad, tmp_path / "in")
    with zipfile.ZipFile(path) as archive:
        told = json.loads(archive.read(state.MEMBER))
    told["files"][0]["path"] = "../../outside.csv"
    with zipfile.ZipFile(bad, "w") as archive:
        archive.writestr("../../outside.csv", "t,u,F\n")
        archive.writestr(told["files"][1]["path"], "t,u,F\n")
        archive.writestr(state.MEMBER, json.dumps(told))
    found = state.unpack_state(bad, tmp_path / "in")
    inside = (tmp_path / "in").resolve()
    assert all(os.path.realpath(f["path"]).startswith(str(inside)) for f in found["files"])
    assert not (tmp_path.parent / "outside.csv").exists()


def test_the_notebook_repeats_each_step(climbed, tmp_path, monkeypatch):
    desk, _, _ = climbed
    for name in ("sweep.csv", "sweep_second.csv"):
        (tmp_path / name).write_bytes((EXAMPLES / name).read_bytes())
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for cell in json.loads(notebook(desk))["cells"]:
        if cell["cell_type"] == "code":
            exec(cell["source"], names)
    assert names["rung1"].rmse == pytest.approx(desk.rungs[1].compared.rmse, rel=1e-6)
    assert (tmp_path / "model.yaml").exists()


def test_what_a_page_is_told_is_json(climbed):
    desk, _, _ = climbed
    told = json.loads(json.dumps(told_of(desk)))
    assert [rung["title"] for rung in told["rungs"]] == [
        "Kelvin-Voigt", "Kelvin-Voigt + hertz_contact",
    ]  # fmt: skip
    for parameter in told["rungs"][1]["parameters"]:
        assert parameter["from"] <= parameter["value"] <= parameter["to"]


def test_a_zoom_is_drawn_of_the_samples_in_it(climbed):
    desk, _, _ = climbed
    asked = {"rung": desk.rungs[1].number, "stretch": 0, "from": 1.0, "to": 1.05, "width": 500}
    told, arrays = Pictures(desk).lines(asked_for("lines", **asked))
    period = arrays["time"][1] - arrays["time"][0]
    assert arrays["time"][0] == pytest.approx(1.0, abs=2 * period)
    assert arrays["time"][-1] == pytest.approx(1.05, abs=2 * period)
    measured = desk.files[desk.fitted].measured.force
    first = round(arrays["time"][0] / period)
    expected = measured[first : first + arrays["time"].size]
    assert arrays["measured"] == pytest.approx(expected, rel=1e-5)
    assert told["end"] == pytest.approx(4.0)


@pytest.mark.parametrize(
    "asked",
    [
        {"rung": 10**6}, {"stretch": 7}, {"values": {"nothing": 1.0}}, {"effect": "backlash"},
        {"source": "second", "effect": "backlash"},
    ],
)  # fmt: skip
def test_a_picture_that_cannot_be_drawn_is_refused_in_a_sentence(climbed, asked):
    from tissue_probe.errors import TissueProbeError

    desk, _, _ = climbed
    with pytest.raises(TissueProbeError):
        Pictures(desk).lines(asked_for("lines", **{"rung": desk.rungs[0].number, **asked}))


def test_a_search_that_is_cancelled_ends_at_once_and_leaves_a_desk_that_works(run):
    async def steps(desk):
        await with_ladder(desk)
        desk.undo()
        told = asyncio.Event()
        desk.briefly = lambda: told.set() if desk.job and desk.job.doing else None
        search = asyncio.create_task(desk.rank())
        await asyncio.wait_for(told.wait(), 60)
        desk.cancel()
        with pytest.raises(Cancelled):
            await search
        assert desk.job is None
        await desk.add("force_bias")
        return [rung.added for rung in desk.rungs]

    assert run(steps) == ["", "force_bias"]


def test_a_worker_that_dies_is_told_and_replaced(run):
    async def steps(desk):
        shop = desk.fitting
        shop.cancel()  # nothing is under way: nothing is ended
        work = asyncio.create_task(shop.do(Work("warm", {})))
        while shop._process is None or not shop._one_at_a_time.locked():
            await asyncio.sleep(0)
        os.kill(shop._process.pid, signal.SIGKILL)
        with pytest.raises(RequestRefused, match="ended from outside"):
            await work
        return await shop.do(Work("preview", {"path": str(EXAMPLES / "sweep.csv")}))

    assert [each.name for each in run(steps).columns] == ["t", "u", "F"]


def test_effects_of_ones_own_go_up_the_ladder(run, tmp_path):
    file = tmp_path / "own.py"
    file.write_text(OWN)

    async def steps(desk):
        desk.asked = StatedQuestion({"rig": "compliant_probe", "starts": "at-rest"})
        opened = await desk.open(EXAMPLES / "sweep.csv", LAYOUT)
        await desk.use(opened.number, None)
        found = await desk.take_effects(file)
        await desk.add("third")
        return [each["name"] for each in found], desk.rungs[-1].compared.fit.composition.names

    assert run(steps) == (["third"], ("third",))


def test_a_page_that_does_not_read_gets_the_newest_only():
    class Slow:
        def __init__(self):
            self.sent, self.may = [], asyncio.Event()

        async def send_text(self, text):
            await self.may.wait()
            self.sent.append(text)

    async def inside():
        socket = Slow()
        page = Page(socket)
        sending = asyncio.create_task(page.send())
        for number in range(1000):
            page.tell("live", lambda number=number: str(number))
            if number == 0:
                await asyncio.sleep(0.01)  # the first is under way
        socket.may.set()
        while len(socket.sent) < 2:
            await asyncio.sleep(0)
        sending.cancel()
        return socket.sent

    assert asyncio.run(inside()) == ["0", "999"]


def test_a_recording_is_seen_before_any_model_is_fitted(run):
    async def steps(desk):
        opened = await desk.open(EXAMPLES / "sweep.csv", LAYOUT)
        assert desk.rungs == []
        return opened.measured, Pictures(desk).draw_recording(
            asked_for("recorded", file=opened.number, width=8000)
        )[1]

    measured, arrays = run(steps)
    np.testing.assert_allclose(arrays["force"], measured.force, rtol=1e-6)
    np.testing.assert_allclose(arrays["position"], measured.position, rtol=1e-6)
    np.testing.assert_allclose(arrays["time"], measured.time - measured.time[0], atol=1e-9)


def test_each_effects_curve_is_there_while_others_are_still_tried(run):
    async def steps(desk):
        desk.asked = StatedQuestion({"rig": "compliant_probe", "starts": "at-rest"})
        opened = await desk.open(EXAMPLES / "sweep.csv", LAYOUT)
        await desk.use(opened.number, None)
        (rung,), pictures, found = desk.rungs, Pictures(desk), {}
        asked = {"rung": rung.number, "stretch": 0, "width": 8000}

        def look():
            for effect, errors in desk.ranking.told.items() if desk.ranking else ():
                if effect not in found and desk.ranking.result is None:
                    found[effect] = (
                        pictures.lines(asked_for("lines", **asked, effect=effect))[1],
                        errors["rmse"],
                    )

        desk.briefly = look
        search = asyncio.create_task(desk.rank())
        while len(found) < 3 and not search.done():
            await asyncio.sleep(0.01)
        desk.cancel()
        with pytest.raises(Cancelled):
            await search
        return found, rung.compared.fit.measurements[0].used

    found, used = run(steps)
    assert len(found) >= 3
    for arrays, rmse in found.values():
        left = (arrays["residual"] - arrays["explained"])[used]
        # The curve may be that of a later search, whose error is not told yet.
        assert 0.9 * rmse < np.sqrt(np.mean(left**2)) < 1.001 * rmse


def test_a_table_of_sites_has_a_map_and_nothing_to_fit(run, tmp_path):
    x, y = (each.ravel() for each in np.meshgrid(np.arange(5) / 100.0, np.arange(5) / 100.0))
    k = 450.0 + 4.0 * np.random.default_rng(1).standard_normal(x.size)
    k[12] = 1100.0
    rows = np.column_stack([x, y, k, 0.01 * k])
    path = tmp_path / "sites.csv"
    np.savetxt(path, rows, delimiter=",", header="x,y,k,k_sd", comments="")

    async def steps(desk):
        opened = await desk.open(path)
        await desk.compare_first(opened)
        with pytest.raises(RequestRefused, match="table of sites"):
            await desk.use(opened.number, None)
        again = Desk(desk.reading, desk.fitting)
        await state.restore(again, state.state(desk))
        return json.loads(as_json(told_of(desk))), raster(desk.map)[1], again.map

    told, arrays, again = run(steps)
    (file,), found = told["files"], told["map"]
    assert (file["table"], file["ready"]) == (True, False)
    assert [site["stiffness"] for site in found["sites"]] == pytest.approx(list(k))
    assert found["inclusions"][0]["probability"] > 0.9
    middle = np.abs(arrays["y"] - 0.02).argmin() * arrays["x"].size
    middle += np.abs(arrays["x"] - 0.02).argmin()
    assert arrays["mean"][middle] > 800.0
    assert arrays["probability"][middle] > 0.5
    assert again.text == found["text"]


def test_a_map_of_a_recording_without_sites_is_refused_in_words(run):
    async def steps(desk):
        opened = await desk.open(EXAMPLES / "sweep.csv", LAYOUT)
        await desk.draw_map(opened.number)

    with pytest.raises(RequestRefused, match=r"sweep\.csv announces no palpation sites"):
        run(steps)


def studied(path, **question):
    """Return a study of one recording that was run, with these statements in its plan."""
    plan = StudyPlan({path: {}}, question=question)
    return Studied("study.yaml", plan, [{"path": str(path), "status": "done"}])


def test_a_recording_of_the_study_is_asked_about_as_the_study_does(run):
    async def steps(desk):
        desk.asked = StatedQuestion(
            {"rig": "tolerant_probe", "site": 3, "constants": {"damping": (0.0, 0.0)}}
        )
        desk.study = studied(
            EXAMPLES / "sweep.csv",
            **LAYOUT,
            rig="compliant_probe",
            constants={"tip_mass": [0.04, 0.001], "load_cell_damping": 0},
            without="springpot",
            prior=None,
        )
        await desk.open_recording(0)
        return desk

    desk = run(steps)
    assert desk.asked == StatedQuestion(
        {
            "rig": "compliant_probe",
            "constants": {"tip_mass": (0.04, 0.001), "load_cell_damping": (0.0, 0.0)},
            "without": ("springpot",),
        }
    )
    assert desk.fitted is not None
    assert len(desk.rungs) == 1


def test_a_recording_of_the_study_that_cannot_be_read_says_so(run, tmp_path):
    broken = tmp_path / "broken.csv"
    broken.write_text("time\n0\n0\n")

    async def steps(desk):
        before = await with_ladder(desk)
        desk.study = studied(broken, rig="compliant_probe")
        with pytest.raises(RequestRefused, match=r"broken\.csv"):
            await desk.open_recording(0)
        return before

    run(steps)


def test_rows_of_another_question_are_not_those_of_the_plan(tmp_path):
    (tmp_path / "empty.csv").write_text("time\n0\n")
    plan = tmp_path / "study.yaml"
    plan.write_text("{recordings: '*.csv', question: {rig: compliant_probe}}")
    tp.study(plan, workers=1)
    assert len(open_study(plan).rows) == 1
    plan.write_text("{recordings: '*.csv', question: {rig: rigid_probe}}")
    with pytest.raises(
        RequestRefused, match="no rows of its question yet: run `tissue_probe study run"
    ):
        open_study(plan)
