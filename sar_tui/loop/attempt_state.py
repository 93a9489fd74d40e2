"""State of a session's attempts, and the pure steps that change it: ``step(task, state, …) ->
(state, decision)``.
"""

from collections.abc import Collection, Mapping

import msgspec
from msgspec.structs import replace

from sar_tui.loop.attempt_scoring import AttemptFacts, Histories, SeatScore, score_seats
from sar_tui.loop.task import Task
from sar_tui.model.messages import (
    AttemptStarted,
    FeedbackChoice,
    GoalChanged,
    LevelChanged,
    Outcome,
)
from sar_tui.model.trial_types import PastAttempt, Result, Results
from sar_tui.rules import feedback_choice, level_choice
from sar_tui.rules.difficulty import MOST_RESULTS, Difficulty, Goal, ScoredAttempt
from sar_tui.rules.feedback import History

_BY_HAND = "Set by hand."
_TAKEN_BACK = "The change was taken back."


class AttemptScore(msgspec.Struct, frozen=True):
    """A scored attempt: the score of each seat that took part, and the changes of level and goal,
    if there are any.
    """

    seats: tuple[SeatScore, ...]
    level: LevelChanged | None = None

    @property
    def first(self) -> SeatScore:
        """The score of the first seat that took part."""
        return self.seats[0]


class EndedAttempt(msgspec.Struct, frozen=True):
    """The last attempt, until the next one begins.

    Attributes:
        before: the state from which it was scored, so that it can be scored again.
        at: when it ended (ns).
        seats: its scores, as they were reported.
        outcome: its outcome for the level.
        following: the difficulty that followed from it, before an operator had a say.
    """

    before: "AttemptState"
    at: int
    seats: Mapping[str, SeatScore]
    outcome: Outcome
    following: Difficulty


class AttemptState(msgspec.Struct, frozen=True):
    """The attempt that runs or comes next, and the state that the following ones depend on.

    Attributes:
        attempt: its number, from 1, practice attempts included.
        level: its level.
        difficulty: the level of the attempt after it, and the difficulty policy's state.
        histories: the feedback history of each seat.
        is_overridden: True if an operator set the level during the attempt; its outcome then leaves
            the level alone.
        started: when it began (ns).
        results: of its trials so far.
        ended: the attempt before it, as long as that one can be amended or feedback on it
            requested.
        held: a change of level that waits for an operator.
        is_level_held: True if a therapist holds the level: attempts leave it as it is.
        proposed: the difficulty after that change, if the operator accepts it.
        goal: its goal, if the difficulty policy made one; None: the task's own.
        past: results at each level so far, oldest first, if the difficulty policy makes goals from
            them.
        scored: the attempts before it, by seat, oldest first.
        restarts: number of attempts so far that were interrupted and began again under the next
            number.
        condition: of the attempt, from its beginning on.
    """

    attempt: int
    level: int
    difficulty: Difficulty
    histories: Histories
    is_overridden: bool = False
    started: int = 0
    results: tuple[Results, ...] = ()
    ended: EndedAttempt | None = None
    held: LevelChanged | None = None
    is_level_held: bool = False
    proposed: Difficulty | None = None
    goal: Goal | None = None
    past: Mapping[int, tuple[float | None, ...]] = {}
    scored: tuple[Mapping[str, PastAttempt], ...] = ()
    restarts: int = 0
    condition: str = ""


def start(task: Task) -> AttemptState:
    """Return the state in which a session begins."""
    initial = level_choice.start(task.parameters, task.levels)
    return AttemptState(1, initial.level, initial, {seat: History() for seat in task.seats})


def aimed(task: Task, state: AttemptState) -> Task:
    """Return the task with the goal of the attempt that runs or comes next."""
    return task.with_goal(state.goal.value if state.goal else None)


def is_practice(task: Task, state: AttemptState) -> bool:
    """Return True if the attempt is for practice: it always gets feedback, and leaves the level
    alone.
    """
    return state.attempt - state.restarts <= task.parameters.practice_attempts


def total(task: Task, state: AttemptState) -> int:
    """Return the number of attempts, practice and those that began again included."""
    return task.parameters.practice_attempts + task.parameters.attempts + state.restarts


def number(task: Task, state: AttemptState) -> int:
    """Return the number of the attempt among those of practice, or those that count, from 1."""
    if is_practice(task, state):
        return state.attempt - state.restarts
    return state.attempt - state.restarts - task.parameters.practice_attempts


def begin(
    task: Task, state: AttemptState, now: int, condition: str = ""
) -> tuple[AttemptState, AttemptStarted]:
    """Begin the attempt at ``now`` (ns), in a condition."""
    started = AttemptStarted(
        attempt=state.attempt,
        practice=is_practice(task, state),
        level=state.level,
        trials=task.trials_at(state.level),
        condition=condition,
    )
    return replace(
        state, results=(), ended=None, is_overridden=False, started=now, condition=condition
    ), started


def add(state: AttemptState, results: Results) -> AttemptState:
    """Add the results of a trial."""
    return replace(state, results=(*state.results, results))


def score(task: Task, state: AttemptState, now: int) -> tuple[AttemptState, AttemptScore]:
    """Score the attempt, which ended at ``now`` (ns), and set the level of the next."""
    practice = is_practice(task, state)
    facts = AttemptFacts(state.attempt, practice, state.level, state.started, now, state.condition)
    scored = score_seats(
        aimed(task, state), facts, _by_seat(task, state), state.histories, state.scored
    )
    following, change = state.difficulty, None
    follows = scored.outcome != "none" or not level_choice.moves_level(task.parameters)
    if follows and not (practice or state.is_overridden or state.is_level_held):
        attempt = ScoredAttempt(
            number(task, state), scored.outcome, scored.result, scored.reached, scored.prompts
        )
        following = level_choice.step(following, attempt, task.parameters, task.levels)
        reason = level_choice.reason(task.parameters, scored.outcome)
        change = _change(state.level, following.level, reason, following.why)
    past = (
        state.past
        if practice or scored.outcome == "none"
        else _with_result(task, state, scored.result)
    )
    after = replace(
        state,
        level=following.level,
        difficulty=following,
        histories=scored.histories,
        ended=EndedAttempt(state, now, scored.seats, scored.outcome, following),
        past=past,
        goal=_goal(task, past, following.level),
        scored=(*state.scored, scored.past),
    )
    return after, AttemptScore(tuple(scored.seats.values()), change)


def advance(task: Task, state: AttemptState) -> tuple[AttemptState, bool]:
    """Move to the next attempt; False if there is none."""
    if state.attempt == total(task, state):
        return state, False
    return replace(state, attempt=state.attempt + 1, results=()), True


def skip(task: Task, state: AttemptState) -> tuple[AttemptState, bool]:
    """Leave out the attempt that runs or comes next: it is not scored, and nothing follows from it.

    False if there is none after it.
    """
    return advance(task, replace(state, results=(), ended=None))


def restart(task: Task, state: AttemptState) -> AttemptState:
    """Begin the attempt again under the next number, at the level that an operator may have set
    meanwhile.

    What was done of it stays, and is not scored.
    """
    level = state.difficulty.level
    return replace(
        state,
        attempt=state.attempt + 1,
        level=level,
        results=(),
        ended=None,
        goal=_goal(task, state.past, level),
        restarts=state.restarts + 1,
    )


def requestable(state: AttemptState) -> tuple[SeatScore, ...]:
    """Return the scores of the last attempt on which a participant may request feedback."""
    seats = state.ended.seats.values() if state.ended else ()
    asked = [one for one in seats if one.feedback and one.feedback.choice.schedule == "request"]
    return tuple(one for one in asked if not one.is_feedback_due)


def request_feedback(state: AttemptState, now: int) -> tuple[AttemptState, AttemptScore | None]:
    """Return the feedback on the last attempt that was requested at ``now`` (ns); None if there is
    none.
    """
    open_seats = requestable(state)
    if state.ended is None or not open_seats:
        return state, None
    requested = {one.ended.seat: _requested(one, now) for one in open_seats}
    histories = {
        **state.histories,
        **{seat: feedback_choice.given(state.histories[seat]) for seat in requested},
    }
    ended = replace(state.ended, seats={**state.ended.seats, **requested})
    return replace(state, histories=histories, ended=ended), AttemptScore(tuple(requested.values()))


def amend(
    task: Task, state: AttemptState, results: Results, unsaid: Collection[str] = ()
) -> tuple[AttemptState, AttemptScore | None]:
    """Replace the results of the last trial; if its attempt has ended, score that again.

    Possible until the next attempt begins or the level is set by hand. Feedback that was given
    stands; the seats in ``unsaid`` get new feedback instead. If an operator has decided on the
    level, it stands too, unless the outcome of the attempt has changed.
    """
    if state.ended is None:
        return replace(state, results=(*state.results[:-1], results)), None
    was = state.ended
    before = replace(was.before, results=(*was.before.results[:-1], results), held=state.held)
    after, scored = score(task, before, was.at)
    assert after.ended
    seats, histories = dict(after.ended.seats), dict(after.histories)
    for seat in seats.keys() - set(unsaid):
        reported = was.seats[seat].ended
        seats[seat] = _keep_feedback(seats[seat], reported.feedback, reported.choice)
        if not is_practice(task, before):
            since = before.histories[seat].since + 1 if reported.feedback == "none" else 0
            histories[seat] = replace(histories[seat], since=since)
    after = replace(after, histories=histories, ended=replace(after.ended, seats=seats))
    if after.ended and after.ended.outcome == was.outcome and state.difficulty != was.following:
        after = replace(
            after,
            level=state.level,
            difficulty=state.difficulty,
            goal=_goal(task, after.past, state.level),
        )
    after, _ = advance(task, after)
    change = _change(state.level, after.level, "mark", "A mark changed the attempt.")
    return after, AttemptScore(tuple(seats[one.ended.seat] for one in scored.seats), change)


def set_level(
    task: Task, state: AttemptState, level: int, *, under_way: bool
) -> tuple[AttemptState, LevelChanged | None]:
    """Set the level of the next attempt by hand. An attempt under way keeps its own, and does not
    change the next.
    """
    overridden = replace(state, ended=None, is_overridden=True)
    return _put_level(task, overridden, level, "operator", _BY_HAND, under_way=under_way)


def restore_level(
    state: AttemptState, before: AttemptState
) -> tuple[AttemptState, LevelChanged | None]:
    """Take back a level that was set by hand: the level is as in the state ``before`` it."""
    after = replace(
        state,
        level=before.level,
        difficulty=before.difficulty,
        goal=before.goal,
        ended=before.ended,
        is_overridden=before.is_overridden,
    )
    change = _change(state.difficulty.level, before.difficulty.level, "operator", _TAKEN_BACK)
    return after, change


def hold(task: Task, state: AttemptState, change: LevelChanged) -> AttemptState:
    """Take back the change of level that followed from the last attempt: it waits for an operator,
    or is refused.
    """
    level = change.previous
    return replace(
        state,
        held=change,
        proposed=state.difficulty,
        difficulty=Difficulty(level),
        level=level,
        goal=_goal(task, state.past, level),
    )


def settle(
    task: Task, state: AttemptState, level: int, *, under_way: bool
) -> tuple[AttemptState, LevelChanged | None]:
    """Apply a change of level that was held, as decided: to ``level``. An attempt under way keeps
    its own.
    """
    if not (state.held and state.held.level == level):
        return _put_level(task, state, level, "operator", _BY_HAND, under_way=under_way)
    after, change = _put_level(
        task, state, level, state.held.reason, state.held.why, under_way=under_way
    )
    return replace(after, difficulty=state.proposed or after.difficulty), change


def goal_change(task: Task, before: AttemptState, after: AttemptState) -> GoalChanged | None:
    """Return the change of goal between two states, if the difficulty policy made the goal before
    or after it.
    """
    was, now = (before.goal and before.goal.value, after.goal and after.goal.value)
    if was == now:
        return None
    return GoalChanged(
        previous=aimed(task, before).goal_value(before.level) or 0.0,
        goal=aimed(task, after).goal_value(after.level) or 0.0,
        unit=task.metric.unit,
        reason=task.parameters.difficulty_policy,
        why=after.goal.why if after.goal else "There is no result at this level yet.",
    )


def _put_level(
    task: Task, state: AttemptState, level: int, reason: str, why: str, *, under_way: bool
) -> tuple[AttemptState, LevelChanged | None]:
    highest = min(task.parameters.max_level, task.levels)
    following = Difficulty(max(task.parameters.min_level, min(level, highest)))
    change = _change(state.difficulty.level, following.level, reason, why)
    after = replace(state, difficulty=following)
    if not under_way:
        after = replace(after, level=following.level, goal=_goal(task, state.past, following.level))
    return after, change


def _change(before: int, after: int, reason: str, why: str) -> LevelChanged | None:
    return (
        LevelChanged(previous=before, level=after, reason=reason, why=why)
        if after != before
        else None
    )


def _with_result(
    task: Task, state: AttemptState, result: float | None
) -> Mapping[int, tuple[float | None, ...]]:
    """Return the past with the result of the attempt, if the difficulty policy needs it."""
    if not level_choice.moves_goal(task.parameters):
        return state.past
    return {**state.past, state.level: (*state.past.get(state.level, ()), result)[-MOST_RESULTS:]}


def _goal(task: Task, past: Mapping[int, tuple[float | None, ...]], level: int) -> Goal | None:
    if not level_choice.moves_goal(task.parameters) or task.goal_value(level) is None:
        return None
    return level_choice.goal(past.get(level, ()), task.metric, task.parameters)


def _by_seat(task: Task, state: AttemptState) -> dict[str, list[Result]]:
    """Return the results of each seat, in the order of the trials."""
    return {
        seat: [results[seat] for results in state.results if seat in results] for seat in task.seats
    }


def _requested(score: SeatScore, now: int) -> SeatScore:
    assert score.feedback
    choice = replace(score.feedback.choice, due=True, why="The participant asked for it.")
    message = replace(score.feedback, due=now, choice=choice)
    return SeatScore(replace(score.ended, feedback=message.valence, choice=choice), message)


def _keep_feedback(score: SeatScore, given: str, choice: FeedbackChoice | None) -> SeatScore:
    return SeatScore(replace(score.ended, feedback=given, choice=choice), score.feedback)
