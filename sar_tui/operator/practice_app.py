"""The panel at a recorded session, for practice."""

import asyncio
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from sar_tui.link.peer import Connection, PeerListener, TerminalState, session_welcome
from sar_tui.loop.bus import Topic
from sar_tui.loop.clock import host_now
from sar_tui.model.messages import Role
from sar_tui.model.protocol import WizardProtocol
from sar_tui.model.theme import Theme
from sar_tui.operator.app import WizardApp
from sar_tui.operator.practice import Practice
from sar_tui.operator.screen import PanelScreen
from sar_tui.plugins import Catalogue
from sar_tui.replay.replay import check_whole, new_session
from sar_tui.runs.plan import Failed
from sar_tui.store import messages, sessions

_TICK_S = 0.05


def recorded_practice(
    database: sqlite3.Connection,
    folder: Path,
    catalogue: Catalogue,
    row: sessions.Row,
    name: str,
    protocol: WizardProtocol,
    speed: float,
) -> Practice:
    """Return the practice on a recorded session.

    Args:
        database: only read.
        folder: the data folder.
        catalogue: where the session's task is found.
        row: of the session, from `store.sessions.find`.
        name: of the trainee, with the role.
        protocol: by which the trainee works.
        speed: how many times as fast as it was.

    Raises:
        StoreError, PluginError, ParameterError, Failed: as `replay.replay.replay`.
    """
    check_whole(database, folder, row)
    task = new_session(row, catalogue, {}).task
    seats = sessions.rows(database, "seats", row["id"])
    codes = {seat["seat"]: seat["participant"] for seat in seats}
    stored = messages.read(database, row["id"])
    records = [one for one in stored if one.topic.origin != "later"]
    if not records:
        raise Failed(f"Session {row['id']} has no messages: there is nothing to practise on.")
    welcome = replace(session_welcome(task, row["id"], "", codes), name=name, role="operator")
    return Practice(records, welcome, task.parameters, protocol, speed)


class PracticePeer:
    """Link of a panel to a practice. It plays on the panel's event loop.

    Args:
        receive: called with what the panel receives.
        practice: the recorded session.
    """

    role: Role = "operator"

    def __init__(self, receive: PeerListener, practice: Practice) -> None:
        self.name = practice.welcome.name
        self._receive, self._practice = receive, practice
        self._loop = asyncio.get_running_loop()
        self._last = host_now()
        self._timer = self._loop.call_soon(self._begin)

    def send(self, topic: Topic[Any], message: Any) -> None:
        self._play()
        frames = self._practice.act(topic, message)
        self._loop.call_soon(self._receive, frames)

    def watch_terminal(self, state: Callable[[], TerminalState]) -> None:
        """Ignore the terminal: nobody depends on it."""

    def take_control(self) -> None:
        """Ignore the request: the trainee has control."""

    def now(self) -> int:
        passed = host_now() - self._last
        return self._practice.now + round(passed * self._practice.rate)

    def close(self, *, says_goodbye: bool = True) -> None:
        self._timer.cancel()

    def _begin(self) -> None:
        practice = self._practice
        self._receive(Connection("connected"))
        self._receive(practice.welcome)
        self._receive(practice.begin())
        self._last = host_now()
        self._tick()

    def _tick(self) -> None:
        self._play()
        self._timer = self._loop.call_later(_TICK_S, self._tick)

    def _play(self) -> None:
        now = host_now()
        frames = self._practice.advance(now - self._last)
        self._last = now
        if frames:
            self._receive(frames)


class PracticeApp(WizardApp):
    """App that shows the panel at a recorded session.

    Args:
        theme: until the session's is known.
        folder: the data folder; holds the operator's own file.
        practice: the recorded session.
    """

    TITLE = "sar-tui wizard practise"

    def __init__(self, theme: Theme, folder: Path, practice: Practice) -> None:
        super().__init__(theme, folder, practice.welcome.name)
        self._practice = practice

    def begin(self) -> None:
        """Show the panel of the recorded session."""

        def connect(receive: PeerListener) -> PracticePeer:
            return PracticePeer(receive, self._practice)

        self.push_screen(PanelScreen(connect, self._theme, self._folder, tr=self.tr), self._left)
