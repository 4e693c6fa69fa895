"""The messages of the server to its pages, as types: the scripts of the page have the same.

Contents: what a page is told unasked, and the answer to each request; samples come behind these as
arrays. ``page_types`` writes the types of the scripts (``page/messages.d.ts``).

A number that is not finite is null in a message (``as_json``): such numbers are ``float | None``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

from typing_extensions import NotRequired, TypedDict


class QuantityMessage(TypedDict):
    """A signal: its names and units, and how many of these make one SI unit."""

    name: Literal["force", "position"]
    unit: Literal["N", "m"]
    rate: str
    drawn: str
    per_drawn: float
    small: str
    per_small: float
    zeroed: bool


class ProblemMessage(TypedDict):
    """Why something cannot be done, and the fields that the sentence names."""

    told: str
    fields: Sequence[str]


class ColumnMessage(TypedDict):
    """A column of a file that could not be read as it is."""

    name: str
    unit: str
    count: int
    first: Sequence[str]
    sketch: Sequence[float | None]


class PreviewMessage(TypedDict):
    """What a file holds that could not be read as it is."""

    kind: Literal["table", "bag", "recording"]
    columns: Sequence[ColumnMessage]
    notes: Sequence[str]


class FileMessage(TypedDict):
    """A recording on the desk; of one that is read, its samples."""

    number: int
    name: str
    layout: Mapping[str, Any]
    ready: bool
    table: bool
    problem: ProblemMessage | None
    preview: PreviewMessage | None
    samples: NotRequired[int]
    rate: NotRequired[float]
    seconds: NotRequired[float]
    sites: NotRequired[int]
    notes: NotRequired[Sequence[str]]


#: A value of a model with its 95 % interval, and the ends of its slider; `from` is no Python name.
ParameterMessage = TypedDict(
    "ParameterMessage",
    {
        "name": str,
        "value": float,
        "deviation": float | None,
        "low": float | None,
        "high": float | None,
        "unit": str,
        "at_limit": bool,
        "from": float,
        "to": float,
    },
)


class StretchesMessage(TypedDict):
    """The stretches of a recording: names, lengths, and the place of the worst."""

    names: Sequence[str]
    worst: int
    seconds: Sequence[float]
    samples: Sequence[int]


class SecondMessage(TypedDict):
    """A model beside the second recording."""

    rmse: float | None
    noise: float
    stretches: StretchesMessage


class RungMessage(TypedDict):
    """A model of the ladder, fitted."""

    number: int
    added: str
    title: str
    output: QuantityMessage
    input: QuantityMessage
    rmse: float
    heldout: float | None
    noise: float
    ratio: float
    converged: bool
    parameters: Sequence[ParameterMessage]
    text: str
    notes: Sequence[str]
    stretches: StretchesMessage
    second: SecondMessage | None
    second_told: str


class ErrorsMessage(TypedDict):
    """The errors that an effect leaves."""

    rmse: float | None
    heldout_rmse: float | None


class RankedMessage(ErrorsMessage):
    """An effect in the answer of a ranking."""

    effect: str
    family: str
    probability: NotRequired[float | None]
    converged: NotRequired[bool]


class ExperimentMessage(TypedDict):
    """The experiment that the diagnosis suggests."""

    excitation: Mapping[str, Any]
    separation: float | None
    shows: Sequence[str]
    calibration: str
    command: str
    command_notes: Sequence[str]


class AnswerMessage(TypedDict):
    """The parts of a diagnosis that a page shows (``DiagnosisResult.to_dict``)."""

    verdict: Literal["adequate", "missing", "ambiguous", "unexplained"]
    sentences: Sequence[str]
    effects: Sequence[str]
    indistinguishable: Sequence[str]
    unseen: Sequence[str]
    ranking: Sequence[RankedMessage]
    suggested_excitation: ExperimentMessage | None


class RankingMessage(TypedDict):
    """Effects beside one rung: errors so far, and the answer when it has ended."""

    rung: int
    rows: Mapping[str, ErrorsMessage]
    done: bool
    answer: NotRequired[AnswerMessage]
    text: NotRequired[str]
    converged: NotRequired[bool]
    physics: NotRequired[Mapping[str, str]]
    rivals: NotRequired[Sequence[str]]
    settings: NotRequired[Mapping[str, str]]
    shape: NotRequired[str | None]


class JobMessage(TypedDict):
    """The job under way; the rows are those of a ranking so far."""

    title: str
    doing: str
    share: float | None
    seconds: float
    rows: Mapping[str, ErrorsMessage]


class SiteMessage(TypedDict):
    """A site of a map; without a recording it has no number."""

    site: int | None
    x: float
    y: float
    stiffness: float | None
    stiffness_sd: float | None
    verdict: str


class InclusionMessage(TypedDict):
    """An inclusion of a map, and the closed lines about it."""

    x: float
    y: float
    probability: float
    stiffness: float | None
    stiffness_sd: float | None
    contrast: float
    boundary_50: Sequence[Sequence[float]]
    boundary_95: Sequence[Sequence[float]]


class MapMessage(TypedDict):
    """A map but its raster; that of a recording has also a number, a file and an open site."""

    text: str
    sites: Sequence[SiteMessage]
    inclusions: Sequence[InclusionMessage]
    contrast: NotRequired[float]
    number: NotRequired[int]
    file: NotRequired[int]
    site: NotRequired[int | None]


class OwnEffectMessage(TypedDict):
    """An effect of the user's own."""

    name: str
    family: str
    physics: str
    file: NotRequired[str]


class DeskMessage(TypedDict):
    """The whole desk."""

    files: Sequence[FileMessage]
    fitted: int | None
    second: int | None
    asked: Mapping[str, Any]
    rungs: Sequence[RungMessage]
    ranking: RankingMessage | None
    map: MapMessage | None
    own: Sequence[OwnEffectMessage]
    job: JobMessage | None
    wants_rig: bool
    refusal: ProblemMessage | None


class ItemMessage(TypedDict):
    """A thing that the page's form asks for."""

    name: str
    kind: str
    about: str
    default: Any
    choices: Sequence[str]
    else_: str
    option: str
    metavar: str
    label: str
    example: str


class RigMessage(TypedDict):
    """A rig, whose it is, and its drawing (SVG)."""

    name: str
    whose: str
    drawing: str


class ExampleMessage(TypedDict):
    """An example that a page may open."""

    name: str
    title: str
    told: str


class ChoicesMessage(TypedDict):
    """The choices of the forms, and whether pages hear ROS and may command its nodes."""

    question: Sequence[ItemMessage]
    rigs: Sequence[RigMessage]
    position_unit: Sequence[str]
    force_unit: Sequence[str]
    time_unit: Sequence[str]
    examples: Sequence[ExampleMessage]
    live: bool
    commands: bool


class StudyMessage(TypedDict):
    """The table of a study: a row for each recording, which the first cell names."""

    name: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str | float | bool | None]]


class VerdictMessage(TypedDict):
    """The monitor's newest verdict on the model."""

    verdict: str
    effects: Sequence[tuple[str, float]]
    error_current: float | None
    error_proposed: float | None
    unseen: Sequence[str]
    experiment: str


class LiveMessage(TypedDict):
    """News of the nodes; samples and estimates come as arrays. Empty: no verdict came yet."""

    estimators: Sequence[str]
    fault: str
    state: str
    verdict: VerdictMessage | None
    health: Sequence[tuple[str, int, str]]


class LinesMessage(TypedDict):
    """Of lines over time: the noise, samples that were not used, whether several lie in a pixel."""

    noise: float
    unused: Sequence[tuple[float, float]]
    dense: bool
    end: float
    rmse: NotRequired[float]


class DotsMessage(TypedDict):
    """Of dots: least and largest x, least and largest y."""

    limits: tuple[float, float, float, float]


class SpectrumMessage(TypedDict):
    """Of a spectrum: the density of the noise."""

    white: float


class BrushMessage(TypedDict):
    """Of brushed samples: their times, how many, and their error."""

    spans: Sequence[tuple[float, float]]
    count: int
    rmse: NotRequired[float]


class RegionMessage(TypedDict):
    """The part of an axis in which an error stands out."""

    begin: float
    end: float
    excess: float
    share: float
    contrast: float


class ProfileMessage(TypedDict):
    """An axis, the region of it in which the error stands out, and the sentence on that."""

    axis: str
    unit: str
    told: str
    here: RegionMessage | None
    foremost: bool


class WhereMessage(TypedDict):
    """Where the model fails, over each axis."""

    regions: Sequence[ProfileMessage]


class NextMessage(TypedDict):
    """Of the suggested experiment: the models whose outputs follow, and what separates them."""

    models: Sequence[str]
    separation: float | None


class NoMessage(TypedDict):
    """Nothing but arrays."""


class Answers(TypedDict):
    """The answer to each request, by its name."""

    cancel: None
    compare: None
    undo: None
    rank: None
    forget: None
    map: None
    recording: None
    define: None
    use: None
    ask: None
    add: None
    site: None
    example: None
    effects: Sequence[OwnEffectMessage]
    command: str
    recorded: NoMessage
    lines: LinesMessage
    dots: DotsMessage
    spectrum: SpectrumMessage
    brush: BrushMessage
    where: WhereMessage
    raster: NoMessage
    next: NextMessage


class News(TypedDict):
    """What pages are told unasked, by its kind."""

    choices: ChoicesMessage
    desk: DeskMessage
    job: JobMessage | None
    study: StudyMessage
    live: LiveMessage
    live_map: MapMessage
