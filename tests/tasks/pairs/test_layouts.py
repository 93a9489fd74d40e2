"""Halves of a keyboard layout and levels of equal difficulty for both seats."""

import importlib
from itertools import pairwise

import pytest

from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build

KIND = Catalogue().task("pairs")
LAYOUTS = importlib.import_module(KIND.__module__)


def make(**parameters: object) -> Task:
    return KIND(build(KIND.Parameters, parameters))


@pytest.mark.parametrize(
    ("layout", "left", "right"),
    [("qwerty", "12345qwertasdfgzxcvb", "67890yuiophjkl;nm,./"), ("azerty", "azertqsdfgwxcvb", "yuiophjklmn,;:!"),
     ("qwertz", "12345qwertasdfgyxcvb", "67890zuiophjklönm,.-")],
)  # fmt: skip
def test_the_left_half_of_the_keyboard_belongs_to_a_and_the_right_half_to_b(
    layout: str, left: str, right: str
) -> None:
    task = make(layout=layout)
    assert {task.seat_of(key) for key in left + left.upper()} == {"A"}
    assert {task.seat_of(key) for key in right + right.upper()} == {"B"}


@pytest.mark.parametrize("key", ["enter", "space", "tab", "left", "up", "f7", "€"])
def test_keys_in_neither_half_belong_to_nobody(key: str) -> None:
    assert make().seat_of(key) == ""


@pytest.mark.parametrize("layout", LAYOUTS.ROWS)
def test_both_halves_have_equally_many_letters_at_mirrored_places(layout: str) -> None:
    places = {
        key: (row, column)
        for row, keys in enumerate(LAYOUTS.ROWS[layout])
        for column, key in enumerate(keys)
    }
    owners = LAYOUTS.owners(layout)
    levels = LAYOUTS.levels(layout)
    assert [len(pairs) for pairs in levels] == [2, 3, 4, 6, 8, 11]
    for pairs in levels:
        for left, right in pairs:
            assert (owners[left], owners[right]) == ("A", "B")
            assert places[left][0] == places[right][0]
            assert places[left][1] + places[right][1] == 9
            assert left.isalpha()
            assert right.isalpha()


@pytest.mark.parametrize("layout", LAYOUTS.ROWS)
def test_a_level_keeps_the_letters_of_the_level_below(layout: str) -> None:
    levels = LAYOUTS.levels(layout)
    assert all(set(below) < set(above) for below, above in pairwise(levels))
