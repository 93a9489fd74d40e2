"""Conditions of a study as complete settings of sessions, checked with the tasks and themes that
are here.
"""

import difflib
from collections.abc import Iterator, Mapping
from typing import Any

import msgspec

from sar_tui.model.session_mode import SessionMode
from sar_tui.model.step import Step
from sar_tui.model.study_place import StudyPlace
from sar_tui.plugins import Catalogue, PluginError
from sar_tui.records.kind import kinds
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.parameters import fields
from sar_tui.rules.policies import DIFFICULTY
from sar_tui.runs.plan import Failed, Plan, make_plan
from sar_tui.store import forms
from sar_tui.store.database import StoreError
from sar_tui.store.programmes import Programme
from sar_tui.study.outcome import Baseline, Number, Outcome
from sar_tui.study.plan import ALLOCATED, OWN, QUESTIONS, Block, Condition, Problem, Study


def problems_here(plan: Study, catalogue: Catalogue) -> Iterator[Problem]:
    """Yield what a plan names and is not here, or cannot be: tasks, themes, settings, levels,
    forms; and what no plan is to be frozen with.
    """
    for name, condition in plan.conditions.items():
        for key, said in _condition_problems(plan, catalogue, condition):
            yield ("conditions", name, *key), said
    for question in plan.prereg:
        if question not in QUESTIONS:
            known = ", ".join(QUESTIONS)
            yield (
                ("prereg", question),
                f"There is no question {question!r:.40}. There are: {known}.",
            )
    for at, visit in enumerate(plan.visits):
        if said := _too_early(plan, at):
            yield ("visits", at, "window"), said
        for number, block in enumerate(visit.blocks):
            for said in _block_problems(plan, catalogue, block):
                yield ("visits", at, "blocks", number), said


def _too_early(plan: Study, at: int) -> str:
    """Return what is wrong with a window that opens before the visit before it can have been; empty
    if nothing is. The first visit is on its day, from which the others count.
    """
    if at == 0:
        return ""
    visit, earlier = plan.visits[at], plan.visits[at - 1]
    opens = visit.day - visit.window[0]
    least = earlier.day - (earlier.window[0] if at > 1 else 0)
    if opens >= least:
        return ""
    return (
        f"The window of the visit {visit.name} opens on day {opens}, before the visit "
        f"{earlier.name} can have been (from day {least} on)."
    )


def _condition_problems(
    plan: Study, catalogue: Catalogue, condition: Condition
) -> Iterator[Problem]:
    try:
        task = catalogue.task(condition.task)
    except PluginError as error:
        yield ("task",), str(error)
        return
    known = {field.name for field in fields(task.Parameters)}
    for name in condition.settings:
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            meant = f" Did you mean {near[0]}?" if near else ""
            yield ("settings", name), f"The task {task.name} has no setting {name}.{meant}"
            return
    try:
        session_plan(plan, catalogue, condition, None, "P01", {})
    except ParameterError as error:
        for name, said in error.problems.items():
            yield ("settings", name), said
    except (PluginError, Failed) as error:
        yield ("theme",), str(error)


def _block_problems(plan: Study, catalogue: Catalogue, block: Block) -> Iterator[str]:
    if block.form:
        usable = [kind.name for kind in kinds().values() if kind.form and not kind.why_unusable]
        try:
            forms.form(block.form)
        except StoreError as error:
            is_known = block.form.casefold() in map(str.casefold, kinds())
            none = f"There is no form {block.form}. The forms are: {', '.join(usable)}."
            yield str(error) if is_known else none
        return
    for name in dict.fromkeys((block.condition, *block.conditions)):
        if name not in plan.conditions:
            continue
        try:
            session_plan(plan, catalogue, plan.conditions[name], block, "P01", {})
        except ParameterError as error:
            yield f"With the condition {name}: {error}"
        except (PluginError, Failed):
            continue  # told of the condition


def session_plan(
    plan: Study,
    catalogue: Catalogue,
    condition: Condition,
    block: Block | None,
    participant: str,
    own: Mapping[str, Any],
    *,
    level: int | None = None,
    place: StudyPlace | None = None,
    seed: int | None = None,
    mode: SessionMode = "live",
    id: str = "",
) -> Plan:
    """Return the plan of a session: every setting is that of the condition, the block, or its
    default, but for those that belong to the person.

    Args:
        plan: the study.
        catalogue: where task and theme are found.
        condition: of the session.
        block: of the session; None for the condition alone.
        participant: code of the person.
        own: settings of the participant's programme, of which those are used that the plan lists.
        level: the level that is carried over from another block; None if none is.
        place: of the session in the study.
        seed, mode, id: as for `make_plan`.

    Raises:
        StoreError, PluginError, ParameterError, Failed: as `make_plan`.
    """
    task = catalogue.task(condition.task)
    known = {field.name for field in fields(task.Parameters)}
    personal = {name: value for name, value in own.items() if name in plan.from_person}
    settings = {
        **{name: value for name, value in personal.items() if name in known},
        **condition.settings,
        **(_of_block(block, level) if block else {}),
    }
    settings.setdefault("start_from", "fixed")
    return make_plan(
        catalogue,
        task,
        [participant],
        settings,
        saved=Programme(theme=condition.theme),
        steps=_steps(condition, block) if block else (),
        seed=seed,
        mode=mode,
        id=id,
        study=place,
    )


def _of_block(block: Block, level: int | None) -> dict[str, Any]:
    """Return the settings that a block decides."""
    found: dict[str, Any] = {}
    if block.attempts is not None:
        found["attempts"] = block.attempts
    if block.practice is not None:
        found["practice_attempts"] = block.practice
    if not block.gives_feedback:
        found["feedback_schedule"] = "none"
    if block.level == OWN:
        found["start_from"] = "estimate"
    elif isinstance(block.level, int):
        found["start_level"] = block.level
    elif level is not None:
        found["start_level"] = level
    return found


def _steps(condition: Condition, block: Block) -> tuple[Step, ...]:
    """Return what comes before the first attempt of a block."""
    steps = []
    if block.rest_s:
        rest = "Take a rest. It goes on by itself."
        steps.append(
            Step(name="rest", kind="rest", text=rest, seconds=float(block.rest_s), before=True)
        )
    texts = {"instructions": block.instructions, "condition": condition.instructions}
    steps += [Step(name=name, text=text, before=True) for name, text in texts.items() if text]
    return tuple(steps)


def resolved(plan: Study, catalogue: Catalogue) -> dict[str, dict[str, Any]]:
    """Return every condition with the version of its task and the value of each setting, as it is
    frozen.
    """
    found = {}
    for name, condition in plan.conditions.items():
        session = session_plan(plan, catalogue, condition, None, "P01", {})
        found[name] = {
            "task": session.task.name,
            "task_version": session.task.version,
            "theme": session.theme,
            "parameters": msgspec.to_builtins(session.parameters),
        }
    return found


def trials_of(plan: Study, catalogue: Catalogue, place: Outcome | Baseline) -> Number | None:
    """Return the number of trials behind a person's outcome or baseline: of reaction times prompts,
    else attempts. Of conditions that differ it is the smallest. None without sessions in the block.

    Raises:
        PluginError, ParameterError, Failed: a condition cannot run here.
    """
    is_metric = plan.outcome is not None and plan.outcome.measure == "metric"
    found = []
    for _, session in _sessions_of(plan, catalogue, place):
        attempts, level = session.parameters.attempts, session.parameters.start_level
        is_time = is_metric and session.task.metric.name == "reaction_time"
        prompts = session.task(session.parameters).trials_at(level) if is_time else 1
        found.append((attempts * prompts, attempts, prompts))
    if not found:
        return None
    trials, attempts, prompts = min(found)
    of_prompts = f" of {prompts} prompts" if prompts > 1 else ""
    return Number(trials, f"the plan: {attempts} attempts{of_prompts}")


def _sessions_of(
    plan: Study, catalogue: Catalogue, place: Outcome | Baseline
) -> Iterator[tuple[str, Plan]]:
    """Yield the conditions of the block of the outcome or the baseline, each with the plan of its
    session; nothing if the outcome is a form's.
    """
    outcome = plan.outcome
    if outcome is None or outcome.is_form:
        return
    block = plan.block(place.visit, place.block)
    names = [group.condition for group in plan.groups.values()]
    names = names if block.condition == ALLOCATED else [block.condition, *block.conditions]
    for name in dict.fromkeys(filter(None, names)):
        yield name, session_plan(plan, catalogue, plan.conditions[name], block, "P01", {})


def warnings(plan: Study, catalogue: Catalogue) -> Iterator[str]:
    """Yield sentences on what is possible, and makes the outcome hard to interpret."""
    yield from _readable_codes(plan)
    if plan.outcome is None or plan.outcome.measure != "metric":
        return
    for name, session in _sessions_of(plan, catalogue, plan.outcome):
        if DIFFICULTY[session.parameters.difficulty_policy].moves_level:
            yield (
                f"In the condition {name} the level follows the results, and the results depend on "
                'the level: to compare them, set difficulty_policy = "fixed".'
            )


def _readable_codes(plan: Study) -> Iterator[str]:
    """Yield a sentence on each condition of groups of a blind study that a block names, too."""
    if not plan.allocation.blind:
        return
    named = {block.condition: f"{visit.name}/{block.name}" for visit, block in plan.blocks()}
    for condition in dict.fromkeys(group.condition for group in plan.groups.values()):
        if condition in named:
            yield (
                f"The block {named[condition]} names the condition {condition}, which a group has, "
                "too: whoever sees the code of the condition there knows that group. Give the block "
                "a condition of its own, with the same settings."
            )
