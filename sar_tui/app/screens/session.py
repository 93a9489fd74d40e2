"""The screen of a live session, from the instructions to the summary: its keys, its pauses, and its
quiet while a response is awaited.
"""

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any, ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import ActiveBinding, Binding, BindingType

from sar_tui.app.live import LiveSession
from sar_tui.app.screens.pause import PauseMenu
from sar_tui.app.screens.session_stage import SessionStage
from sar_tui.app.screens.switch_choices import session_choices
from sar_tui.app.screens.waiting_text import help_text, key_name
from sar_tui.loop import topics
from sar_tui.loop.agent_state import AWAITED
from sar_tui.loop.clock import Handle
from sar_tui.model.language import Language
from sar_tui.model.messages import (
    AgentActing,
    AttemptEnded,
    AttemptStarted,
    MarkersChanged,
    PromptVoided,
    Recall,
    SessionCommand,
    SessionEnded,
    StepEnded,
    TrialEnded,
    TrialMarked,
    Waiting,
)
from sar_tui.model.units import SECOND
from sar_tui.rules.scanning import Choice
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.gc_control import GcControl
from sar_tui.widgets.key_footer import KeyFooter

_IN_VAIN = 3
"""Presses of Enter, for one that is awaited, after which the participant is asked to let go of
it.
"""

_MISSED = 3
"""Responses missed in succession, after which a session with a switch pauses."""


class SessionScreen(DismissedOnce[None]):
    """Shows a live session on a stage, and sends it what the people in front of it do.

    Attributes:
        stage: draws the session's messages.
    """

    app: Any
    AUTO_FOCUS = ""
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "pause", "Pause", id="pause"),
        Binding("ctrl+z", "undo", "Take back", id="undo"),
    ]

    def __init__(self, live: LiveSession) -> None:
        super().__init__()
        self._live = live
        self.stage = SessionStage(live, live)
        self._pause = _Pause(self, live)
        self._keys = _Keys(self, live)
        self._undo = _Undo(self, live)
        self._gc = GcControl()
        self._warned_of = ""
        self._has_warned = False
        self._missed = 0

    @property
    def tr(self) -> Language:
        """Language of the session."""
        return self.stage.tr

    @property
    def help_text(self) -> str:
        """Instructions of the task, and the keys to pause, ask for feedback and, for a therapist,
        mark a trial.
        """
        return help_text(self._live.session.task, self.tr, with_marks=not self.app.patient)

    @property
    def active_bindings(self) -> dict[str, ActiveBinding]:
        """Bindings in the session's language; the stop key only if there is an output to stop."""
        outputs = self._live.session.task.parameters.outputs
        others = [name for name in outputs if name != "screen"]
        has_voice = any(name.partition(":")[0] in ("speech", "tones") for name in others)
        bindings = super().active_bindings
        for key, active in bindings.items():
            binding, is_shown = active.binding, True
            words = self.tr(binding.description)
            if binding.id == "stop":
                words = words if has_voice else self.tr("Stop robot")
                is_shown = bool(others)
            if binding.id == "undo" and not self._undo.is_ctrl_z:
                binding = dataclasses.replace(binding, key_display=self.tr("Backspace"))
            if binding.id == "quit":
                is_shown = not self.app.patient
            shown = dataclasses.replace(binding, description=words, show=binding.show and is_shown)
            bindings[key] = active._replace(binding=shown)
        return bindings

    @property
    def sentences(self) -> list[str]:
        """All that can be read now, in sentences."""
        return self.stage.sentences

    def compose(self) -> ComposeResult:
        yield self.stage
        yield KeyFooter(for_participant=True)

    def on_mount(self) -> None:
        self._live.begin(self.app, self._broken)
        bus = self._live.session.bus
        bus.subscribe(topics.WAITING, self._waits)
        bus.subscribe(topics.MARKED, self._marked)
        bus.subscribe(topics.ATTEMPT_STARTED, self._attempt_started)
        bus.subscribe(topics.TRIAL, self._trial_over)
        bus.subscribe(topics.VOIDED, self._trial_over)
        bus.subscribe(topics.ATTEMPT_ENDED, self._attempt_ended)
        bus.subscribe(topics.STEP_ENDED, self._pause.step_ended)
        bus.subscribe(topics.SESSION_ENDED, self._session_ended)
        bus.subscribe(topics.ACTING, self._agent_acted)
        bus.subscribe(topics.MARKERS, self._markers_changed)
        bus.subscribe(topics.PRESENCE, lambda _: self.stage.visitors_changed())
        if self.app.sync_flash:
            from sar_tui.app.screens.sync_signal import SyncScreen

            self.app.push_screen(SyncScreen(self._live))

    def on_unmount(self) -> None:
        self._gc.end_attempt()
        self._undo.stop()

    @property
    def can_save(self) -> bool:
        """False while the session waits for a disk that cannot be written to."""
        waiting = self.stage.waiting
        return waiting is None or waiting.reason != "storage"

    # --- what the session does; the stage draws it after these handlers

    def _waits(self, waiting: Waiting) -> None:
        """Look for edited themes, and warn, except in a trial; keep the collector off while a
        response is awaited.
        """
        is_awaited = waiting.stage == "trial" and waiting.what in AWAITED
        self.app.themes.look_for_edits(not is_awaited and waiting.what != "quiet")
        self._warn(waiting)
        if not is_awaited:
            self.call_later(self._undo.look)
        if waiting.what == "response":
            self._gc.begin_trial()

    def _marked(self, _: TrialMarked) -> None:
        if not self.is_in_trial:
            self.call_later(self._undo.look)

    def _attempt_started(self, started: AttemptStarted) -> None:
        if self._has_warned:
            self.app.clear_notifications()  # nothing may vanish while a response is awaited
            self._has_warned = False
        self._gc.begin_attempt()

    def _trial_over(self, trial: TrialEnded | PromptVoided) -> None:
        """Pause for a person with a switch who has stopped to press: no other key can."""
        self._gc.end_trial()
        if isinstance(trial, TrialEnded) and self.app.switch:
            if trial.response is not None:
                self._missed = 0
            elif not trial.correct:
                self._missed += 1
            if self._missed == _MISSED:
                self._missed = 0
                self.action_pause()

    def _attempt_ended(self, ended: AttemptEnded) -> None:
        self._gc.end_attempt()

    def _session_ended(self, ended: SessionEnded) -> None:
        """Tell the number of the session, and compare it with the last comparable one, if it is
        whole.
        """
        task, bus = self._live.session.task, self._live.session.bus
        if ended.status == "completed" and len(task.seats) == 1 and not self._live.run.rescue_file:
            attempts = bus.call(topics.RECALL, Recall(seat=task.seats[0])).attempts
            counted = [attempt for attempt in attempts if not attempt.practice]
            compare = functools.partial(self._compare, counted)
            self.run_worker(compare, name="comparison", thread=True, exit_on_error=False)

    def _compare(self, attempts: Sequence[AttemptEnded]) -> None:
        """Add the number and the last comparable session to the summary. Runs in a thread: it
        reads all of the person's sessions.
        """
        from sar_tui.runs.previous import beside_earlier_sessions, number_of

        run = self._live.run
        if number := number_of(self.app.folder, run.id):
            self.app.call_from_thread(self.stage.summary.tell_session, number)
        if words := beside_earlier_sessions(
            self.app.folder, run.session.task, run.id, attempts, self.tr
        ):
            self.app.call_from_thread(self.stage.summary.compare, words)
        self.app.call_from_thread(self.stage.read_aloud)

    def _agent_acted(self, acting: AgentActing) -> None:
        self._keys.agent_acted(acting)
        if self.stage.shown == "summary":
            self.stage.end_is_near(awaits_goodbye=self._keys.awaits_goodbye)
            self.stage.read_aloud()

    def _markers_changed(self, _: MarkersChanged) -> None:
        if self.stage.waiting:
            self._warn(self.stage.waiting)

    def _warn(self, waiting: Waiting) -> None:
        """Tell a therapist who is there, once and never in a trial, that markers are lost or tones
        not heard.
        """
        trouble = self._live.trouble
        is_told = waiting.stage != "trial" and not self.app.patient
        if trouble and trouble != self._warned_of and is_told:
            self._warned_of, self._has_warned = trouble, True
            self.app.notify(trouble, severity="warning", timeout=30)

    def _broken(self, why: str) -> None:
        """Record that the task raised, so that the app ends with this message; the data is safe."""
        self._gc.end_attempt()
        self.app.screen_keys.changed(self)
        self.app.failure = why

    # --- keys

    @property
    def is_in_trial(self) -> bool:
        """True in a trial, which is paused when another screen covers this one."""
        waiting = self.stage.waiting
        return waiting is not None and waiting.stage == "trial"

    @property
    def judges_keys(self) -> bool:
        """True while the session itself judges which keys count, and records the others."""
        waiting = self.stage.waiting
        return waiting is not None and waiting.what != "nothing" and self.stage.shown != "menu"

    def on_key(self, event: events.Key) -> None:
        if event.key in self._undo.keys:
            event.stop()
            event.prevent_default()
            if not self.app.screen_keys.is_repeat:
                self._undo.take_back()
        else:
            self._keys.pressed(event, self._gc)

    def on_paste(self, event: events.Paste) -> None:
        event.stop()
        self._live.keyboard.pasted(len(event.text), self._live.stamp(event.time))

    @property
    def switch_key(self) -> str:
        """The key that a press of a switch stands for: in a trial, that of the response."""
        waiting = self.stage.waiting
        is_start = waiting is not None and waiting.what == "start"
        return "" if is_start or not self.is_in_trial else self._live.session.task.switch_key

    @property
    def switch_choices(self) -> tuple[Choice, ...]:
        """Everything that can be done now with a switch."""
        waiting = self.stage.waiting
        if waiting is None or self._keys.awaits_goodbye:
            return ()
        if self.stage.shown == "menu":
            return self.stage.menu.switch_choices
        start = self._live.session.task.start_key
        can_pause = self.check_action("pause", ()) and waiting.stage != "review"
        return session_choices(
            waiting, start, self.tr, can_undo=self._undo.is_offered, can_pause=can_pause
        )

    def mark(self, at: int, choice: Choice) -> None:
        """Mark a choice of the pause menu, or an answer."""
        if self.stage.shown == "menu":
            self.stage.menu.mark(at)
        else:
            self.stage.mark(choice.entry)

    # --- pauses

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool:
        """Offer a pause if there is something to pause, and its menu while a sensor is awaited;
        and to take back what was just done.
        """
        waiting = self.stage.waiting
        if action == "undo":
            return self._undo.is_offered
        if action != "pause" or waiting is None:
            return action != "pause"
        return waiting.what == "sensor" or waiting.stage not in ("paused", "ended")

    def action_pause(self) -> None:
        """Pause at once, without a question."""
        self._live.operate(SessionCommand(command="pause"))

    def action_undo(self) -> None:
        """Take back what was done last."""
        self._undo.take_back()

    def on_screen_resume(self) -> None:
        self.stage.read_aloud()

    def on_screen_suspend(self) -> None:
        """Pause a trial that another screen covers: the participant cannot see the prompt."""
        if self.is_in_trial:
            self.action_pause()

    def on_pause_menu_chosen(self, event: PauseMenu.Chosen) -> None:
        self._pause.chosen(event.act)

    def on_pause_menu_therapist_asked(self) -> None:
        self._pause.ask_therapist()


class _Keys:
    """Reads the keys of a session: responses with their time stamps, and the therapist's marks."""

    def __init__(self, screen: SessionScreen, live: LiveSession) -> None:
        self._screen = screen
        self._live = live
        self._is_goodbye_held = False
        self._enters: tuple[Waiting | None, int] = (None, 0)

    def pressed(self, event: events.Key, gc: GcControl) -> None:
        """Handle a key, unless it is the menu's or the app's."""
        screen, stage = self._screen, self._screen.stage
        waiting = stage.waiting
        if waiting is None or isinstance(screen.focused, PauseMenu):
            return
        if stage.shown == "menu":  # a click beside the menu took the focus from it
            screen.set_focus(stage.menu)
        if waiting.stage != "trial" and event.key in ("question_mark", "f1", "ctrl+p"):
            return
        if waiting.what == "nothing":
            if event.key in ("enter", "space"):
                event.stop()
                if not self.awaits_goodbye:
                    screen.dismiss()
            return
        if event.key not in ("escape", "f1", "ctrl+p"):
            event.stop()
            event.prevent_default()
        if event.key in stage.marks:
            if not screen.app.screen_keys.is_repeat:
                self._press_mark(event.key, waiting)
            return
        if event.key == "escape" and waiting.reason == "visit":
            self._live.operate(SessionCommand(command="dismiss"))
            return
        at = self._live.stamp(event.time)
        stalled = gc.is_stalled(round(at * SECOND))
        self._live.keyboard.pressed(event.key, event.character, at, gc.lag, stalled)
        self._correct_key(event.key, waiting)

    def _press_mark(self, key: str, waiting: Waiting) -> None:
        """Mark the trial, or ask for the key again if it would replace another mark. Do nothing in
        patient mode.
        """
        stage = self._screen.stage
        if self._screen.app.patient:
            return
        if mark := stage.marks.press(key):
            self._live.operate(SessionCommand(command="mark", actor="therapist", reason=mark.name))
        else:
            stage.show_position(waiting)

    def _correct_key(self, key: str, waiting: Waiting) -> None:
        """Say which key is awaited after Enter was pressed for the start key, or the other way
        round.

        Ask to let go of the keys if Enter has no effect, because it is held or pressed again too
        soon.
        """
        start, tr = self._live.session.task.start_key, self._screen.tr
        wanted = {"enter": "enter", "start": start}.get(waiting.what)
        if start and wanted and key in ("enter", start) and key != wanted:
            later = tr("({key} comes later.)", key=key_name(key, tr))
            self._screen.stage.correct(later)
        elif wanted == key == "enter":
            last, count = self._enters
            self._enters = waiting, count + 1 if waiting is last else 1
            if self._enters[1] == _IN_VAIN:
                let_go = tr("Please let go of the keys for a moment.")
                self._screen.stage.correct(let_go)

    @property
    def awaits_goodbye(self) -> bool:
        """True while an operator may still veto the goodbye, and then until it is said: all that is
        due is given.

        A broken session says no goodbye.
        """
        session = self._live.session
        if not session.ended or session.broken:
            return False
        return session.awaits_operator or (self._is_goodbye_held and session.is_agent_acting)

    def agent_acted(self, acting: AgentActing) -> None:
        """Note that the goodbye waits for an operator."""
        self._is_goodbye_held |= self._live.session.ended and acting.awaits_operator


class _Undo:
    """Offers to take back what was just done at this screen, as long as that can be.

    While a response is awaited nothing changes on the screen, so what was offered before it stays.
    """

    def __init__(self, screen: SessionScreen, live: LiveSession) -> None:
        self._screen = screen
        self._live = live
        self._timer: Handle | None = None
        self.is_offered = False
        self.is_ctrl_z = False

    @property
    def _actors(self) -> tuple[str, ...]:
        """Those in front of this screen."""
        return ("participant",) if self._screen.app.patient else ("participant", "therapist")

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys that take something back now."""
        is_menu = self._screen.stage.shown == "menu"
        return () if is_menu else self._live.undo_keys(*self._actors)

    def take_back(self) -> None:
        """Take back what was done last."""
        self._live.undo(*self._actors)

    def look(self) -> None:
        """Show the key if something can be taken back, until it is too late."""
        self.stop()
        waiting = self._screen.stage.waiting
        if waiting and waiting.stage == "trial" and waiting.what in AWAITED:
            return
        done = self._live.session.undoable(*self._actors)
        before = (self.is_offered, self.is_ctrl_z)
        self.is_offered = done is not None
        self.is_ctrl_z = self.is_offered and self._live.session.takes_backspace
        if done:
            self._timer = self._live.clock.call_at(done.until + 1, self.look)
        if (self.is_offered, self.is_ctrl_z) != before:
            self._screen.refresh_bindings()
            self._screen.app.look_for_choices()

    def stop(self) -> None:
        """Look no more."""
        if self._timer:
            self._timer.cancel()
            self._timer = None


class _Pause:
    """Follows the choices in the pause menu: pain is asked about, the therapist's changes are
    opened.
    """

    def __init__(self, screen: SessionScreen, live: LiveSession) -> None:
        self._screen = screen
        self._live = live

    def chosen(self, act: SessionCommand) -> None:
        """Send a choice to the session."""
        self._live.is_mistake = act.command == "end" and act.reason == "mistake"
        self._live.operate(act)
        if act.reason == "pain" and self._live.session.task.parameters.ask_wellbeing:
            from sar_tui.app.screens.questions import QuestionScreen
            from sar_tui.app.wellbeing import ask_after

            app = self._screen.app
            question = QuestionScreen(ask_after(app, self._live, "pause"))
            app.push_screen(question, self._told_of_pain)

    def step_ended(self, ended: StepEnded) -> None:
        """Pause after too much pain in an answer between attempts, and advise to stop."""
        from sar_tui.app.screens.questions import QuestionScreen
        from sar_tui.app.wellbeing import advise

        if advice := advise(self._screen.app, self._live, ended):
            self._live.operate(SessionCommand(command="pause", reason="pain", seat=ended.seat))
            self._screen.app.push_screen(QuestionScreen(advice), self._told_of_pain)

    def _told_of_pain(self, goes_on: bool | None) -> None:
        """End the session if the participant follows the advice not to go on."""
        if goes_on is False:
            self._live.operate(SessionCommand(command="end", reason="finished"))

    def ask_therapist(self) -> None:
        """Open the therapist's changes, behind the passphrase if there is one."""
        from sar_tui.app.screens.passphrase import PassphraseScreen

        passphrase = self._screen.app.patient_mode.passphrase
        if passphrase.is_set:
            self._screen.app.push_screen(PassphraseScreen(passphrase, "pause"), self._entered)
        else:
            self._entered(True)

    def _entered(self, is_right: bool | None) -> None:
        from sar_tui.app.screens.adjust import AdjustScreen

        waiting = self._screen.stage.waiting
        if is_right and waiting and waiting.stage == "paused":
            self._screen.app.push_screen(AdjustScreen(self._live), self._leave)

    def _leave(self, leaves: bool | None) -> None:
        """Leave the session as it is, so that it can be resumed."""
        if leaves:
            self._screen.dismiss()
