"""Levels of the keyboard task for each layout and hand, each harder than the last."""

import math
from itertools import pairwise, product

import pytest

from sar_tui.loop.task import Task
from sar_tui.rules.parameters import build, fields

CHOICE_SETS = ("both hands", "left hand", "right hand", "arrow keys")
UNSHIFTED = {
    "qwerty": "1234567890qwertyuiopasdfghjkl;zxcvbnm,./",
    "azerty": "&é\"'(-è_çàazertyuiopqsdfghjklmwxcvbn,;:!",
    "qwertz": "1234567890qwertzuiopasdfghjklöyxcvbnm,.-",
}
"""Characters of the three rows and the digits without Shift, left to right, top to bottom."""


def levels(keyboard: type[Task], choice_set: str, layout: str) -> list[tuple[str, ...]]:
    parameters = build(keyboard.Parameters, {"choice_set": choice_set, "layout": layout})
    chosen = parameters.chosen_levels()  # type: ignore[attr-defined]
    if choice_set.endswith("hand"):
        assert not any(level.needs_shift for level in chosen)
    return [level.keys for level in chosen]


def test_the_available_choices(keyboard: type[Task]) -> None:
    declared = {field.name: set(field.choices) for field in fields(keyboard.Parameters)}
    assert declared["choice_set"] == set(CHOICE_SETS)
    assert declared["layout"] == set(UNSHIFTED)


@pytest.mark.parametrize(("choice_set", "layout"), [*product(CHOICE_SETS, UNSHIFTED)])
def test_each_level_has_a_few_more_keys_than_the_one_before(
    keyboard: type[Task], choice_set: str, layout: str
) -> None:
    found = levels(keyboard, choice_set, layout)
    one_hand = 12 if layout == "azerty" else 13
    assert len(found) == {"arrow keys": 3, "both hands": 20}.get(choice_set, one_hand)
    for keys in found:
        assert len(set(keys)) == len(keys)
        assert all(key.isascii() and key.isprintable() and key != " " for key in keys)
    sizes = [len(keys) for keys in found]
    assert sizes[0] == 2
    for easier, harder in pairwise(sizes):
        assert harder > easier
        assert easier < 4 or math.log2(harder / easier) < 1 / 3


@pytest.mark.parametrize("layout", UNSHIFTED)
@pytest.mark.parametrize(
    ("hand", "columns"), [("left hand", range(5)), ("right hand", range(5, 10))]
)
def test_one_handed_levels_need_neither_shift_nor_the_other_half(
    keyboard: type[Task], hand: str, columns: range, layout: str
) -> None:
    for keys in levels(keyboard, hand, layout):
        assert all(UNSHIFTED[layout].index(key) % 10 in columns for key in keys)


@pytest.mark.parametrize(
    ("layout", "home"), [("qwerty", "asdf"), ("azerty", "qsdf"), ("qwertz", "asdf")]
)
def test_levels_for_the_left_hand_begin_at_its_home_row(
    keyboard: type[Task], layout: str, home: str
) -> None:
    assert sorted(levels(keyboard, "left hand", layout)[2]) == sorted(home)


@pytest.mark.parametrize("layout", UNSHIFTED)
def test_levels_for_both_hands_go_from_the_index_fingers_to_capitals_and_symbols(
    keyboard: type[Task], layout: str
) -> None:
    steps = levels(keyboard, "both hands", layout)
    assert steps[0] == ("f", "j")
    assert all("".join(keys).isalpha() and "".join(keys).islower() for keys in steps[:14])
    assert set("abcdefghijklmnopqrstuvwxyz") == set(steps[13])
    assert any(key.isdigit() for key in steps[14])
    assert any(key.isupper() for key in steps[15])
    assert any(not key.isalnum() for key in steps[18])
    assert not any(not key.isalnum() for keys in steps[:18] for key in keys)
    for keys in steps[14:]:
        for alike in ("1lI", "0oO", "iI"):
            assert not set(alike) & set(keys)


def test_arrows_are_left_and_right_first(keyboard: type[Task]) -> None:
    assert levels(keyboard, "arrow keys", "qwerty") == [
        ("left", "right"),
        ("left", "right", "up"),
        ("left", "right", "up", "down"),
    ]
