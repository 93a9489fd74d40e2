"""Plays a task with simulated people of three skills, kills and resumes one of their sessions, and
replays all of them.
"""

import math
import re
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any, Literal

import msgspec

from sar_tui.checks import level_steps, task_prompts, task_state, task_view
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
from sar_tui.plugin_calls import PLUGIN_ERRORS
from sar_tui.plugins import Catalogue, task_folder
from sar_tui.rules.parameters import TaskParameters, changed
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


class Simulated(msgspec.Struct, frozen=True):
    """A simulated session: its row, its attempts and trials, and its messages."""

    session: sessions.Row
    attempts: list[sessions.Row]
    trials: list[sessions.Row]
    history: list[Record]


def checks(kind: type[Task], parameters: TaskParameters) -> Iterator[Check]:
    """Check what a task does in sessions. Nothing is checked after a session that goes wrong."""
    played: list[Simulated] = []
    calls: list[task_state.Call] = []
    with tempfile.TemporaryDirectory(prefix="sar-tui-check-") as folder:
        for person in PEOPLE.values():
            article = "an" if person.name[0] in "aeiou" else "a"
            calls_now = list[task_state.Call]()
            watched = task_state.recorded(kind, calls_now)
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
        lambda: task_state.problem(kind(parameters), calls, SEED),
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


def _failure(kind: type[Task], error: BaseException, calls: Sequence[task_state.Call]) -> str:
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
    calls: Sequence[task_state.Call],
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


def _unanswered(
    kind: type[Task], trials: Sequence[sessions.Row], calls: Sequence[task_state.Call]
) -> str:
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


def _stray_key_problem(task: Task, calls: Sequence[task_state.Call]) -> str:
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
            warning = level_steps.warning(
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
