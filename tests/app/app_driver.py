"""Drives the app in tests: presses keys and reads the screen, with a clock that is advanced by
hand.
"""

import io
import sqlite3
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AbstractAsyncContextManager, asynccontextmanager, closing, suppress
from pathlib import Path
from typing import Any

import msgspec
from rich.console import Console
from textual.events import Key
from textual.geometry import Region
from textual.message import Message
from textual.pilot import Pilot, WaitForScreenTimeout

from sar_tui.app.app import SarTui
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.session import Session
from sar_tui.loop.task import Task
from sar_tui.loop.topics import FRAME, PROMPT, STORAGE, WAITING
from sar_tui.model.messages import FrameDue, Prompt, StorageChanged, Waiting
from sar_tui.model.units import MS, SECOND
from sar_tui.plugins import Catalogue
from sar_tui.rules.keys import QUIET
from sar_tui.runs.plan import Plan, make_plan
from sar_tui.store import participants, programmes
from sar_tui.store.database import connect
from sar_tui.store.programmes import Programme
from tests.settle import settle

SHORT = {"attempts": 2, "prompts_per_attempt": 2}
"""Parameters of a short session."""
OpenApp = Callable[..., AbstractAsyncContextManager["AppDriver"]]
"""Opens the app on the test's data folder: `open_app` without its first two arguments."""
OpenSession = Callable[..., AbstractAsyncContextManager["AppDriver"]]
"""Opens the app for a short session of the keyboard task; takes what `plan` takes, and a size."""
_NAMES = {"?": "question_mark", "-": "minus", "/": "slash", " ": "space"}
_TYPED = {"space": " ", "enter": "\r", "tab": "\t"}
_FRAMES = str.maketrans("│▌╭╮╰╯─", "       ")


def plan(
    catalogue: Catalogue,
    task: type[Task],
    participant: str = "P01",
    theme: str = "calm",
    **parameters: object,
) -> Plan:
    """Return the plan of a short session."""
    return make_plan(catalogue, task, [participant], SHORT | parameters, theme=theme, seed=7)


def given(*answers: str) -> list[str]:
    """Return the keys that give answers: each is chosen by its key, and said by Enter."""
    return [key for answer in answers for key in (answer, "enter")]


def known(
    data: Path,
    participant: str = "P01",
    theme: str = "calm",
    task: str = "keyboard",
    **parameters: object,
) -> None:
    """Store a participant with settings for a task; a session of the keyboard task is short."""
    values = (SHORT if task == "keyboard" else {}) | parameters
    with closing(connect(data)) as database:
        participants.add(database, participant)
        before = programmes.newest(database, participant, task).version
        programmes.save(database, participant, task, Programme(values, theme), after=before)


class AppDriver:
    """Drives the app as a user. Only this class advances the session's clock."""

    def __init__(self, app: SarTui, clock: VirtualClock) -> None:
        self.app = app
        self.pilot: Pilot[int]
        self.clock = clock
        self._watched: Session | None = None
        self._waiting: list[Waiting] = []
        self._waiting_since = self._pressed_at = 0
        self._pressed, self._pressed_on = "", None
        self._prompts: list[Prompt] = []
        self._frames: list[FrameDue] = []

    # --- what is done

    async def press(self, *keys: str) -> None:
        """Press keys one after the other, as somebody who reads each screen before. A key is a
        character or its name.

        No time passes in trials.
        """
        for key in keys:
            await self._read_the_screen(key)
            await self.write(key)

    async def strike(self, *keys: str) -> None:
        """Press keys one after the other, without time passing, whatever is on the screen."""
        for key in keys:
            await self.write(key)

    async def _read_the_screen(self, key: str) -> None:
        """Let the time pass after which a key counts, if no trial is under way."""
        if self.app.open_session:
            self.session  # noqa: B018  watches it
        if getattr(self.app.screen, "is_in_trial", False):
            return
        shown_at = max(self.app.screen_keys._guard._appeared, self._waiting_since, self._pressed_at)
        if self.app.has_participant or (
            key == self._pressed and self._pressed_on is not self.app.screen
        ):
            await self.wait(max(0, shown_at + QUIET - self.clock.now()) / MS)
        elif not self.app.has_participant:
            self.clock.advance(MS)  # no two keys come at the same time

    async def write(self, *keys: str) -> None:
        """Type characters without settling between them."""
        for key in keys:
            self._pressed, self._pressed_on, self._pressed_at = (
                key,
                self.app.screen,
                self.clock.now(),
            )
            self.app.post_message(
                Key(_NAMES.get(key, key), key if len(key) == 1 else _TYPED.get(key))
            )
        await self.settle()

    async def enter(self, text: str) -> None:
        """Type a text, and press Enter."""
        await self.write(*text)
        await self.press("enter")

    async def send_event(self, event: Message) -> None:
        """Send an event of the terminal."""
        self.app.post_message(event)
        await self.settle()

    async def settle(self) -> None:
        """Wait until the app and everything due in the session at this moment are done."""
        await settle(self.app)
        while self.clock.step(self.clock.now()):
            self.clock.advance(0)
            await settle(self.app)

    async def wait(self, ms: float) -> None:
        """Let time pass. A prompt that appears, or a frame of it, is displayed at once."""
        until = self.clock.now() + round(ms * MS)
        seen = self._drawn
        while self.clock.step(until):
            if self._drawn > seen:
                seen = self._drawn
                await self.settle()
        self.clock.advance(until - self.clock.now())
        await self.settle()

    async def resize(self, columns: int, rows: int) -> None:
        """Resize the window."""
        with suppress(WaitForScreenTimeout):  # a widget that it waited for was removed meanwhile
            await self.pilot.resize_terminal(columns, rows)
        await self.settle()

    # --- a session

    @property
    def session(self) -> Session:
        assert self.app.live
        session = self.app.live.run.session
        if session is not self._watched:
            self._watched = session
            session.bus.subscribe(WAITING, self._waits)
            session.bus.subscribe(PROMPT, self._prompts.append)
            session.bus.subscribe(FRAME, self._frames.append)
        return session

    def _waits(self, waiting: Waiting) -> None:
        self._waiting.append(waiting)
        self._waiting_since = self.clock.now()

    @property
    def _drawn(self) -> int:
        """Number of prompts and of their later frames so far."""
        return len(self._prompts) + len(self._frames)

    @property
    def session_id(self) -> str:
        assert self.app.live
        return self.app.live.run.id

    @property
    def waiting(self) -> Waiting:
        assert self.session
        return self._waiting[-1]

    async def to_first_prompt(self) -> Prompt:
        """Continue from the instructions to the first prompt."""
        await self.press("enter")
        return await self.begin()

    async def begin(self) -> Prompt:
        """Begin the next attempt, and wait for its first prompt."""
        await self.wait(300)
        await self.press("enter")
        return await self.to_prompt()

    async def to_prompt(self) -> Prompt:
        """Wait until the next prompt is on the screen."""
        before = len(self._prompts) if self.session else 0
        while len(self._prompts) == before:
            assert self.clock.step(), f"no prompt will come; the session waits for {self.waiting}"
        await self.settle()
        return self._prompts[-1]

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

    async def fail_to_start(self, why: str) -> None:
        """Press Start on the home screen, and find this reason why no session starts."""
        await self.press("right", "right", "right", "enter")
        assert self.screen_name == "HomeScreen"
        assert self.sees(why)

    async def do_session(self) -> None:
        """Continue from the instructions to the summary."""
        await self.finish(await self.to_first_prompt())

    async def finish(self, first: Prompt) -> None:
        """Continue from a prompt to the summary."""
        await self.do_attempt(first)
        while self.waiting.stage == "attempt":
            await self.do_attempt(await self.begin())
        await self.see_the_summary()

    async def see_the_summary(self) -> None:
        """Continue from the last response to the summary, and wait a moment."""
        assert self.waiting.stage == "review", f"the session waits for {self.waiting}"
        await self.wait(300)
        await self.press("enter")
        await self.wait(300)

    async def disk(self, working: bool) -> None:
        """Make writing to the disk fail, or work again."""
        self.session.bus.post(
            STORAGE, StorageChanged(working=working, reason="" if working else "The disk is full.")
        )
        await self.settle()

    # --- what is seen

    @property
    def screen_name(self) -> str:
        return type(self.app.screen).__name__

    @property
    def rows(self) -> list[str]:
        """The lines of text on the screen, as `App.export_screenshot` composes them."""
        width, height = self.app.size
        console = Console(
            width=width, height=height, file=io.StringIO(), record=True, legacy_windows=False
        )
        composed = self.app.screen._compositor.render_update(
            full=True, screen_stack=self.app._background_screens
        )
        console.print(composed)
        return [row.rstrip() for row in console.export_text().splitlines()]

    @property
    def text(self) -> str:
        return "\n".join(self.rows)

    @property
    def said(self) -> str:
        """The text beside the agent's face."""
        words = self.app.screen.query_one("#agent .words").region
        beside = " ".join(row[words.x :] for row in self.rows[words.y : words.bottom])
        return " ".join(beside.translate(_FRAMES).split())

    def sees(self, words: str) -> bool:
        """Return True if the words are on the screen, wherever its lines break, also within a part
        of it that stands beside others.
        """
        rows = self.rows
        whole = Region(0, 0, *self.app.size)
        parts = (widget.region for widget in self.app.screen.query("*") if widget.display)
        return any(words in _joined(rows, region) for region in dict.fromkeys((whole, *parts)))

    def see(self, *words: str) -> None:
        """Assert that each of the words is on the screen."""
        unseen = [each for each in words if not self.sees(each)]
        assert not unseen, f"{unseen} not on the screen:\n{self.text}"

    def lacks(self, *words: str) -> None:
        """Assert that none of the words is on the screen."""
        seen = [each for each in words if self.sees(each)]
        assert not seen, f"{seen} on the screen:\n{self.text}"

    # --- the database

    def stored(self, query: str, *values: object) -> list[tuple[Any, ...]]:
        """Query the database."""
        if self.app.live and not self.app.live.is_closed:
            self.app.live.run.recorder.write()
        return stored(self.app.folder, query, *values)

    def messages(self, topic: str) -> list[dict[str, Any]]:
        """The recorded messages of a topic."""
        found = self.stored("SELECT message FROM events WHERE topic=? ORDER BY seq", topic)
        return [msgspec.json.decode(text) for (text,) in found]


def _joined(rows: Sequence[str], region: Region) -> str:
    """Return the words in a region of the screen, with one space between them."""
    inside = (row[region.x : region.right] for row in rows[region.y : region.bottom])
    return " ".join(" ".join(inside).translate(_FRAMES).split())


def stored(data: Path, query: str, *values: object) -> list[tuple[Any, ...]]:
    """Query the database."""
    with closing(sqlite3.connect(data / "sar-tui.db")) as database:
        return database.execute(query, values).fetchall()


@asynccontextmanager
async def open_app(
    data: Path,
    catalogue: Catalogue,
    begin: Plan | str | None = None,
    size: tuple[int, int] = (80, 24),
    link: Any = None,
    patient: str = "",
    markers: Sequence[str] = (),
    sync_flash: bool = False,
) -> AsyncIterator[AppDriver]:
    """Open the app, and close it in the end."""
    clock = VirtualClock(10 * SECOND)
    app = SarTui(
        data,
        catalogue,
        begin,
        clock=clock,
        link=link,
        patient=patient,
        markers=markers,
        sync_flash=sync_flash,
    )
    driver = AppDriver(app, clock)
    async with app.run_test(size=size, notifications=True) as driver.pilot:
        await driver.settle()
        yield driver
    app.close_session()
