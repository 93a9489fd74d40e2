"""The attempts of a session: their state, changed by the pure steps of `attempt_state`."""

import copy
from collections.abc import Collection, Mapping
from typing import NamedTuple

import msgspec
from msgspec.structs import replace

from sar_tui.loop import attempt_state as steps
from sar_tui.loop.attempt_state import AttemptScore
from sar_tui.loop.task import Task
from sar_tui.loop.trial import OpenTrial
from sar_tui.model.language import Language
from sar_tui.model.messages import AttemptStarted, GoalChanged, LevelChanged
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import UNSURE, Results, Situation
from sar_tui.plugin_calls import PLUGIN_ERRORS
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.level_choice import moves_goal
from sar_tui.rules.parameters import TaskParameters, build, changed
from sar_tui.rules.policies import FEEDBACK


class NextAttempt(NamedTuple):
    """Level of the next attempt with its bounds, and the settings that can be changed.

    ``is_level_held``: attempts leave the level as it is.
    """

    level: int
    lowest: int
    highest: int
    is_level_held: bool
    settings: dict[str, int | float]


class Attempts:
    """The attempts of a session: practice first, then those that count. Scores and adapts;
    publishes nothing.

    Args:
        task: built with its parameters.
        seed: of the session.
    """

    def __init__(self, task: Task, seed: int) -> None:
        self._task = task
        self._seed = seed
        self._streams = RandomStreams(seed)
        self._named: tuple[int, Language, str] | None = None
        self._settings: dict[str, int | float] = {}
        self._coming: dict[str, int | float] = {}
        self._scored_with: dict[str, int | float] = {}
        self.state = steps.start(task)

    @property
    def attempt(self) -> int:
        """Number of the attempt that runs or comes next, from 1, practice included."""
        return self.state.attempt

    @property
    def level(self) -> int:
        """Level of the attempt that runs or comes next."""
        return self.state.level

    @property
    def goal(self) -> str:
        """Goal of the attempt that runs or comes next, as a sentence for the participant."""
        return steps.aimed(self._task, self.state).goal(self.level)

    @property
    def trial(self) -> int:
        """Number of the next trial, from 1."""
        return len(self.state.results) + 1

    @property
    def total(self) -> int:
        """Number of attempts, practice included."""
        return steps.total(self._task, self.state)

    @property
    def name(self) -> str:
        """The attempt for people: "attempt 3 of 20"."""
        attempt, tr = self.attempt, self._task.tr
        if self._named is None or self._named[0] != attempt or self._named[1] is not tr:
            self._named = attempt, tr, self._name()
        return self._named[2]

    def _name(self) -> str:
        parameters, tr = self._task.parameters, self._task.tr
        number = steps.number(self._task, self.state)
        if steps.is_practice(self._task, self.state):
            return tr(
                "practice {number} of {total}", number=number, total=parameters.practice_attempts
            )
        return tr("attempt {number} of {total}", number=number, total=parameters.attempts)

    @property
    def last_trial(self) -> tuple[int, int]:
        """Attempt and number of the last trial that was done."""
        return (self.attempt, len(self.state.results))

    @property
    def is_attempt_done(self) -> bool:
        """True if every trial of the attempt is done."""
        return len(self.state.results) >= self.trials

    @property
    def trials(self) -> int:
        """Number of trials of the attempt that runs or comes next; after the last one, of that."""
        ended = self.state.ended
        is_over = ended is not None and ended.before.attempt == self.attempt
        level = ended.before.level if ended and is_over else self.level
        trials = self._task.trials_at(level)
        if type(trials) is not int or trials < 1:
            raise TypeError(
                f"an attempt at level {level} has {trials!r:.60} trials, not a whole number from "
                "1 on"
            )
        return trials

    @property
    def is_first_after_practice(self) -> bool:
        """True if the attempt is the first that counts, and practice came before it."""
        is_first = (
            not steps.is_practice(self._task, self.state)
            and steps.number(self._task, self.state) == 1
        )
        return self._task.parameters.practice_attempts > 0 and is_first

    @property
    def can_request_feedback(self) -> bool:
        """True if a participant may request feedback on the last attempt, and has not yet."""
        return bool(steps.requestable(self.state))

    @property
    def amendable_trial(self) -> tuple[int, int] | None:
        """Attempt and number of the last trial as long as it can be amended; else None."""
        if ended := self.state.ended:
            return (ended.before.attempt, len(ended.before.results))
        return self.last_trial if self.state.results and not self.is_attempt_done else None

    @property
    def is_unsure(self) -> bool:
        """True if the last attempt was not scored, as none of its trials is sure."""
        results = self.state.ended.before.results if self.state.ended else ()
        return bool(results) and all(
            UNSURE in result.flags for trial in results for result in trial.values()
        )

    def begin(self, now: int) -> AttemptStarted:
        """Begin the attempt at ``now`` (ns)."""
        self.state = replace(self.state, condition="")
        condition = _checked(self._task.condition(self._situation(1)))
        self.state, started = steps.begin(self._task, self.state, now, condition)
        return started

    def next_trial(self) -> OpenTrial:
        """Return the next trial of the attempt; the same at each call."""
        situation = self._situation(self.trial)
        return OpenTrial(situation, self._task.stimulus(situation), self._task.seats)

    def _situation(self, trial: int) -> Situation:
        state = self.state
        return Situation(
            attempt=state.attempt,
            trial=trial,
            level=state.level,
            streams=RandomStreams(self._seed, state.attempt, trial),
            session=self._streams,
            results_by_seat=state.results,
            history_by_seat=state.scored,
            condition=state.condition,
        )

    def add(self, results: Results) -> None:
        """Add the results of a trial."""
        self.state = steps.add(self.state, results)

    def score(self, now: int) -> AttemptScore:
        """Score the attempt, which ended at ``now`` (ns), and set the level of the next."""
        self._scored_with = {name: getattr(self._task.parameters, name) for name in NAMES}
        self.state, scored = steps.score(self._task, self.state, now)
        return scored

    def advance(self) -> bool:
        """Move to the next attempt, with the settings changed since the last began; False if there
        is none.
        """
        return self._go_on(steps.advance(self._task, self.state))

    def skip(self) -> bool:
        """Leave out the attempt that runs or comes next; False if there is none after it."""
        return self._go_on(steps.skip(self._task, self.state))

    def restart(self) -> None:
        """Begin the attempt that runs again, under the next number."""
        self._go_on((steps.restart(self._task, self.state), True))

    def _go_on(self, step: tuple[steps.AttemptState, bool]) -> bool:
        self.state, is_next = step
        if self._coming:
            self._apply_settings()
        return is_next

    def request_feedback(self, now: int) -> AttemptScore | None:
        """Return the feedback on the last attempt that was requested at ``now`` (ns); None if there
        is none.
        """
        self.state, requested = steps.request_feedback(self.state, now)
        return requested

    def amend(self, results: Results, unsaid: Collection[str] = ()) -> AttemptScore | None:
        """Replace the results of the last trial; score its attempt again if that has ended
        (`attempt_state.amend`).

        It is scored by the goal that it had, even if another is set for the next.
        """
        now = self._task.parameters
        if self.state.ended:
            self._use(self._scored_with)
        self.state, scored = steps.amend(self._task, self.state, results, unsaid)
        self._task.parameters = now
        return scored

    def set_level(self, level: int, *, under_way: bool) -> LevelChanged | None:
        """Set the level of the next attempt by hand."""
        self.state, change = steps.set_level(self._task, self.state, level, under_way=under_way)
        return change

    def restore_level(self, before: steps.AttemptState) -> LevelChanged | None:
        """Take back a level that was set by hand."""
        self.state, change = steps.restore_level(self.state, before)
        return change

    @property
    def next(self) -> NextAttempt:
        """Level and settings of the next attempt."""
        parameters = self._task.parameters
        return NextAttempt(
            level=self.state.difficulty.level,
            lowest=parameters.min_level,
            highest=min(parameters.max_level, self._task.levels),
            is_level_held=self.state.is_level_held,
            settings={name: getattr(parameters, name) for name in NAMES} | self._coming,
        )

    def hold_level(self, *, held: bool) -> None:
        """Let attempts leave the level as it is, or change it again."""
        self.state = replace(self.state, is_level_held=held)

    def change_setting(self, name: str, value: int | float, *, under_way: bool) -> None:
        """Change a setting of the task from the next attempt on. An attempt under way keeps its
        own.

        Raises:
            ParameterError: it cannot be changed, or to this value.
        """
        with_setting(self._task.parameters, name, value)
        self._coming[name] = value
        if not under_way:
            self._apply_settings()

    def _apply_settings(self) -> None:
        """Give the task the settings that were changed since the last attempt began."""
        self._settings |= self._coming
        self._coming = {}
        self._use(self._settings)

    def _use(self, settings: Mapping[str, int | float]) -> None:
        for name, value in settings.items():
            self._task.parameters = with_setting(self._task.parameters, name, value)

    def hold(self, change: LevelChanged) -> None:
        """Take back a change of level: it waits for an operator, or is refused."""
        self.state = steps.hold(self._task, self.state, change)

    def goal_change_since(self, before: steps.AttemptState) -> GoalChanged | None:
        """Return the change of goal since an earlier state, if the difficulty policy made one."""
        return steps.goal_change(self._task, before, self.state)

    def settle(self, level: int, *, under_way: bool) -> LevelChanged | None:
        """Apply a change of level that was held, as decided."""
        self.state, change = steps.settle(self._task, self.state, level, under_way=under_way)
        return change


def _checked(condition: object) -> str:
    """Return a condition if it can be stored. Raises TypeError if it is not one line of plain
    text.
    """
    if not (isinstance(condition, str) and (condition == "" or condition.isprintable())):
        raise TypeError(f"condition() returned {condition!r:.60}, not a line of plain text")
    return condition


# --- settings that a therapist may change


GOAL, FEEDBACK_EVERY = "threshold", "feedback_every"
NAMES = (GOAL, FEEDBACK_EVERY)


def adjustable(task: Task) -> tuple[str, ...]:
    """Return the names of the settings that have an effect in this session, as it is set up."""
    schedule = FEEDBACK[task.parameters.feedback_schedule]
    has_effect = {
        GOAL: _goal_follows(task),
        FEEDBACK_EVERY: FEEDBACK_EVERY in schedule.settings.__struct_fields__,
    }
    return tuple(name for name in NAMES if has_effect[name])


def with_setting(parameters: TaskParameters, name: str, value: object) -> TaskParameters:
    """Return parameters with another value, typed or as text. Raises ParameterError if it is out of
    bounds.
    """
    if name not in NAMES:
        raise ParameterError({name: f"{name} cannot be changed during a session."})
    return build(type(parameters), {**changed(parameters), name: value})


def _goal_follows(task: Task) -> bool:
    """Return True if the goals depend on the threshold: they may be a task's own, or follow a
    person's results.
    """
    if moves_goal(task.parameters):
        return False
    other = copy.copy(task)
    other.parameters = msgspec.structs.replace(
        task.parameters, threshold=task.parameters.threshold * 2 + 1
    )
    try:
        levels = range(1, task.levels + 1)
        return any(other.goal_value(level) != task.goal_value(level) for level in levels)
    except PLUGIN_ERRORS:
        return False
