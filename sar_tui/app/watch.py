"""A recorded session on the participant's screen again: for watching only."""

import sqlite3
from collections.abc import Callable
from pathlib import Path
from time import monotonic_ns
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.widgets import Static

from sar_tui.app.app import SarTui
from sar_tui.app.guarded_view import GuardedView
from sar_tui.app.live import LiveSession
from sar_tui.app.screen_output import ScreenOutput
from sar_tui.app.screens.pause import PauseMenu
from sar_tui.app.screens.session import SessionScreen
from sar_tui.loop.bus import Record
from sar_tui.loop.nodes.memory import Memory
from sar_tui.loop.session import Session
from sar_tui.model.messages import (
    Prompt,
    SessionCommand,
    SessionStarted,
    Shown,
    ThemeApplied,
    TrialFeedback,
)
from sar_tui.plugins import Catalogue
from sar_tui.replay.player import Player
from sar_tui.rules.parameters import build, current_values
from sar_tui.runs.plan import Failed, without_outputs
from sar_tui.store import sessions
from sar_tui.widgets.big_prompt import BigPrompt

if TYPE_CHECKING:
    from textual.app import App

TICK_SECONDS = 0.02


class _SilentScreen(ScreenOutput):
    """The screen as an output that reports nothing."""

    def shown(self, shown: Shown) -> None:
        """Report nothing: the onset is in the record."""


class WatchedSession(LiveSession):
    """Stands for a live session on its screen: what is drawn comes from a player.

    Args:
        row: of the session.
        catalogue: where its task and theme are found.
        records: of the session, without samples.
        codes: of its participants, by seat.
        speed: how many times as fast as it was.
    """

    def __init__(
        self,
        row: sessions.Row,
        catalogue: Catalogue,
        records: list[Record],
        codes: dict[str, str],
        speed: float,
    ) -> None:
        kind = catalogue.task(row["task"])
        task = without_outputs(
            kind, build(kind.Parameters, current_values(kind.Parameters, row["parameters"]))
        )
        theme = next(
            (one.message.theme for one in records if isinstance(one.message, ThemeApplied)), None
        )
        started = next(
            (one.message for one in records if isinstance(one.message, SessionStarted)), None
        )
        if theme is None or started is None:
            raise Failed(f"Session {row['id']} has no messages: there is nothing to watch.")
        catalogue.theme_folder(theme.name)
        task.names, task.rules = started.names, started.rules
        self.player = Player(records, speed)
        self.clock = self.player.clock
        session = Session(task, theme, self.clock, row["seed"], rules=started.rules)
        session.bus = self.player.bus
        self.markers = None
        self.trouble = ""
        self.codes = codes
        self.view = GuardedView(task)
        self.run: Any = SimpleNamespace(
            id=row["id"], session=session, participants=codes, rescue_file=None
        )

    def begin(self, app: "App[int]", broken: Callable[[str], None]) -> None:
        """Attach what draws."""
        screen = app.screen
        assert isinstance(screen, WatchScreen)
        session = self.run.session
        self.screen = _SilentScreen(
            screen, session.theme, shows_agent="screen" in session.task.parameters.outputs
        )
        for node in (Memory(), self.view, self.screen):
            node.attach(self.player.bus)

    def operate(self, act: SessionCommand) -> None:
        """Ignore an act: nothing goes into a replay."""

    def stamp(self, seconds: float) -> float:
        return seconds


class WatchScreen(SessionScreen):
    """The session's screen with a header that says it is a replay, and keys of its own."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("space", "watch('pause')", "Pause", priority=True),
        Binding("left", "watch('back')", "Back", key_display="←", priority=True),
        Binding("right", "watch('on')", "On", key_display="→", priority=True),
        Binding("plus,equals_sign", "watch('faster')", "Faster", key_display="+", priority=True),
        Binding("minus", "watch('slower')", "Slower", key_display="-", priority=True),
        Binding("q", "watch('leave')", "Leave", priority=True),
    ]
    DEFAULT_CSS = (
        "WatchScreen #replay { height: 1; padding: 0 1; background: $warning; color: $background; }"
    )
    app: "WatchApp"

    def __init__(self, live: WatchedSession, attempt: int = 0) -> None:
        super().__init__(live)
        self._player = live.player
        self._first = attempt
        self._last_tick = 0

    def compose(self) -> ComposeResult:
        yield Static("", id="replay", markup=False)
        yield from super().compose()

    def on_mount(self) -> None:
        """Start once the base's handler, which Textual calls after this one, has attached what
        draws.
        """
        self.call_later(self._start)

    def _start(self) -> None:
        self._player.skip_to(self._first)
        self._last_tick = monotonic_ns()
        self.set_interval(TICK_SECONDS, self._tick)
        self._show_state()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool:
        """Leave out the pause: a replay has its own."""
        return action == "watch" or (action != "pause" and super().check_action(action, parameters))

    async def action_watch(self, what: str) -> None:
        """Pause, jump, change the speed, or leave."""
        player = self._player
        match what:
            case "pause":
                player.paused = not player.paused
            case "on":
                player.skip_to(player.attempt + 1)
            case "back":
                self.app.watch_from(player.attempt - 1, player)
                return
            case "faster" | "slower":
                player.faster(1 if what == "faster" else -1)
            case "leave":
                self.app.exit(return_code=0)
        self._show_state()

    def on_key(self, event: events.Key) -> None:
        """Ignore all other keys of a session."""
        event.prevent_default()  # Textual would call the base's handler as well
        if event.key not in ("f1", "question_mark", "ctrl+p"):
            event.stop()

    def on_paste(self, event: events.Paste) -> None:
        event.prevent_default().stop()

    @property
    def is_in_trial(self) -> bool:
        """False: there is no trial to pause if another screen covers this one."""
        return False

    def show_prompt(self, prompt: Prompt) -> None:
        """Show the prompt; its onset is in the record."""
        if self._shown != "prompt":
            self._stage("prompt")
        self.query_one(BigPrompt).show(prompt.shown())

    @property
    def holds_frames(self) -> bool:
        """False: it is drawn when it is due."""
        return False

    def show_frame(self, prompt: Prompt, frame: int, due: int) -> None:
        """Show a frame; its onset is in the record."""
        self.query_one(BigPrompt).show(prompt.shown(frame))

    def show_trial_feedback(self, feedback: TrialFeedback) -> None:
        """Show the answer to a trial; its onset is in the record."""
        self.query_one(BigPrompt).show_answer(feedback.text, feedback.halves)

    def _stage(self, name: str | None) -> None:
        super()._stage(name)
        self.query_one(PauseMenu).disabled = True  # the pause is a recorded one
        self.set_focus(None)

    def _compare(self, attempts: object) -> None:
        """Leave out the comparison with an earlier session."""

    def _tick(self) -> None:
        now = monotonic_ns()
        self._player.advance(now - self._last_tick)
        self._last_tick = now
        self._show_state()

    def _show_state(self) -> None:
        player = self._player
        state = (
            "over" if player.is_over else "paused" if player.paused else f"{player.speed:g}× speed"
        )
        text = f"Replay · attempt {player.attempt} of {player.attempts} · {state}"
        self.query_one("#replay", Static).update(text)


class WatchApp(SarTui):
    """The app for a recorded session.

    Args:
        folder: the data folder.
        catalogue: the installed tasks and themes.
        database: only read.
        row: of the session.
        speed: how many times as fast as it was.
    """

    def __init__(
        self,
        folder: Path,
        catalogue: Catalogue,
        database: sqlite3.Connection,
        row: sessions.Row,
        speed: float,
    ) -> None:
        self._row = row
        self._speed = speed
        self._records = [
            one for one in sessions.history(database, row["id"]) if not one.topic.stream
        ]
        self._codes = {
            seat["seat"]: seat["participant"]
            for seat in sessions.rows(database, "seats", row["id"])
        }
        self.watched = WatchedSession(row, catalogue, self._records, self._codes, speed)
        super().__init__(folder, catalogue, begin=row["id"])

    def begin_session(self, what: object) -> None:
        """Show the recorded session in place of a live one."""
        self._push()

    def watch_from(self, attempt: int, before: Player) -> None:
        """Show the session again from the beginning of an attempt."""
        self.watched = WatchedSession(
            self._row, self.catalogue, self._records, self._codes, before.speed
        )
        self.watched.player.paused = before.paused
        self.pop_screen()
        self._push(max(0, attempt))

    def _push(self, attempt: int = 0) -> None:
        session = self.watched.run.session
        self.themes.use(session.theme, session.task.parameters.language)
        self.push_screen(WatchScreen(self.watched, attempt))
