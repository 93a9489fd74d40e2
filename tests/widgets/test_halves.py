"""The two halves of the screen, drawn without a screen."""

import pytest

from sar_tui.widgets.prompt_lines import FIXATION, halves

WALL = 39
"""The column between the halves of a terminal of 80."""


def drawn(glyphs: tuple[str, ...], text: str, size: tuple[int, int] = (80, 15)) -> list[str]:
    return [line for line, _ in halves(glyphs, text, *size, ("Left", "Right"))]


@pytest.mark.parametrize("size", [(80, 15), (40, 10), (120, 40), (20, 4)])
@pytest.mark.parametrize("glyphs", [("d", ""), ("", "k"), ("d", "k")])
def test_a_glyph_is_drawn_in_its_own_half_and_stays_inside(
    size: tuple[int, int], glyphs: tuple[str, str]
) -> None:
    lines = drawn(glyphs, "Left: d  Right: k", size)
    wall = (size[0] - 1) // 2
    assert all(line[wall] == "│" for line in lines[:3])
    assert (lines[0][:wall].strip(), lines[0][wall + 1 :].strip()) == ("Left", "Right")
    if size[1] >= 10:
        assert len(lines) == size[1]
        body = [line.ljust(size[0]) for line in lines[2:-2]]
        inked = (
            any(line[:wall].strip() for line in body),
            any(line[wall + 1 :].strip() for line in body),
        )
        assert inked == tuple(map(bool, glyphs))
        assert lines[-1].strip() == "Left: d  Right: k"


def test_without_glyphs_the_fixation_point_is_on_the_divider() -> None:
    lines = drawn((), "")
    assert [line.index(FIXATION) for line in lines if FIXATION in line] == [WALL]
    assert all("█" not in line for line in lines)
