"""Checks a task folder against the contract of tasks."""

import math
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec
from msgspec.structs import replace

from sar_tui.checks import (
    level_steps,
    task_prompts,
    task_state,
    task_texts,
    task_translations,
    task_view,
)
from sar_tui.checks.check import Check
from sar_tui.loop.bus import FAULT, Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.session import ReplayError, Session
from sar_tui.loop.task import Task
from sar_tui.loop.trial import stimulus_problem
from sar_tui.model import frames
from sar_tui.model.messages import Fault, Prompt
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Results, Situation, Stimulus, Trial
from sar_tui.model.visible_text import control_problem
from sar_tui.plugin_calls import PLUGIN_ERRORS
from sar_tui.plugin_loader import CURRENT_NAMES
from sar_tui.plugins import Catalogue, PluginError, load_task
from sar_tui.rules.declaration import Field, ParameterError
from sar_tui.rules.parameters import TaskParameters, build, changed, fields
from sar_tui.rules.questions import problem_of
from sar_tui.runs.plan import Failed, make_plan
from sar_tui.runs.sensors import sensor_parameter
from sar_tui.runs.simulate import simulate
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


def check(folder: Path) -> Iterator[Check]:
    """Check a task folder. Checks that an earlier problem makes impossible are skipped."""
    try:
        kind = load_task(folder)
    except PluginError as error:
        yield _check("can be loaded", str(error))
        return
    yield Check("can be loaded")
    declared = _check("declares its title and metric", lambda: _declaration(kind))
    yield declared
    yield _check("describes every parameter: title, help, bounds", lambda: _parameters(kind))
    try:
        task = kind(build(kind.Parameters, {"attempts": ATTEMPTS}))
    except PLUGIN_ERRORS as error:
        yield _check("can be set up with its defaults", _reason(error))
        return
    yield Check("can be set up with its defaults")
    yield _check("gives instructions, and a goal for each level", lambda: _words(task))
    yield _check(
        "has no control characters in its texts", lambda: " ".join(task_texts.problems(task))
    )
    yield _check(
        "has all its texts in each of its languages",
        lambda: " ".join(task_translations.problems(kind)),
    )
    yield _check(
        "gives feedback in words without numbers", lambda: " ".join(task_translations.numbers(kind))
    )
    if task_view.has_view(kind):
        yield _check("has a view that keeps its contract", lambda: task_view.contract_problem(kind))
    prompts = _check(
        "makes the same one-line prompts when asked twice", lambda: _prompts(kind, task)
    )
    yield prompts
    if declared.ok and prompts.ok:
        yield from _sessions(kind, task.parameters)


def _check(name: str, problem: str | Callable[[], str]) -> Check:
    """Return a check with the problem given or found; an exception is a problem as well."""
    try:
        found = problem if isinstance(problem, str) else problem()
    except PLUGIN_ERRORS as error:
        found = _reason(error)
    return Check(name, (found,) if found else ())


def _reason(error: BaseException) -> str:
    if isinstance(error, ParameterError | Failed):
        return str(error)
    raised = f"It raised {type(error).__name__}: {error}."
    return f"{raised} {CURRENT_NAMES}" if isinstance(error, AttributeError) else raised


# --- what it declares


def _declaration(kind: type[Task]) -> str:
    if not kind.title.strip():
        return "Its title is empty."
    if not (kind.metric.is_none or kind.metric.name.isidentifier()):
        return f"Its metric's name is not a plain word such as reaction_time: {kind.metric.name!r}."
    return ""


def _parameters(kind: type[Task]) -> str:
    declared = fields(kind.Parameters)
    problems = [problem for field in declared if (problem := _lacks(field))]
    sensors = {sensor_parameter(seat) for seat in kind.seats} if kind.sensors else set()
    missing = sorted(sensors - {field.name for field in declared})
    problems += [
        f"It has a motion sensor, and no parameter {name} (a str) that names it."
        for name in missing
    ]
    return " ".join(problems)


def _lacks(field: Field) -> str:
    missing = [
        name
        for name, value in (("a title", field.title), ("help", field.help))
        if not value.strip()
    ]
    if field.kind in ("int", "float") and (field.ge is None or field.le is None):
        missing.append("bounds (ge and le)")
    return f"{field.name} lacks {' and '.join(missing)}." if missing else ""


# --- what it shows


def _words(task: Task) -> str:
    if not task.instructions().strip():
        return "Its instructions are empty."
    if wrong := problem_of(task.steps):
        return wrong
    silent = [
        level
        for level in _levels(task)
        if not task.goal(level).strip() and task.goal_value(level) is not None
    ]
    return f"The goal is empty at level {silent[0]}." if silent else ""


def _levels(task: Task) -> range:
    return range(1, min(task.levels, task.parameters.max_level) + 1)


def _prompts(kind: type[Task], task: Task) -> str:
    if task.levels < 1:
        return f"It has {task.levels} levels; it needs one."
    if empty := [level for level in _levels(task) if task.trials_at(level) < 1]:
        return (
            f"It has {task.trials_at(empty[0])} trials in an attempt at level {empty[0]}; it "
            "needs one."
        )
    again = kind(task.parameters)
    for level in _levels(task):
        earlier: tuple[Results, ...] = ()
        first = Situation(1, 1, level, RandomStreams(SEED, 1, 1), RandomStreams(SEED))
        if (condition := task.condition(first)) != again.condition(first):
            return (
                f"The condition differs when asked for again at level {level}. Draw from "
                "situation.session only."
            )
        for trial in range(1, min(task.trials_at(level), 5) + 1):
            streams = RandomStreams(SEED, 1, trial)
            situation = replace(
                first, trial=trial, streams=streams, results_by_seat=earlier, condition=condition
            )
            prompt = task.stimulus(situation)
            where = f"at level {level}, trial {trial}"
            if problem := _content_problem(prompt, where) or _timing_problem(
                prompt, task.parameters, where
            ):
                return problem
            if prompt != task.stimulus(situation) or prompt != again.stimulus(situation):
                return (
                    f"The prompt differs when asked for again {where}. Draw from "
                    "situation.streams only."
                )
            onsets = tuple(
                frames.planned(prompt.frames, place) for place in range(len(prompt.frames))
            )
            onset = frames.planned(prompt.frames, frames.timed(prompt.frames))
            missed = task.timed_out(Trial(situation, prompt, onset=onset, frames=onsets))
            earlier += (missed if isinstance(missed, dict) else dict.fromkeys(task.seats, missed),)
    return ""


def _content_problem(prompt: Stimulus, where: str) -> str:
    if problem := stimulus_problem(prompt):
        return f"{problem.removesuffix('.')}, {where}."
    if not prompt.name:
        return f"The stimulus has no name {where}."
    if not prompt.text.strip() or not prompt.text.isprintable():
        return f"The prompt's text is not one line of plain text {where}: {prompt.text!r}."
    if prompt.choices < 1:
        return f"The prompt is drawn from {prompt.choices} stimuli {where}."
    texts = (prompt.glyph, prompt.hint, *prompt.halves)
    for place, frame in enumerate(prompt.frames, 1):
        if not frame.line.isprintable():
            return (
                f"The text of frame {place} is not one line of plain text {where}: "
                f"{frame.line!r:.60}."
            )
        texts += (frame.text, frame.glyph, frame.hint, *frame.halves)
    return control_problem(f"What the prompt shows {where}", "".join(texts))


def _timing_problem(prompt: Stimulus, parameters: TaskParameters, where: str) -> str:
    timeout_ms = parameters.response_timeout_ms if prompt.timeout_ms is None else prompt.timeout_ms
    if (place := frames.never_shown(prompt.frames, timeout_ms)) is None:
        return ""
    return (
        f"Frame {place + 1} of {len(prompt.frames)} would come after the time for the response is "
        "over "
        f"({timeout_ms:g} ms), {where}. Give the stimulus a longer timeout_ms, or mark a later "
        "frame as timed."
    )


# --- what it does


def _sessions(kind: type[Task], parameters: TaskParameters) -> Iterator[Check]:
    done: list[Simulated] = []
    calls: list[task_state.Call] = []
    with tempfile.TemporaryDirectory(prefix="sar-tui-check-") as folder:
        for person in PEOPLE.values():
            name = (
                f"runs a whole session with a{'n' if person.name[0] in 'aeiou' else ''} "
                f"{person.name} participant"
            )
            try:
                played = kind if done else task_state.recorded(kind, calls)
                simulated = _simulate(played, parameters, person, Path(folder))
            except PLUGIN_ERRORS as error:
                yield _check(name, _reason(error))
                return
            yield _check(name, _outcome(kind, simulated, parameters))
            done.append(simulated)
    yield _check(
        "keeps no state from call to call",
        lambda: task_state.problem(kind(parameters), calls, SEED),
    )
    yield _check("stores only the details that it declares", _details(kind, done))
    yield Check("has the measures that it declares", warning=_measures(kind, done))
    prompts = [
        prompt.shown(frame)
        for each in done
        for record in each.history
        if isinstance(prompt := record.message, Prompt)
        for frame in range(max(1, len(prompt.frames)))
    ]
    themes = [Catalogue().theme(name) for name in Catalogue().theme_names()]
    yield from task_prompts.checks(kind, prompts, themes)
    yield _check("changes its level", _level_moves(kind, parameters, done))
    yield _levels_apart(kind, parameters)
    yield _check(
        "gives the same result when replayed, so that it can be resumed",
        _replay(kind, parameters, done),
    )
    if task_view.has_view(kind) and not task_view.contract_problem(kind):
        yield _check("draws its view in a whole session", lambda: _drawing(kind, parameters, done))


def _measures(kind: type[Task], done: list[Simulated]) -> str:
    """Return a sentence that names declared measures that no attempt had; others that they had may
    be meant.
    """
    had = {
        name
        for simulated in done
        for attempt in simulated.attempts
        for name in attempt["qualities"]
    }
    declared = [measure.name for measure in kind.measured]
    if not (missing := [name for name in declared if name not in had]):
        return ""
    others = sorted(had.difference(declared, (quality.field for quality in kind.qualities)))
    instead = f" Attempts had {', '.join(others)}, which are not declared." if others else ""
    return f"No attempt had {', '.join(missing)}: so no column shows it.{instead}"


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
            return _check(name, _reason(error))
    return Check(name, warning=warning)


def _simulate(
    kind: type[Task], parameters: TaskParameters, person: Person, folder: Path
) -> Simulated:
    catalogue = Catalogue()
    values = changed(parameters)
    plan = make_plan(catalogue, kind, ["CHECK"], values, theme=THEME, seed=SEED, mode="simulated")
    session = simulate(plan, person, folder, catalogue)
    database = connect(folder)
    try:
        return Simulated(
            sessions.find(database, folder, session),
            sessions.rows(database, "attempts", session),
            sessions.rows(database, "trials", session),
            list(sessions.history(database, session)),
        )
    finally:
        database.close()


def _outcome(kind: type[Task], simulated: Simulated, parameters: TaskParameters) -> str:
    for record in simulated.history:
        if record.topic is FAULT and isinstance(fault := record.message, Fault):
            return f"The node {fault.node} failed at {fault.topic} ({fault.error})."
    expected = parameters.practice_attempts + parameters.attempts
    found = len({attempt["attempt"] for attempt in simulated.attempts})
    if simulated.session["status"] != "completed" or found != expected:
        status = simulated.session["status"]
        return f"The session is {status} after {found} of {expected} attempts."
    scores = [attempt["metric"] for attempt in simulated.attempts]
    if any(score is not None and not math.isfinite(score) for score in scores):
        return "An attempt's metric is not a finite number."
    if scores.count(None) > len(scores) / 2 and not kind.metric.is_none:
        return (
            f"{scores.count(None)} of {len(scores)} attempts have no metric: no trial in them was "
            "right and had a "
            "value. Look at perceived, timed_out and rehearse."
        )
    return ""


def _details(kind: type[Task], done: list[Simulated]) -> str:
    declared = {field.name for field in msgspec.structs.fields(kind.Details)}
    kept = {name for simulated in done for trial in simulated.trials for name in trial["details"]}
    return (
        f"Its Details do not declare {', '.join(sorted(kept - declared))}."
        if kept - declared
        else ""
    )


def _level_moves(kind: type[Task], parameters: TaskParameters, done: list[Simulated]) -> str:
    task = kind(parameters)
    is_judged = any(task.goal_value(level) is not None for level in _levels(task))
    if parameters.difficulty_policy == "fixed" or len(_levels(task)) == 1 or not is_judged:
        return ""
    seen = {attempt["level"] for simulated in done for attempt in simulated.attempts}
    if len(seen) > 1:
        return ""
    return (
        f"The level stays at {seen.pop()} for every participant. Is the goal "
        f"({parameters.threshold:g}) within reach?"
    )


def _replay(kind: type[Task], parameters: TaskParameters, done: list[Simulated]) -> str:
    theme = Catalogue().theme(THEME)
    for simulated in done:
        try:
            Session(kind(parameters), theme, VirtualClock(), SEED).replay(simulated.history)
        except ReplayError as error:
            return (
                f"{error} Does the task keep state, or draw from elsewhere than situation.streams?"
            )
    return ""


def _drawing(kind: type[Task], parameters: TaskParameters, done: list[Simulated]) -> str:
    theme = Catalogue().theme(THEME)
    problems = (
        task_view.drawing_problem(kind(parameters), theme, SEED, simulated.history)
        for simulated in done
    )
    return next(filter(None, problems), "")
