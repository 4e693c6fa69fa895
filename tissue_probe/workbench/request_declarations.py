"""The arguments of each request of a page, declared once; nothing else comes in.

Contents: names, types, bounds.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from tissue_probe.workbench.declaration import Declared, as_object, check_declared, shorten_value
from tissue_probe.workbench.opened_file import check_layout
from tissue_probe.workbench.question import check_question
from tissue_probe.workbench.refusal import RequestRefused

#: Longest request [characters]: effects of one's own are typed, and take some hundred lines.
LONGEST_REQUEST = 2**20
#: No page is wider, nor any plot on one.
WIDEST_PAGE = 8192
#: The largest number that a ROS message holds of rows or columns.
UINT32 = 2**32 - 1

Pixels = Annotated[int, Field(ge=1, le=WIDEST_PAGE)]
Layout = Annotated[dict[str, Any], AfterValidator(check_layout)]
Stated = Annotated[dict[str, Any], AfterValidator(check_question)]
Axis = Literal["time", "indentation", "speed", "phase"]


class Request(Declared):
    """A request, with the number that its answer bears; without more it takes nothing."""

    id: int


class OfFile(Request):
    """A recording, by its number."""

    file: int


class Define(OfFile):
    """A recording, and a form's statements on it."""

    layout: Layout


class Use(Request):
    """Which recording is fitted, and which one models are held against."""

    fitted: int
    second: int | None = None


class Ask(Request):
    """A form's statements on the model."""

    asked: Stated


class Add(Request):
    """An effect, and the rung that it is to stand on."""

    effect: str
    after: int | None = None


class SiteRequest(Request):
    """A site of the scan that is mapped."""

    site: int


class OfRow(Request):
    """A recording of the study, by its row."""

    row: int


class Effects(Request):
    """A program with effects, and the user's consent to run it."""

    text: str = ""
    name: str = "own.py"
    consent: bool = False


class ByName(Request):
    """An example."""

    name: str


class Recorded(OfFile):
    """A recording as it was read; of several in one file that of the number ``part``."""

    part: Annotated[int, Field(ge=0)] = 0
    width: Pixels = 800


class Brush(Declared):
    """Two places on an axis."""

    axis: Literal["frequency", "time", "indentation", "speed", "phase"]
    low: float
    high: float


class LookRequest(Request):
    """A rung on a stretch of the recording that was fitted, or of the second one."""

    rung: int
    source: Literal["fitted", "second"] = "fitted"
    stretch: Annotated[int, Field(ge=0)] = 0
    width: Pixels = 800
    height: Pixels = 800
    brush: Brush | None = None


class Lines(LookRequest):
    """A span of time [s], drawn at other values [SI], or with the curve of an effect."""

    begin: float | None = Field(None, alias="from")
    end: float | None = Field(None, alias="to")
    values: dict[str, float] | None = None
    effect: str | None = None


class Dots(LookRequest):
    """A look over an axis."""

    axis: Axis


class Excitation(Declared):
    """Parameters of the driver's excitation [SI]; the driver judges them."""

    kind: str | None = None
    amplitude: float | None = None
    frequency: float | None = None
    start: float | None = None
    stop: float | None = None
    duration: float | None = None
    steps: Annotated[int | None, Field(ge=0, le=UINT32)] = None
    spacing: float | None = None


class GridRequest(Declared):
    """A grid to be palpated [m, s]; the scan node judges it."""

    origin: Annotated[list[float], Field(min_length=3, max_length=3)]
    spacing: float
    rows: Annotated[int, Field(ge=1, le=UINT32)]
    columns: Annotated[int, Field(ge=1, le=UINT32)]
    dwell_time: float


class Command(Request):
    """A command to the nodes, and its arguments."""

    command: str
    given: dict[str, Any] = {}


#: The requests that pages may make.
REQUESTS: Mapping[str, type[Request]] = {
    **dict.fromkeys(("cancel", "compare", "undo", "rank", "raster", "next"), Request),
    **dict.fromkeys(("forget", "map"), OfFile),
    "recording": OfRow,
    **dict.fromkeys(("spectrum", "brush", "where"), LookRequest),
    "define": Define,
    "use": Use,
    "ask": Ask,
    "add": Add,
    "site": SiteRequest,
    "effects": Effects,
    "example": ByName,
    "recorded": Recorded,
    "lines": Lines,
    "dots": Dots,
    "command": Command,
}
#: The commands to the nodes, and the arguments of each.
COMMANDS: Mapping[str, type[Declared]] = {
    **dict.fromkeys(("configure", "start", "stop", "emergency_stop", "reset", "tare"), Declared),
    "excite": Excitation,
    "scan": GridRequest,
}


def parse_request(text: str | bytes) -> dict[str, Any]:
    """Return a request as the object that it is.

    Raises
    ------
    Refused
        If it is none, or longer than ``LONGEST_REQUEST``.
    """
    if isinstance(text, bytes):
        raise RequestRefused("a request is text, and not bytes")
    if len(text) > LONGEST_REQUEST:
        raise RequestRefused(
            f"a request has {LONGEST_REQUEST} characters at most; this has {len(text)}"
        )
    return as_object(text, "a request")


def request(asked: dict[str, Any]) -> tuple[str, Request]:
    """Return the name of a request, and its declared arguments.

    Raises
    ------
    Refused
        If there is no such request, or it does not fit its declaration.
    """
    name = _choose_named(asked, "do", REQUESTS)
    found = check_declared(REQUESTS[name], {n: v for n, v in asked.items() if n != "do"}, name)
    if isinstance(found, Command):
        command = _choose_named(asked, "command", COMMANDS)
        given = check_declared(COMMANDS[command], found.given, command)
        found = found.model_copy(update={"given": given.model_dump(exclude_none=True)})
    return name, found


def _choose_named(asked: dict[str, Any], key: str, among: Mapping[str, Any]) -> str:
    name = asked.get(key)
    if not isinstance(name, str) or name not in among:
        told = f"is {shorten_value(name)}" if key in asked else "is missing"
        raise RequestRefused(f"a request: `{key}` {told}; give one of {', '.join(among)}")
    return name
