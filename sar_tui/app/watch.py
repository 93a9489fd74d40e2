"""A recorded session on the participant's screen again: for watching only."""

import sqlite3
from collections.abc import Callable
from pathlib import Path
from time import monotonic_ns
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import ActiveBinding, Binding, BindingType
from textual.screen import Screen
from textual.widgets import Static

from sar_tui.app.app import SarTui
from sar_tui.app.guarded_view import GuardedView
from sar_tui.app.screen_output import ScreenOutput
from sar_tui.app.screens.session_stage import SessionStage
from sar_tui.app.screens.waiting_text import help_text
from sar_tui.loop.bus import Record
from sar_tui.loop.clock import Clock
from sar_tui.loop.nodes.memory import Memory
from sar_tui.loop.session import Session
from sar_tui.model.language import Language
from sar_tui.model.messages import SessionStarted, ThemeApplied
from sar_tui.plugins import Catalogue
from sar_tui.replay.player import Player
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import Failed, without_outputs
from sar_tui.store import sessions
from sar_tui.tui.language import translated
from sar_tui.widgets.key_footer import KeyFooter

TICK_SECONDS = 0.02


class WatchedSession:
    """A recorded session for its stage: what is drawn comes from a player.

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
        task = without_outputs(kind, build(kind.Parameters, row["parameters"]))
        theme = next(
            (one.message.theme for one in records if isinstance(one.message, ThemeApplied)), None
        )
        started = next(
            (one.message for one in records if isinstance(one.message, SessionStarted)), None
        )
        if theme is None or started is None:
            raise Failed(f"Session {row['id']} has no messages: there is nothing to watch.")
        catalogue.theme_folder(theme.name)
        task.names = started.names
        self.player = Player(records, speed)
        self.clock: Clock = self.player.clock
        self.session = Session(task, theme, self.clock, row["seed"])
        self.session.bus = self.player.bus
        self.codes = codes
        self.view = GuardedView(task)
        self.is_mistake = False

    def begin(self, stage: SessionStage) -> None:
        """Attach what draws."""
        shows_agent = "screen" in self.session.task.parameters.outputs
        screen = ScreenOutput(stage, self.session.theme, shows_agent=shows_agent)
        for node in (Memory(), self.view, screen):
            node.attach(self.player.bus)


class WatchScreen(Screen[None]):
    """The stage of a session below a line that says it is a replay, with keys of its own."""

    AUTO_FOCUS = ""
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

    def __init__(
        self, watched: WatchedSession, attempt: int, go_back_to: Callable[[int], None]
    ) -> None:
        super().__init__()
        self._go_back_to = go_back_to
        self._watched = watched
        self._player = watched.player
        self._first = attempt
        self._last_tick = 0
        self.stage = SessionStage(watched)

    @property
    def tr(self) -> Language:
        """Language of the session."""
        return self.stage.tr

    @property
    def active_bindings(self) -> dict[str, ActiveBinding]:
        return translated(super().active_bindings, self.tr)

    @property
    def help_text(self) -> str:
        """Instructions of the task, and its keys."""
        return help_text(self._watched.session.task, self.tr)

    def compose(self) -> ComposeResult:
        yield Static("", id="replay", markup=False)
        yield self.stage
        yield KeyFooter()

    def on_mount(self) -> None:
        self.stage.menu.disabled = True  # the pause is a recorded one
        self._watched.begin(self.stage)
        self._player.skip_to(self._first)
        self._last_tick = monotonic_ns()
        self.set_interval(TICK_SECONDS, self._tick)
        self._show_state()

    async def action_watch(self, what: str) -> None:
        """Pause, jump, change the speed, or leave."""
        player = self._player
        match what:
            case "pause":
                player.paused = not player.paused
            case "on":
                player.skip_to(player.attempt + 1)
            case "back":
                self._go_back_to(player.attempt - 1)
                return
            case "faster" | "slower":
                player.faster(1 if what == "faster" else -1)
            case "leave":
                self.app.exit(return_code=0)
        self._show_state()

    def _tick(self) -> None:
        now = monotonic_ns()
        self._player.advance(now - self._last_tick)
        self._last_tick = now
        self._show_state()

    def _show_state(self) -> None:
        player = self._player
        tr = self.tr
        if player.is_over:
            state = tr("over")
        elif player.paused:
            state = tr("paused")
        else:
            state = tr("{times}× speed", times=f"{player.speed:g}")
        text = tr(
            "Replay · attempt {number} of {count} · {state}",
            number=player.attempt,
            count=player.attempts,
            state=state,
        )
        self.query_one("#replay", Static).update(text)


class Watch:
    """Shows a recorded session in the app.

    Args:
        folder: the data folder.
        catalogue: the installed tasks and themes.
        database: only read.
        row: of the session.
        speed: how many times as fast as it was.

    Attributes:
        app: the app, to be run.
        watched: the session, as it is shown now.
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
        self._catalogue = catalogue
        history = sessions.history(database, row["id"])
        self._records = [one for one in history if not one.topic.stream]
        seats = sessions.rows(database, "seats", row["id"])
        self._codes = {seat["seat"]: seat["participant"] for seat in seats}
        self.watched = self._open(speed)
        self.app = SarTui(folder, catalogue, begin=self._show)

    def _open(self, speed: float) -> WatchedSession:
        return WatchedSession(self._row, self._catalogue, self._records, self._codes, speed)

    def _show(self, attempt: int = 0) -> None:
        session = self.watched.session
        self.app.themes.use(session.theme, session.task.parameters.language)
        self.app.push_screen(WatchScreen(self.watched, attempt, self._show_from))

    def _show_from(self, attempt: int) -> None:
        """Show the session again from the beginning of an attempt."""
        before = self.watched.player
        self.watched = self._open(before.speed)
        self.watched.player.paused = before.paused
        self.app.pop_screen()
        self._show(max(0, attempt))
