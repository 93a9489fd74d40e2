"""Checks a task folder against the contract of tasks."""

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

from msgspec.structs import replace

from sar_tui.checks import task_sessions, task_translations, task_view
from sar_tui.checks.check import Check, checked, reason
from sar_tui.checks.task_sessions import ATTEMPTS, SEED, levels_of
from sar_tui.checks.task_translations import declared, texts_in
from sar_tui.loop.author_lines import at, line_of, strangers
from sar_tui.loop.task import Task
from sar_tui.loop.trial import stimulus_problem
from sar_tui.model import frames
from sar_tui.model.language import read_words
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Results, Situation, Stimulus, Trial
from sar_tui.model.visible_text import control_problem
from sar_tui.plugin_calls import PLUGIN_ERRORS
from sar_tui.plugins import PluginError, load_task, task_folder
from sar_tui.rules.declaration import Field, ParameterError
from sar_tui.rules.parameters import TaskParameters, build, fields
from sar_tui.rules.questions import problem_of
from sar_tui.runs.sensors import sensor_parameter


def check(folder: Path) -> Iterator[Check]:
    """Check a task folder. Checks that an earlier problem makes impossible are skipped."""
    try:
        kind = load_task(folder)
    except PluginError as error:
        yield checked("can be loaded", str(error))
        return
    yield Check("can be loaded")
    declared = checked("declares its title and metric", lambda: _declaration(kind))
    yield declared
    yield Check("names its methods as the contract does", warning=_misnamed(kind))
    yield checked("describes every parameter: title, help, bounds", lambda: _parameters(kind))
    defaults = checked("has defaults within their own bounds", lambda: _defaults(kind))
    yield defaults
    try:
        task = kind(build(kind.Parameters, {"attempts": ATTEMPTS}))
    except PLUGIN_ERRORS as error:
        yield checked("can be set up with its defaults", reason(error))
        return
    yield Check("can be set up with its defaults")
    yield checked("gives instructions, and a goal for each level", lambda: _words(task))
    yield checked("has no control characters in its texts", lambda: " ".join(problems(task)))
    yield checked(
        "has all its texts in each of its languages",
        lambda: " ".join(task_translations.problems(kind)),
    )
    yield checked(
        "gives feedback in words without numbers", lambda: " ".join(task_translations.numbers(kind))
    )
    if task_view.has_view(kind):
        yield checked(
            "has a view that keeps its contract", lambda: task_view.contract_problem(kind)
        )
    prompts = checked(
        "makes the same one-line prompts when asked twice", lambda: _prompts(kind, task)
    )
    yield prompts
    if declared.ok and defaults.ok and prompts.ok:
        yield from task_sessions.checks(kind, task.parameters)


# --- what it declares


def _declaration(kind: type[Task]) -> str:
    if not kind.title.strip():
        return f"{line_of(kind, 'title')}: Its title is empty."
    if not (kind.metric.is_none or kind.metric.name.isidentifier()):
        return (
            f"{line_of(kind, 'metric')}: Its metric's name is not a plain word such as "
            f"reaction_time: {kind.metric.name!r}."
        )
    return ""


def _misnamed(kind: type[Task]) -> str:
    """Return a sentence for each method that is never called, with a name like one that is."""
    return " ".join(
        f"{line_of(kind, name)}: {name} is never called. Did you mean {near}?"
        for name, near in strangers(kind, Task)
    )


def _parameters(kind: type[Task]) -> str:
    declared = fields(kind.Parameters)
    problems = [
        at(line_of(kind.Parameters, field.name), problem)
        for field in declared
        if (problem := _lacks(field))
    ]
    sensors = {sensor_parameter(seat) for seat in kind.seats} if kind.sensors else set()
    missing = sorted(sensors - {field.name for field in declared})
    problems += [
        at(
            line_of(kind, "sensors"),
            f"It has a motion sensor, and no parameter {name} (a str) that names it.",
        )
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


def _defaults(kind: type[Task]) -> str:
    """Return a sentence for each parameter whose default its own declaration does not allow."""
    try:
        build(kind.Parameters, {field.name: field.default for field in fields(kind.Parameters)})
    except ParameterError as error:
        return " ".join(
            f"{line_of(kind.Parameters, name)}: The default of {name} breaks its own bounds. {why}"
            for name, why in error.problems.items()
        )
    return ""


# --- what it shows


def _words(task: Task) -> str:
    if not task.instructions().strip():
        return f"{line_of(type(task), 'instructions')}: Its instructions are empty."
    if wrong := problem_of(task.steps):
        return at(line_of(type(task), "steps"), wrong)
    silent = [
        level
        for level in levels_of(task)
        if not task.goal(level).strip() and task.goal_value(level) is not None
    ]
    if not silent:
        return ""
    return f"{line_of(type(task), 'goal')}: The goal is empty at level {silent[0]}."


def _prompts(kind: type[Task], task: Task) -> str:
    if task.levels < 1:
        return f"{line_of(kind, 'levels')}: It has {task.levels} levels; it needs one."
    if empty := [level for level in levels_of(task) if task.trials_at(level) < 1]:
        name = "trials_per_attempt" if kind.trials_at is Task.trials_at else "trials_at"
        return (
            f"{line_of(kind, name)}: It has {task.trials_at(empty[0])} trials in an attempt at "
            f"level {empty[0]}; it needs one."
        )
    again = kind(task.parameters)
    for level in levels_of(task):
        earlier: tuple[Results, ...] = ()
        first = Situation(1, 1, level, RandomStreams(SEED, 1, 1), RandomStreams(SEED))
        if (condition := task.condition(first)) != again.condition(first):
            return (
                f"{line_of(kind, 'condition')}: The condition differs when asked for again at level {level}. Draw from "
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
                return at(line_of(kind, "stimulus"), problem)
            if prompt != task.stimulus(situation) or prompt != again.stimulus(situation):
                return (
                    f"{line_of(kind, 'stimulus')}: The prompt differs when asked for again "
                    f"{where}. Draw from situation.streams only."
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


# --- texts


def problems(task: Task) -> list[str]:
    """Return a sentence for each text with such characters: declared, in the code, translated, or
    made for a level.
    """
    found = {control_problem(ascii(text), text) for text in _texts(task)}
    return sorted(found - {""})


def _texts(task: Task) -> Iterator[str]:
    kind = type(task)
    folder = task_folder(kind)
    yield from declared(kind)
    yield from chain.from_iterable(
        (field.title, field.help, field.unit) for field in fields(kind.Parameters)
    )
    for path in folder.glob("*.py"):
        yield from texts_in(path.read_text("utf-8"))
    for path in folder.glob("words.*.toml"):
        yield from chain.from_iterable(read_words(path).items())
    yield task.instructions()
    yield from (
        task.goal(level) for level in range(1, min(task.levels, task.parameters.max_level) + 1)
    )
