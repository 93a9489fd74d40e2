"""Driver of the operator's panel in tests, with a fake link and a virtual clock."""

import io
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any
from unittest.mock import patch

import msgspec
from rich.console import Console
from textual.events import Key
from textual.pilot import Pilot

from sar_tui.link.peer import (
    Connection,
    Frame,
    MarkKey,
    MotionTrace,
    PeerEvent,
    PeerListener,
    TerminalState,
    Welcome,
)
from sar_tui.loop import topics as t
from sar_tui.loop.answers import answer_to
from sar_tui.loop.bus import Topic
from sar_tui.loop.clock import VirtualClock
from sar_tui.model import messages as m
from sar_tui.model.messages import Message, Role
from sar_tui.model.protocol import WizardProtocol
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Metric
from sar_tui.model.units import MS, SECOND
from sar_tui.operator.app import WizardApp
from sar_tui.operator.screen import PanelScreen
from sar_tui.plugins import Catalogue
from tests.settle import settle

START = 1000 * SECOND
ANNA = "operator.anna"
_NAMES = {"!": "exclamation_mark"}
PRESSED = 50 * SECOND
"""Host time at which every key is pressed, and handled."""
_TYPED = {"space": " ", "plus": "+", "minus": "-", "equals_sign": "="}
MODES: dict[m.ControlledKind, m.Mode] = {
    "feedback": "approve",
    "encouragement": "autonomous",
    "instruction": "autonomous",
    "gesture": "autonomous",
    "difficulty": "veto",
}


class FakePeer:
    """Link that stores what is sent."""

    def __init__(self, receive: PeerListener, role: Role = "operator") -> None:
        self.name, self.role = f"{role}.anna", role
        self.receive = receive
        self.clock = VirtualClock(START)
        self.sent: list[tuple[str, Any]] = []
        self.control_requests = 0
        self.is_closed = False

    def send(self, topic: Topic[Any], message: Message) -> None:
        self.sent.append((topic.name, message))

    def of(self, topic: Topic[Any]) -> list[Any]:
        """Return what was sent on a topic, without time stamps and ids."""
        anonymous = {"id": ""} if issubclass(topic.type, m.OperatorAct) else {}
        return [
            msgspec.structs.replace(message, at=0, **anonymous)
            for name, message in self.sent
            if name == topic.name
        ]

    def watch_terminal(self, state: Callable[[], TerminalState]) -> None:
        self.terminal = state

    def take_control(self) -> None:
        self.control_requests += 1

    def now(self) -> int:
        return self.clock.now()

    def close(self, *, says_goodbye: bool = True) -> None:
        self.is_closed, self.says_goodbye = True, says_goodbye


def welcome(role: Role = "operator", **other: Any) -> Welcome:
    fields: dict[str, Any] = {
        "link": "abcd",
        "session": "s1",
        "task": "keyboard",
        "title": "Keyboard reaction",
        "participants": {"A": "P01"},
        "name": f"{role}.anna",
        "role": role,
        "unit": "ms",
        "decimals": 0,
        "levels": 10,
        "attempts": 20,
        "trials": 20,
        "metric": Metric("reaction_time", "ms", "lower"),
        "parameters": {
            "min_level": 1,
            "max_level": 10,
            "operator_lost": "autonomous",
            "operator_difficulty": "veto",
        },
    }
    return Welcome(**fields | other)


def frame(topic: Topic[Any], message: Message, at: int = START, seq: int = 1) -> Frame:
    return Frame(seq, at, topic, message)


def proposal(id: str = "p1", **other: Any) -> m.Proposal:
    fields: dict[str, Any] = {
        "id": id,
        "kind": "feedback",
        "text": "Well done. You were 22 ms faster than in the last attempt; keep on like this.",
        "spoken": "Well done.",
        "face": "happy",
        "gesture": "nod",
        "valence": "positive",
        "degree": "clear",
        "attempt": 3,
    }
    return m.Proposal(**fields | other)


def approval(
    id: str = "p1", ms: int | None = 4000, level: int | None = None, **other: Any
) -> m.PendingApproval:
    deadline = None if ms is None else START + ms * MS
    kind: dict[str, Any] = (
        {"kind": "difficulty", "text": "", "valence": None} if level is not None else {}
    )
    return m.PendingApproval(
        proposal=proposal(id, **kind | other),
        mode="approve",
        deadline=deadline,
        otherwise="act",
        level=level,
    )


def action(id: str, **other: Any) -> m.Action:
    fields = {name: getattr(proposal(id), name) for name in m.Proposal.__struct_fields__}
    return m.Action(**fields | {"decision": "accepted", "actor": "agent", "decided": START} | other)


def arbiter_state(*pending: m.PendingApproval, **other: Any) -> m.ArbiterState:
    return m.ArbiterState(**{"modes": MODES, "operated": True, "pending": pending} | other)


def trial(
    number: int, stimulus: str, ms: float | None, *, correct: bool = True, seat: str = "A"
) -> m.TrialEnded:
    timing = m.Timing("flush", 0.2, 0.1, 0, 1, 900.0, ())
    return m.TrialEnded(
        seat=seat,
        attempt=3,
        trial=number,
        stimulus=stimulus,
        response=None if ms is None else stimulus if correct else "j",
        correct=correct and ms is not None,
        onset=START,
        response_at=None if ms is None else START + round(ms * MS),
        reaction_time_ms=ms,
        value=ms if correct else None,
        timing=timing,
        details={},
    )


def attempt(seat: str = "A", **other: Any) -> m.AttemptEnded:
    fields: dict[str, Any] = {
        "seat": seat,
        "attempt": 2,
        "practice": False,
        "level": 4,
        "metric": 498.2,
        "metric_unit": "ms",
        "accuracy": 0.95,
        "correct": 19,
        "trials": 20,
        "goal": 520.0,
        "outcome": "success",
        "feedback": "positive",
        "started": START,
        "ended": START,
    }
    return m.AttemptEnded(**fields | other)


def waiting(what: Any = "response", stage: Any = "trial", **other: Any) -> m.Waiting:
    fields: dict[str, Any] = {
        "what": what,
        "stage": stage,
        "attempt": 3,
        "trial": 5,
        "level": 4,
        "attempt_name": "attempt 3 of 20",
        "trials": 20,
    }
    return m.Waiting(**fields | other)


def prompt(text: str = "Press: f") -> m.Prompt:
    return m.Prompt(
        attempt=3,
        trial=5,
        presentation=1,
        level=4,
        stimulus="f",
        expected="f",
        text=text,
        glyph="f",
        choices=4,
        timeout=3 * SECOND,
    )


def cue(side: Any = "left") -> m.CueGiven:
    return m.CueGiven(attempt=3, trial=5, presentation=1, side=side, gaze=side)


def presence(state: Any = "baton", actor: str = ANNA, **peers: Role) -> m.OperatorChanged:
    """Return a change of presence. Anna has control unless ``actor`` takes it (state ``baton``)."""
    there = {f"{role}.{name}": role for name, role in peers.items()}
    holder = actor if state == "baton" else ANNA
    return m.OperatorChanged(
        actor=actor, state=state, operated=True, holder=holder, peers={ANNA: "operator", **there}
    )


def session_frames(theme: Theme) -> list[Frame]:
    """Return the frames of a running session."""
    return [
        frame(t.THEME, m.ThemeApplied(theme=theme)),
        frame(t.PRESENCE, presence()),
        frame(t.LEVEL, m.LevelChanged(previous=3, level=4, reason="success")),
        frame(t.ATTEMPT_ENDED, attempt()),
        frame(
            t.ACTION,
            action("a1", text="Welcome back. Good to see you again.", valence=None, decided=0),
        ),
        frame(t.WAITING, waiting("enter", "attempt")),
        frame(t.ACTING, m.AgentActing(acting=False)),
        frame(t.ARBITER_STATE, arbiter_state()),
        frame(t.TRIAL, trial(1, "f", 512)),
        frame(t.TRIAL, trial(2, "j", 430)),
        frame(t.TRIAL, trial(3, "f", 377, correct=False)),
        frame(t.TRIAL, trial(4, "d", None)),
        frame(t.TRIAL, trial(5, "k", 455)),
    ]


def rows_of(app: WizardApp) -> list[str]:
    """Return the rows that an app shows."""
    width, height = app.size
    console = Console(
        width=width, height=height, file=io.StringIO(), record=True, legacy_windows=False
    )
    console.print(
        app.screen._compositor.render_update(full=True, screen_stack=app._background_screens)
    )
    return [row.rstrip() for row in console.export_text().splitlines()]


class PanelDriver:
    """Presses keys on the panel, reads its screen and plays the session."""

    def __init__(self, app: WizardApp, peer: Callable[[], FakePeer], theme: Theme) -> None:
        self.app = app
        self.pilot: Pilot[int]
        self._peer = peer
        self._theme = theme

    @property
    def peer(self) -> FakePeer:
        return self._peer()

    @property
    def panel(self) -> PanelScreen:
        assert isinstance(self.app.screen, PanelScreen)
        return self.app.screen

    async def receive(self, *events: PeerEvent) -> None:
        """Pass events of the link to the panel, and draw it."""
        for each in events:
            self.panel.receive(each)
        self.panel.draw()
        await settle(self.app)

    async def publish(self, topic: Topic[Any], message: Message) -> None:
        await self.receive([frame(topic, message, self.peer.now())])

    async def join(self, role: Role = "operator", **other: Any) -> None:
        """Join a running session."""
        await self.receive(
            Connection("connected"), welcome(role, **other), session_frames(self._theme)
        )

    async def propose(self, *approvals: m.PendingApproval) -> None:
        """Show proposals for long enough to be read."""
        await self.publish(t.ARBITER_STATE, arbiter_state(*approvals))
        await self.advance(500)

    async def advance(self, ms: int) -> None:
        """Advance the session's clock."""
        self.peer.clock.advance(ms * MS)
        self.panel.draw()
        await settle(self.app)

    def _type(self, key: str) -> None:
        """Press a key now, on the session's clock: how long this machine takes to handle it does
        not count.
        """
        pressed = Key(_NAMES.get(key, key), key if len(key) == 1 else _TYPED.get(key))
        pressed.time = PRESSED / SECOND
        self.app.post_message(pressed)

    async def press(self, *keys: str) -> None:
        for key in keys:
            self._type(key)
            await settle(self.app)
        if isinstance(self.app.screen, PanelScreen):
            self.panel.draw()
            await settle(self.app)

    async def burst(self, *keys: str) -> None:
        """Press keys that are read all at once, as over a slow link."""
        for key in keys:
            self._type(key)
        await settle(self.app)
        self.panel.draw()
        await settle(self.app)

    def sent(self, topic: Topic[Any]) -> list[Any]:
        """Return what was sent on a topic, without time stamps and ids."""
        return self.peer.of(topic)

    async def answer(self, outcome: m.ActOutcome = "done", why: str = "", ms: int = 0) -> None:
        """Answer the last act, which took some time to arrive."""
        act = self.peer.sent[-1][1]
        answer = answer_to(act, act.at + ms * MS, outcome, why)
        await self.publish(t.ANSWERED, answer)

    @property
    def rows(self) -> list[str]:
        return rows_of(self.app)

    @property
    def text(self) -> str:
        return "\n".join(self.rows)


class _App(WizardApp):
    """App that uses the fake link."""

    role: Role = "operator"
    peer: FakePeer

    def make_panel(self, where: Any) -> PanelScreen:
        def connect(receive: PeerListener) -> FakePeer:
            self.peer = FakePeer(receive, self.role)
            return self.peer

        clock = VirtualClock(START)
        return PanelScreen(
            connect,
            self._theme,
            self._folder,
            clock,
            self._wall_time,
            self.tr,
            self._protocol,
        )

    def _wall_time(self) -> datetime:
        return datetime(2026, 1, 5, 14, 3, 20) + timedelta(
            microseconds=(self.peer.now() - START) / 1000
        )


@asynccontextmanager
async def open_panel(
    catalogue: Catalogue,
    folder: Path,
    theme: str = "calm",
    size: tuple[int, int] = (80, 24),
    role: Role = "operator",
    *,
    joins: bool = True,
    protocol: WizardProtocol | None = None,
) -> AsyncIterator[PanelDriver]:
    """Open the panel. ``joins``: at a running session."""
    active = catalogue.theme(theme)
    app = _App(active, folder, "anna", role, where=object(), protocol=protocol)  # type: ignore[arg-type]
    app.role = role
    driver = PanelDriver(app, lambda: app.peer, active)
    with patch("sar_tui.operator.screen.host_now", lambda: PRESSED):
        async with app.run_test(size=size) as driver.pilot:
            await settle(app)
            if joins:
                await driver.join(role)
            yield driver


TRACE = MotionTrace("A", START, 50.0, tuple(abs(((n * 7) % 40) / 10 - 2) for n in range(200)))
MARKS = (MarkKey("missed", "Marker missed"), MarkKey("assisted", "Assisted"))
