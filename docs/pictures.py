"""Draws the pictures of the documentation from the app itself: ``python -m docs.pictures``."""

import asyncio
import os
import re
import tempfile
from contextlib import closing
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import msgspec
from textual.app import App

from docs.cast import Cast
from sar_tui.app.app import SarTui
from sar_tui.app.screens.progress import ProgressScreen
from sar_tui.link.broker_process import (
    BrokerEnded,
    BrokerListener,
    Outgoing,
    OutgoingBatch,
    OutgoingSnapshot,
)
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.peer import Connection, Frame, PeerEvent
from sar_tui.link.protocol import BrokerEvent, PeerJoined, SnapshotRequested
from sar_tui.loop.clock import VirtualClock
from sar_tui.model.messages import Role
from sar_tui.model.units import MS, SECOND
from sar_tui.operator.app import WizardApp
from sar_tui.operator.screen import PanelScreen
from sar_tui.plugins import Catalogue
from sar_tui.records.kind import find
from sar_tui.runs.demonstration import make_demonstration
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import participants, programmes
from sar_tui.store.database import connect
from sar_tui.store.forms import Occasion
from sar_tui.store.programmes import Programme
from sar_tui.study import enrolment, ledger, next_block
from sar_tui.study.plan import parse_plan
from sar_tui.study.secret import key_file

IMAGES = Path(__file__).parent / "images"


def save(app: App[Any], name: str, folder: Path | None = None) -> None:
    """Keep the screen as an SVG that fetches no font from anywhere; ``folder``: `IMAGES`."""
    svg = re.sub(
        r"@font-face\s*\{.*?\}", "", app.export_screenshot(title="sar-tui"), flags=re.DOTALL
    )
    ((folder or IMAGES) / f"{name}.svg").write_text(svg.replace("Fira Code", "monospace"))


async def _draw() -> None:
    catalogue = Catalogue()
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder)
        make_demonstration(data / "demonstration", TODAY)
        await _draw_home(data / "demonstration", catalogue)
        await _draw_progress(data / "demonstration", catalogue)
        await _draw_cast(data / "demonstration", catalogue)
        # a data folder for each: an app that ends in run_test leaves its database open
        await _draw_agent(data / "agent", catalogue)
        await _draw_reaching(data / "reaching", catalogue)
        await _draw_pairs(data / "pairs", catalogue)
        await _draw_panel(data / "panel", catalogue)
        os.environ["XDG_CONFIG_HOME"] = str(data / "configuration")
        await _draw_study(data / "study", catalogue)
        await _draw_form(data / "form", catalogue)


TODAY = datetime(2026, 3, 20, 14, 15).astimezone()


def demonstration(data: Path, catalogue: Catalogue, clock: VirtualClock) -> SarTui:
    """Return the app on a demonstration folder, on the day for which it was made. It has all colours,
    whatever this terminal has.
    """
    os.environ["COLORTERM"] = "truecolor"
    os.environ.pop("NO_COLOR", None)
    app = SarTui(data, catalogue, clock=clock)
    app.today = TODAY.date
    return app


async def _draw_home(data: Path, catalogue: Catalogue) -> None:
    """The first screen."""
    app = demonstration(data, catalogue, clock := VirtualClock(SECOND))
    async with app.run_test(size=(80, 24)) as pilot:
        await settle(pilot, clock)
        save(app, "home")


async def _draw_agent(data: Path, catalogue: Catalogue) -> None:
    """The agent, in the middle of its gesture after an attempt that went very well."""
    settings = {"prompts_per_attempt": 1}
    clock = VirtualClock(SECOND)
    app = SarTui(
        data, catalogue, make_plan(catalogue, "keyboard", ["P03"], settings, seed=3), clock
    )
    async with app.run_test(size=(80, 24)) as pilot:
        for _ in range(2):
            await _enter(pilot, clock)
        shown = None
        while not (
            shown := re.search(r"Press: (\S)", app.export_screenshot().replace("&#160;", " "))
        ):
            clock.advance(50 * MS)
            await pilot.pause()
        clock.advance(400 * MS)
        await pilot.press(shown[1])
        for _ in range(10):
            clock.advance(50 * MS)
            await pilot.pause()
        save(app, "agent")


async def _draw_reaching(data: Path, catalogue: Catalogue) -> None:
    """The sensor check with a test reach, and the screen after a reach."""
    settings = {"imu": "simulated:steady"}
    clock = VirtualClock(SECOND)
    app = SarTui(
        data, catalogue, make_plan(catalogue, "reaching", ["P02"], settings, seed=3), clock
    )
    async with app.run_test(size=(80, 24)) as pilot:

        async def do(key: str, wait_ms: int) -> None:
            await pilot.press(key)
            for _ in range(wait_ms // 50):
                clock.advance(50 * MS)
                await pilot.pause()

        await settle(pilot, clock)
        await do("t", 6000)
        save(app, "sensor-check")
        for key, wait_ms in (
            ("enter", 800),
            ("enter", 800),
            ("enter", 800),
            ("space", 3000),
            ("space", 2000),
        ):
            await do(key, wait_ms)
        save(app, "reaching")


async def _draw_pairs(data: Path, catalogue: Catalogue) -> None:
    """The agent looks to one side, and a letter appears there."""
    settings = {"policy": "joint attention", "congruent_share": 1.0}
    clock = VirtualClock(SECOND)
    app = SarTui(
        data, catalogue, make_plan(catalogue, "pairs", ["P01", "P02"], settings, seed=3), clock
    )
    async with app.run_test(size=(80, 24)) as pilot:
        for _ in range(2):
            await _enter(pilot, clock)
        await _until_asked(pilot, clock, app)
        save(app, "pairs")


class _Channel:
    """Stands in for the broker process, and keeps what is sent to it."""

    link = "picture"
    is_visit = False
    listener: BrokerListener

    def __init__(self) -> None:
        self.sent: list[Outgoing] = []

    def listen(self, listener: BrokerListener) -> None:
        self.listener = listener

    def send(self, message: Outgoing) -> bool:
        self.sent.append(message)
        return True

    def check(self) -> None:
        pass

    def panel_events(self) -> list[PeerEvent]:
        """Return the events that a panel would receive."""
        found: list[PeerEvent] = [Connection("connected")]
        for message in self.sent:
            if isinstance(message, OutgoingSnapshot):
                found.append(message.welcome)
            if isinstance(message, OutgoingSnapshot | OutgoingBatch):
                found.append(
                    [Frame(each.seq, each.at, each.topic, each.message) for each in message.records]
                )
        return found


class _Peer:
    """A panel's link that sends nothing, on a clock that stands still."""

    name = "operator.op1"
    role: Role = "operator"

    def __init__(self, clock: VirtualClock) -> None:
        self.now = clock.now

    def send(self, topic: Any, message: Any) -> None:
        pass

    def watch_terminal(self, state: Any) -> None:
        pass

    def take_control(self) -> None:
        pass

    def close(self, *, says_goodbye: bool = True) -> None:
        pass


async def _draw_panel(data: Path, catalogue: Catalogue) -> None:
    """The operator's panel, with feedback that waits to be approved."""
    settings = {"prompts_per_attempt": 3, "operator_feedback": "approve", "encouragement": False}
    clock, channel = VirtualClock(SECOND), _Channel()
    plan = make_plan(catalogue, "keyboard", ["P04"], settings, seed=3)
    app = SarTui(data, catalogue, plan, clock, link=channel)  # type: ignore[arg-type]
    async with app.run_test(size=(80, 24)) as pilot:
        await settle(pilot, clock)
        events: tuple[BrokerEvent | BrokerEnded, ...] = (
            PeerJoined(_Peer.name),
            SnapshotRequested(_Peer.name),
        )
        for event in events:
            channel.listener(event)
        for _ in range(2):
            for _ in range(20):
                await settle(pilot, clock)
            await _enter(pilot, clock)
        for wait_ms in (412, 655, 523):
            key = await _until_asked(pilot, clock, app)
            clock.advance(wait_ms * MS)
            await pilot.press(key)
        for _ in range(6):
            await settle(pilot, clock)

    def join(listener: Any) -> _Peer:
        asyncio.get_running_loop().call_soon(
            lambda: [listener(event) for event in channel.panel_events()]
        )
        return _Peer(clock)

    class Panel(WizardApp):
        def make_panel(self, where: object) -> PanelScreen:
            return PanelScreen(
                join, self._theme, self._folder, wall_time=lambda: datetime(2026, 3, 2, 10, 15)
            )

    panel = Panel(
        catalogue.theme("calm"),
        data,
        "op1",
        where=JoinableSession("picture", "keyboard", "picture", 0),
    )
    async with panel.run_test(size=(100, 30)) as pilot:
        for _ in range(5):
            await pilot.pause()
        save(panel, "panel")


async def _draw_progress(data: Path, catalogue: Catalogue) -> None:
    """The progress of a participant who gets better."""
    app = demonstration(data, catalogue, VirtualClock(SECOND))
    async with app.run_test(size=(100, 30)) as pilot:
        app.themes.load()
        app.themes.use_named("calm")
        await app.push_screen(ProgressScreen("P01", catalogue.task("keyboard")))
        for _ in range(10):
            await pilot.pause()
        save(app, "progress")


_STUDY = """
name = "praise"
title = "Praise and reaction time"
hypothesis = "People are faster with praise."
[groups.praised]
condition = "praise"
[groups.unpraised]
condition = "silence"
[conditions.praise]
task = "keyboard"
settings = { feedback_form = "qualitative", prompts_per_attempt = 2 }
[conditions.silence]
task = "keyboard"
settings = { feedback_schedule = "none", prompts_per_attempt = 2 }
[outcome]
visit = "second"
block = "training"
compared = "groups"
[[visits]]
name = "first"
[[visits.blocks]]
name = "baseline"
condition = "silence"
attempts = 1
[[visits]]
name = "second"
day = 7
window = [2, 2]
[[visits.blocks]]
name = "training"
condition = "as allocated"
attempts = 1
[[visits]]
name = "third"
day = 28
window = [3, 7]
[[visits.blocks]]
name = "training"
condition = "as allocated"
attempts = 1
"""
_CAME = {"P01": (0, 7), "P02": (2, 9), "P03": (4,), "P04": (16,), "P05": ()}
"""Days, after the first person's enrolment, on which people came to their visits."""


async def _draw_study(data: Path, catalogue: Catalogue) -> None:
    """A study under way: what is done, due, late, and on which day."""
    plan = parse_plan(_STUDY, "study.toml")
    key = key_file(plan.name)
    key.parent.mkdir(parents=True)
    key.write_text("5a" * 32)
    first = TODAY - timedelta(days=18)
    with closing(connect(data)) as database:
        enrolment.freeze(database, catalogue, _STUDY, plan, key, mode="live", author="", now=first)
        frozen = ledger.find(database)
        for code, days in _CAME.items():
            enrolled = first + timedelta(days=days[0] if days else 18)
            enrolment.enrol(database, frozen, code, key, now=enrolled)
            for day in days:
                now = first + timedelta(days=day)
                person = next_block.person(database, frozen, code, key)
                due = next_block.due(database, person, now)
                planned = next_block.plan_of(database, catalogue, person, due, seed=1)
                shown = msgspec.structs.replace(planned, mode="simulated")
                simulate(shown, PEOPLE["average"], data, catalogue, began=now)
                database.execute("UPDATE sessions SET mode='live'")
    app = demonstration(data, catalogue, clock := VirtualClock(SECOND))
    async with app.run_test(size=(80, 24)) as pilot:
        await settle(pilot, clock)
        await pilot.press("f7")
        for _ in range(5):
            await settle(pilot, clock)
        await pilot.press("down")
        await settle(pilot, clock)
        save(app, "study")


async def _draw_form(data: Path, catalogue: Catalogue) -> None:
    """An item of a form."""
    app = demonstration(data, catalogue, clock := VirtualClock(SECOND))
    with closing(connect(data)) as database:
        participants.add(database, "P01")
    async with app.run_test(size=(80, 24)) as pilot:
        await settle(pilot, clock)
        app.fill_form(find("SUS"), Occasion("P01"), lambda _: None)
        for _ in range(5):
            await settle(pilot, clock)
        await pilot.press("4")
        await settle(pilot, clock)
        save(app, "form")


_SHORT = {
    "attempts": 2,
    "prompts_per_attempt": 3,
    "start_from": "fixed",
    "start_level": 5,
    "ask_wellbeing": False,
    "quiet_ms": 200,
    "foreperiod_max_ms": 700,
}
"""Settings of a session that fits into a moving picture."""


async def _draw_cast(data: Path, catalogue: Catalogue) -> None:
    """A short session from the first screen to the summary, as a moving picture."""
    with closing(connect(data)) as database:
        last = programmes.newest(database, "P01", "keyboard")
        programmes.save(
            database, "P01", "keyboard", Programme({**last.parameters, **_SHORT}),
            after=last.version, now=TODAY,
        )  # fmt: skip
    app = demonstration(data, catalogue, clock := VirtualClock(SECOND))
    cast = Cast()
    async with app.run_test(size=(80, 24)) as pilot:

        async def show(ms: int) -> None:
            """Let time pass, and add it to the picture."""
            for _ in range(ms // 100):
                clock.advance(100 * MS)
                await pilot.pause()
                cast.show(app, 0.1)

        await settle(pilot, clock)
        await show(2500)
        for _ in range(2):
            await pilot.press("enter")
            await show(900)
        while "to finish." not in (shown := _text(app)):
            if asked := _ASKED.search(shown):
                await show(500)
                cast.keep_still()
                await pilot.press(asked[1])
            elif "Enter" in shown:
                await show(1300)
                await pilot.press("enter")
            await show(100)
        await show(3000)
    (IMAGES / "session.svg").write_text(cast.svg(), encoding="utf-8")


async def _until_asked(pilot: Any, clock: VirtualClock, app: SarTui) -> str:
    """Advance the clock until a prompt is on the screen; return its key."""
    for _ in range(200):
        clock.advance(50 * MS)
        await pilot.pause()
        if found := _ASKED.search(_text(app)):
            return found[1]
    raise RuntimeError("no prompt appeared")


_ASKED = re.compile(r"(?:Press|Left|Right): (\S) *<")


def _text(app: SarTui) -> str:
    return app.export_screenshot().replace("&#160;", " ")


async def _enter(pilot: Any, clock: VirtualClock) -> None:
    """Press Enter after the time in which it does nothing."""
    for _ in range(16):
        clock.advance(50 * MS)
        await pilot.pause()
    await pilot.press("enter")


async def settle(pilot: object, clock: VirtualClock) -> None:
    for _ in range(3):
        clock.advance(100 * MS)
        await pilot.pause()  # type: ignore[attr-defined]


if __name__ == "__main__":
    IMAGES.mkdir(exist_ok=True)
    asyncio.run(_draw())
