"""A prompt whose texts are none ends the session with a sentence: it could not be stored, or not be
read again.
"""

import math
from pathlib import Path
from typing import Any

import pytest

from sar_tui.loop.trial import LONGEST_DATA, problem_of_data, stimulus_problem
from sar_tui.model.trial_types import Frame, Stimulus


def stimulus(**given: Any) -> Stimulus:
    return Stimulus(**{"name": "cat", "expected": "c", "text": "What is it?"} | given)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"picture": Path("x")}, "The picture of a prompt is a text, not PosixPath('x')."),
        ({"text": 3}, "The text of a prompt is a text, not 3."),
        ({"expected": None}, "The expected of a prompt is a text, not None."),
        ({"halves": (1, "2")}, "The halves of a prompt are a pair of texts, not (1, '2')."),
        ({"frames": (Frame(7, 100), Frame("X"))}, "The glyph of a frame is a text, not 7."),  # type: ignore[arg-type]
    ],
)
def test_what_is_no_text_is_named(given: dict[str, Any], sentence: str) -> None:
    assert stimulus_problem(stimulus(**given)) == sentence


def test_texts_are_fine() -> None:
    frames = (Frame("X", 50), Frame("Y"))
    assert stimulus_problem(stimulus(picture="cat.png", colour="red", frames=frames)) == ""


# --- data


def test_json_is_stored_as_it_is() -> None:
    values = {"congruent": True, "side": "left", "list": [1, 2.5, None], "more": {"a": "b"}}
    assert problem_of_data(values) == ""


@pytest.mark.parametrize(
    "value", [(1, 2), math.nan, math.inf, {1: "a"}, {"a", "b"}, object(), b"bytes"]
)
def test_anything_else_is_a_sentence(value: object) -> None:
    said = problem_of_data({"value": value})
    assert said.startswith("The data of a prompt ")
    assert stimulus_problem(Stimulus("a", "a", "a", data={"value": value})) == said


def test_a_structure_that_holds_itself_is_a_sentence() -> None:
    endless: dict[str, object] = {}
    endless["again"] = endless
    assert "cannot be stored as JSON" in problem_of_data(endless)


def test_no_more_than_a_page_is_kept_with_a_prompt() -> None:
    assert str(LONGEST_DATA) in problem_of_data({"text": "x" * LONGEST_DATA})
