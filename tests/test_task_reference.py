"""docs/task-reference.md names every field and method that a task may use."""

import re
from pathlib import Path

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
NAMES = "Stimulus Cue Situation Trial Result Show Again Metric Target Axis Score PastAttempt Quality Mark"
VALUES = [*(getattr(trial_types, name) for name in NAMES.split()), Frame, Tone, Measure, Step]


def named(text: str) -> set[str]:
    """Return the names that stand in code spans of a text, each of a call, of its arguments too."""
    return {name for span in re.findall(r"`([^`]+)`", text) for name in re.findall(r"\w+", span)}


def declared(kind: type) -> set[str]:
    return {field.name for field in msgspec.structs.fields(kind)}


def public(kind: type) -> set[str]:
    """Return the methods and properties of a class."""
    return {
        name
        for name, value in vars(kind).items()
        if not name.startswith("_")
        and (callable(value) or isinstance(value, property | classmethod))
    }


@pytest.mark.parametrize("kind", VALUES, ids=lambda kind: kind.__name__)
def test_every_field_of_a_value_has_a_line(kind: type) -> None:
    assert declared(kind) - named(SECTIONS[kind.__name__]) == set()


def test_everything_that_a_task_declares_or_computes_has_a_line() -> None:
    attributes = set(Task.__annotations__)
    assert attributes - named(SECTIONS["What a task declares"]) == set()
    assert public(Task) - {"Details", "Parameters"} - named(SECTIONS["What it computes"]) == set()


def test_every_percept_stream_and_method_of_a_view_has_a_line() -> None:
    for kind in (Percept, KeyPerceived, TextPerceived, ReachPerceived):
        assert declared(kind) - named(SECTIONS["Percepts"]) == set()
    assert public(RandomStreams) - named(SECTIONS["Situation"]) == set()
    assert {"latency_ms", "frame_at"} <= named(SECTIONS["Trial"])
    own = {"prompt_lines", "between_attempts", "facts", "findings"}
    assert own <= public(TaskView)
    assert own - named(SECTIONS["TaskView"]) == set()
