"""Drives a session as a participant would, at exact times on a virtual clock."""

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from sar_tui.loop import topics as t
from sar_tui.loop.bus import Record, Topic
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.loop.session import Session
from sar_tui.loop.task import Task
from sar_tui.model import messages as m
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.rules.keys import QUIET, UNREAD
from sar_tui.rules.parameters import build

M = TypeVar("M", bound=m.Message)

SHOWING = 4 * MS
"""Time from a prompt's publication to its onset."""


class Screen(Node):
    """Shows prompts after ``SHOWING``, and acknowledges storage, unless switched off."""

    name = "screen"
    emits = (t.SHOWN, t.STORED, t.TONE_BEGAN)

    def __init__(self) -> None:
        super().__init__()
        self.shows = True
        self.stores = True
        self.source: Any = "flush"
        self.hears: Any = "device"
        self.prompt: m.Prompt | None = None
        self.onset: int | None = None
        self.waiting: m.Waiting | None = None
        self.waiting_since = 0

    @on(t.WAITING)
    def now_waiting(self, waiting: m.Waiting) -> None:
        self.waiting, self.waiting_since = waiting, self.now
        if waiting.what != "response":
            self.onset = None

    @on(t.PROMPT)
    def prompted(self, prompt: m.Prompt) -> None:
        self.prompt = prompt
        if self.shows:
            self.bus.clock.call_at(self.now + SHOWING, lambda: self.show(prompt))

    @on(t.FRAME)
    def frame_due(self, due: m.FrameDue) -> None:
        if self.shows:
            self.bus.clock.call_at(
                max(due.at, self.now + SHOWING), lambda: self.show_frame(due.frame)
            )

    @on(t.TONE_DUE)
    def tone_due(self, due: m.ToneDue) -> None:
        at = max(due.at, self.now + SHOWING)
        began = m.ToneBegan(
            attempt=due.attempt,
            trial=due.trial,
            presentation=due.presentation,
            frame=due.frame,
            at=at,
            source=self.hears,
        )
        self.bus.clock.call_at(at, lambda: self.emit(t.TONE_BEGAN, began))

    def show_frame(self, frame: int, at: int | None = None) -> None:
        assert self.prompt
        self._report(self.prompt, self.bus.clock.now() if at is None else at, frame)

    def show(self, prompt: m.Prompt, at: int | None = None) -> None:
        onset = self.bus.clock.now() if at is None else at
        if prompt is self.prompt and self.waiting is not None and self.waiting.what == "response":
            self.onset = onset
        self._report(prompt, onset)

    def _report(self, prompt: m.Prompt, at: int, frame: int = 0) -> None:
        self.emit(
            t.SHOWN,
            m.Shown(
                attempt=prompt.attempt,
                trial=prompt.trial,
                presentation=prompt.presentation,
                at=at,
                source=self.source,
                frame=frame,
            ),
        )

    @on(t.TRIAL)
    def ended(self, trial: m.TrialEnded) -> None:
        if self.stores:
            self.store(trial.attempt, trial.trial)

    def store(self, attempt: int, trial: int) -> None:
        self.emit(t.STORED, m.Stored(attempt=attempt, trial=trial))


class LoopDriver:
    """A session with a screen and a keyboard, driven by a test.

    Args:
        task: the class of the task.
        theme: of the agent.
        seed: of the session.
        history: a record to resume.
        parameters: of the task.
    """

    def __init__(
        self,
        task: type[Task],
        theme: Theme,
        *,
        seed: int = 1,
        history: Iterable[Record] | None = None,
        extra: Iterable[Node] = (),
        begin: bool = True,
        **parameters: object,
    ) -> None:
        self.clock = VirtualClock(10 * SECOND)
        self.screen = Screen()
        built = task(build(task.Parameters, parameters))
        self.session = Session(built, theme, self.clock, seed, [self.screen, *extra])
        self.records: list[Record] = []
        self._last_press = 0
        if history is not None:
            self.session.replay(history)
        self.session.bus.tap(self.records.extend)
        if begin:
            self.session.begin(1 if history is None else 2)

    # --- the participant

    def press(self, key: str, at: int | None = None, lag: int = 0, stalled: bool = False) -> None:
        """Press a key now, or as soon as somebody would who has read what is asked for between two
        trials.

        ``at``: its time stamp, if it is handled late; ``stalled``: the program was suspended.
        """
        waiting = self.screen.waiting
        if at is None and waiting and waiting.what in ("enter", "step"):
            read = max(
                self.screen.waiting_since + UNREAD,
                self._last_press + (QUIET if key == "enter" else 0),
            )
            self.clock.advance(max(0, read - self.clock.now()))
        self.strike(key, at, lag, stalled)

    def strike(self, key: str, at: int | None = None, lag: int = 0, stalled: bool = False) -> None:
        """Press a key now, whatever is on the screen."""
        self._last_press = self.clock.now()
        stamp = self.clock.now() if at is None else at
        self.session.bus.publish(
            t.KEY, m.KeyPressed(key=key, at=stamp, loop_lag=lag, stalled=stalled)
        )

    def hold(self, key: str, ms: int, every_ms: int = 30) -> None:
        """Hold a key down: publish it repeatedly."""
        for _ in range(0, ms, every_ms):
            self.strike(key)
            self.wait(every_ms)

    def paste(self, length: int = 5) -> None:
        self.session.bus.publish(t.PASTE, m.Pasted(length=length, at=self.clock.now()))

    def focus(self, focused: bool) -> None:
        self.session.bus.publish(t.FOCUS, m.FocusChanged(focused=focused, at=self.clock.now()))

    def operate(self, command: Any, reason: str = "", value: int | None = None) -> None:
        self.session.bus.publish(
            t.COMMAND, m.SessionCommand(command=command, reason=reason, value=value)
        )

    def disk(self, working: bool) -> None:
        self.session.bus.publish(
            t.STORAGE, m.StorageChanged(working=working, reason="" if working else "full")
        )

    # --- time

    def wait(self, ms: float) -> None:
        self.clock.advance(round(ms * MS))

    def until(self, is_so: Callable[[], object]) -> None:
        """Step the clock from callback to callback until a condition holds."""
        while not is_so():
            if not self.clock.step():
                raise AssertionError(
                    f"nothing is due any more; the session waits for {self.screen.waiting}"
                )

    def to_prompt(self) -> m.Prompt:
        """Continue until the next prompt is on the screen."""
        self.until(lambda: self.screen.onset is not None)
        assert self.screen.prompt is not None
        return self.screen.prompt

    # --- the record

    def difference(self) -> object:
        """Return where a replay of the session differs from its record."""
        session = self.session
        again = Session(type(session.task)(session.parameters), session.theme, self.clock, 1)
        return again.compare(self.records).difference

    # --- whole steps

    def start(self) -> m.Prompt:
        """Continue from the instructions to the first prompt."""
        self.enter()
        return self.begin_attempt()

    def enter(self) -> None:
        self.press("enter")
        self.wait(300)

    def begin_attempt(self) -> m.Prompt:
        self.press("enter")
        return self.to_prompt()

    def answer(self, after_ms: float = 400, key: str | None = None) -> m.TrialEnded:
        """Respond to the next prompt: correctly, unless a key is given."""
        prompt = self.to_prompt()
        self.wait(after_ms)
        self.press(prompt.expected if key is None else key)
        return self.last(t.TRIAL)

    def attempt(self, after_ms: float = 400, wrong: int = 0) -> None:
        """Do a whole attempt, from its Enter to its end."""
        self.press("enter")
        assert self.screen.waiting is not None
        for trial in range(self.screen.waiting.trials):
            self.answer(after_ms, key="#" if trial < wrong else None)
        self.wait(1000)

    # --- messages

    def all(self, topic: Topic[M]) -> list[M]:
        return [record.message for record in self.records if record.topic is topic]

    def last(self, topic: Topic[M]) -> M:
        return self.all(topic)[-1]

    @property
    def waiting(self) -> m.Waiting:
        return self.last(t.WAITING)
