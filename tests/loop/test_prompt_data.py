"""Data of prompts: what can be stored as it is."""

import math

import pytest

from sar_tui.loop.prompt_data import LONGEST_DATA, problem
from sar_tui.loop.trial import stimulus_problem
from sar_tui.model.trial_types import Stimulus


def test_json_is_stored_as_it_is() -> None:
    assert (
        problem(
            {
                "congruent": True,
                "side": "left",
                "soa_ms": 100,
                "list": [1, 2.5, None],
                "more": {"a": "b"},
            }
        )
        == ""
    )


@pytest.mark.parametrize(
    "value", [(1, 2), math.nan, math.inf, {1: "a"}, {"a", "b"}, object(), b"bytes"]
)
def test_anything_else_is_a_sentence(value: object) -> None:
    said = problem({"value": value})
    assert said.startswith("The data of a prompt ")
    assert stimulus_problem(Stimulus("a", "a", "a", data={"value": value})) == said


def test_a_structure_that_holds_itself_is_a_sentence() -> None:
    endless: dict[str, object] = {}
    endless["again"] = endless
    assert "cannot be stored as JSON" in problem(endless)


def test_no_more_than_a_page_is_kept_with_a_prompt() -> None:
    assert str(LONGEST_DATA) in problem({"text": "x" * LONGEST_DATA})
