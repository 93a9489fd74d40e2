"""Levels of the keyboard task for each layout and hand, each harder than the last."""

import math
from itertools import pairwise, product

import pytest

from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build, fields

CHOICE_SETS = ("both hands", "left hand", "right hand", "arrow keys")
LAYOUTS = ("qwerty", "azerty", "qwertz")
ALL = list(product(CHOICE_SETS, LAYOUTS))

UNSHIFTED = {
    "qwerty": "1234567890qwertyuiopasdfghjkl;zxcvbnm,./",
    "azerty": "&é\"'(-è_çàazertyuiopqsdfghjklmwxcvbn,;:!",
    "qwertz": "1234567890qwertzuiopasdfghjklöyxcvbnm,.-",
}
"""Characters of the three rows and the digits without Shift, left to right, top to bottom."""


def levels(choice_set: str, layout: str) -> list[tuple[str, ...]]:
    kind = Catalogue().task("keyboard")
    parameters = build(kind.Parameters, {"choice_set": choice_set, "layout": layout})
    return [level.keys for level in parameters.chosen_levels()]  # type: ignore[attr-defined]


def column(key: str, layout: str) -> int:
    return UNSHIFTED[layout].index(key) % 10


def test_the_available_choices(keyboard: type[Task]) -> None:
    declared = {field.name: set(field.choices) for field in fields(keyboard.Parameters)}
    assert declared["choice_set"] == set(CHOICE_SETS)
    assert declared["layout"] == set(LAYOUTS)


@pytest.mark.parametrize(("choice_set", "layout"), ALL)
def test_a_level_contains_no_key_twice(choice_set: str, layout: str) -> None:
    for keys in levels(choice_set, layout):
        assert len(set(keys)) == len(keys)


@pytest.mark.parametrize(("choice_set", "layout"), ALL)
def test_every_level_has_more_keys_than_the_one_before(choice_set: str, layout: str) -> None:
    sizes = [len(keys) for keys in levels(choice_set, layout)]
    assert sizes[0] == 2
    assert all(harder > easier for easier, harder in pairwise(sizes))


@pytest.mark.parametrize(("choice_set", "layout"), ALL)
def test_there_are_many_levels_and_three_of_arrows(choice_set: str, layout: str) -> None:
    count = {"arrow keys": 3, "both hands": 20}.get(choice_set, 12 if layout == "azerty" else 13)
    assert len(levels(choice_set, layout)) == count


@pytest.mark.parametrize(("choice_set", "layout"), ALL)
def test_from_four_keys_on_a_level_adds_at_most_a_third_of_a_bit(
    choice_set: str, layout: str
) -> None:
    sizes = [len(keys) for keys in levels(choice_set, layout) if len(keys) >= 4]
    assert all(math.log2(harder / easier) < 1 / 3 for easier, harder in pairwise(sizes))


@pytest.mark.parametrize(("hand", "layout"), [pair for pair in ALL if pair[0].endswith("hand")])
def test_one_handed_levels_need_neither_shift_nor_the_other_half(hand: str, layout: str) -> None:
    own = range(5) if hand == "left hand" else range(5, 10)
    for keys in levels(hand, layout):
        assert all(key in UNSHIFTED[layout] for key in keys)
        assert all(column(key, layout) in own for key in keys)


@pytest.mark.parametrize(("hand", "layout"), [pair for pair in ALL if pair[0].endswith("hand")])
def test_one_handed_levels_ignore_case(keyboard: type[Task], hand: str, layout: str) -> None:
    parameters = build(keyboard.Parameters, {"choice_set": hand, "layout": layout})
    assert not any(level.needs_shift for level in parameters.chosen_levels())  # type: ignore[attr-defined]


@pytest.mark.parametrize("layout", LAYOUTS)
def test_levels_for_both_hands_begin_at_the_index_fingers(layout: str) -> None:
    assert levels("both hands", layout)[0] == ("f", "j")


@pytest.mark.parametrize(
    ("layout", "home"), [("qwerty", "asdf"), ("azerty", "qsdf"), ("qwertz", "asdf")]
)
def test_levels_for_the_left_hand_begin_at_its_home_row(layout: str, home: str) -> None:
    assert sorted(levels("left hand", layout)[2]) == sorted(home)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_levels_for_both_hands_go_from_the_home_row_to_capitals_and_symbols(layout: str) -> None:
    steps = levels("both hands", layout)
    assert all("".join(keys).isalpha() and "".join(keys).islower() for keys in steps[:14])
    assert set("abcdefghijklmnopqrstuvwxyz") == set(steps[13])
    assert any(key.isdigit() for key in steps[14])
    assert any(key.isupper() for key in steps[15])
    assert any(not key.isalnum() for key in steps[18])
    assert not any(not key.isalnum() for keys in steps[:18] for key in keys)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_characters_that_look_alike_are_not_mixed(layout: str) -> None:
    for keys in levels("both hands", layout)[14:]:
        for alike in ("1lI", "0oO", "iI"):
            assert not set(alike) & set(keys)


@pytest.mark.parametrize(("choice_set", "layout"), ALL)
def test_every_key_is_plain_enough_to_be_shown_and_typed(choice_set: str, layout: str) -> None:
    for keys in levels(choice_set, layout):
        assert all(key.isascii() and key.isprintable() and key != " " for key in keys)


def test_arrows_are_left_and_right_first() -> None:
    assert levels("arrow keys", "qwerty") == [
        ("left", "right"),
        ("left", "right", "up"),
        ("left", "right", "up", "down"),
    ]
