"""The declarations of messages are what is told, and the types of the page's scripts."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import get_type_hints

import pytest
from pydantic import TypeAdapter

import tissue_probe as tp
from served import EXAMPLES
from tissue_probe import workbench
from tissue_probe.studies.plan import StudyPlan
from tissue_probe.workbench import desk_messages
from tissue_probe.workbench.desk import Desk
from tissue_probe.workbench.messages import as_json
from tissue_probe.workbench.opened_study import Studied
from tissue_probe.workbench.page_messages import AnswerMessage, Answers, News
from tissue_probe.workbench.page_types import write_types
from tissue_probe.workbench.pictures import Pictures
from tissue_probe.workbench.question import StatedQuestion
from tissue_probe.workbench.request_declarations import REQUESTS, request
from tissue_probe.workbench.workshop import Workshop

LAYOUT = {"force_polarity": "compression"}
#: Of the library, which would take a minute.
TRIED = ("hertz_contact", "cubic_stiffening", "backlash")


def check(kind, name, message):
    """Hold a message, as a page reads it, against its declaration: nothing is missing or beside."""
    read = json.loads(as_json(message))
    adapter = TypeAdapter(get_type_hints(kind)[name])
    assert json.loads(adapter.dump_json(adapter.validate_json(as_json(message)))) == read


@pytest.fixture(scope="module")
def desks(tmp_path_factory):
    """A desk with a ladder, a second recording and a ranking; one that asks; one with a map."""

    sites = tmp_path_factory.mktemp("map") / "sites.csv"
    sites.write_text("x,y,k\n" + "".join(f"{n % 4}e-2,{n // 4}e-2,450\n" for n in range(16)))
    untold = sites.with_name("untold.csv")
    untold.write_text("a,b,c\n" + "".join(f"{n},{n % 3},{n % 5}\n" for n in range(50)))

    async def make():
        workshop = Workshop()
        whole, asking, mapped = (Desk(workshop, workshop) for _ in range(3))
        left_out = tuple(row["name"] for row in tp.effects() if row["name"] not in TRIED)
        whole.asked = StatedQuestion(
            {"rig": "compliant_probe", "starts": "at-rest", "without": left_out}
        )
        opened = [
            await whole.open(EXAMPLES / name, LAYOUT) for name in ("sweep.csv", "sweep_second.csv")
        ]
        await whole.use(opened[0].number, opened[1].number)
        await whole.rank()
        await whole.add("hertz_contact")
        await asking.open(untold, {})
        await mapped.compare_first(await mapped.open(sites, {}))
        await workshop.close()
        return whole, asking, mapped

    return asyncio.run(make())


def test_the_types_of_the_scripts_are_those_of_the_declarations():
    kept = Path(workbench.__file__).parent / "page" / "told.d.ts"
    assert kept.read_text() == write_types(), "write it anew: see page_types"


def test_each_request_has_a_declared_answer():
    assert set(Answers.__annotations__) == set(REQUESTS)


def test_a_desk_is_told_as_it_is_declared(desks):
    whole, asking, mapped = map(desk_messages.desk, desks)
    assert whole["ranking"]["done"]
    assert whole["rungs"][1]["second"] is not None
    assert asking["files"][0]["problem"] is not None
    assert mapped["map"]["sites"]
    # Of a diagnosis the page shows a part.
    TypeAdapter(AnswerMessage).validate_json(as_json(whole["ranking"].pop("answer")))
    for message in (whole, asking, mapped):
        check(News, "desk", message)


def test_choices_and_a_study_are_told_as_they_are_declared():
    check(News, "choices", desk_messages.choices(live=True, commands=False))
    rows = [{"path": "/somewhere/one.csv", "status": "done", "tissue": "liver", "rmse": 0.1}]
    study = Studied(
        "study.yaml", StudyPlan({Path("/somewhere/one.csv"): {"tissue": "liver"}}), rows
    )
    check(News, "study", study.describe_study())


@pytest.mark.parametrize(
    ("name", "more"),
    [
        ("recorded", {}),
        ("lines", {"values": {"damping": 5.0}}),
        ("dots", {"axis": "speed"}),
        ("spectrum", {}),
        ("brush", {"brush": {"axis": "time", "low": 0.1, "high": 0.2}}),
        ("brush", {}),
        ("where", {}),
    ],
)
def test_a_picture_is_told_as_it_is_declared(desks, name, more):
    whole, _, _ = desks
    pictures = Pictures(whole)
    of = {"file": whole.fitted} if name == "recorded" else {"rung": whole.rungs[0].number}
    asked = request({"id": 1, "do": name, **of, **more})[1]
    draw = pictures.draw_recording if name == "recorded" else getattr(pictures, name)
    check(Answers, name, draw(asked)[0])
