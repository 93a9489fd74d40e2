"""Simulated participants: nodes that receive prompts, and publish key presses or move a simulated
hand.
"""

from collections.abc import Callable
from typing import Any, ClassVar, Protocol

from sar_tui.loop.bus import Topic
from sar_tui.loop.clock import Handle
from sar_tui.loop.node import Node, on
from sar_tui.loop.task import Task
from sar_tui.loop.topics import (
    ACTION,
    FRAME,
    KEY,
    PROMPT,
    REPORT,
    SHOWN,
    TONE_BEGAN,
    TONE_DUE,
    TRIAL_FEEDBACK,
    TRIAL_FEEDBACK_SHOWN,
    WAITING,
)
from sar_tui.model.frames import planned, timed
from sar_tui.model.messages import (
    Action,
    AskedStep,
    FrameDue,
    KeyPressed,
    OutputReport,
    PartState,
    Prompt,
    Shown,
    ToneBegan,
    ToneDue,
    TrialFeedback,
    TrialFeedbackShown,
    Waiting,
)
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.step import DECLINE_KEY, FULL, TIMED, Entry, Step, points
from sar_tui.model.trial_types import Act, Cue, Performance, Stimulus
from sar_tui.model.units import MS

SHOWING = 4 * MS
"""Time from a prompt's publication to its onset."""
READING = 1200 * MS
"""Time from a request for a key to its press."""
TYPING = 250 * MS
"""Time between two keys of an answer."""
_SEEN: tuple[PartState, ...] = ("queued", "started", "done")


class Person(Protocol):
    """A model of a participant, such as `participant_model.Person`."""

    def perform(self, choices: int, attempt: int, streams: RandomStreams) -> Performance:
        """Draw the performance of one prompt among ``choices`` in an attempt (1, 2, …)."""
        ...

    def misses_it(self, streams: RandomStreams) -> bool:
        """Return True if this prompt gets no response."""
        ...

    def wants_feedback(self, streams: RandomStreams) -> bool:
        """Return True if they request feedback on an attempt."""
        ...


def acts(person: Person, task: Task, seed: int, prompt: Prompt, seat: str = "A") -> list[Act]:
    """Return the acts of a person at a seat on a prompt: none if they miss it or it is for the
    other seat.
    """
    streams = RandomStreams(
        seed, "person" if seat == "A" else f"person {seat}", prompt.attempt, prompt.trial
    )
    if prompt.seat not in ("", seat) or person.misses_it(streams):
        return []
    stimulus = Stimulus(
        prompt.stimulus,
        prompt.expected,
        prompt.text,
        choices=prompt.choices,
        seat=seat,
        halves=prompt.halves,
        cue=Cue(prompt.cue, 0) if prompt.cue else None,  # type: ignore[arg-type]
        frames=prompt.frames,
        colour=prompt.colour,
        picture=prompt.picture,
        tone=prompt.tone,
        data=prompt.data,
        expects=prompt.expects,  # type: ignore[arg-type]
    )
    return task.rehearse(stimulus, person.perform(prompt.choices, prompt.attempt, streams), streams)


class _Performer(Node):
    """Base of nodes that respond to prompts as a person would.

    Args:
        person: the model of the participant.
        task: the task that is done.
        seed: decides everything random.
        move: moves the hand, given a time in ns and a movement; for tasks that ask for movements.
        seat: the person's seat.
    """

    def __init__(
        self,
        person: Person,
        task: Task,
        seed: int,
        move: Callable[[int, Any], None] | None = None,
        seat: str = "A",
    ) -> None:
        super().__init__()
        self._person = person
        self._task = task
        self._seed = seed
        self._move = move
        self._seat = seat
        self._responds_until = 0

    def _perform(self, prompt: Prompt, shown: int) -> None:
        """Respond to a prompt shown at ``shown`` (ns): with keys if the node emits any, and with
        movements.
        """
        onset = shown + planned(prompt.frames, timed(prompt.frames))
        for delay_ms, act in acts(self._person, self._task, self._seed, prompt, self._seat):
            at = onset + round(delay_ms * MS)
            if not isinstance(act, str):
                if self._move:
                    self._move(at, act)
            elif KEY in self.emits:
                self._responds_until = max(self._responds_until, at)
                self._press(act, at)

    def _press(self, key: str, at: int) -> Handle:
        return self.bus.clock.call_at(at, lambda: self.emit(KEY, KeyPressed(key=key, at=at)))


class Known(Protocol):
    """Responses that are known already, so that the person's model gives only the others."""

    def covers(self, prompt: Prompt) -> bool:
        """Return True if the response to a prompt, or that there was none, is known."""
        ...

    def response_to(self, prompt: Prompt) -> tuple[str, int] | None:
        """Return the key, and its time from the onset (ns); None if there was none."""
        ...

    def wants_feedback(self, waiting: Waiting) -> bool | None:
        """Return True if feedback was requested; None if that is not known."""
        ...


class SimulatedParticipant(_Performer):
    """Presses Enter when the session waits for it, and responds to each prompt as its person
    would.

    ``known``: responses that come before the person's.
    """

    name = "participant"
    emits: ClassVar[tuple[Topic[Any], ...]] = (KEY, SHOWN, TRIAL_FEEDBACK_SHOWN, REPORT, TONE_BEGAN)
    _next: Handle | None = None
    _asked = (0, 0)
    _keys: tuple[str, ...] = ()

    def __init__(
        self,
        person: Person,
        task: Task,
        seed: int,
        move: Callable[[int, Any], None] | None = None,
        *,
        known: Known | None = None,
    ) -> None:
        super().__init__(person, task, seed, move)
        self._known = known

    @on(WAITING)
    def waiting(self, waiting: Waiting) -> None:
        """Press the key that the session waits for, or the key that requests feedback.

        A response that is late for its prompt comes first: a key just after it would not count. A
        press that is due is cancelled if the session waits for something else by then.
        """
        if self._next:
            self._next.cancel()
        if waiting.step and not waiting.until:
            self._answer(waiting.step)
            return
        key = {"enter": "" if waiting.until else "enter", "start": self._task.start_key}.get(
            waiting.what
        )
        if waiting.ask and self._wants_feedback(waiting):
            key = waiting.ask
        self._next = (
            self._press(key, max(self.now, self._responds_until) + READING) if key else None
        )

    def _answer(self, asked: AskedStep) -> None:
        """Press the next of the keys that answer a question; each changes what the session waits
        for.
        """
        is_new = (asked.number, asked.shown) != self._asked or asked.entry == Entry()
        if asked.entry == Entry():
            streams = RandomStreams(self._seed, "person", "step", asked.number)
            self._keys = answer_keys(asked.step, streams)
        elif asked.entry.is_missing:
            self._keys = (DECLINE_KEY,)  # Enter was refused
        elif is_new:
            self._keys = ("enter",)  # something was chosen before the session was interrupted
        self._asked = (asked.number, asked.shown)
        self._next = (
            self._press(self._keys[0], self.now + (READING if is_new else TYPING))
            if self._keys
            else None
        )
        self._keys = self._keys[1:]

    def _wants_feedback(self, waiting: Waiting) -> bool:
        if self._known and (wanted := self._known.wants_feedback(waiting)) is not None:
            return wanted
        return self._person.wants_feedback(
            RandomStreams(self._seed, "person", waiting.attempt, waiting.stage)
        )

    @on(PROMPT)
    def prompted(self, prompt: Prompt) -> None:
        shown = self._show(prompt)
        if not (self._known and self._known.covers(prompt)):
            self._perform(prompt, shown)
        elif response := self._known.response_to(prompt):
            key, after = response
            self._press(key, shown + planned(prompt.frames, timed(prompt.frames)) + after)

    @on(FRAME)
    def frame_due(self, due: FrameDue) -> None:
        self._show(due, due.frame, due.at)

    @on(TONE_DUE)
    def tone_due(self, due: ToneDue) -> None:
        """Report that a tone is heard at its time, and that of a prompt as it is shown."""
        at = max(due.at, self.now + SHOWING)
        began = ToneBegan(
            attempt=due.attempt,
            trial=due.trial,
            presentation=due.presentation,
            frame=due.frame,
            at=at,
            source="virtual",
        )
        self.bus.clock.call_at(at, lambda: self.emit(TONE_BEGAN, began))

    def _show(self, prompt: Prompt | FrameDue, frame: int = 0, at: int = 0) -> int:
        """Report that a prompt or a frame of it is shown in a moment, and return its onset (ns)."""
        onset = max(self.now + SHOWING, at)
        shown = Shown(
            attempt=prompt.attempt,
            trial=prompt.trial,
            presentation=prompt.presentation,
            at=onset,
            source="virtual",
            frame=frame,
        )
        self.bus.clock.call_at(onset, lambda: self.emit(SHOWN, shown))
        return onset

    @on(TRIAL_FEEDBACK)
    def trial_feedback_due(self, due: TrialFeedback) -> None:
        onset = self.now + SHOWING
        shown = TrialFeedbackShown(
            seat=due.seat, attempt=due.attempt, trial=due.trial, at=onset, source="virtual"
        )
        self.bus.clock.call_at(onset, lambda: self.emit(TRIAL_FEEDBACK_SHOWN, shown))

    @on(ACTION)
    def action_begun(self, action: Action) -> None:
        """Report that the text of an action is shown at once."""
        for state in _SEEN:
            self.emit(
                REPORT,
                OutputReport(
                    action=action.id, output="screen", part="show", state=state, at=self.now
                ),
            )


class SimulatedPartner(_Performer):
    """Responds to the prompts of one seat at the same keyboard, and leaves other keys to the
    participant at seat A.
    """

    name = "partner"
    emits = (KEY,)

    @on(PROMPT)
    def prompted(self, prompt: Prompt) -> None:
        self._perform(prompt, self.now + SHOWING)


class SimulatedMover(_Performer):
    """Moves a simulated hand as its person would, while a real participant presses the keys."""

    name = "mover"

    @on(PROMPT)
    def prompted(self, prompt: Prompt) -> None:
        self._perform(prompt, self.now)


DECLINES = 0.03
"""Share of questions that a simulated participant would rather not answer."""
_WORDS = ("fine", "ok", "it went well", "my arm is tired")


def answer_keys(step: Step, streams: RandomStreams) -> tuple[str, ...]:
    """Return the keys with which a participant answers a step; none for one that ends by itself.

    Each option is equally likely; ratings lie near the middle. They agree to what is required.
    """
    if step.kind in TIMED:
        return ()
    if step.required:
        return (
            next(point.typed for point in points(step) if point.label == step.required),
            "enter",
        )
    if step.is_question and streams.uniform("declines") < DECLINES:
        return (DECLINE_KEY,)
    return (*_chosen(step, streams), "enter")


def _chosen(step: Step, streams: RandomStreams) -> tuple[str, ...]:
    """Return the keys before Enter."""
    match step.kind:
        case "text":
            return tuple(
                "space" if char == " " else char for char in streams.choice(_WORDS, "words")
            )
        case "line":
            return (str(int(_middling(streams) * FULL) // 10),)
        case "choices":
            return tuple(
                str(n) for n in range(1, len(step.labels) + 1) if streams.uniform("tick", n) < 0.5
            ) or ("1",)
        case "choice":
            return (streams.choice(points(step), "option").typed,)
        case "screen":
            return ()
    scale = points(step)
    return tuple(scale[int(_middling(streams) * len(scale))].typed)


def _middling(streams: RandomStreams) -> float:
    """Return a number in [0, 1), most often near a half."""
    return (streams.uniform("one") + streams.uniform("other")) / 2
