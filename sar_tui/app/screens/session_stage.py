"""The middle of a session's screen: draws the messages of a session, live or recorded."""

import functools
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from msgspec.structs import replace
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.widget import Widget
from textual.widgets import ContentSwitcher, Static

from sar_tui.app.agent.session_agent import SessionAgent
from sar_tui.app.guarded_view import GuardedView
from sar_tui.app.live import LiveSession
from sar_tui.app.prompt_onset import Onset, report_onset, report_trial_feedback
from sar_tui.app.screens.message_panel import MessagePanel
from sar_tui.app.screens.pause import PauseMenu
from sar_tui.app.screens.summary import Summary
from sar_tui.app.screens.waiting_text import (
    WATCHED,
    WaitingText,
    decline_text,
    key_name,
    step_text,
    waiting_text,
)
from sar_tui.loop.agent_state import AWAITED
from sar_tui.loop.clock import Clock, Handle
from sar_tui.loop.feedback_text import result_phrases
from sar_tui.loop.marks import TrialMark
from sar_tui.loop.session import Session
from sar_tui.loop.topics import RECALL
from sar_tui.model.language import Language
from sar_tui.model.messages import (
    AttemptEnded,
    AttemptStarted,
    Feedback,
    Prompt,
    Recall,
    SessionEnded,
    TrialFeedback,
    TrialMarked,
    Waiting,
)
from sar_tui.model.results_for_people import meeting_text
from sar_tui.model.spoken_text import sentences
from sar_tui.model.step import Entry
from sar_tui.model.trial_types import Mark
from sar_tui.model.units import SECOND
from sar_tui.plugins import task_folder
from sar_tui.tui.heading import is_roomy
from sar_tui.tui.key_line import KeyLine
from sar_tui.tui.language import session_language
from sar_tui.tui.timestamps import paint_now
from sar_tui.widgets.big_prompt import BigPrompt
from sar_tui.widgets.goal_bar import GoalBar, bar_of
from sar_tui.widgets.language import language_of
from sar_tui.widgets.prompt_pictures import Pictures

_BETWEEN = ("attempt", "answer", "step", "rest", "review")
"""Stages between two attempts, and after the last."""
_BEFORE = ("instructions", "attempt", "paused")
"""Stages in which the agent is in the middle too, if there is room."""
_FULL_HEIGHT = 40
"""Least rows of a window in which a drawing, or the instructions, leave room above the agent."""
_MARGINS = 2
"""Columns beside a scale, at both sides together."""


class StagedSession(Protocol):
    """The part of a session that its stage reads: live, or recorded."""

    clock: Clock
    view: GuardedView
    codes: dict[str, str]
    is_mistake: bool

    @property
    def session(self) -> Session:
        """The session, once it is open."""
        ...


class SessionStage(Vertical):
    """The top line of a session's screen, the widgets in the middle, the agent, and the progress
    below.

    `screen_output.ScreenOutput` passes it each message. Nothing moves while a response is awaited.

    Args:
        staged: the session, which may be opened later, but before the stage is composed.
        reported_to: the session that is told when prompts reached the terminal; None if nobody is.

    Attributes:
        agent: the agent.
        waiting: what the session waits for.
        shown: the widget in the middle.
    """

    app: Any

    def __init__(self, staged: StagedSession, reported_to: LiveSession | None = None) -> None:
        super().__init__()
        self._staged = staged
        self._reported_to = reported_to
        self.agent = SessionAgent(self._forget_results)
        self.waiting: Waiting | None = None
        self.shown = "message"
        self._position = self._ended_position = ""
        self._agent_seat = ""
        self._bars: dict[str, GoalBar] = {}
        self._result_phrases: tuple[str, ...] = ()
        self._goal = ""
        self._asked = ""
        self._marked: Entry | None = None
        self._countdown: Handle | None = None
        self._visit_words = ""

    @functools.cached_property
    def tr(self) -> Language:
        """Language of the session."""
        return session_language(self._staged.session.task)

    @functools.cached_property
    def marks(self) -> "MarkKeys":
        """The marks of trials, and their keys."""
        session = self._staged.session
        return MarkKeys(session.task.marks, self.tr, lambda: session.trial_mark)

    @functools.cached_property
    def _pictures(self) -> Pictures | None:
        """The pictures of the task; None if none can be shown here."""
        if self.app.picture_way is None:
            return None
        folder = task_folder(type(self._staged.session.task))
        return Pictures(folder, self.app.picture_way, self.app.write_to_terminal)

    def compose(self) -> ComposeResult:
        session, view = self._staged.session, self._staged.view
        self.agent.make_widgets(
            session.theme,
            self._staged.clock,
            self.tr,
            is_shown="screen" in session.task.parameters.outputs,
            picture=self.app.picture,
            folder=self.app.catalogue.theme_folder(session.theme.name),
        )
        with Horizontal(id="top"):
            codes = ", ".join(self._staged.codes.values())
            yield Static(f"{self.tr(session.task.title)} · {codes}", id="task", markup=False)
            yield self.agent.notice
            yield Static("", id="visit", markup=False)
            yield Static("", id="where", markup=False)
        yield Static("", id="above")
        with ContentSwitcher(initial="message", id="stage"):
            yield MessagePanel(self._leave_out_result, id="message")
            yield BigPrompt(id="prompt", draw=view.prompt_lines, pictures=self._pictures)
            yield PauseMenu(id="menu")
            yield Summary(session.task.metric, view.facts, self._praise_beside, id="summary")
        yield self.agent.widget
        with Horizontal(id="progress"):
            yield ProgressLine(id="trials")
            yield ProgressLine(id="attempts")
        yield KeyLine(grows=True)

    def on_mount(self) -> None:
        self._show_attempts(0)
        self._staged.view.call_to_redraw(self._prompt.redraw)

    def on_unmount(self) -> None:
        self._stop_countdown()
        if self._pictures:
            self._pictures.close()

    def on_resize(self) -> None:
        """Give all parts more room in a large window."""
        self.set_class(is_roomy(*self.app.size), "roomy")
        self.set_class(self.app.size.height >= _FULL_HEIGHT, "tall")

    @property
    def message(self) -> MessagePanel:
        """The texts in the middle."""
        return self.query_one(MessagePanel)

    def ask(self, press: str) -> None:
        """Show the one thing to do, in the row for it; empty: nothing."""
        self._asked = press
        names = (key_name(key, self.tr) for key in ("enter", "space", "tab"))
        self.query_one(KeyLine).show(press, *names)

    def correct(self, later: str) -> None:
        """Add to the one thing to do that another key comes later, or what hinders."""
        asked = self._asked
        self.ask(f"{asked} {later}")
        self._asked = asked
        self.read_aloud()

    @property
    def menu(self) -> PauseMenu:
        """The pause menu."""
        return self.query_one(PauseMenu)

    @property
    def summary(self) -> Summary:
        """The summary after the session."""
        return self.query_one(Summary)

    @property
    def _prompt(self) -> BigPrompt:
        return self.query_one(BigPrompt)

    # --- a prompt

    def show_prompt(self, prompt: Prompt) -> None:
        """Show the prompt, and report its onset with ``ScreenOutput.shown``."""
        onset = report_onset(self.screen, self._reported_to, prompt) if self._reported_to else None
        if self.shown != "prompt":
            self._switch_to("prompt")
        self._draw(prompt, 0, onset)

    @property
    def holds_frames(self) -> bool:
        """True if the driver flushes a frame when it is due, not before."""
        stamps = bool(getattr(self.app._driver, "can_stamp_onset", False))
        return stamps and self._reported_to is not None

    def show_frame(self, prompt: Prompt, frame: int, due: int) -> None:
        """Show a later frame of the prompt when it is due, and report when it reached the
        terminal.
        """
        live = self._reported_to
        onset = report_onset(self.screen, live, prompt, frame, due) if live else None
        self._draw(prompt, frame, onset)

    def _draw(self, prompt: Prompt, frame: int, onset: Onset | None) -> None:
        widget = self._prompt
        picture = widget.show(prompt.shown(frame))
        if onset:
            onset.picture = picture
            if prompt.frames:
                paint_now(widget)

    def show_typed(self, prompt: Prompt, text: str) -> None:
        """Show the text typed so far, below the prompt or its last frame."""
        self._prompt.show(prompt.shown(len(prompt.frames) - 1, text))

    def clear_prompt(self) -> None:
        """Remove the prompt."""
        self._prompt.clear()

    def show_trial_feedback(self, feedback: TrialFeedback) -> None:
        """Show the answer to a trial, and report when it reached the terminal."""
        if self._reported_to:
            report_trial_feedback(self.screen, self._reported_to, feedback)
        self._prompt.show_answer(feedback.text, feedback.halves)

    # --- an attempt

    def begin_attempt(self, started: AttemptStarted) -> None:
        """Forget the results before it, and note its goal."""
        self._forget_results()
        self._ended_position = ""
        self._goal = self.waiting.goal if self.waiting else ""

    def progress(self, done: int) -> None:
        """Show the number of trials done in this attempt."""
        self._show_trials(done)

    def marked(self, marked: TrialMarked) -> None:
        """Show the mark that a therapist gave a trial."""
        self.marks.marked()
        if self.waiting:
            self.show_position(self.waiting)

    def end_attempt(self, ended: AttemptEnded) -> None:
        """Show the number of attempts done, and keep which attempt it was."""
        self._show_attempts(ended.attempt)
        if self._ended_position and ended.metric is None:  # a mark has taken its result away
            self._forget_results()
            self.agent.clear("listening")
        self._ended_position = self._ended_position or self._position

    def feedback_given(self, feedback: Feedback) -> None:
        """Show the result beside its goal, with the words that tell it."""
        task = self._staged.session.task
        who = task.display_name(feedback.seat) if len(task.seats) > 1 else ""
        if bar := bar_of(feedback, task.metric, who):
            self._bars[feedback.seat] = bar
        else:
            self._bars.pop(feedback.seat, None)
        self._result_phrases = result_phrases(feedback, task, self._staged.session.theme)
        self._show_again()

    def feedback_over(self) -> None:
        """Remove the result: the agent speaks of something else."""
        self._forget_results()
        self._show_again()

    def _leave_out_result(self, is_shown: bool) -> None:
        """Let the agent's words on the screen not repeat the result that is shown. Where operators
        decide on feedback, the participant sees the words that they decided on.
        """
        parameters = self._staged.session.task.parameters
        is_decided = (
            bool(self._visitors)
            or parameters.operator_joins
            or parameters.operator_feedback != "autonomous"
        )
        self.agent.leave_out(self._result_phrases if is_shown and not is_decided else ())

    def _forget_results(self) -> None:
        self._bars = {}

    # --- a wait

    def wait(self, waiting: Waiting) -> None:
        """Show what the session waits for: Enter, a response, or a person."""
        before, self.waiting = self.waiting, waiting
        self._stop_countdown()
        is_skipped = (
            before is not None and before.stage == "paused" and waiting.attempt > before.attempt
        )
        if before is None or is_skipped:
            self._show_trials(0)
        if self.marks.follow():
            self.show_position(waiting)
        if waiting.what == "foreperiod" and before is not None and before.reason == "held":
            self.agent.clear("listening")
        self.agent.let_move(not self._is_awaited)
        self._show_visitors()
        if before is not None and before.what == "result" and waiting.what != "response":
            # the next prompt, where no wait precedes it, has replaced the answer
            self._prompt.clear()
        self._prepare_pictures(waiting)
        self._marked = None
        if waiting.what not in ("foreperiod", "response", "result"):
            self._show_wait(waiting, entered=before is None or before.stage != waiting.stage)
        self._look_for_choices()
        self.read_aloud()

    @property
    def _is_awaited(self) -> bool:
        """True in a trial in which a response is awaited, so that nothing may be drawn."""
        waiting = self.waiting
        return waiting is not None and waiting.stage == "trial" and waiting.what in AWAITED

    @property
    def _visitors(self) -> tuple[str, ...]:
        return self._reported_to.visitors if self._reported_to else ()

    def visitors_changed(self) -> None:
        """Show the sign that somebody watches, or remove it; the choices in a pause change with
        it.
        """
        self._show_visitors()
        if self.shown == "menu" and self.waiting:
            self._show_wait(self.waiting, entered=False)

    def _show_visitors(self) -> None:
        """Draw the sign, if it has changed. While a response is awaited it waits for the next
        wait.
        """
        words = f"● {self.tr(WATCHED)}" if self._visitors else ""
        if not self._is_awaited and words != self._visit_words:
            self._visit_words = words
            self.query_one("#visit", Static).update(words)

    def _look_for_choices(self) -> None:
        """Let a switch choose from what can be done now."""
        if self._reported_to:
            self.app.look_for_choices()

    def mark(self, answer: Entry | None) -> None:
        """Draw a question with this answer marked; None: with what was chosen so far."""
        if answer != self._marked:
            self._marked = answer
            self._show_again()

    @property
    def sentences(self) -> list[str]:
        """All that can be read now, in sentences: also the words of the agent. Nothing in a trial,
        except before it begins, and while the agent is waited for.
        """
        waiting = self.waiting
        if waiting is None:
            return []
        if waiting.reason == "held":
            return sentences(self.agent.words)
        if waiting.stage == "trial" and waiting.what != "start":
            return []
        if self.shown == "menu":
            return self.menu.sentences
        asked = self.query_one(KeyLine).text
        if self.shown == "summary":
            return [*self.summary.sentences, *sentences(self.agent.words, asked)]
        return [*sentences(self.agent.words), *self.message.sentences, *sentences(asked)]

    def read_aloud(self) -> None:
        """Let the voice say what is new; it is silent in a trial."""
        if self._reported_to and (waiting := self.waiting):
            about = waiting.step.step.name if waiting.step else ""
            place = (waiting.stage, waiting.what, waiting.reason, waiting.attempt, waiting.trial)
            self.app.aloud.read(self.screen, (*place, about))

    def _show_wait(self, waiting: Waiting, *, entered: bool) -> None:
        """Show what is waited for: in words, as the prompt's place, or as the pause menu."""
        text = self._waiting_text(waiting)
        if waiting.stage == "trial" and waiting.what == "quiet":
            self._prompt.redraw()
        if waiting.reason == "held":
            self.agent.ask(self.tr("Please let go of the keys for a moment."))
        elif text is not None:
            self._show_text(waiting, text)
            if waiting.reason == "visit":
                self.app.screen_keys.changed(self.screen)
        elif waiting.stage == "trial" and (entered or self.shown != "prompt"):
            self._show_trials(waiting.trial - 1)
            self.show_position(waiting)
            self._prompt.clear()
            self.agent.clear("listening")
            self._switch_to("prompt")
        elif waiting.stage == "paused":
            self.show_position(waiting)
            self._show_trials(waiting.trial - 1)
            can_skip = bool(self.app.patient) and self._staged.session.can_skip_attempt
            may_be_mistake = waiting.reason == "finished" and not any(self._attempts())
            self.menu.open(
                waiting.reason,
                can_skip=can_skip,
                may_be_mistake=may_be_mistake,
                is_visited=bool(self._visitors),
            )
            self._switch_to("menu")
            self.app.screen_keys.changed(self.screen)

    def _prepare_pictures(self, waiting: Waiting) -> None:
        """Prepare what the next prompt shows, before it comes."""
        to_come = self._staged.session.pictures_to_come if self._pictures else ()
        if to_come and waiting.what != "response":
            self.call_after_refresh(self._prompt.prepare, to_come)

    def _waiting_text(self, waiting: Waiting) -> WaitingText | None:
        left = max(0, waiting.until - self._staged.clock.now())
        if asked := waiting.step:
            asked = replace(asked, entry=self._marked or asked.entry)
            return step_text(asked, self.tr, left, self.app.size.width - _MARGINS)
        session = self._staged.session
        return waiting_text(
            waiting,
            session.task,
            left=left,
            is_goal_shown=bool(self._bars) and waiting.goal == self._goal,
            is_recording_over=session.is_recording_over,
        )

    def _show_text(self, waiting: Waiting, text: WaitingText) -> None:
        """Show the text for a wait, with the last result beside its goal, and the progress."""
        stage = waiting.stage
        if stage in ("attempt", "review", "trial", "paused"):
            self.show_position(waiting)
        if stage in ("review", "trial", "paused"):
            self._show_trials(waiting.trial - 1)
        if stage == "trial" and waiting.what != "agent":
            self.agent.clear("listening")
        ask = decline_text(waiting.step.step, self.tr) if waiting.step else ""
        if waiting.ask:
            key = key_name(waiting.ask, self.tr)
            ask = self.tr("Press {key} to hear how it went.", key=key)
        if self.app.switch:
            ask = ""
        is_between = stage in _BETWEEN and waiting.attempt > 1
        bars = []
        if is_between and not waiting.step:
            bars = [bar for _, bar in sorted(self._bars.items())]
        drawing = None
        if stage in ("attempt", "review"):
            drawing = self._staged.view.between_attempts()
        is_scale = waiting.step is not None and waiting.step.step.kind == "number"
        self.update_classes({"result": bool(bars), "scale": is_scale})
        self.message.show(text, bars, drawing, ask)
        self.ask(text.press)
        self._seat_agent(self._seat_beside(stage, is_between, has_drawing=bool(drawing)))
        self._switch_to("message")
        if stage == "rest" or (waiting.step and waiting.until):
            self._count_down(waiting)

    def _seat_beside(self, stage: str, is_between: bool, *, has_drawing: bool) -> str:
        """Return the agent's place beside a text."""
        is_in_middle = is_between or (stage in _BEFORE and is_roomy(*self.app.size))
        if not (is_in_middle and self.agent.widget.display):
            return ""
        is_large = has_drawing or stage == "instructions"
        return "drawn" if is_large and self.app.size.height < _FULL_HEIGHT else "between"

    def _show_again(self) -> None:
        """Show the text for the same wait, because the result beside it has changed."""
        waiting = self.waiting
        if waiting is None or waiting.stage not in _BETWEEN or self.shown != "message":
            return
        if text := self._waiting_text(waiting):
            self._show_text(waiting, text)

    def _count_down(self, waiting: Waiting) -> None:
        """Show the time that is left of a rest, each second."""
        left = waiting.until - self._staged.clock.now()
        if left > 0:
            due = self._staged.clock.now() + (left % SECOND or SECOND)
            self._countdown = self._staged.clock.call_at(due, self._show_again)

    def _stop_countdown(self) -> None:
        if self._countdown:
            self._countdown.cancel()
            self._countdown = None

    # --- the end

    def end(self, ended: SessionEnded) -> None:
        """Show the summary."""
        task = self._staged.session.task
        codes = self._staged.codes if len(task.seats) > 1 else {}
        names = [f"{task.seat_name(seat)} ({code})" for seat, code in codes.items()]
        status = "mistake" if self._staged.is_mistake else ended.status
        self.summary.show(
            *self._attempts(), status=status, names=names, what_next=self._what_next(status)
        )
        self.end_is_near(awaits_goodbye=False)
        self.query_one("#where", Static).update("")
        self._switch_to("summary")
        self.app.screen_keys.changed(self.screen)
        self._look_for_choices()
        self.read_aloud()

    def end_is_near(self, *, awaits_goodbye: bool) -> None:
        """Say how to finish, or to wait for a goodbye that an operator decides on."""
        tr = self.tr
        self.ask(tr("One moment…") if awaits_goodbye else tr("Press Enter to finish."))
        self._look_for_choices()

    def _what_next(self, status: str) -> str:
        """Return the next exercise of a participant who trains alone, else when they meet again, if
        the programme says so; empty after a mistake.
        """
        if status in ("mistake", "refused"):
            return ""
        if to_come := self.app.patient_mode.next_exercise:
            number, total = to_come
            return self.tr("Next: exercise {number} of {total}", number=number, total=total)
        days = self._staged.session.task.parameters.days_between_visits
        return meeting_text(self.app.today(), days, self.tr)

    def _praise_beside(self, words: Content) -> bool:
        """Show words below those of the agent in a small window. Returns False in a large one, and
        without an agent.
        """
        agent = self.agent.widget
        is_beside = agent.display and not is_roomy(*self.app.size)
        agent.show_below(words if is_beside else Content(""))
        return is_beside

    def _attempts(self) -> list[Sequence[AttemptEnded]]:
        """Return the attempts that are finished, of each seat."""
        task, bus = self._staged.session.task, self._staged.session.bus
        return [bus.call(RECALL, Recall(seat=seat)).attempts for seat in task.seats]

    # --- the parts of the screen

    def _switch_to(self, name: str) -> None:
        """Show one widget in the middle of the screen."""
        self.shown = name
        if name != "message":
            self.remove_class("result")
            self._seat_agent(self._seat_above(name) if self.agent.widget.display else "")
        self.query_one("#stage", ContentSwitcher).current = name
        self.screen.set_focus(self.menu if name == "menu" else None)
        self.query_one("#progress").display = name != "summary"
        stage = self.waiting.stage if self.waiting else ""
        is_between = name == "message" and stage in ("instructions", *_BETWEEN)
        self.query_one("#trials").display = not is_between  # they are of the last attempt
        self.query_one("#attempts", ProgressLine).show_signs(is_between)
        has_choices = name == "menu" and self.app.switch is not None
        self.query_one(KeyLine).display = name in ("message", "summary") or has_choices
        self.screen.refresh_bindings()

    def _seat_above(self, name: str) -> str:
        """Return the agent's place above a widget that is no text."""
        if name == "summary":
            return "between" if self.app.size.height >= _FULL_HEIGHT else "drawn"
        return "pause" if name == "menu" else ""

    def _seat_agent(self, where: str) -> None:
        """Let the agent speak from the middle, ``between`` two attempts or ``drawn`` above a
        drawing; else from below.

        In a ``pause`` it is silent above the menu.
        """
        if where != self._agent_seat:
            self._agent_seat, stage = where, self.query_one("#stage")
            between = where in ("between", "pause")
            self.update_classes(
                {"middle": bool(where), "between": between, "pausing": where == "pause"}
            )
            if where:
                self.move_child(self.agent.widget, before=stage)
            else:
                self.move_child(self.agent.widget, after=stage)

    def show_position(self, waiting: Waiting) -> None:
        """Show the mark of the trial, or attempt and level, in the corner; and the progress at the
        bottom. The attempt is the last one while its result is shown.
        """
        # after the last attempt: there is no next level to show
        is_over = waiting.trial > waiting.trials
        self._show_attempts(waiting.attempt - (not is_over))
        if not is_over:
            level = self.tr("level {level}", level=waiting.level)
            self._position = f"{waiting.attempt_name.capitalize()} · {level}"
        is_result_shown = waiting.stage == "attempt" and bool(self._bars)
        position = self._ended_position if is_result_shown else self._position
        unsure = "" if self.app.patient else self.marks.unsure_text
        parts = (self.marks.text, unsure, "" if self.marks.asks else position)
        self.query_one("#where", Static).update(" · ".join(filter(None, parts)))

    def _show_attempts(self, done: int) -> None:
        """Show the number of attempts done; practice attempts are counted separately."""
        parameters = self._staged.session.task.parameters
        done -= self.waiting.restarts if self.waiting else 0
        kind, total = "Practice", parameters.practice_attempts
        if done >= total:
            kind, total, done = "Attempts", parameters.attempts, done - total
        self.query_one("#attempts", ProgressLine).show(self.tr(kind), done, total)

    def _show_trials(self, done: int) -> None:
        total = self.waiting.trials if self.waiting else 0
        name = self.tr(self._staged.session.task.trials)
        self.query_one("#trials", ProgressLine).show(name, done, total)


class ProgressLine(Widget):
    """Shows "Prompts 3 of 20 ━━───────", or a sign for each: "■ ■ ■ □ □". It has no timer, and
    changes only by its methods.
    """

    DEFAULT_CSS = "ProgressLine { height: 1; width: 1fr; margin-right: 2; text-align: center; }"

    def __init__(self, id: str | None = None) -> None:
        super().__init__(id=id)
        self._what, self._done, self._total = "", 0, 0
        self._as_signs = False

    def show(self, what: str, done: int, total: int) -> None:
        """Show that ``done`` of ``total`` are done; ``what`` is in the screen's language."""
        self._what, self._done, self._total = what, done, total
        self.refresh()

    def show_signs(self, as_signs: bool) -> None:
        """Show a sign for each, if there is room, or words with a bar."""
        if as_signs != self._as_signs:
            self._as_signs = as_signs
            self.refresh()

    def render(self) -> Content:
        if self._as_signs and 0 < 2 * self._total <= self.size.width:
            left = self._total - self._done
            return Content.assemble(
                ("■ " * self._done, "$accent"), ("□ " * left, "$text-muted")
            ).rstrip()
        tr = language_of(self.app)
        words = (
            tr("{what} {done} of {total}", what=self._what, done=self._done, total=self._total)
            + " "
        )
        room = max(0, self.size.width - len(words))
        done = room * min(self._done, self._total) // max(1, self._total)
        return Content.assemble(
            (words, "$text-muted"),
            ("━" * done, "$accent"),
            ("─" * (room - done), "$text-muted 50%"),
        )


# --- keys of marks


class MarkKeys:
    """Follows the marks of a session, so that one replaces another only if its key is pressed
    twice.

    Args:
        marks: of the task.
        tr: the session's language.
        trial_mark: returns the trial that a mark is put on now, and the mark that is on it.
    """

    def __init__(
        self, marks: Sequence[Mark], tr: Language, trial_mark: Callable[[], TrialMark]
    ) -> None:
        self._marks = {mark.key: mark for mark in marks}
        self._titles = {mark.name: tr(mark.title) for mark in marks}
        self.tr = tr
        self._trial_mark = trial_mark
        self._mark = TrialMark()
        self._replaces = ""

    def follow(self) -> bool:
        """Follow the session to the trial that is marked from now on. Returns True if this changes
        the text.
        """
        before = self.text, self.unsure_text
        self._mark = self._trial_mark()
        return (self.text, self.unsure_text) != before

    def marked(self) -> None:
        """Follow a mark that was put on a trial, or removed."""
        self.follow()
        self._replaces = ""

    def press(self, key: str) -> Mark | None:
        """Return the mark of a key; None if the key must be pressed again to replace the present
        mark.
        """
        mark = self._marks[key]
        if self._mark.present in ("", mark.name) or self._replaces == mark.name:
            self._replaces = ""
            return mark
        self._replaces = mark.name
        return None

    @property
    def asks(self) -> bool:
        """True if a key must be pressed again to replace the present mark."""
        return bool(self._mark.present and self._replaces)

    def __contains__(self, key: object) -> bool:
        return key in self._marks

    @property
    def unsure_text(self) -> str:
        """The words on a trial that is not scored, with the key of the mark by which it is; empty
        for a sure one.
        """
        counting = next((mark for mark in self._marks.values() if mark.counts), None)
        if not self._mark.is_unsure or counting is None:
            return ""
        key, name = counting.key.upper(), self._titles[counting.name]
        return self.tr("Unsure, not scored · {key}: {mark}", key=key, mark=name)

    @property
    def text(self) -> str:
        """The mark that is on the trial, and the key that would replace it; empty without a
        mark.
        """
        if not self._mark.present:
            return ""
        text = self.tr(
            "Marked: {mark}", mark=self._titles.get(self._mark.present, self._mark.present)
        )
        if not self.asks:
            return text
        key = next(mark.key for mark in self._marks.values() if mark.name == self._replaces)
        instead = self._titles[self._replaces]
        return f"{text} · {self.tr('{key} again: {mark} instead', key=key.upper(), mark=instead)}"
