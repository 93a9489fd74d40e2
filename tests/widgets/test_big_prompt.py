"""The big prompt: large, and as one plain line."""

import msgspec
import pytest
from rich.cells import cell_len
from textual.app import App, ComposeResult

from sar_tui.model.messages import Prompt
from sar_tui.widgets.big_prompt import BigPrompt, DrawPrompt
from sar_tui.widgets.prompt_lines import FIXATION, halves, plain_lines


def prompt(glyph: str, text: str, hint: str = "") -> Prompt:
    numbers = {"attempt": 1, "trial": 1, "presentation": 1, "level": 1, "choices": 1}
    shown = {"stimulus": glyph, "expected": glyph, "text": text, "glyph": glyph, "hint": hint}
    return Prompt(timeout=10**9, **numbers, **shown)  # type: ignore[arg-type]


class Stage(App[None]):
    def __init__(self, draw: DrawPrompt = plain_lines) -> None:
        super().__init__()
        self._draw_prompt = draw

    def compose(self) -> ComposeResult:
        yield BigPrompt(draw=self._draw_prompt)

    @property
    def lines(self) -> list[str]:
        shown = self.query_one(BigPrompt)
        return [shown.render_line(y).text for y in range(shown.size.height)]


@pytest.mark.parametrize("size", [(80, 15), (40, 10), (200, 60), (20, 4)])
async def test_a_prompt_is_drawn_large_above_its_plain_line(size: tuple[int, int]) -> None:
    app = Stage()
    async with app.run_test(size=size):
        app.query_one(BigPrompt).show(prompt("f", "Press: f", "with Shift"))
        stripped = [line.strip() for line in app.lines]
        assert stripped.count("Press: f") == 1
        assert all(len(line) == size[0] for line in app.lines)
        assert stripped[stripped.index("Press: f") + 1] == "with Shift"
        assert stripped[0] == "" or size[1] < 15


def test_halves_are_drawn_side_by_side_with_one_seat_too() -> None:
    both = msgspec.structs.replace(prompt("", "Press: f", ""), halves=("f", "←"))
    lines = [text for text, _ in plain_lines(both, 60, 20)]
    left, right = (
        "\n".join(part) for part in ([line[:29] for line in lines], [line[30:] for line in lines])
    )
    assert "█" in left
    assert "█" in right
    assert [line.strip() for line in lines].count("Press: f") == 1
    assert len(lines) <= 20


async def test_a_cleared_prompt_leaves_a_fixation_point() -> None:
    app = Stage()
    async with app.run_test(size=(80, 15)) as pilot:
        shown = app.query_one(BigPrompt)
        shown.show(prompt("f", "Press: f"))
        drawn = [y for y, line in enumerate(app.lines) if "█" in line]
        shown.clear()
        points = [(y, line.index(FIXATION)) for y, line in enumerate(app.lines) if FIXATION in line]
        assert len(points) == 1
        assert min(drawn) <= points[0][0] <= max(drawn)
        assert 38 <= points[0][1] <= 41
        await pilot.resize_terminal(100, 30)
        points = [line.index(FIXATION) for line in app.lines if FIXATION in line]
        assert len(points) == 1
        assert 48 <= points[0] <= 51


async def test_text_wider_than_the_screen_is_cut_not_wrapped() -> None:
    app = Stage()
    async with app.run_test(size=(10, 12)):
        app.query_one(BigPrompt).show(prompt("f", "Press: Backspace"))
        assert all(len(line) == 10 for line in app.lines)


async def test_a_task_can_draw_the_prompt_itself() -> None:
    def drawn(prompt: Prompt | None, width: int, height: int) -> list[tuple[str, bool]]:
        return [(f"{prompt.text if prompt else 'wait'} {width}x{height}", True)]

    app = Stage(drawn)
    async with app.run_test(size=(30, 5)) as pilot:
        assert app.lines[0].strip() == "wait 30x5"
        app.query_one(BigPrompt).show(prompt("f", "Press: f"))
        await pilot.resize_terminal(40, 5)
        assert app.lines[0].strip() == "Press: f 40x5"


@pytest.mark.parametrize("glyph", ["語", "語a🍎"])
@pytest.mark.parametrize("size", [(80, 15), (81, 16)])
async def test_wide_characters_stand_in_the_middle(glyph: str, size: tuple[int, int]) -> None:
    app = Stage()
    async with app.run_test(size=size):
        app.query_one(BigPrompt).show(prompt(glyph, f"Say: {glyph}"))
        assert all(cell_len(line) == size[0] for line in app.lines)
        (framed,) = [line for line in app.lines if f"│ {glyph} │" in line]
        left, _, right = framed.partition(f"│ {glyph} │")
        assert abs(len(left) - len(right)) <= 1
        regions = app.query_one(BigPrompt)._regions()
        strips = map(app.query_one(BigPrompt).render_line, range(size[1]))
        assert {strip.cell_length for strip in strips} == {size[0]}
        right = max(cell_len(line.rstrip()) for line in app.lines)
        assert max(region.right for region in regions) == right


def test_wide_characters_leave_the_wall_between_halves_where_it_is() -> None:
    both = msgspec.structs.replace(prompt("", "家 犬", ""), halves=("家", "犬 dog"))
    lines = [text for text, _ in plain_lines(both, 60, 20)]
    walls = {cell_len(line[: line.index(" │ ") + 1]) for line in lines if line.count("│") == 1}
    assert walls <= {29}
    assert any("│ 家 │" in line and "│ 犬 dog │" in line for line in lines)


WALL = 39
"""The column between the halves of a terminal of 80."""


def drawn(glyphs: tuple[str, ...], text: str, size: tuple[int, int] = (80, 15)) -> list[str]:
    return [line for line, _ in halves(glyphs, text, *size, ("Left", "Right"))]


@pytest.mark.parametrize("size", [(80, 15), (40, 10), (120, 40), (20, 4)])
@pytest.mark.parametrize("glyphs", [("d", ""), ("", "k"), ("d", "k")])
def test_a_glyph_stays_in_its_half(size: tuple[int, int], glyphs: tuple[str, str]) -> None:
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
