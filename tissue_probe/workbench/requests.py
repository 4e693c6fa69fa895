"""The answers to a page's requests: changes of the desk, and pictures of it.

Contents: each request by its name, and how it is answered.

A request is ``{"id": n, "do": name, ...}``; the answer ``{"id": n, "ok": ...}``, with arrays behind
it where there are samples, or ``{"id": n, "refused": sentence, "fields": [...]}``.
"""

from __future__ import annotations

import asyncio
import traceback
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from tissue_probe.errors import TissueProbeError
from tissue_probe.workbench import desk_messages, examples, request_declarations, uploads
from tissue_probe.workbench.declaration import shorten_value
from tissue_probe.workbench.desk import Desk
from tissue_probe.workbench.live import LiveListener
from tissue_probe.workbench.map_messages import raster
from tissue_probe.workbench.messages import as_json, pack_message
from tissue_probe.workbench.next_experiment import next_experiment
from tissue_probe.workbench.page_messages import ChoicesMessage
from tissue_probe.workbench.pages import Page, Pages
from tissue_probe.workbench.pictures import Arrays, Pictures
from tissue_probe.workbench.refusal import RequestRefused, describe_refusal
from tissue_probe.workbench.request_declarations import ByName, Command, Effects, OfFile, Request
from tissue_probe.workbench.workshop import Cancelled

Change = Callable[[Any], Awaitable[Any]]


class Requests:
    """Answers the pages of one desk.

    Changes are made one after the other; a search for effects that is under way gives way to them.
    Pictures are drawn meanwhile, in a thread of their own.

    Parameters
    ----------
    desk : Desk
        The desk that is shown.
    folder : path
        Where examples and typed effects are kept.
    live : bool
        Whether ROS is listened to.
    commands : bool
        Whether pages may command the nodes.
    """

    def __init__(
        self, desk: Desk, folder: Path, live: bool = False, commands: bool = False
    ) -> None:
        self.desk, self.pages, self._folder = desk, Pages(), folder
        self.live = LiveListener(self.pages) if live else None
        self._commands = commands
        self._pictures = Pictures(desk)
        self._drawing = ThreadPoolExecutor(1, "pictures")
        self._changing = asyncio.Lock()
        self._tasks: set[asyncio.Task[None]] = set()
        self._searching = False
        desk.changed = lambda: self.pages.tell("desk", lambda: desk_messages.desk(desk))
        desk.briefly = lambda: self.pages.tell("job", lambda: desk_messages.job(desk))
        self._changes: dict[str, Change] = {
            "define": lambda a: desk.define(a.file, a.layout),
            "forget": self._forget,
            "use": lambda a: desk.use(a.fitted, a.second),
            "ask": lambda a: desk.ask(a.asked),
            "compare": lambda a: desk.compare(),
            "add": lambda a: desk.add(a.effect, a.after),
            "undo": self._undo,
            "rank": self._rank,
            "map": lambda a: desk.draw_map(a.file),
            "site": lambda a: desk.open_site(a.site),
            "recording": lambda a: desk.open_recording(a.row),
            "effects": self._take_effects,
            "example": self._example,
        }
        self._drawn: dict[str, Callable[[Any], tuple[object, Arrays]]] = {
            "recorded": self._pictures.draw_recording,
            "lines": self._pictures.lines,
            "dots": self._pictures.dots,
            "spectrum": self._pictures.spectrum,
            "brush": self._pictures.brush,
            "where": self._pictures.where,
            "raster": lambda a: raster(desk.map),
            "next": lambda a: next_experiment(desk.ranking.result if desk.ranking else None),
        }

    def close(self) -> None:
        """Answer no more."""
        for task in self._tasks:
            task.cancel()
        self._drawing.shutdown(wait=False, cancel_futures=True)

    def greet(self, page: Page) -> None:
        """Tell a page that has just come everything."""
        page.tell("choices", lambda: as_json({"choices": self._choices()}))
        page.tell("desk", lambda: as_json({"desk": desk_messages.desk(self.desk)}))
        if (study := self.desk.study) is not None:
            page.tell("study", lambda: as_json({"study": study.describe_study()}))
        if self.live is not None and (found := self.live.map) is not None:
            page.tell("live_map", lambda: found)

    def hear(self, page: Page, text: str | bytes) -> None:
        """Answer a request when it is done."""
        task = asyncio.create_task(self._answer(page, text))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def change(self, change: Callable[[], Awaitable[Any]]) -> Any:
        """Make a change when those before it are made; a search for effects gives way."""
        if self._searching:
            self.desk.cancel()
        async with self._changing:
            return await change()

    def _choices(self) -> ChoicesMessage:
        return desk_messages.choices(self.live is not None, self._commands)

    async def _answer(self, page: Page, text: str | bytes) -> None:
        number = None
        try:
            asked = request_declarations.parse_request(text)
            number = asked["id"] if isinstance(asked.get("id"), int) else None
            page.answer(await self._result(*request_declarations.request(asked)))
        except (TissueProbeError, OSError) as error:
            page.answer(self._refusal(number, describe_refusal(error)))
        except Exception as error:  # a page must not wait for ever
            traceback.print_exc()
            told_all = f"an error of the program itself: {type(error).__name__}: {error}"
            page.answer(self._refusal(number, RequestRefused(told_all)))

    def _refusal(self, number: int | None, error: RequestRefused) -> str:
        sentence = desk_messages.without_paths(self.desk, str(error))
        answer = {"id": number, "refused": sentence, "fields": error.fields}
        return as_json(answer | {"cancelled": isinstance(error, Cancelled)})

    async def _result(self, name: str, asked: Request) -> bytes | str:
        number = asked.id
        if name == "cancel":
            self.desk.cancel()
            return as_json({"id": number, "ok": None})
        if draw := self._drawn.get(name):
            loop = asyncio.get_running_loop()
            drawn, arrays = await loop.run_in_executor(self._drawing, draw, asked)
            return pack_message({"id": number, "ok": drawn}, arrays)
        if isinstance(asked, Command):
            return as_json({"id": number, "ok": await self._command(asked)})
        change = self._changes[name]
        result = await self.change(lambda: change(asked))
        return as_json({"id": number, "ok": result})

    async def _command(self, asked: Command) -> Any:
        if self.live is None:
            raise RequestRefused("nobody listens to ROS: start the workbench with `live`")
        if not self._commands:
            raise RequestRefused("pages may only listen: start the workbench with `allow_commands`")
        return await self.live.command(asked.command, asked.given)

    async def _forget(self, asked: OfFile) -> None:
        self.desk.forget(asked.file)

    async def _undo(self, asked: Request) -> None:
        self.desk.undo()

    async def _rank(self, asked: Request) -> None:
        self._searching = True
        try:
            await self.desk.rank()
        finally:
            self._searching = False

    async def _example(self, asked: ByName) -> None:
        if asked.name not in examples.EXAMPLES:
            raise RequestRefused(f"there is no example {shorten_value(asked.name)}")
        example = examples.EXAMPLES[asked.name]
        opened = [await self.desk.open(path, dict(example.layout)) for path in example.paths]
        if any(each.measured is None for each in opened):
            return  # it asks for values that it does not tell
        self.desk.asked = example.asked
        numbers = [each.number for each in opened]
        await self.desk.use(numbers[0], numbers[1] if len(numbers) > 1 else None)

    async def _take_effects(self, asked: Effects) -> Any:
        """Run the typed or chosen effects, if the user agrees to it."""
        if not asked.consent:
            raise RequestRefused("`consent`: a file of effects is a program; say that it may run")
        text, name = asked.text, uploads.plain(asked.name or "own.py")
        if not text.strip():
            raise RequestRefused("`effects`: type or choose a file of effects")
        if not name.endswith(".py"):
            raise RequestRefused("`effects`: give a file that ends in .py")
        path = self._folder / name
        before = path.read_text(encoding="utf-8") if path.exists() else None
        path.write_text(text, encoding="utf-8")
        try:
            return await self.desk.take_effects(path)
        except TissueProbeError as error:
            if before is None:
                path.unlink()
            else:
                path.write_text(before, encoding="utf-8")
            raise RequestRefused(str(error).replace(str(path), name)) from None
