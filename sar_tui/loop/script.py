"""The script of a session: it reads downwards, as Figure 3.1 of the thesis tells it.

A session shows its instructions, runs its attempts and ends. An attempt runs its trials. A trial
goes through (start) → quiet → foreperiod → (storing) → onset → response → (result). Each of these
waits with ``yield`` for the kinds of events that mean something to it, and is sent one of them;
`nodes.event_handler` feeds it. What can happen at any moment is thrown in as an `Interruption`
where the script waits, and is caught at the level that it concerns.
"""

from collections.abc import Callable, Generator
from functools import partial
from typing import Any, Literal, NamedTuple, TypeVar

from msgspec.structs import replace

from sar_tui.loop.attempts import Attempts
from sar_tui.loop.clock import STALLED
from sar_tui.loop.dose import DoseCount
from sar_tui.loop.node import TimedNode
from sar_tui.loop.scores import Scores
from sar_tui.loop.session_phase import (
    ENTER_RESUMES,
    IN_TRIAL,
    VISIT_ASKED,
    Phase,
    waiting_message,
)
from sar_tui.loop.status import Status
from sar_tui.loop.steps import Ended, Steps, is_refusal
from sar_tui.loop.task import Task
from sar_tui.loop.topics import (
    ATTEMPT_STARTED,
    CUE,
    FRAME,
    PROMPT,
    SESSION_ENDED,
    STEP_ENDED,
    TONE_DUE,
    TONES_AHEAD,
    TRIAL,
    TRIAL_FEEDBACK,
    TYPED,
    VISIT_DECIDED,
    VOIDED,
    WAITING,
)
from sar_tui.loop.trial import OpenTrial, trial_feedback
from sar_tui.loop.undo import Done, Undo
from sar_tui.model import frames
from sar_tui.model import messages as m
from sar_tui.model.step import TIMED, Step
from sar_tui.model.trial_types import Again, Result, Results, complete
from sar_tui.model.units import MS, SECOND

CONTINUES_AFTER = 1500 * MS
"""Time between two attempts of a continuous task."""
STARTS_AFTER = 1 * SECOND
"""The same before the first attempt of a session without instructions, for which Enter was pressed
on another screen.
"""
READING = 5 * SECOND
"""The same if there was feedback."""
MAX_PRESENTATIONS = 3
"""A trial that cannot be measured is shown this many times in total; then it counts as missed."""
HELD_NOTICE = 3 * SECOND
"""After this long without quiet the participant is asked to release the keys."""
GRACE = 50 * MS
"""Wait after the time-out for responses that were stamped in time but are handled late."""

T = TypeVar("T")
Script = Generator[tuple[type, ...], Any, T]
"""Yields the kinds of events that it waits for, and is sent one of them."""
Judged = Result | Results


# --- events that are no messages


class TimeUp(NamedTuple):
    """A timer fired, ``late`` ns after it was due."""

    name: str
    late: int


class Decided(NamedTuple):
    """No proposal waits for an operator any more."""


class Resume(NamedTuple):
    """The pause is to end."""


class Withdrawn(NamedTuple):
    """Somebody does not ask to watch any longer, or the participant has declined."""


# --- interruptions


class Interruption(Exception):
    """Thrown into the script where it waits. A presentation that it interrupts is void."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


class Pause(Interruption):
    """The session pauses; then it goes on with what was interrupted."""


class Repeat(Interruption):
    """The trial is presented again."""


class SkipAttempt(Interruption):
    """The attempt that is under way, or comes next, is left out."""


class TakeBack(Interruption):
    """The last answer is taken back, or the attempt that was just begun."""


class End(Interruption):
    """The session ends."""


class Skip(Exception):
    """The trial, the step or the rest is over now."""


class CannotMeasure(Exception):
    """The task cannot measure a response."""

    def __init__(self, again: Again) -> None:
        super().__init__(again.reason)
        self.again = again


class AttemptRestarts(Exception):
    """The attempt was interrupted, and its trials build on each other."""


class Refused(Exception):
    """A required answer was not given."""


def time_up(timer: str) -> Script[None]:
    """Wait until a timer fires."""
    while (yield (TimeUp,)).name != timer:
        pass


class SessionScript:
    """Runs a session. Read it from `session` downwards.

    Args:
        node: publishes its messages, and keeps its timers.
        task: built with its parameters.
        seed: of the session.

    Attributes:
        is_all_done: True after the last attempt.
        starts_at_once: the first attempt is still to begin by itself, without instructions.
        rest_until: end of the rest (ns); 0 without one.
        undo: what can be taken back.
        feedback_due_at: when feedback on the last attempt is given (ns).
    """

    def __init__(self, node: TimedNode, task: Task, seed: int) -> None:
        self.node = node
        self.task = task
        self.status = Status(task)
        self.attempts = Attempts(task, seed)
        self.scores = Scores(node, task, self.attempts, self.status)
        self.dose = DoseCount(task)
        self.steps = Steps(task)
        self.presenter = Presenter(node, task, self.status, self.announce)
        self.is_all_done = False
        self.starts_at_once = task.parameters.instructions == "never"
        self.rest_until = 0
        self.undo = Undo()
        self.feedback_due_at = 0
        self._has_feedback = False  # on the last attempt
        self._continues_at = 0
        self._limit = ""  # text, once a limit is reached
        self._is_restarted = False
        self._is_sensor_checked = False
        # after a question or a limit, Enter does not wait for a decision that is pending
        self._ignores_decision = False
        self._unmeasured = 0  # presentations of the open trial

    # --- the session

    def session(self) -> Script[None]:
        """Run the session, from the instructions to its end."""
        status: m.EndStatus = "completed"
        try:
            if not self.starts_at_once:
                yield from self.through_pauses(self.instructions)
            yield from self.steps_due()
            yield from self.all_attempts()
            yield from self.enter_pressed(Phase.REVIEW)
        except Refused:
            status = "refused"
        except End:
            self.node.cancel_timers()
            status = "completed" if self.is_all_done else "aborted"
            if self.steps.awaits_agreement:
                status = "refused"
        yield from self.last_trial_stored()
        self.announce(Phase.ENDED)
        self.node.emit(SESSION_ENDED, m.SessionEnded(status=status))

    def instructions(self) -> Script[None]:
        """Show the instructions until Enter."""
        self.announce(Phase.INSTRUCTIONS)
        while (yield (m.KeyPerceived,)).key != "enter":
            pass

    def all_attempts(self) -> Script[None]:
        """Run attempts until the last one is done, or a limit is reached."""
        is_skipped = False
        while not self.is_all_done:
            try:
                if is_skipped and self.status.blockers.is_sensor_lost:
                    yield from self.paused("sensor")
                is_skipped = False
                is_by_hand = yield from self.enter_pressed(Phase.READY)
                self._limit = self.dose.limit_text(self.node.now)
                if self._limit:  # it was reached while the participant rested
                    self.is_all_done = self._ignores_decision = True
                    return
                yield from self.attempt(is_by_hand=is_by_hand)
                yield from self.after_attempt()
            except SkipAttempt:
                self.node.cancel_timers()
                self.is_all_done = not self.attempts.skip()
                self.status.phase = Phase.READY
                is_skipped = True
            except (AttemptRestarts, TakeBack):
                self.attempts.restart()
                self._is_restarted = True

    # --- before an attempt

    def enter_pressed(self, phase: Phase) -> Script[bool]:
        """Wait for Enter, before an attempt or at the end: first for an operator's decision.

        Returns False if the attempt begins by itself.
        """
        return self.through_answers(partial(self._enter_pressed, phase))

    def _enter_pressed(self, phase: Phase) -> Script[bool]:
        was_entered_before = self.starts_at_once and phase is Phase.READY
        if was_entered_before:
            self.starts_at_once = False
            self.continue_after(STARTS_AFTER)
        self.announce(phase)
        may_await_decision, self._ignores_decision = not self._ignores_decision, False
        while True:
            if may_await_decision and self.status.awaits_operator:
                yield from self.feedback_given()
                self._let_continue(phase)
                self.announce(phase)
            if phase is Phase.READY:
                self._check_sensor()
            match (yield (m.KeyPerceived, TimeUp, m.AgentActing)):
                case m.KeyPerceived(key="enter", repeat=False):
                    return True
                case TimeUp("continue") if phase is Phase.READY:
                    if self.status.asking:  # the agent spoke until now
                        raise Pause(VISIT_ASKED)
                    return was_entered_before
                case event:
                    may_await_decision = isinstance(event, m.AgentActing)

    def _let_continue(self, phase: Phase) -> None:
        """Let the next attempt of a continuous task begin by itself, unless it is the first."""
        is_first = self.attempts.is_first_after_practice
        if self.task.continuous and phase is Phase.READY and not is_first:
            self.continue_after(READING if self._has_feedback else CONTINUES_AFTER)

    def continue_after(self, duration: int) -> None:
        """Let the next attempt begin by itself after a time (ns)."""
        self._continues_at = self.node.now + duration
        self.node.set_timer("continue", self._continues_at)

    # --- an attempt

    def attempt(self, *, is_by_hand: bool) -> Script[None]:
        """Run the trials of an attempt, and score it."""
        self.node.cancel_timer("continue")
        self._is_restarted = False
        self.dose.begin_attempt(self.node.now)
        self.node.emit(ATTEMPT_STARTED, self.attempts.begin(self.node.now))
        self.scores.begin_attempt()
        self.undo.forget("answer", "attempt", "level", "hold", "setting", "mark")
        if is_by_hand:
            self._can_take_back("attempt", self.attempts.attempt)
        while not self.attempts.is_attempt_done:
            yield from self.trial()
        self._score_attempt()

    def _can_take_back(
        self, what: Literal["answer", "attempt"], number: int, seat: str = "A"
    ) -> None:
        """Let the participant take back an answer, or the beginning of an attempt."""

        def is_possible() -> bool:
            return self.status.phase is not Phase.PAUSED

        done = Done(
            "participant",
            what,
            self.node.now,
            number=number,
            seat=seat,
            is_possible=is_possible,
        )
        self.undo.note(done)

    def _score_attempt(self) -> None:
        """Score the attempt, and decide if another one follows."""
        self.undo.forget("level", "hold", "setting")
        scored = self.scores.end_attempt()
        ended = scored.first.ended
        self.dose.end_attempt(ended.level, self.node.now, is_practice=ended.practice)
        self.steps.attempts_done += not ended.practice
        is_last = self.attempts.attempt == self.attempts.total
        self._limit = "" if is_last else self.dose.limit_text(self.node.now)
        self.is_all_done = bool(self._limit) or not self.attempts.advance()
        self.feedback_due_at = max(one.feedback.due if one.feedback else 0 for one in scored.seats)
        self._has_feedback = any(one.is_feedback_due for one in scored.seats)

    # --- a trial

    def trial(self) -> Script[None]:
        """Present the next trial until it is judged, and record it."""
        self.presenter.trial = self.attempts.next_trial()
        judged, notice = None, ""
        while judged is None:
            judged, notice = yield from self.presentation(notice)
        yield from self.result(judged)

    def presentation(self, notice: str) -> Script[tuple[Judged | None, str]]:
        """Present the trial once. An interruption voids that.

        Returns how it was judged, or None and what the participant is told before the next time.
        """
        pause: str | None = None
        try:
            return (yield from self.presenter.presentation(notice)), ""
        except Skip:
            return Result(correct=False, flags=("skipped",)), ""
        except CannotMeasure as why:
            return self._unmeasurable(why.again)
        except Pause as why:
            pause = why.reason
            self.void(why.reason or "pause")
        except Interruption as why:
            self.void(why.reason)
            if not isinstance(why, Repeat):
                raise
        if pause is not None:
            yield from self.paused(pause)
            self.status.keys.last = self.node.now
        if self.task.restarts_attempts and self.attempts.trial > 1:
            raise AttemptRestarts
        return None, ""

    def _unmeasurable(self, again: Again) -> tuple[Judged | None, str]:
        """Present the trial again, with a notice, unless that was tried often enough."""
        self._unmeasured += 1
        if self._unmeasured < MAX_PRESENTATIONS:
            self.void(again.reason)
            return None, again.text
        flags = ("unmeasured", again.reason)
        return Result(correct=False, flags=flags, remark=again.text), ""

    def result(self, judged: Judged) -> Script[None]:
        """Record the trial, and show the answer to it."""
        self.node.cancel_timers()
        self.undo.forget("attempt")
        trial = self.presenter.trial
        results = self._by_seat(trial, judged)
        self._unmeasured = 0
        whole = {seat: complete(mine, self.task.Details) for seat, mine in results.items()}
        flagged = {seat: self._flagged(trial, mine) for seat, mine in whole.items()}
        stored = self.scores.add(flagged, trial.mark)
        self.status.last_trial = self.attempts.last_trial
        for seat, mine in stored.items():
            self.node.emit(TRIAL, trial.ended(mine, seat))
        sign_ms = self.task.parameters.trial_feedback_ms
        shown = trial_feedback(trial.situation, stored, self.task.seats, sign_ms)
        if shown:
            self.node.emit(TRIAL_FEEDBACK, shown)
            self.node.set_timer("result", self.node.now + shown.duration)
            self.announce(Phase.RESULT)
            yield from self.result_seen(shown.duration)

    def _by_seat(self, trial: OpenTrial, judged: Judged) -> Results:
        """Return the result of each seat of a trial. Raises ValueError if they are for others."""
        results = judged if isinstance(judged, dict) else dict.fromkeys(trial.seats, judged)
        if set(results) != set(trial.seats):
            given, due = ", ".join(map(str, results)) or "none", ", ".join(trial.seats)
            raise ValueError(
                f"the results of a trial are for the seats {given}; they are due for {due}"
            )
        return results

    def _flagged(self, trial: OpenTrial, result: Result) -> Result:
        """Flag a result that came too soon to be a response."""
        latency = trial.latency_ms(result)
        if latency is None or latency >= self.task.parameters.min_rt_ms:
            return result
        return replace(result, flags=(*result.flags, "anticipation"))

    def result_seen(self, duration: int) -> Script[None]:
        """Wait while the answer to a trial is shown, from when it reached the terminal."""
        while True:
            match (yield (TimeUp, m.TrialFeedbackShown)):
                case TimeUp():
                    self.node.cancel_timer("result")
                    return
                case m.TrialFeedbackShown() as shown:
                    if (shown.attempt, shown.trial) == self.status.last_trial:
                        self.node.set_timer("result", shown.at + duration)

    # --- after an attempt

    def after_attempt(self) -> Script[None]:
        """Wait for feedback, ask what is due, and rest if that must be."""
        must_rest = not self.is_all_done and self.dose.is_rest_due(self.node.now)
        yield from self.feedback_given()
        yield from self.steps_due()
        if must_rest:
            self._ignores_decision = False
            self.dose.begin_rest()
            yield from self.rest()
        else:
            self._let_continue(Phase.REVIEW if self.is_all_done else Phase.READY)

    def feedback_given(self) -> Script[None]:
        """Wait for delayed feedback, and for an operator's decision on it."""
        return self.through_pauses(self._feedback_given)

    def _feedback_given(self) -> Script[None]:
        while self.feedback_due_at > self.node.now or self.status.awaits_operator:
            self.announce(Phase.FEEDBACK)
            if self.feedback_due_at > self.node.now:
                self.node.set_timer("answer", self.feedback_due_at)
            self._check_sensor()
            is_over = False
            while not is_over:
                event = yield (TimeUp, Decided)
                is_over = isinstance(event, Decided) or event.name == "answer"

    def steps_due(self) -> Script[None]:
        """Ask what is due now, one step after the other."""
        for step in self.steps.due(is_last=self.is_all_done):
            try:
                ended = yield from self.through_pauses(partial(self.step, step))
            except Skip:
                ended = Ended("skipped", None, self.node.now)
            except TakeBack:
                self.node.cancel_timer("step")
                self.steps.take_back()
                continue
            self.node.cancel_timer("step")
            message = self.steps.end(ended)
            self.node.emit(STEP_ENDED, message)
            self.undo.forget("answer")
            if ended.status in ("answered", "declined"):
                self._can_take_back("answer", message.number, message.seat)
            if is_refusal(step, ended.answer):
                raise Refused
            self._ignores_decision = self.steps.attempts_done > 0

    def through_answers(self, wait: Callable[[], Script[T]]) -> Script[T]:
        """Wait for something, through pauses. If the last answer is taken back meanwhile, ask for
        it again, then wait anew.
        """
        while True:
            try:
                return (yield from self.through_pauses(wait))
            except TakeBack:
                continues = self.node.has_timer("continue")
                self.node.cancel_timers()
                self.steps.take_back()
            yield from self.steps_due()
            if continues:
                self.continue_after(CONTINUES_AFTER)

    def step(self, step: Step) -> Script[Ended]:
        """Show a step until it is answered, read or over."""
        self.steps.show(self.node.now)
        if step.kind in TIMED:
            self.node.set_timer("step", self.steps.until)
            self.announce(Phase.STEP)
            yield from time_up("step")
            return Ended("done", None, self.node.now)
        self.announce(Phase.STEP)
        while True:
            given = self.steps.press((yield (m.KeyPerceived,)))
            if isinstance(given, Ended):
                return given
            if given:
                self.announce(Phase.STEP)

    def rest(self) -> Script[None]:
        """Rest as long as the settings say, or until somebody ends the rest."""
        self.rest_until = self.node.now + self.task.parameters.rest_seconds * SECOND
        try:
            yield from self.through_answers(self._rested)
        except Skip:
            self.node.cancel_timer("rest")
        self.dose.end_rest(self.node.now)
        self.rest_until = 0

    def _rested(self) -> Script[None]:
        if self.rest_until > self.node.now:
            self.announce(Phase.REST)
            self.node.set_timer("rest", self.rest_until)
            yield from time_up("rest")

    # --- the end

    def last_trial_stored(self) -> Script[None]:
        """Wait until the last trial is on disk, where another run would find it."""
        if not self.status.is_last_trial_stored:
            self.announce(Phase.CLOSING)
        while not self.status.is_last_trial_stored:
            yield (m.Stored, m.SessionStarted)

    # --- interruptions

    def through_pauses(self, wait: Callable[[], Script[T]]) -> Script[T]:
        """Wait for something. If a pause interrupts that, begin to wait for it anew afterwards."""
        while True:
            try:
                return (yield from wait())
            except Pause as why:
                reason = why.reason
            # outside the handler, so that what interrupts the pause is not taken for its cause
            yield from self.paused(reason)

    def paused(self, reason: str) -> Script[None]:
        """Wait until nothing blocks the session. Another reason to pause replaces the first."""
        status = self.status
        self.node.cancel_timers()
        status.paused_from, status.pause_reason = status.phase, reason
        interrupted: str | None = None  # by the question whether somebody may watch
        self.announce(Phase.PAUSED)
        while True:
            try:
                event = yield (Resume, m.KeyPerceived, m.SensorChanged, Withdrawn)
            except Pause as another:
                interrupted = status.pause_reason if another.reason == VISIT_ASKED else None
                status.pause_reason = another.reason
                self.announce(Phase.PAUSED)
                continue
            if status.reason == VISIT_ASKED:
                if isinstance(event, m.KeyPerceived) and event.key == "enter":
                    self.decide_visit("agreed")
                resumes = not status.asking and interrupted is None
                if not status.asking and interrupted is not None:
                    status.pause_reason, interrupted = interrupted, None
                    self.announce(Phase.PAUSED)
            else:
                resumes = self._ends_pause(event)
            if not resumes:
                continue
            if status.blockers.is_sensor_lost and self.needs_sensor:
                status.pause_reason = "sensor"
            elif status.blockers.has_disk_failed:
                status.pause_reason = "restored"
            else:
                return
            self.announce(Phase.PAUSED)

    def _ends_pause(self, event: object) -> bool:
        """Return True if an event ends the pause, unless something blocks the session."""
        match event:
            case m.KeyPerceived(key=key):
                return key == "enter" and self.status.reason in ENTER_RESUMES
            case m.SensorChanged():
                return self.status.pause_reason == "sensor"
        return isinstance(event, Resume)

    def decide_visit(self, outcome: Literal["agreed", "declined", "ended"]) -> None:
        """Publish what the participant decided: for those who ask, or for the rest of this run."""
        status = self.status
        peers, status.asking = tuple(status.asking), []
        status.are_visits_over |= outcome != "agreed"
        self.node.emit(VISIT_DECIDED, m.VisitDecided(outcome=outcome, peers=peers))

    @property
    def needs_sensor(self) -> bool:
        """True if movements follow: not in the instructions, and not after the last attempt."""
        return not (self.is_all_done or self.status.place is Phase.INSTRUCTIONS)

    def _check_sensor(self) -> None:
        """Pause if the sensor was lost before the first attempt, where it was not needed."""
        if not self._is_sensor_checked:
            self._is_sensor_checked = True
            if self.status.blockers.is_sensor_lost:
                raise Pause("sensor")

    def void(self, reason: str) -> None:
        """Void the presentation of the open trial, so that the trial is presented again."""
        self.node.cancel_timers()
        trial = self.presenter.trial
        if trial.mark:
            self.scores.mark_open_trial(trial, None)
        self.node.emit(VOIDED, trial.voided(reason))
        self.presenter.trial = trial.repeated()

    # --- what the session waits for

    def announce(self, phase: Phase, reason: str = "") -> None:
        """Enter a phase, and publish what the session waits for."""
        status, asked = self.status, self.steps.asked
        status.phase = phase
        why = reason or status.reason
        step = (asked.number, asked.shown) if phase is Phase.STEP and asked else None
        status.keys.asked_for((phase, self.attempts.attempt, step, why), self.node.now)
        message = waiting_message(
            phase,
            self.attempts,
            self.task,
            notice=self._notice(phase),
            reason=why,
            detail=status.blockers.detail(why),
            seat=status.blockers.lost_seat if why == "sensor" else self._turn(phase),
            until=self._until(phase),
        )
        if phase is Phase.STEP:
            message = replace(message, step=asked)
        if phase is Phase.READY and (explained := self.scores.explained):
            message = replace(message, why=explained)
        self.node.emit(WAITING, message)

    def _notice(self, phase: Phase) -> str:
        """Return what the participant must know first."""
        if phase is Phase.READY:
            tr = self.task.tr
            counts = tr("Practice is over. From here on it counts.")
            parts = (
                tr("This attempt begins again.") if self._is_restarted else "",
                counts if self.attempts.is_first_after_practice else "",
                self.scores.level_notice,
            )
            return " ".join(filter(None, parts))
        if phase is Phase.REVIEW:
            return self._limit
        return self.presenter.notice if phase is Phase.START else ""

    def _until(self, phase: Phase) -> int:
        """Return when a wait ends by itself (ns); 0 if that is not known."""
        if phase is Phase.REST:
            return self.rest_until
        if phase is Phase.STEP:
            return self.steps.until
        continues = phase is Phase.READY and self.node.has_timer("continue")
        return self._continues_at if continues else 0

    def _turn(self, phase: Phase) -> str:
        """Return the seat whose turn it is, if it may be known; empty for all seats."""
        if len(self.task.seats) == 1:
            return self.task.seats[0]
        return self.presenter.trial.turn if phase in IN_TRIAL else ""


class Presenter:
    """Presents a trial: from its start to the response (thesis 3.2.3).

    A key in the foreperiod restarts it. No prompt is shown while the agent speaks or moves. With
    several seats, a trial ends for all of them at once, and keys of a seat whose turn it is not are
    ignored.

    Attributes:
        trial: the one that is open.
        notice: told to the participant before it.
    """

    trial: OpenTrial

    def __init__(
        self,
        node: TimedNode,
        task: Task,
        status: Status,
        announce: Callable[..., None],
    ) -> None:
        self.node = node
        self.task = task
        self.parameters = task.parameters
        self.status = status
        self.announce = announce
        self.notice = ""

    def presentation(self, notice: str) -> Script[Judged]:
        """Present the trial once.

        Raises:
            CannotMeasure: the task cannot measure the response.
            Repeat: the program was suspended, so that the time of the response is not known.
        """
        self.notice = notice
        if self.trial.tones:
            self.node.emit(TONES_AHEAD, m.TonesAhead(tones=self.trial.tones))
        yield from self.agent_still()
        if self.task.start_key:
            yield from self.started()
        if self.task.has_foreperiod:
            yield from self.foreperiod()
        else:
            yield from self.agent_still()
            yield from self.last_trial_stored()
        self.show()
        yield from self.onset()
        return (yield from self.response())

    # --- before the prompt

    def agent_still(self) -> Script[None]:
        """Wait until the agent neither speaks nor moves."""
        if self.status.is_agent_acting:
            self.announce(Phase.AGENT)
        while self.status.is_agent_acting:
            yield (m.AgentActing,)

    def started(self) -> Script[None]:
        """Wait until the participant starts the trial with a key."""
        self.announce(Phase.START)
        while True:
            key = yield (m.KeyPerceived,)
            if self.status.keys.is_start:
                self.trial.started = key.at
                return

    def foreperiod(self) -> Script[None]:
        """Wait for quiet, for a random time, and for the disk. A key restarts all that."""
        while True:
            yield from self.quiet()
            is_over = yield from self.random_time()
            if is_over and (yield from self.last_trial_stored()):
                return
            self.node.cancel_timer("foreperiod")
            self.node.cancel_timer("cue")

    def quiet(self) -> Script[None]:
        """Wait until no key has been pressed for a moment, and the agent is still."""
        while True:
            since = self.node.now
            self.announce(Phase.QUIET)
            self._set_quiet_timer()
            while not isinstance((yield (m.KeyPerceived, m.Pasted, TimeUp)), TimeUp):
                self._set_quiet_timer()
                if self.node.now - since > HELD_NOTICE:
                    since = self.node.now
                    self.announce(Phase.QUIET, "held")
            if not self.status.is_agent_acting:
                return
            yield from self.agent_still()

    def _set_quiet_timer(self) -> None:
        now, last = self.node.now, self.status.keys.last
        quiet = self.parameters.quiet_ms * MS
        self.node.set_timer("quiet", now if last is None else max(now, last + quiet))

    def random_time(self) -> Script[bool]:
        """Wait for the foreperiod, and give the cue in it; False if it must be restarted."""
        shortest, longest = self.parameters.foreperiod_min_ms, self.parameters.foreperiod_max_ms
        wait = self.trial.draw_foreperiod(shortest, longest)
        self.announce(Phase.FOREPERIOD)
        self.node.set_timer("foreperiod", self.node.now + wait)
        if cue := self.trial.stimulus.cue:
            self.node.set_timer("cue", self.node.now + wait - cue.lead_ms * MS)
        while True:
            match (yield (m.KeyPerceived, m.Pasted, TimeUp)):
                case m.KeyPerceived() | m.Pasted():
                    self.trial.false_starts += 1
                    return False
                case TimeUp(_, late) if late > STALLED:
                    return False
                case TimeUp("cue"):
                    self._give_cue()
                case TimeUp("foreperiod"):
                    return True

    def last_trial_stored(self) -> Script[bool]:
        """Wait until the last trial is on disk; False if a foreperiod was disturbed meanwhile."""
        if not self.status.is_last_trial_stored:
            self.announce(Phase.STORING)
        while not self.status.is_last_trial_stored:
            match (yield (m.KeyPerceived, m.Pasted, m.Stored, TimeUp)):
                case m.KeyPerceived() | m.Pasted() if self.task.has_foreperiod:
                    self.trial.false_starts += 1
                    return False
                case TimeUp("cue"):  # it has no lead
                    self._give_cue()
        return True

    def _give_cue(self) -> None:
        self.node.emit(CUE, self.trial.cue(self.node.now))

    # --- the prompt and the response

    def show(self) -> None:
        """Publish the prompt."""
        if not self.status.focused:
            self.trial.flag("focus_lost")
        prompt = self.trial.prompt(self.parameters.response_timeout_ms, self.node.now)
        self.node.emit(PROMPT, prompt)
        self._request_tone()
        self.announce(Phase.ONSET)

    def onset(self) -> Script[None]:
        """Wait until the prompt is on the screen. What comes earlier is judged afterwards."""
        while True:
            match (yield (m.Shown, m.KeyPerceived, m.ReachPerceived, TimeUp)):
                case m.Shown() as shown if self.trial.is_shown_by(shown):
                    self.status.phase = Phase.RESPONSE
                    self._set_onset(shown)
                    return
                case m.KeyPerceived() | m.ReachPerceived() as percept:
                    self.trial.early.append(percept)
                case TimeUp("cue"):  # it has no lead
                    self._give_cue()

    def response(self) -> Script[Judged]:
        """Wait for the response. Stamps decide what is in time, not the order of callbacks."""
        while True:
            if not self.trial.is_drawing:
                judged = self._judge_early()
                if judged is not None:
                    return judged
            match (yield (m.Shown, m.KeyPerceived, m.ReachPerceived, TimeUp)):
                case m.Shown() as shown if self.trial.is_shown_by(shown):
                    self._set_onset(shown)
                case m.KeyPerceived() | m.ReachPerceived() as percept:
                    self.trial.early.append(percept)
                case TimeUp("frame" | "timeout", late) if late > STALLED:
                    raise Repeat("stalled")
                case TimeUp("frame"):
                    self.node.emit(FRAME, self.trial.frame())
                case TimeUp("timeout", late):
                    self.node.cancel_timer("frame")
                    self.trial.lag = late
                    self.node.set_timer("grace", self.node.now + GRACE)
                case TimeUp("grace"):
                    judged = self._judge_early()
                    return self.task.timed_out(self.trial.view()) if judged is None else judged

    def _set_onset(self, shown: m.Shown) -> None:
        """Store an onset, and schedule what follows from it."""
        was_timed = self.trial.timeout_at is not None
        self.trial.set_onset(shown)
        over, due = self.trial.timeout_at, self.trial.next_onset_due
        if over is not None and not was_timed:
            self.node.set_timer("timeout", over)
        if due is not None:
            self.node.set_timer("frame", due - frames.LEAD)
            self._request_tone()

    def _request_tone(self) -> None:
        if due := self.trial.next_tone():
            self.node.emit(TONE_DUE, due)

    # --- the judgement

    def _judge_early(self) -> Judged | None:
        """Judge what was done while the prompt or a frame was on its way to the screen."""
        early, self.trial.early = self.trial.early, []
        for percept in early:
            judged = self._judge(percept)
            if judged is not None:
                return judged
        return None

    def _judge(self, percept: m.Percept) -> Judged | None:
        """Flag what is no response; let the task judge the rest."""
        trial = self.trial
        if percept.seat not in trial.seats:
            if percept.seat:
                trial.flag("other_seat")
            return None
        if percept.repeat:
            trial.flag("repeat_key")
            if isinstance(percept, m.KeyPerceived):
                trial.remember_repeat(percept)
            return None
        if percept.stalled and trial.stimulus.signals:
            raise Repeat("stalled")
        if not trial.is_awaited(percept.at):
            trial.flag("early_key")
            return None
        seen = trial.view()
        if seen.latency_ms(percept.at) > trial.timeout_ms:
            trial.remember(percept)
            trial.flag("late_key")
            return self.task.timed_out(seen)
        if trial.expects_text and isinstance(percept, m.KeyPerceived):
            return self._type(percept)
        return self._take(percept)

    def _type(self, key: m.KeyPerceived) -> Judged | None:
        """Take a key of a typed text, show the text so far, and judge it when it is sent."""
        before = self.trial.typed()
        text = self.trial.type(key)
        judged = self._take(text) if text else None
        typed = self.trial.typed()
        if judged is None and typed != before:
            self.node.emit(TYPED, typed)
        return judged

    def _take(self, percept: m.Percept) -> Judged | None:
        """Let the task judge a percept."""
        seen = self.trial.view()
        self.trial.remember(percept)
        judged = self.task.perceived(seen, percept)
        if isinstance(judged, Again):
            raise CannotMeasure(judged)
        return judged
