"""A prompt whose texts are none ends the session with a sentence: it could not be stored, or not be
read again.
"""

from pathlib import Path
from typing import Any

import pytest

from sar_tui.loop.trial import stimulus_problem
from sar_tui.model.trial_types import Frame, Stimulus


def stimulus(**given: Any) -> Stimulus:
    return Stimulus(**{"name": "cat", "expected": "c", "text": "What is it?"} | given)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (
            {"picture": Path("cat.png")},
            "The picture of a prompt is a text, not PosixPath('cat.png').",
        ),
        ({"text": 3}, "The text of a prompt is a text, not 3."),
        ({"expected": None}, "The expected of a prompt is a text, not None."),
        ({"halves": (1, "2")}, "The halves of a prompt are a pair of texts, not (1, '2')."),
        ({"frames": (Frame(7, 100), Frame("X"))}, "The glyph of a frame is a text, not 7."),  # type: ignore[arg-type]
    ],
)
def test_what_is_no_text_is_named(given: dict[str, Any], sentence: str) -> None:
    assert stimulus_problem(stimulus(**given)) == sentence


def test_texts_are_fine() -> None:
    assert (
        stimulus_problem(
            stimulus(picture="cat.png", colour="red", frames=(Frame("X", 50), Frame("Y")))
        )
        == ""
    )
