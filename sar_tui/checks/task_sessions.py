"""Plays a task with simulated people of three skills, kills and resumes one of their sessions, and
replays all of them. From their records it tells whether the task keeps a state of its own, and
whether neighbouring levels are far apart.
"""

import math
import random
import re
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from itertools import pairwise
from pathlib import Path
from statistics import fmean, pvariance
from typing import Any, Literal, NamedTuple

import msgspec

from sar_tui.checks import task_prompts, task_view
from sar_tui.checks.check import Check, checked
from sar_tui.loop.author_lines import at, line_of, line_of_text
from sar_tui.loop.bus import FAULT, Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node
from sar_tui.loop.session import ReplayError, Session
from sar_tui.loop.task import Task
from sar_tui.loop.topics import TRIAL
from sar_tui.model import messages
from sar_tui.model.messages import Fault, KeyPerceived, Prompt
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import PastAttempt, Situation, Trial
from sar_tui.plugin_calls import PLUGIN_ERRORS, line_of_error
from sar_tui.plugins import Catalogue, task_folder
from sar_tui.rules.parameters import TaskParameters, build, changed, fields
from sar_tui.runs.plan import Failed, Plan, make_plan
from sar_tui.runs.run import Run, resume, start
from sar_tui.runs.simulate import people, play, simulate
from sar_tui.simulation.participant_model import PEOPLE, Person
from sar_tui.store import sessions
from sar_tui.store.database import connect

ATTEMPTS = 10
"""Number of attempts of each simulated participant."""
THEME = "calm"
SEED = 1


class Call(NamedTuple):
    """A call of a task's method in a session, and what it returned."""

    method: str
    arguments: tuple[Any, ...]
    returned: Any
    given: dict[str, Any]


class Simulated(msgspec.Struct, frozen=True):
    """A simulated session: its row, its attempts and trials, and its messages."""

    session: sessions.Row
    attempts: list[sessions.Row]
    trials: list[sessions.Row]
    history: list[Record]


def checks(kind: type[Task], parameters: TaskParameters) -> Iterator[Check]:
    """Check what a task does in sessions. Nothing is checked after a session that goes wrong."""
    played: list[Simulated] = []
    calls: list[Call] = []
    with tempfile.TemporaryDirectory(prefix="sar-tui-check-") as folder:
        for person in PEOPLE.values():
            article = "an" if person.name[0] in "aeiou" else "a"
            calls_now = list[Call]()
            watched = recorded(kind, calls_now)
            problem = ""
            try:
                simulated = _simulate(watched, parameters, person, Path(folder))
                played.append(simulated)
                problem = _outcome(kind, simulated, calls_now, parameters)
            except PLUGIN_ERRORS as error:
                problem = _failure(kind, error, calls_now)
            yield checked(f"runs a whole session with {article} {person.name} participant", problem)
            if problem:
                return
            calls = calls or calls_now
    task = kind(parameters)
    yield checked("judges each kind of percept", lambda: _stray_key_problem(task, calls))
    yield checked(
        "keeps no state from call to call",
        lambda: state_problem(kind(parameters), calls, SEED),
    )
    yield checked("stores the details that it declares", lambda: _details(kind, played))
    yield Check("has the measures that it declares", warning=_measures(kind, played))
    yield from _prompts(kind, played)
    yield checked("changes its level", _level_moves(kind, parameters, played))
    yield _levels_apart(kind, parameters)
    yield checked(
        "gives the same result when replayed, so that it can be resumed",
        _replay(kind, parameters, played),
    )
    yield checked(
        "goes on as before when killed and resumed",
        lambda: _resumption_problem(kind, parameters, played[-1]),
    )
    if task_view.has_view(kind) and not task_view.contract_problem(kind):
        yield checked(
            "draws its view in a whole session", lambda: _drawing(kind, parameters, played)
        )


# --- sessions


def _plan(
    kind: type[Task],
    parameters: TaskParameters,
    catalogue: Catalogue,
    mode: Literal["live", "simulated"] = "simulated",
) -> Plan:
    codes = [f"CHECK{seat}" for seat in kind.seats]
    values = changed(parameters)
    return make_plan(catalogue, kind, codes, values, theme=THEME, seed=SEED, mode=mode)


def _simulate(
    kind: type[Task], parameters: TaskParameters, person: Person, folder: Path
) -> Simulated:
    catalogue = Catalogue()
    session = simulate(_plan(kind, parameters, catalogue), person, folder, catalogue)
    return _stored(folder, session)


def _stored(folder: Path, session: str) -> Simulated:
    with closing(connect(folder)) as database:
        return Simulated(
            sessions.find(database, folder, session),
            sessions.rows(database, "attempts", session),
            sessions.rows(database, "trials", session),
            list(sessions.history(database, session)),
        )


def _failure(kind: type[Task], error: BaseException, calls: Sequence[Call]) -> str:
    """Return why a session failed, at the author's line: of the error, else of the last method
    that was called.
    """
    text = str(error)
    failed = re.search(r"\((\w+: .*), line (\d+) of ([\w.]+)\)", text, re.DOTALL)
    if not isinstance(error, Failed) or not failed:
        return text if isinstance(error, Failed) else f"It raised {type(error).__name__}: {text}."
    reason, number, file = failed.groups()
    line = f"{file}:{number}"
    if not (task_folder(kind) / file).is_file():
        line = line_of(kind, calls[-1].method) if calls else ""
    return f"{line}: {reason}.{_fields_hint(reason)}" if line else text


def _fields_hint(reason: str) -> str:
    """Return what a percept has, if an attribute that it does not have was asked for."""
    missing = re.match(r"AttributeError: '(\w+Perceived)' object has no attribute", reason)
    if missing is None:
        return ""
    fields = getattr(messages, missing[1]).__struct_fields__
    return f" A {missing[1]} has {', '.join(fields)}."


def _outcome(
    kind: type[Task],
    simulated: Simulated,
    calls: Sequence[Call],
    parameters: TaskParameters,
) -> str:
    for record in simulated.history:
        if record.topic is FAULT and isinstance(fault := record.message, Fault):
            return f"The node {fault.node} failed at {fault.topic} ({fault.error}, {fault.place})."
    expected = parameters.practice_attempts + parameters.attempts
    found = len({attempt["attempt"] for attempt in simulated.attempts})
    if simulated.session["status"] != "completed" or found != expected:
        status = simulated.session["status"]
        return f"The session is {status} after {found} of {expected} attempts."
    if problem := _unanswered(kind, simulated.trials, calls):
        return problem
    scores = [attempt["metric"] for attempt in simulated.attempts]
    if any(score is not None and not math.isfinite(score) for score in scores):
        return f"{line_of(kind, 'score')}: An attempt's metric is not a finite number."
    if scores.count(None) > len(scores) / 2 and not kind.metric.is_none:
        return (
            f"{line_of(kind, 'perceived')}: {scores.count(None)} of {len(scores)} attempts have no "
            "metric: no trial in them was right and had a value. Look at perceived, timed_out and "
            "rehearse."
        )
    return ""


def _unanswered(kind: type[Task], trials: Sequence[sessions.Row], calls: Sequence[Call]) -> str:
    """Return why every trial timed out; empty if one did not, or was right without a response."""
    if not trials or any(trial["correct"] or trial["response"] is not None for trial in trials):
        return ""
    judged = [call.returned for call in calls if call.method == "perceived"]
    if judged:
        if any(returned is not None for returned in judged):
            return ""
        asked = next(call for call in calls if call.method == "perceived")
        return (
            f"{line_of(kind, 'perceived')}: Every trial timed out: perceived() returned None for "
            f"each of {len(judged)} percepts, such as {_named(asked.arguments[1])}."
        )
    acts = [call.returned for call in calls if call.method == "rehearse"]
    if any(acts):
        act = next(filter(None, acts))[0]
        return (
            f"{line_of(kind, 'rehearse')}: Every trial timed out: no act of the simulated person, "
            f"such as {act!r:.60}, reached perceived()."
        )
    is_own = kind.rehearse is not Task.rehearse
    place = line_of(kind, "rehearse" if is_own else "stimulus")
    why = "rehearse() returned no act" if is_own else "no prompt has an expected key"
    return f"{place}: Every trial timed out: the simulated person never answers, as {why}."


def _named(percept: Any) -> str:
    key = getattr(percept, "key", None)
    return f"{type(percept).__name__}(key={key!r})" if key else type(percept).__name__


def _stray_key_problem(task: Task, calls: Sequence[Call]) -> str:
    """Return a sentence if a task with a sensor fails as soon as somebody presses a key."""
    call = next((call for call in calls if call.method == "perceived"), None)
    if call is None or not task.sensors:
        return ""
    trial = call.arguments[0]
    vars(task).update(call.given)
    percept = KeyPerceived(seat=task.seats[0], key="x", at=trial.onset or 0)
    try:
        task.perceived(trial, percept)
    except PLUGIN_ERRORS as error:
        return (
            f"{line_of(type(task), 'perceived')}: perceived() is given a KeyPerceived too, whenever a "
            f"key is pressed, and raised {type(error).__name__}: {error}. Return None for it."
        )
    return ""


# --- what was stored


def _details(kind: type[Task], played: Sequence[Simulated]) -> str:
    """Return the first detail of a trial that is not what the task's Details declare."""
    declared = msgspec.structs.fields(kind.Details)
    types = {field.name: field.type for field in declared}
    needed = {field.name for field in declared if field.required}
    folder = task_folder(kind)
    for trial in (trial for simulated in played for trial in simulated.trials):
        details = trial["details"]
        if unknown := sorted(details.keys() - types.keys() - {"mark"}):
            line = line_of_text(folder, unknown[0])
            return f"{line}: Its Details do not declare {', '.join(unknown)}."
        if missing := sorted(needed - details.keys()):
            return (
                f"{line_of(kind.Details, missing[0])}: Its Details declare {missing[0]} without a "
                f"default, and the details of attempt {trial['attempt']}, trial {trial['trial']} "
                "do not have it."
            )
        for name, value in details.items():
            if value is None or name not in types:
                continue
            try:
                msgspec.convert(value, types[name])
            except msgspec.ValidationError as error:
                line = line_of(kind.Details, name)
                return (
                    f"{line}: Its Details declare {name} otherwise than it is stored, "
                    f"{value!r:.60}: {error}."
                )
    return ""


def _measures(kind: type[Task], played: Sequence[Simulated]) -> str:
    """Return a sentence that names declared measures that no attempt had; others that they had may
    be meant.
    """
    attempts = [attempt for simulated in played for attempt in simulated.attempts]
    had = {name for attempt in attempts for name in attempt["qualities"]}
    declared = [measure.name for measure in kind.measured]
    if not (missing := [name for name in declared if name not in had]):
        return ""
    others = sorted(had.difference(declared, (quality.field for quality in kind.qualities)))
    instead = f" Attempts had {', '.join(others)}, which are not declared." if others else ""
    return f"No attempt had {', '.join(missing)}: so no column shows it.{instead}"


def _prompts(kind: type[Task], played: Sequence[Simulated]) -> Iterator[Check]:
    shown = [
        prompt.shown(frame)
        for simulated in played
        for record in simulated.history
        if isinstance(prompt := record.message, Prompt)
        for frame in range(max(1, len(prompt.frames)))
    ]
    themes = [Catalogue().theme(name) for name in Catalogue().theme_names()]
    return task_prompts.checks(kind, shown, themes)


# --- levels


def levels_of(task: Task) -> range:
    """Return the levels that a session may have."""
    return range(1, min(task.levels, task.parameters.max_level) + 1)


def _level_moves(kind: type[Task], parameters: TaskParameters, played: Sequence[Simulated]) -> str:
    task = kind(parameters)
    is_judged = any(task.goal_value(level) is not None for level in levels_of(task))
    if parameters.difficulty_policy == "fixed" or len(levels_of(task)) == 1 or not is_judged:
        return ""
    seen = {attempt["level"] for simulated in played for attempt in simulated.attempts}
    if len(seen) > 1:
        return ""
    return at(
        line_of(kind.Parameters, "threshold"),
        f"The level stays at {seen.pop()} for every participant. Is the goal "
        f"({parameters.threshold:g}) within reach?",
    )


def _levels_apart(kind: type[Task], parameters: TaskParameters) -> Check:
    """Check the distances of the levels with a session of an average participant that visits
    each.
    """
    name = "keeps neighbouring levels close together"
    with tempfile.TemporaryDirectory(prefix="sar-tui-check-") as folder:
        try:
            warning = level_steps_warning(
                kind,
                parameters,
                lambda visits: _simulate(kind, visits, PEOPLE["average"], Path(folder)).attempts,
            )
        except PLUGIN_ERRORS as error:
            return checked(name, _failure(kind, error, ()))
    return Check(name, warning=warning)


# --- again


def _replay(kind: type[Task], parameters: TaskParameters, played: Sequence[Simulated]) -> str:
    theme = Catalogue().theme(THEME)
    for simulated in played:
        try:
            Session(kind(parameters), theme, VirtualClock(), SEED).replay(simulated.history)
        except ReplayError as error:
            return (
                f"{error} Does the task keep state, or draw from elsewhere than situation.streams?"
            )
    return ""


def _resumption_problem(kind: type[Task], parameters: TaskParameters, whole: Simulated) -> str:
    """Return a sentence if a session that was killed in its middle goes on otherwise than the
    whole one did.
    """
    with tempfile.TemporaryDirectory(prefix="sar-tui-check-") as folder:
        resumed = _killed_and_resumed(kind, parameters, len(whole.trials) // 2, Path(folder))
    if resumed.session["status"] != "completed":
        return "A session that was killed in its middle did not end after it was resumed."
    for before, after in zip(whole.trials, resumed.trials, strict=False):
        if (before["attempt"], before["trial"]) != (after["attempt"], after["trial"]):
            break  # the attempt began again
        if before["stimulus"] != after["stimulus"]:
            return (
                f"{line_of(kind, 'stimulus')}: After a session was killed and resumed, attempt "
                f"{after['attempt']}, trial {after['trial']} had the prompt {after['stimulus']} "
                f"instead of {before['stimulus']}."
            )
        if any(before[name] != after[name] for name in ("response", "correct")):
            break  # what follows may depend on it
    return ""


def _killed_and_resumed(
    kind: type[Task], parameters: TaskParameters, trials: int, data: Path
) -> Simulated:
    """Play a session until a number of trials are done, drop it, and resume it to its end."""
    catalogue = Catalogue(tasks=(task_folder(kind).parent,))
    person = list(PEOPLE.values())[-1]
    clock, later = VirtualClock(), VirtualClock()

    def people_at(clock: VirtualClock, task: Task, seed: int) -> list[Node]:
        return people(person, task, seed, clock)

    killed = start(
        _plan(kind, parameters, catalogue, mode="live"),
        data,
        catalogue,
        clock,
        lambda task, theme, seed: people_at(clock, task, seed),
    )
    done: list[object] = []
    killed.session.bus.subscribe(TRIAL, done.append)
    killed.begin()
    while len(done) < trials and clock.step():
        pass
    _leave(killed)
    resumed = resume(
        killed.id,
        data,
        catalogue,
        later,
        lambda task, theme, seed: people_at(later, task, seed),
    )
    resumed.begin()
    play(resumed.session, later)
    _leave(resumed)
    return _stored(data, killed.id)


def _leave(run: Run) -> None:
    """Leave a session as it is."""
    run.recorder.write()
    run.close()


def _drawing(kind: type[Task], parameters: TaskParameters, played: Sequence[Simulated]) -> str:
    theme: Theme = Catalogue().theme(THEME)
    problems = (
        task_view.drawing_problem(kind(parameters), theme, SEED, simulated.history)
        for simulated in played
    )
    return next(filter(None, problems), "")


# --- a task keeps no state: a new one gives the same answers in another order


_METHODS = (
    "condition",
    "stimulus",
    "perceived",
    "timed_out",
    "score",
    "measures",
    "learning",
    "trials_at",
    "target",
)
_WATCHED = (*_METHODS, "rehearse")
"""Methods whose calls are kept; a simulated person, whom `rehearse` moves, is not asked again."""
_GIVEN = ("names", "tr")
"""Attributes of a task that the session sets."""
_MOST_KEPT = 5000
_MOST_ASKED = 400


def recorded(kind: type[Task], calls: list[Call]) -> type[Task]:
    """Return a subclass of a task that is used like it, and keeps the calls of its methods."""
    wrapped = {name: _wrapped(name, getattr(kind, name), calls) for name in _WATCHED}
    return type(
        kind.__name__, (kind,), {**wrapped, "__module__": kind.__module__, "__doc__": kind.__doc__}
    )


def _wrapped(name: str, method: Callable[..., Any], calls: list[Call]) -> Callable[..., Any]:
    def call(self: Task, *arguments: Any) -> Any:
        kept = tuple(list(each) if isinstance(each, list) else each for each in arguments)
        returned = method(self, *arguments)
        # not of a copy with another goal
        if len(calls) < _MOST_KEPT and "target" not in vars(self):
            calls.append(
                Call(name, kept, returned, {given: getattr(self, given) for given in _GIVEN})
            )
        return returned

    return call


def state_problem(task: Task, calls: list[Call], seed: int) -> str:
    """Return a sentence if a new task answers calls that were made in a session otherwise, in a
    shuffled order.
    """
    asked = [call for call in calls if call.method in _METHODS]
    shuffled = random.Random(seed).sample(asked, min(len(asked), _MOST_ASKED))
    for call in shuffled:
        vars(task).update(call.given)
        try:
            returned = getattr(task, call.method)(*call.arguments)
        except PLUGIN_ERRORS as error:
            return at(
                line_of_error(error),
                f"{_where(call)} it raised {type(error).__name__} when it was asked in another "
                f"order ({error}).",
            )
        if returned != call.returned:
            return at(
                line_of(type(task), call.method),
                f"{_where(call)} it returned something else when a new task was asked in another "
                "order. Does it keep something from call to call? What it needs is in its "
                "arguments: see trial.percepts, situation.results and situation.history.",
            )
    return ""


def _where(call: Call) -> str:
    """Return the method and the place in the session: "In stimulus, at attempt 2, trial 3,"."""
    for argument in call.arguments:
        place = argument.situation if isinstance(argument, Trial) else argument
        if isinstance(place, Situation):
            return f"In {call.method}, at attempt {place.attempt}, trial {place.trial},"
        if isinstance(place, PastAttempt):
            return f"In {call.method}, at attempt {place.attempt},"
    return f"In {call.method}"


# --- neighbouring levels far apart: a person surely succeeds at one, and surely fails at the next


MOST_REPEATS, FEWEST_REPEATS = 8, 3
"""Attempts at each level; a task with so many levels that there are fewer is not examined."""
MOST_ATTEMPTS = 160
FARTHEST = 1.0
"""Largest distance of neighbouring levels, in standard deviations of an attempt's result."""


def level_steps_warning(
    kind: type[Task],
    parameters: TaskParameters,
    run: Callable[[TaskParameters], Sequence[sessions.Row]],
) -> str:
    """Return which levels are farther apart than one standard deviation of an attempt's result;
    empty for none.

    Args:
        kind: the task.
        parameters: with which it is checked.
        run: returns the attempts of a session with some parameters.
    """
    levels = range(parameters.min_level, min(kind(parameters).levels, parameters.max_level) + 1)
    most = next(field.le for field in fields(type(parameters)) if field.name == "attempts")
    repeats = min(
        MOST_REPEATS, int(min(MOST_ATTEMPTS, most or MOST_ATTEMPTS)) // max(1, len(levels))
    )
    if len(levels) < 2 or repeats < FEWEST_REPEATS:
        return ""
    listed = [level for level in levels for _ in range(repeats)]
    settings: dict[str, object] = {
        **changed(parameters),
        "difficulty_policy": "sequence",
        "level_sequence": listed,
        "attempts": len(listed),
        "practice_attempts": 0,
    }
    return far_apart(run(build(type(parameters), settings)), kind.metric.better == "lower")


def far_apart(attempts: Sequence[sessions.Row], lower_is_better: bool) -> str:
    """Return a sentence on the neighbouring levels that are surely too far apart; empty for none.

    What counts is the distance from the goal, which may differ by level. Few attempts leave the
    difference of two levels uncertain by its standard error: a distance counts from two of them
    beyond the largest.
    """
    sign = 1 if lower_is_better else -1
    found: dict[int, list[float]] = {}
    for row in attempts:
        if row["metric"] is not None and row["goal"] is not None:
            found.setdefault(row["level"], []).append(sign * (row["metric"] - row["goal"]))
    results = {
        level: values for level, values in sorted(found.items()) if len(values) >= FEWEST_REPEATS
    }
    if not results:
        return ""
    # a population variance of few values is too small by (n - 1) / n
    sd = (
        fmean(pvariance(values) * len(values) / (len(values) - 1) for values in results.values())
        ** 0.5
    )
    far = []
    for (easier, before), (harder, after) in pairwise(results.items()):
        surely = FARTHEST + 2 * (1 / len(before) + 1 / len(after)) ** 0.5
        if (
            sd
            and harder == easier + 1
            and (distance := (fmean(after) - fmean(before)) / sd) > surely
        ):
            far.append(f"{easier} and {harder} ({distance:.1f})")
    if not far:
        return ""
    return (
        "These levels are more than one standard deviation of an attempt's result apart: "
        f"{', '.join(far)}. A person "
        "may succeed at each attempt at one level and at none at the next."
    )
