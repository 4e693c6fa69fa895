"""The desk: recordings, the ladder of models, the ranking, the map; and its changes.

Contents: the order of the steps.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tissue_probe.workbench.opened_file import Opened
from tissue_probe.workbench.page_messages import ErrorsMessage, OwnEffectMessage
from tissue_probe.workbench.question import StatedQuestion
from tissue_probe.workbench.refusal import RequestRefused
from tissue_probe.workbench.work import READING, Work, predict_file
from tissue_probe.workbench.workshop import Cancelled, Workshop

if TYPE_CHECKING:
    from tissue_probe.analysis.comparing import ComparisonResult, Fit
    from tissue_probe.analysis.diagnosing import DiagnosisResult
    from tissue_probe.analysis.mapping import MapResult
    from tissue_probe.analysis.measurements import Measurements
    from tissue_probe.workbench.opened_study import Studied


@dataclass
class Rung:
    """One model of the ladder: fitted, and held against a second recording.

    Attributes
    ----------
    number : int
        Of all rungs there ever were, so that no picture of an older one is taken for it.
    added : str
        The effect that the rung before did not have; empty for the first.
    compared, second : ComparisonResult
        On the fitted recordings, and on the second recording if there is one.
    second_told : str
        Why there is nothing on the second recording.
    """

    number: int
    added: str
    compared: ComparisonResult
    second: ComparisonResult | None = None
    second_told: str = ""


@dataclass
class Ranking:
    """Effects beside one rung: those told so far, and the diagnosis when it has ended.

    ``shape`` is the picture of the missing force's shape, if one is claimed; ``kept`` the folder of
    each effect's prediction.
    """

    rung: int
    told: dict[str, ErrorsMessage] = field(default_factory=dict)
    result: DiagnosisResult | None = None
    answer: dict[str, Any] = field(default_factory=dict)
    shape: str | None = None
    kept: TemporaryDirectory[str] = field(default_factory=TemporaryDirectory)

    def of(self, rung: Rung, effect: str) -> Fit | None:
        """Return the fit of an effect beside a rung; None if there is none."""
        if self.result is None or self.rung != rung.number:
            return None
        known = {row["effect"] for row in self.answer["ranking"] if row["rmse"] is not None}
        return self.result.beside(effect) if effect in known else None

    def explain_residual(self, rung: Rung, effect: str, stretch: int) -> NDArray[np.float64]:
        """Return the part of the residual that an effect alone explains, if it is known by now.

        Raises
        ------
        Refused
            If the ranking is beside another rung, or has not come to the effect.
        """
        if self.rung != rung.number:
            raise RequestRefused("the ranking is of another model")
        if self.result is not None:
            return self.result.explain_by(effect, stretch)
        path = predict_file(Path(self.kept.name), effect, stretch)
        if effect not in self.told or not path.exists():
            raise RequestRefused(f"{effect} is not fitted yet")
        return np.fromfile(path) - rung.compared.fit.predicted[stretch]


@dataclass
class Job:
    """The job under way, and where; its last message, the share done, when it began [s]."""

    title: str
    shop: Workshop
    doing: str = ""
    share: float | None = None
    begun: float = field(default_factory=time.time)


class Desk:
    """All that pages show and change; every page shows the same desk.

    Parameters
    ----------
    reading, fitting : Workshop
        Do the long work: a file is read, and seen, while the other still makes itself ready.
    """

    def __init__(self, reading: Workshop, fitting: Workshop) -> None:
        self.reading, self.fitting = reading, fitting
        self.files: dict[int, Opened] = {}
        self.fitted: int | None = None
        self.second: int | None = None
        self.asked = StatedQuestion()
        self.effects: tuple[str, ...] = ()
        self.own: list[OwnEffectMessage] = []
        self.rungs: list[Rung] = []
        self.ranking: Ranking | None = None
        self.map: MapResult | None = None
        self.study: Studied | None = None
        #: Why there is no first rung; None where there is one, or none was wanted.
        self.refusal: RequestRefused | None = None
        #: Which recording the map is of, and the map's own number.
        self.mapped: tuple[int, int] | None = None
        self.job: Job | None = None
        #: To be called after each change; ``briefly`` after changes of the job alone.
        self.changed: Callable[[], None] = lambda: None
        self.briefly: Callable[[], None] = lambda: None
        self._count = 0

    def cancel(self) -> None:
        """End the job under way, if there is one."""
        if self.job is not None:
            self.job.shop.cancel()

    def rung(self, number: int) -> Rung:
        """Return a rung of the ladder by its number.

        Raises
        ------
        Refused
            If it is no more there.
        """
        for rung in self.rungs:
            if rung.number == number:
                return rung
        raise RequestRefused("this model is no more on the ladder")

    def file(self, number: int) -> Opened:
        """Return a recording by its number.

        Raises
        ------
        Refused
            If there is none.
        """
        if number not in self.files:
            raise RequestRefused("this recording is no more on the desk")
        return self.files[number]

    async def open(
        self, path: Path, layout: dict[str, Any] | None = None, name: str = "", owned: bool = False
    ) -> Opened:
        """Put a recording on the desk, and read it if nothing more must be known for that."""
        opened = Opened(self._next(), path, name or path.name, dict(layout or {}), owned)
        self.files[opened.number] = opened
        self.changed()
        await self._read(opened)
        first = self.files.get(self.fitted) if self.fitted is not None else None
        if opened.problem is not None and not opened.layout and first and first.layout:
            # The statements on the first hold for others without their own.
            opened.layout = dict(first.layout)
            await self._read(opened)
        return opened

    async def compare_first(self, opened: Opened) -> None:
        """Compare a recording that was read, if none is chosen yet; map a table of sites."""
        if opened.table:
            await self.draw_map(opened.number)
        if opened.measured is not None and self.fitted in (None, opened.number):
            await self.use(opened.number, self.second)

    async def define(self, number: int, layout: dict[str, Any]) -> None:
        """Read a recording by the user's statements."""
        opened = self.file(number)
        opened.layout = layout
        if number in (self.fitted, self.second):
            self._forget_fits()
        await self._read(opened)
        await self.compare_first(opened)

    async def _read(self, opened: Opened) -> None:
        opened.measured = opened.problem = None
        opened.table = False
        arguments = {"path": str(opened.path), "layout": opened.layout}
        try:
            opened.measured = await self._do(f"{opened.name} is read", "read", arguments)
            opened.table = opened.measured is None
        except Cancelled as error:
            opened.problem = error
        except RequestRefused as error:
            opened.problem = RequestRefused(str(error).replace(str(opened.path), opened.name))
            await self._look_into(opened)
        finally:
            self.changed()

    async def _look_into(self, opened: Opened) -> None:
        """Show the contents of a file that cannot be read as it is, as far as they can be told."""
        if opened.preview is None:
            try:
                arguments = {"path": str(opened.path)}
                opened.preview = await self._do("a look into the file", "preview", arguments)
            except RequestRefused:
                return

    def forget(self, number: int) -> None:
        """Take a recording from the desk, and the results on it."""
        opened = self.file(number)
        if opened.owned:
            opened.path.unlink(missing_ok=True)
        del self.files[number]
        if self.mapped is not None and number == self.mapped[0]:
            self.map = self.mapped = None
        if number == self.fitted:
            self.fitted = None
            self._forget_fits()
        if number == self.second:
            self.second = None
            for rung in self.rungs:
                rung.second, rung.second_told = None, ""
        self.changed()

    async def use(self, fitted: int, second: int | None) -> None:
        """Choose which recording is fitted, and which other one the models are held against."""
        for each in (fitted, second):
            if each is not None:
                self._read_already(self.file(each))
        if second == fitted:
            raise RequestRefused(
                "`validate` is the fitted recording; give another recording of the specimen"
            )
        again = fitted != self.fitted or not self.rungs
        self.fitted, self.second = fitted, second
        if self._has_sites(fitted) and self.asked.of_samples()["site"] is None:
            self._forget_fits()
            await self.draw_map(fitted)
            return
        if again:
            await self.compare()
        else:
            for rung in self.rungs:
                await self._hold_against_second(rung)
        self.changed()

    def _read_already(self, opened: Opened) -> Measurements:
        if opened.table:
            raise RequestRefused(f"{opened.name} is a table of sites: it has no samples to fit")
        if opened.measured is None:
            raise RequestRefused(
                f"{opened.name} is not read yet: state the values that it asks for"
            )
        return opened.measured

    def _has_sites(self, number: int) -> bool:
        measured = self.file(number).measured
        sites = (
            {s.site for part in measured.parts for s in part.recording.sites} if measured else ()
        )
        return len(sites) > 1

    async def ask(self, changes: dict[str, Any]) -> None:
        """Ask about another model, or the same otherwise; the ladder begins anew."""
        self.asked = self.asked.changed(changes)
        self.changed()
        if self.fitted is not None and self.file(self.fitted).measured is not None:
            await self.compare()

    @property
    def wants_rig(self) -> bool:
        """Whether nobody has said on which rig the chosen recording was measured."""
        measured = self.files[self.fitted].measured if self.fitted in self.files else None
        own = measured is None or all(part.is_own for part in measured.parts)
        return self.asked.parameters()["rig"] is None and not own

    async def compare(self) -> None:
        """Fit the model that is asked about to the chosen recording: the first rung.

        Nothing is fitted before the rig is known; the page asks for it.
        """
        self._forget_fits()
        self.changed()
        if self.fitted is None:
            raise RequestRefused("open a recording first")
        if self.wants_rig:
            return
        arguments = {
            "measured": self.file(self.fitted).measured,
            "asked": self.asked.parameters() | {"effects": self.effects},
        }
        try:
            compared = await self._do("the model is fitted", "compare", arguments)
        except RequestRefused as error:
            self.refusal = error
            self.changed()
            raise
        await self._put_up("", compared)

    async def add(self, effect: str, after: int | None = None) -> None:
        """Add an effect to the last rung, or to another one: those above it are taken down."""
        base = self._last() if after is None else self.rung(after)
        begin = self.ranking.of(base, effect) if self.ranking else None
        arguments = {"compared": base.compared, "effect": effect, "begin": begin}
        compared = await self._do(f"{effect} is added", "add", arguments)
        self.rungs = self.rungs[: self.rungs.index(base) + 1]
        await self._put_up(effect, compared)

    def undo(self) -> None:
        """Take the last rung down."""
        if len(self.rungs) < 2:
            raise RequestRefused("there is no effect to take away")
        self.rungs.pop()
        self.changed()

    async def _put_up(self, added: str, compared: ComparisonResult) -> None:
        rung = Rung(self._next(), added, compared)
        self.rungs.append(rung)
        self.changed()
        await self._hold_against_second(rung)
        self.changed()

    async def _hold_against_second(self, rung: Rung) -> None:
        rung.second, rung.second_told = None, ""
        if self.second is None:
            return
        asked = {**self.asked.of_samples(), "model": rung.compared.model}
        arguments = {"measured": self.file(self.second).measured, "asked": asked}
        try:
            rung.second = await self._do("the second recording is compared", "compare", arguments)
        except RequestRefused as error:
            rung.second_told = str(error)

    async def rank(self) -> None:
        """Try every effect beside the last rung."""
        base = self._last()
        self.ranking = ranking = Ranking(base.number)
        self.changed()

        def hear(told: dict[str, Any]) -> None:
            if effect := told.get("effect"):
                ranking.told[effect] = {
                    "rmse": told["rmse"],
                    "heldout_rmse": told["heldout_rmse"],
                }

        second = None if self.second is None else self.file(self.second).measured
        assert self.fitted is not None
        asked = self.asked.parameters() | {"effects": self.effects}
        if base is not self.rungs[0]:
            asked = {n: v for n, v in asked.items() if n not in ("rig", "tissue", "effects")}
            asked["model"] = base.compared.model
        arguments = {
            "measured": self.file(self.fitted).measured, "second": second, "asked": asked,
            "folder": ranking.kept.name,
        }  # fmt: skip
        try:
            ranking.result = await self._do("effects are tried", "rank", arguments, hear)
            ranking.answer = ranking.result.to_dict()
            ranking.shape = await asyncio.to_thread(ranking.result.draw_shape)
        except RequestRefused:
            if not ranking.told and self.ranking is ranking:
                self.ranking = None
            raise
        finally:
            self.changed()

    async def draw_map(self, number: int) -> None:
        """Map the stiffness over the sites of a scan, or of a table of them."""
        opened = self.file(number)
        measured = str(opened.path) if opened.table else self._read_already(opened)
        self.map = await self._do("the map is made", "scan", {"measured": measured})
        self.mapped = number, self._next()
        self.changed()

    async def open_site(self, site: int) -> None:
        """Compare the model with the samples at one site of the mapped scan."""
        if self.mapped is None:
            raise RequestRefused("there is no map")
        self._read_already(self.file(self.mapped[0]))
        self.fitted, self.second = self.mapped[0], None
        await self.ask({"site": site})

    async def open_recording(self, row: int) -> None:
        """Compare the model with a recording of the study, read and asked about as the study does.

        Raises
        ------
        Refused
            If there is no study, it has no such row, or the recording cannot be read.
        """
        if self.study is None:
            raise RequestRefused("there is no study: start the workbench with `study`")
        path = self.study.path(row)
        there = [each for each in self.files.values() if each.path == path]
        opened = there[0] if there else await self.open(path, self.study.layout)
        if opened.problem is not None:
            raise opened.problem
        self._read_already(opened)
        self.asked = StatedQuestion().changed(self.study.asked)
        self._forget_fits()
        await self.use(opened.number, None)

    async def take_effects(self, path: Path) -> list[OwnEffectMessage]:
        """Run a file of effects of the user's own, and take them among those that are tried."""
        found: list[OwnEffectMessage] = await self._do(
            "effects of your own are checked", "check_effects", {"path": str(path)}
        )
        self.effects = (*(each for each in self.effects if each != str(path)), str(path))
        self.own = [*(e for e in self.own if e["file"] != path.name),
                    *(_note_file(each, path.name) for each in found)]  # fmt: skip
        if self.fitted is not None and self.rungs:
            added = [rung.added for rung in self.rungs[1:]]
            await self.compare()
            await self.add_all(added)
        self.changed()
        return found

    async def add_all(self, effects: Iterable[str]) -> None:
        """Add effects one after the other."""
        for effect in effects:
            await self.add(effect)

    async def report(self) -> bytes:
        """Return the report on the ladder."""
        self._last()
        assert self.fitted is not None
        second = None if self.second is None else self.file(self.second).measured
        arguments = {
            "measured": self.file(self.fitted).measured,
            "second": second,
            "asked": self.asked.parameters() | {"effects": self.effects},
            "added": [rung.added for rung in self.rungs[1:]],
        }
        found: bytes = await self._do("the report is written", "report", arguments)
        return found

    def _last(self) -> Rung:
        if not self.rungs:
            raise RequestRefused("there is no model yet: open a recording first")
        return self.rungs[-1]

    def _forget_fits(self) -> None:
        self.rungs, self.ranking, self.refusal = [], None, None

    def _next(self) -> int:
        self._count += 1
        return self._count

    async def _do(
        self,
        title: str,
        name: str,
        arguments: dict[str, Any],
        hear: Callable[[dict[str, Any]], None] = lambda told: None,
    ) -> Any:
        """Have work done, and tell its progress meanwhile."""
        shop = self.reading if name in READING else self.fitting
        job = Job(title, shop)

        def listen(told: dict[str, Any]) -> None:
            if self.job is None:
                self.job = job
            job.doing = told.get("doing", job.doing)
            job.share = told.get("share", job.share)
            hear(told)
            self.briefly()

        self.job = job
        self.briefly()
        try:
            return await shop.do(Work(name, arguments, self.effects), listen)
        finally:
            if self.job is job:
                self.job = None
            self.briefly()


def _note_file(effect: OwnEffectMessage, file: str) -> OwnEffectMessage:
    return {**effect, "file": file}
