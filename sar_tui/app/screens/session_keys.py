"""The keys of a session's screen: responses with their time stamps, and the therapist's marks."""

from textual import events

from sar_tui.app.live import LiveSession
from sar_tui.app.screens.message_panel import MessagePanel
from sar_tui.app.screens.pause import PauseMenu
from sar_tui.app.screens.session_pause import PausingScreen
from sar_tui.app.screens.waiting_text import help_text, key_name
from sar_tui.model.messages import SessionCommand, TrialMarked, Waiting
from sar_tui.model.units import SECOND
from sar_tui.tui.gc_control import GcControl

_IN_VAIN = 3
"""Presses of Enter, for one that is awaited, after which the participant is asked to let go of
it.
"""


class KeysScreen(PausingScreen):
    """The part of a session's screen that reads its keys."""

    def __init__(self, live: LiveSession) -> None:
        super().__init__(live)
        self._gc = GcControl()
        self._is_goodbye_held = False
        self._enters: tuple[Waiting | None, int] = (None, 0)

    @property
    def help_text(self) -> str:
        """Instructions of the task, and the keys to pause, ask for feedback and, for a therapist,
        mark a trial.
        """
        return help_text(self._live.run.session.task, self.tr, with_marks=not self.app.patient)

    @property
    def judges_keys(self) -> bool:
        """True while the session itself judges which keys count, and records the others."""
        waiting = self._waiting
        return waiting is not None and waiting.what != "nothing" and self._shown != "menu"

    def on_key(self, event: events.Key) -> None:
        waiting = self._waiting
        if waiting is None or isinstance(self.focused, PauseMenu):
            return
        if self._shown == "menu":  # a click beside the menu took the focus from it
            self.set_focus(self.query_one(PauseMenu))
        if waiting.stage != "trial" and event.key in ("question_mark", "f1", "ctrl+p"):
            return
        if waiting.what == "nothing":
            if event.key in ("enter", "space"):
                event.stop()
                if not self._awaits_goodbye:
                    self.dismiss()
            return
        if event.key not in ("escape", "f1", "ctrl+p"):
            event.stop()
            event.prevent_default()
        if event.key in self._marks:
            if not self.app.screen_keys.is_repeat:
                self._press_mark(event.key, waiting)
            return
        at = self._live.stamp(event.time)
        stalled = self._gc.is_stalled(round(at * SECOND))
        self._live.keyboard.pressed(event.key, event.character, at, self._gc.lag, stalled)
        self._correct_key(event.key, waiting)

    @property
    def _awaits_goodbye(self) -> bool:
        """True while an operator may still veto the goodbye, and then until it is said: all that is
        due is given.

        A broken session says no goodbye.
        """
        session = self._live.run.session
        if not session.ended or session.broken:
            return False
        return session.awaits_operator or (self._is_goodbye_held and session.is_agent_acting)

    def _press_mark(self, key: str, waiting: Waiting) -> None:
        """Mark the trial, or ask for the key again if it would replace another mark. Do nothing in
        patient mode.
        """
        if self.app.patient:
            return
        if mark := self._marks.press(key):
            self._live.operate(SessionCommand(command="mark", actor="therapist", reason=mark.name))
        else:
            self._show_position(waiting)

    def _correct_key(self, key: str, waiting: Waiting) -> None:
        """Say which key is awaited after Enter was pressed for the start key, or the other way
        round.

        Ask to let go of the keys if Enter has no effect, because it is held or pressed again too
        soon.
        """
        start = self._live.run.session.task.start_key
        wanted = {"enter": "enter", "start": start}.get(waiting.what)
        if start and wanted and key in ("enter", start) and key != wanted:
            later = self.tr("({key} comes later.)", key=key_name(key, self.tr))
            self.query_one(MessagePanel).correct(later)
        elif wanted == key == "enter":
            last, count = self._enters
            self._enters = waiting, count + 1 if waiting is last else 1
            if self._enters[1] == _IN_VAIN:
                self.query_one(MessagePanel).correct(
                    self.tr("Please let go of the keys for a moment.")
                )

    def on_paste(self, event: events.Paste) -> None:
        event.stop()
        self._live.keyboard.pasted(len(event.text), self._live.stamp(event.time))

    def marked(self, marked: TrialMarked) -> None:
        self._marks.marked()
        if self._waiting:
            self._show_position(self._waiting)
