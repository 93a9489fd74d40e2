"""Given a wording for a situation, when it is looked at, then it can be said, or what is wrong with it is told."""

import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.framework.number_words import holds_number
from sar_tui.framework.phrase_keys import (
    FIGURES,
    PERFORMANCE,
    QUALITATIVE,
    QUANTITATIVE,
    SITUATIONS,
    wording_problems,
)


def test_every_situation_is_either_in_words_or_in_figures() -> None:
    assert set(QUALITATIVE) | set(QUANTITATIVE) == set(SITUATIONS)
    assert not set(QUALITATIVE) & set(QUANTITATIVE)
    assert {"positive", "negative_strong", "accuracy", "performance_improved", "greeting"} <= set(QUALITATIVE)
    assert {"positive_first", "accuracy_figures", "performance_same_figures", "summary_figures"} <= set(QUANTITATIVE)


def test_performance_is_told_in_words_and_in_figures_of_the_same_situations() -> None:
    in_words = [name for name in PERFORMANCE if not name.endswith("_figures")]
    assert in_words == ["performance_first", "performance_improved", "performance_worsened", "performance_same"]
    for name in in_words:
        assert SITUATIONS[name] < SITUATIONS[f"{name}_figures"]


def test_the_page_on_themes_lists_every_situation_with_its_slots() -> None:
    page = (Path(__file__).parents[2] / "docs" / "themes-and-words.md").read_text(encoding="utf-8")
    rows = [line.strip("|").split("|") for line in page.splitlines() if line.count("|") == 4]
    listed = {
        situation: set(re.findall(r"`(\w+)`", slots))
        for situations, _, slots in rows
        for situation in re.findall(r"`(\w+)`", situations)
        if situation in SITUATIONS
    }
    assert listed == SITUATIONS


@pytest.mark.parametrize(
    ("situation", "wording"),
    [
        ("goodbye", "Bye."),
        ("positive_first", "{value}"),
        ("negative_improved", "{{ {difference} {change} than {reference} }}"),
        ("performance_first", "Next time: {aim}."),
    ],
)
def test_a_wording_that_can_be_said_has_no_problems(situation: str, wording: str) -> None:
    assert wording_problems(situation, wording, "en") == []


@pytest.mark.parametrize(
    ("situation", "wording", "problem"),
    [
        ("goodbye", "Bye, {name}.", " uses the slot {name}, which it does not have."),
        ("goodbye", "  ", " is empty."),
        ("positive_first", "{value}, {difference}", " uses the slot {difference}, which it does not have."),
        ("neutral", "Three quarters there.", " holds a number: 'Three quarters there.'."),
        ("accuracy", "Get 8 right.", " holds a number: 'Get 8 right.'."),
        ("performance_first", "Do it twice {aim}.", " holds a number: 'Do it twice {aim}.'."),
        ("negative_same", "The same as {reference}.", " gives no figure: 'The same as {reference}.'."),
        ("positive_improved", "You were {change}.", " gives no figure: 'You were {change}.'."),
        ("neutral_first", "At {value", " has broken slots (expected '}' before end of string): 'At {value'."),
        ("neutral_first", "At {value:.1f}", " has more than a name in a slot: 'At {value:.1f}'."),
        ("neutral_first", "At {value!x}", " has more than a name in a slot"),
        ("neutral_first", "At {value:{width}}", " has more than a name in a slot"),
        ("neutral_first", "At {}", " uses the slot {}, which it does not have."),
        ("neutral_first", "At {value.real}", " uses the slot {value.real}, which it does not have."),
    ],
)
def test_a_wording_that_cannot_be_is_told_in_one_sentence(situation: str, wording: str, problem: str) -> None:
    told, *_ = wording_problems(situation, wording, "en")
    assert told.startswith(f"A wording for {situation} (en){problem}")


def test_number_words_are_those_of_the_language() -> None:
    assert wording_problems("positive", "Ya once veces.", "es") == [
        "A wording for positive (es) holds a number: 'Ya once veces.'."
    ]
    assert wording_problems("positive", "Ocho, ocho!", "en") == []


@given(st.text(max_size=60), st.sampled_from(sorted(SITUATIONS)), st.sampled_from(["en", "es"]))
def test_a_wording_without_problems_can_be_said(wording: str, situation: str, language: str) -> None:
    if not wording_problems(situation, wording, language):
        said = wording.format(**{slot: "12 ms" if slot in FIGURES else "faster" for slot in SITUATIONS[situation]})
        assert holds_number(said, language) == (situation in QUANTITATIVE)


@given(st.lists(st.sampled_from(["{", "}", "{{", "}}", "value", "goal", "!", ":", "r", "12", "[0]", ".x", " "])))
def test_whatever_is_done_with_braces_a_wording_is_refused_or_can_be_said(parts: list[str]) -> None:
    wording = "".join(parts)
    if not wording_problems("neutral_first", wording, "en"):
        assert wording.format(value="12 ms", goal="12 ms")
