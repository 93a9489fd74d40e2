"""Checks a task's texts for characters that a terminal would obey instead of showing them."""

from collections.abc import Iterator
from itertools import chain

from sar_tui.checks.task_translations import declared, texts_in
from sar_tui.loop.task import Task
from sar_tui.model.language import read_words
from sar_tui.model.visible_text import control_problem
from sar_tui.plugins import task_folder
from sar_tui.rules.parameters import fields


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
