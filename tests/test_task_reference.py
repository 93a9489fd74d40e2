"""docs/task-reference.md names every field and method that a task may use."""

import re
from pathlib import Path
from typing import Any

import msgspec
import pytest

from sar_tui.loop.task import Task
from sar_tui.model import trial_types
from sar_tui.model.frames import Frame
from sar_tui.model.measure import Measure
from sar_tui.model.messages import KeyPerceived, Percept, ReachPerceived, TextPerceived
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.step import Step
from sar_tui.model.tone import Tone
from sar_tui.widgets.task_view import TaskView

PAGE = (Path(__file__).parents[1] / "docs" / "task-reference.md").read_text(encoding="utf-8")
SECTIONS = dict(re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", PAGE, re.DOTALL | re.MULTILINE))
VALUES = [
    *(
        getattr(trial_types, name)
        for name in "Stimulus Cue Situation Trial Result Show Again Metric Target".split()
    ),
    *(
        getattr(trial_types, name)
        for name in "Axis Score PastAttempt Quality Mark Performance".split()
    ),
    Frame,
    Tone,
    Measure,
    Step,
]


def named(text: str) -> set[str]:
    """Return the names that stand in code spans of a text, each of a call, of its arguments too."""
    return {name for span in re.findall(r"`([^`]+)`", text) for name in re.findall(r"\w+", span)}


def public(kind: type) -> set[str]:
    fields = (
        {field.name for field in msgspec.structs.fields(kind)}
        if issubclass(kind, msgspec.Struct)
        else set()
    )
    return fields | {name for name, value in vars(kind).items() if _is_own(name, value)}


def _is_own(name: str, value: Any) -> bool:
    return not name.startswith("_") and (
        callable(value) or isinstance(value, property | classmethod)
    )


@pytest.mark.parametrize("kind", VALUES, ids=lambda kind: kind.__name__)
def test_every_field_of_a_value_has_a_line(kind: type) -> None:
    declared = (
        {field.name for field in msgspec.structs.fields(kind)}
        if issubclass(kind, msgspec.Struct)
        else set()
    )
    assert declared - named(SECTIONS[kind.__name__]) == set()


def test_everything_that_a_task_declares_or_computes_has_a_line() -> None:
    attributes = set(Task.__annotations__)
    assert attributes - named(SECTIONS["What a task declares"]) == set()
    assert public(Task) - {"Details", "Parameters"} - named(SECTIONS["What it computes"]) == set()


def test_every_percept_has_its_fields() -> None:
    for kind in (Percept, KeyPerceived, TextPerceived, ReachPerceived):
        assert {field.name for field in msgspec.structs.fields(kind)} - named(
            SECTIONS["Percepts"]
        ) == set()


def test_every_random_stream_and_every_method_of_a_view_has_a_line() -> None:
    assert public(RandomStreams) - named(SECTIONS["Situation"]) == set()
    assert {"latency_ms", "frame_at"} <= named(SECTIONS["Trial"])
    own = {"prompt_lines", "between_attempts", "facts", "findings"}
    assert own <= public(TaskView)
    assert own - named(SECTIONS["TaskView"]) == set()
