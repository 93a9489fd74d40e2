"""A chair in front of the app: a person who presses keys and reads the screen, while time stands still."""

import io
import sqlite3
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager, closing
from pathlib import Path
from typing import Any

import msgspec
from rich.console import Console
from textual import events
from textual.keys import _character_to_key
from textual.pilot import Pilot

from sar_tui.app.app import SarTui
from sar_tui.framework.clock import MS, SECOND, VirtualClock
from sar_tui.framework.messages import Prompt, StorageChanged, Waiting
from sar_tui.framework.parameters import build
from sar_tui.framework.session import Session
from sar_tui.framework.task import Task
from sar_tui.framework.topics import PROMPT, STORAGE, WAITING
from sar_tui.plugins import Catalogue
from sar_tui.runs import Plan

NAMED = {"enter", "escape", "space", "tab", "up", "down", "left", "right", "home", "end", "backspace", "f1", "f2"}


def plan(task: type[Task], participant: str = "P01", theme: str = "calm", seed: int = 7, **parameters: object) -> Plan:
    """A session to go straight into: short, unless told otherwise."""
    chosen = {"attempts": 2, "prompts_per_attempt": 2} | parameters
    return Plan(task, build(task.Parameters, chosen), theme, participant, seed)


class Chair:
    """What a person does and sees. Their keys are stamped by the session's clock, which only they move."""

    def __init__(self, app: SarTui, pilot: Pilot[int], clock: VirtualClock) -> None:
        self.app = app
        self.pilot = pilot
        self.clock = clock

    # --- what is done --------------------------------------------------------------------------------------

    async def press(self, *keys: str) -> None:
        """Press keys one after the other, now."""
        for key in keys:
            character = key if len(key) == 1 else {"space": " ", "enter": "\r", "tab": "\t"}.get(key)
            await self.do(events.Key(_character_to_key(key) if len(key) == 1 else key, character))

    async def write(self, text: str) -> None:
        """Type a text into a form."""
        await self.press(*text)

    async def do(self, event: events.Event) -> None:
        """Let the terminal tell an event, stamped now."""
        event.time = self.clock.now() / SECOND
        event.set_sender(self.app)
        self.app.post_message(event)
        await self.settle()

    async def settle(self) -> None:
        """Let the app, and what the session owes at this moment, come to rest."""
        await self.pilot.pause()
        while self.app.is_running and self.clock.step(self.clock.now()):
            await self.pilot.pause()

    async def wait(self, ms: float) -> None:
        """Let time pass, the screen keeping up with it."""
        until = self.clock.now() + round(ms * MS)
        while self.clock.step(until):
            await self.settle()
        self.clock.advance(until - self.clock.now())

    # --- a session ------------------------------------------------------------------------------------------

    @property
    def session(self) -> Session:
        assert self.app.live
        return self.app.live.run.session

    @property
    def session_id(self) -> str:
        assert self.app.live
        return self.app.live.run.id

    @property
    def waiting(self) -> Waiting:
        last = self.session.bus.last(WAITING)
        assert last
        return last

    async def to_first_prompt(self) -> Prompt:
        """From the instructions to the first prompt."""
        await self.press("enter")
        return await self.begin()

    async def begin(self) -> Prompt:
        """Begin the attempt that is offered, and wait for its first prompt."""
        await self.wait(300)
        await self.press("enter")
        return await self.to_prompt()

    async def to_prompt(self) -> Prompt:
        """Wait until a prompt is on the screen."""
        prompts: list[Prompt] = []
        self.session.bus.subscribe(PROMPT, prompts.append)
        while not prompts:
            assert self.clock.step(), f"no prompt will come; the session waits for {self.waiting}"
        await self.settle()
        return prompts[-1]

    async def answer(self, prompt: Prompt, after_ms: float = 400) -> None:
        """Press the right key."""
        await self.wait(after_ms)
        await self.press(prompt.expected)

    async def do_attempt(self, first: Prompt) -> None:
        """Answer every prompt of an attempt."""
        prompt = first
        for _ in range(self.session.task.trials_per_attempt - 1):
            await self.answer(prompt)
            prompt = await self.to_prompt()
        await self.answer(prompt)

    async def disk(self, working: bool) -> None:
        """The disk refuses to write, or no longer does."""
        self.session.bus.post(STORAGE, StorageChanged(working=working))
        await self.settle()

    # --- what is seen ------------------------------------------------------------------------------------------

    @property
    def rows(self) -> list[str]:
        """The lines of text on the screen."""
        return screen_rows(self.app)

    @property
    def text(self) -> str:
        return "\n".join(self.rows)

    def sees(self, words: str) -> bool:
        """Whether the words are on the screen, wherever its lines break."""
        return " ".join(words.split()) in " ".join(self.text.replace("│", " ").split())

    # --- what is kept ------------------------------------------------------------------------------------------

    def rows_of(self, query: str, *values: object) -> list[tuple[Any, ...]]:
        return kept(self.app.folder, query, *values)

    def events(self, topic: str) -> list[dict[str, Any]]:
        """The recorded messages of a topic."""
        assert self.app.live
        self.app.live.run.recorder.write()
        return [
            msgspec.json.decode(text)
            for (text,) in self.rows_of("SELECT message FROM events WHERE topic=? ORDER BY session, seq", topic)
        ]


def screen_rows(app: SarTui) -> list[str]:
    """What a terminal would show, as `App.export_screenshot` composes it."""
    width, height = app.size
    console = Console(width=width, height=height, file=io.StringIO(), record=True, legacy_windows=False)
    console.print(app.screen._compositor.render_update(full=True, screen_stack=app._background_screens))
    return [row.rstrip() for row in console.export_text().splitlines()]


def kept(folder: Path, query: str, *values: object) -> list[tuple[Any, ...]]:
    """What the database holds."""
    with closing(sqlite3.connect(folder / "sar-tui.db")) as database:
        return database.execute(query, values).fetchall()


@asynccontextmanager
async def sit_down(
    data: Path,
    catalogue: Catalogue,
    begin: Plan | str | None = None,
    size: tuple[int, int] = (80, 24),
    notifications: bool = True,
) -> AsyncIterator[Chair]:
    """Open the app in front of a person."""
    clock = VirtualClock(10 * SECOND)
    app = SarTui(data, catalogue, begin, clock=clock)
    async with app.run_test(size=size, notifications=notifications) as pilot:
        chair = Chair(app, pilot, clock)
        await chair.settle()
        yield chair
    app.close_session()
