"""A session played again from its responses, which are taken as far as its prompts are the recorded
ones.
"""

import sqlite3
from typing import Any, NamedTuple

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import on
from sar_tui.loop.session import Session
from sar_tui.loop.task import Task
from sar_tui.loop.topics import (
    ATTEMPT_ENDED,
    KEY,
    REPORT,
    SHOWN,
    STORED,
    TONE_BEGAN,
    TRIAL,
    TRIAL_FEEDBACK_SHOWN,
)
from sar_tui.model.frames import planned, timed
from sar_tui.model.messages import (
    AttemptEnded,
    Decision,
    KeyPressed,
    OperatorChanged,
    Prompt,
    SessionCommand,
    SessionStarted,
    SettingChanged,
    Stored,
    ThemeApplied,
    TrialEnded,
    Waiting,
)
from sar_tui.model.theme import Theme
from sar_tui.runs.plan import Failed, without_outputs
from sar_tui.simulation.participant import Person, SimulatedParticipant
from sar_tui.store import sessions


class Responses(NamedTuple):
    """The responses of a record, the prompts that they answer, and the facts with which the session
    began.

    Attributes:
        started: the facts.
        theme: the first one.
        prompts, trials: by attempt and trial.
        ended: the scored attempts.
        offered: attempts on which the participant could request feedback.
        asked: those on which they did.
    """

    started: SessionStarted
    theme: Theme
    prompts: dict[tuple[int, int], Prompt]
    trials: dict[tuple[int, int], TrialEnded]
    ended: list[AttemptEnded]
    offered: set[int]
    asked: set[int]


def read_responses(database: sqlite3.Connection, row: sessions.Row) -> Responses:
    """Read a record. Raises Failed if somebody acted on the session, so that its course is not the
    task's own.
    """
    started: SessionStarted | None = None
    theme: Theme | None = None
    prompts, trials = {}, {}
    ended: list[AttemptEnded] = []
    offered, asked = set(), set()
    ask = ("", 0)
    for one in sessions.history(database, row["id"]):
        match one.message:
            case ThemeApplied(theme=applied) if theme is None:
                theme = applied
            case SessionStarted() as message if started is None:
                started = message
            case Prompt() as message:
                prompts[message.attempt, message.trial] = message
            case TrialEnded() as message:
                trials[message.attempt, message.trial] = message
            case AttemptEnded() as message:
                ended.append(message)
            case Waiting() as message:
                ask = message.ask, message.attempt
                if message.ask:
                    offered.add(message.attempt)
            case KeyPressed(key=key) if key == ask[0]:
                asked.add(ask[1])
            case Decision() | SettingChanged() | OperatorChanged(operated=True):
                raise _acted_on(row)
            case SessionCommand(command=command) if command not in ("pause", "resume"):
                raise _acted_on(row)
    if not started or not theme or not ended:
        raise Failed(f"The session {row['id']} has no attempts: there is nothing to fork.")
    return Responses(started, theme, prompts, trials, ended, offered, asked)


def _acted_on(row: sessions.Row) -> Failed:
    return Failed(
        f"An operator or a therapist acted on session {row['id']}. It cannot be forked: there is "
        "no model of what they "
        "would have done."
    )


class _Participant(SimulatedParticipant):
    """Gives the recorded responses up to the first prompt that is not the recorded one, then those
    of a person.

    Attributes:
        forked_at: the attempt of that prompt; None before it.
    """

    emits = (KEY, SHOWN, TRIAL_FEEDBACK_SHOWN, REPORT, TONE_BEGAN, STORED)

    def __init__(
        self, person: Person | None, task: Task, seed: int, record: Responses | None
    ) -> None:
        super().__init__(person, task, seed)  # type: ignore[arg-type]
        self._modelled = person is not None
        self._record = record
        self.forked_at: int | None = None

    @on(TRIAL)
    def trial_ended(self, ended: TrialEnded) -> None:
        """Acknowledge the trial as the recorder does: nothing is stored."""
        stored = Stored(seat=ended.seat, attempt=ended.attempt, trial=ended.trial)
        self.bus.clock.call_soon(lambda: self.emit(STORED, stored))

    def _perform(self, prompt: Prompt, shown: int) -> None:
        key = prompt.attempt, prompt.trial
        was = self._record and self._record.prompts.get(key)
        if self.forked_at is None and not (was and _is_same_prompt(was, prompt)):
            self.forked_at = prompt.attempt
        if self.forked_at is not None:
            if self._modelled:
                super()._perform(prompt, shown)
            return
        assert self._record
        trial = self._record.trials.get(key)
        if (
            trial
            and trial.response is not None
            and trial.response_at is not None
            and trial.onset is not None
        ):
            onset = shown + planned(prompt.frames, timed(prompt.frames))
            self._press(trial.response, onset + trial.response_at - trial.onset)

    def _wants_feedback(self, waiting: Waiting) -> bool:
        if self.forked_at is not None or not self._record:
            return self._modelled and super()._wants_feedback(waiting)
        return waiting.attempt in self._record.asked


def _is_same_prompt(was: Prompt, now: Prompt) -> bool:
    return (was.stimulus, was.expected, was.level, was.choices, was.cue, was.frames, was.tone) == (
        now.stimulus,
        now.expected,
        now.level,
        now.choices,
        now.cue,
        now.frames,
        now.tone,
    )


class Played(NamedTuple):
    """The attempts of a session that was played, and where it was forked."""

    ended: list[AttemptEnded]
    forked_at: int | None


def play(
    kind: type[Task],
    parameters: Any,
    record: Responses,
    seed: int,
    kept: Responses | None,
    person: Person | None,
    person_seed: int = 0,
) -> Played:
    """Play a session on the virtual clock; without a person, only up to the fork.

    Args:
        kind: the task.
        parameters: of the task.
        record: the facts with which the session began.
        seed: of the session: decides its prompts.
        kept: the record whose responses are played up to the first other prompt; None for none.
        person: responds from there on.
        person_seed: decides what they do.
    """
    task = without_outputs(kind, parameters)
    clock = VirtualClock()
    participant = _Participant(person, task, person_seed, kept)
    started = record.started
    session = Session(
        task,
        record.theme,
        clock,
        seed,
        [participant],
        best=started.best,
        others_best=started.others_best,
        names=started.names,
        done_today=started.done_today,
        steps=started.steps,
    )
    ended: list[AttemptEnded] = []
    session.bus.subscribe(ATTEMPT_ENDED, ended.append)
    session.begin()
    while not session.ended and session.broken is None and clock.step():
        if person is None and participant.forked_at is not None:
            break
    if fault := session.broken:
        raise Failed(f"The task {task.name} failed ({fault.error}, {fault.place}).")
    return Played(ended, participant.forked_at)
