"""Checks what a task's class declares, before anything uses it: types, and methods that can be
called. It is apart from the contract, which loads little.
"""

from typing import Any

import msgspec

from sar_tui.loop.author_lines import at, hook_problem, line_of
from sar_tui.loop.task import Task
from sar_tui.model.measure import Measure
from sar_tui.model.trial_types import Details, Mark, Metric, Quality
from sar_tui.rules.parameters import TaskParameters

_TEXTS = ("title", "summary", "trains", "trials", "version")
_CLASSES: dict[str, type] = {"Parameters": TaskParameters, "Details": Details}
_LISTS: dict[str, type] = {
    "sensors": str,
    "seats": str,
    "qualities": Quality,
    "measured": Measure,
    "marks": Mark,
}
_SEATS = (("A",), ("A", "B"))


def declaration_problem(task: type[Task]) -> str:
    """Return the first wrong declaration of a task as the end of a sentence; empty if there is
    none.
    """
    for name in _TEXTS:
        if not isinstance(getattr(task, name), str):
            return f"its {name} is not a text"
    if not _is_a(task.metric, Metric):
        return "its metric is not a Metric, or has values of wrong types"
    for name, kind in _CLASSES.items():
        if not (isinstance(declared := getattr(task, name), type) and issubclass(declared, kind)):
            return f"its {name} is not a subclass of {kind.__name__}"
    if required := [
        field.name for field in msgspec.structs.fields(task.Parameters) if field.required
    ]:
        line = line_of(task.Parameters, required[0])
        return at(line, f"these parameters have no default: {', '.join(required)}")
    problems = (
        _problem_of_lists(task),
        hook_problem(task, Task),
        hook_problem(task.Parameters, TaskParameters),
    )
    return next(filter(None, problems), "").removesuffix(".")


def _problem_of_lists(task: type[Task]) -> str:
    for name, kind in _LISTS.items():
        items = getattr(task, name)
        if not (isinstance(items, tuple | list) and all(_is_a(item, kind) for item in items)):
            return f"its {name} are not a tuple of {'texts' if kind is str else kind.__name__}"
    if tuple(task.seats) not in _SEATS:
        return f'its seats are {task.seats!r:.60}; they can be ("A",) or ("A", "B")'
    return ""


def _is_a(value: Any, kind: type) -> bool:
    """Return True if a value is of a type, with fields of the types that this declares."""
    if not isinstance(value, kind):
        return False
    try:
        msgspec.convert(msgspec.to_builtins(value), kind)
    except (msgspec.ValidationError, TypeError):
        return False
    return True
