"""Very large characters: every key that a task asks for is drawn, fits, and differs from the
others.

What has no large shape is seen as well: at the terminal's own size, in a frame.
"""

import unicodedata

import pytest
from rich.cells import cell_len

from sar_tui.loop.task import Task
from sar_tui.rules.parameters import build
from sar_tui.widgets.large_characters import bitmap, draw, is_large, unknown

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
def test_every_character_of_a_level_is_drawn_large_and_unlike_the_others(
    choice_set: str, layout: str, keyboard: type[Task]
) -> None:
    for glyphs in levels_of(keyboard, choice_set, layout):
        drawings = {glyph: draw(glyph, *STAGE) for glyph in glyphs}
        for glyph, drawn in drawings.items():
            assert bitmap(glyph), f"{glyph} has no bitmap"
            assert "█" in "".join(drawn)
            assert len(drawn) <= STAGE[1]
            assert max(map(len, drawn)) <= STAGE[0]
        assert len(set(drawings.values())) == len(glyphs), f"two of {glyphs} look alike"


def test_a_glyph_scales_with_the_available_space() -> None:
    sizes = ((78, 40), (78, 20), (78, 12), (10, 5), (3, 2))
    heights = [len(draw("f", *size)) for size in sizes]
    assert heights == sorted(heights, reverse=True)
    assert heights[0] > heights[2]
    assert draw("f", 3, 2) == ("f",)


def test_an_arrow_points_in_its_direction() -> None:
    assert draw("→", *STAGE) == tuple(row[::-1] for row in draw("←", *STAGE))
    assert draw("↑", *STAGE) == draw("↓", *STAGE)[::-1]


@pytest.mark.parametrize("text", ["←←→←←", "HOUSE", "3 1 4 1", "Häuser", "¿Listo?"])
def test_a_row_of_characters_is_drawn_large_in_a_small_terminal(text: str) -> None:
    drawn = draw(text, *STAGE)
    assert len(drawn) >= 4
    assert set("".join(drawn)) <= set(" █▀▄")
    assert max(map(len, drawn)) <= STAGE[0]
    assert len(draw(text, 160, 40)) > len(drawn)


def test_flankers_differ_only_where_the_target_is() -> None:
    same, other = draw("←←←←←", 100, 12), draw("←←→←←", 100, 12)
    differing = {
        x for one, two in zip(same, other, strict=True) for x in range(len(one)) if one[x] != two[x]
    }
    assert min(differing) >= 2 * len(same[0]) // 5
    assert max(differing) < 3 * len(same[0]) // 5


WITH_MARKS = "äöüÄÖÜßéèêëáàâãåçñíìîïóòôõøúùûýÿæœÉÈÊÁÀÂÃÅÇÑÍÓÔÕØÚŸÆŒąćęłńśźżčďěňřšťžůőűğışțăāēī¿¡€"


def test_letters_with_marks_are_drawn_large_and_differ_from_all_others() -> None:
    for letter in WITH_MARKS:
        apart = unicodedata.normalize("NFD", letter)
        assert is_large(letter, *STAGE), letter
        assert draw(letter, *STAGE) != draw(apart[0], *STAGE) or letter == apart[0]
        assert draw(apart, *STAGE) == draw(letter, *STAGE)
    assert len({draw(letter, *STAGE) for letter in WITH_MARKS}) == len(WITH_MARKS)


@pytest.mark.parametrize("text", ["語", "家 house", "🍎", "Щ", "ש", "👩‍⚕️", "∫", "e\u0338"])
def test_characters_without_a_large_shape_are_drawn_small_in_a_frame(text: str) -> None:
    drawn = draw(text, *STAGE)
    assert text in drawn[1]
    assert drawn[0][0] + drawn[0][-1] + drawn[2][0] + drawn[2][-1] == "┌┐└┘"
    assert len({cell_len(line) for line in drawn}) == 1
    assert unknown(text)
    assert not is_large(text, *STAGE)


@pytest.mark.parametrize("size", [(6, 3), (5, 3), (2, 1), (1, 1)])
@pytest.mark.parametrize("text", ["語語語", "🍎"])
def test_a_small_drawing_never_exceeds_its_room(text: str, size: tuple[int, int]) -> None:
    drawn = draw(text, *size)
    assert len(drawn) <= size[1]
    assert all(cell_len(line) <= size[0] for line in drawn)


def test_a_text_too_long_to_be_large_is_drawn_small() -> None:
    assert draw("encyclopaedia", *STAGE)[1] == "│ encyclopaedia │"


def test_lines_of_a_text_are_drawn_below_each_other() -> None:
    assert draw("X", 78, 40) != draw("X\nX", 78, 40)
    assert len(bitmap("X\nXO")) == 2 * len(bitmap("X"))
    assert draw("語\nab", *STAGE) == ("┌────┐", "│ 語 │", "│ ab │", "└────┘")
