"""Texts from anywhere: what a terminal would obey becomes visible, and what people read stays as it
is.
"""

import json
import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model.visible_text import control_problem, escaped, obeyed, visible
from tests.hostile import OBEYED

any_text = st.text(st.characters(exclude_categories=()), max_size=40) | st.text(
    st.sampled_from(OBEYED + "aé\n")
)
DIRECTIONS = {"LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI", "B", "S"}
"""Classes of characters that change the direction of text, or separate paragraphs and segments."""
READ = [
    "Bien hecho, mañana más.",
    "אבג 12 \u200fדה",
    "مرحبا \u200e12\u200f \u061c",
    "👩\u200d👩\u200d👧\u200d👦 🏴\U000e0067\U000e0062\U000e007f 🇪🇸 ✊🏽",
    "e\u0301 n\u0303 \u0915\u094d\u200d\u0937",
    "漢字 \ufeffﬁ \u00ad",
    "(•‿•) ▁▂▃ ⠿ │",
]


@given(any_text)
def test_nothing_that_a_terminal_obeys_is_left_and_every_other_character_stays(text: str) -> None:
    shown = visible(text)
    assert visible(shown) == shown
    assert not set(shown) & set(OBEYED)
    assert not [each for each in shown if unicodedata.category(each) in ("Cc", "Cs", "Zl", "Zp")]
    assert not [each for each in shown if unicodedata.bidirectional(each) in DIRECTIONS]
    both = zip(text, shown, strict=True)
    assert [before for before, after in both if after != before and before not in OBEYED] == []


@given(any_text)
def test_a_kept_character_stays(text: str) -> None:
    assert visible(text, "\n\t").count("\n") == text.count("\n")
    assert not set(visible(text, "\n\t")) & set(OBEYED) - {"\n", "\t"}


@pytest.mark.parametrize("text", READ)
def test_what_people_read_stays_as_it_is(text: str) -> None:
    assert visible(text) == text
    assert obeyed(text) == ()


def test_each_control_character_has_its_own_picture() -> None:
    assert visible("\x1b[31m\x00\r\n\x7f") == "␛[31m␀␍␊␡"
    assert visible("\x9b31m user\u202etxt.exe \udcff") == "�31m user�txt.exe �"


def test_a_problem_names_the_characters() -> None:
    assert (
        control_problem("The title", "A\x1b[31m\u202e\x1b")
        == "The title has control characters: U+001B, U+202E."
    )
    assert control_problem("The title", "two\nlines") == ""


@given(any_text)
def test_escaped_json_holds_the_same_value(text: str) -> None:
    encoded = escaped(json.dumps({"text": text}, ensure_ascii=False))
    assert not set(encoded) & set(OBEYED)
    assert json.loads(encoded) == {"text": text}
