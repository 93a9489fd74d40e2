"""Very large characters: every key that a task asks for is drawn, fits, and differs from the others."""

from itertools import combinations

import pytest

from sar_tui.framework.parameters import build
from sar_tui.framework.task import Task
from sar_tui.widgets.large_characters import bitmap, draw

STAGE = (78, 12)
"""Columns and rows for a glyph on the stage of an 80 by 24 terminal."""
CHOICE_SETS = ("both hands", "left hand", "right hand", "arrow keys")
LAYOUTS = ("qwerty", "azerty", "qwertz")


def levels_of(keyboard: type[Task], choice_set: str, layout: str) -> list[set[str]]:
    """The glyphs of each level."""
    task = keyboard(build(keyboard.Parameters, {"choice_set": choice_set, "layout": layout}))
    return [{_glyph_of(key) for key in level.keys} for level in task._levels]  # type: ignore[attr-defined]


def _glyph_of(key: str) -> str:
    return {"left": "←", "right": "→", "up": "↑", "down": "↓"}.get(key, key)


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("choice_set", CHOICE_SETS)
def test_every_character_of_every_level_is_drawn_large_and_fits_the_stage(
    choice_set: str, layout: str, keyboard: type[Task]
) -> None:
    for glyphs in levels_of(keyboard, choice_set, layout):
        for glyph in glyphs:
            drawn = draw(glyph, *STAGE)
            assert bitmap(glyph), f"{glyph} has no bitmap"
            assert "█" in "".join(drawn)
            assert len(drawn) <= STAGE[1]
            assert max(map(len, drawn)) <= STAGE[0]


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("choice_set", CHOICE_SETS)
def test_no_two_characters_of_a_level_are_drawn_alike(choice_set: str, layout: str, keyboard: type[Task]) -> None:
    for glyphs in levels_of(keyboard, choice_set, layout):
        for one, other in combinations(sorted(glyphs), 2):
            assert draw(one, *STAGE) != draw(other, *STAGE), f"{one} looks like {other}"


def test_a_glyph_scales_with_the_available_space() -> None:
    heights = [len(draw("f", columns, rows)) for columns, rows in ((78, 40), (78, 20), (78, 12), (10, 5), (3, 2))]
    assert heights == sorted(heights, reverse=True)
    assert heights[0] > heights[2]
    assert draw("f", 3, 2) == ("f",)


def test_an_arrow_points_in_its_direction() -> None:
    assert draw("→", *STAGE) == tuple(row[::-1] for row in draw("←", *STAGE))
    assert draw("↑", *STAGE) == draw("↓", *STAGE)[::-1]


def test_characters_missing_in_the_font_are_plain_text() -> None:
    assert draw("語", *STAGE) == ("語",)
