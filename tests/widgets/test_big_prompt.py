"""The big prompt: large, and as one plain line."""

import pytest
from textual.app import App, ComposeResult

from sar_tui.widgets.big_prompt import FIXATION, BigPrompt


class Stage(App[None]):
    def compose(self) -> ComposeResult:
        yield BigPrompt()

    @property
    def lines(self) -> list[str]:
        prompt = self.query_one(BigPrompt)
        return [prompt.render_line(y).text for y in range(prompt.size.height)]


@pytest.mark.parametrize("size", [(80, 15), (40, 10), (200, 60), (20, 4)])
async def test_a_prompt_is_drawn_large_above_its_plain_line_and_stays_inside(size: tuple[int, int]) -> None:
    app = Stage()
    async with app.run_test(size=size):
        app.query_one(BigPrompt).show("f", "Press: f", "with Shift")
        stripped = [line.strip() for line in app.lines]
        assert stripped.count("Press: f") == 1
        assert all(len(line) == size[0] for line in app.lines)
        assert stripped[stripped.index("Press: f") + 1] == "with Shift"
        assert stripped[0] == "" or size[1] < 15


async def test_a_cleared_prompt_leaves_a_fixation_point_where_the_glyph_was() -> None:
    app = Stage()
    async with app.run_test(size=(80, 15)) as pilot:
        prompt = app.query_one(BigPrompt)
        prompt.show("f", "Press: f")
        drawn = [y for y, line in enumerate(app.lines) if "█" in line]
        prompt.clear()
        points = [(y, line.index(FIXATION)) for y, line in enumerate(app.lines) if FIXATION in line]
        assert len(points) == 1
        assert min(drawn) <= points[0][0] <= max(drawn)
        assert 38 <= points[0][1] <= 41
        await pilot.resize_terminal(100, 30)
        points = [line.index(FIXATION) for line in app.lines if FIXATION in line]
        assert len(points) == 1
        assert 48 <= points[0] <= 51


async def test_text_that_is_wider_than_the_screen_is_cut_not_wrapped() -> None:
    app = Stage()
    async with app.run_test(size=(10, 12)):
        app.query_one(BigPrompt).show("f", "Press: Backspace")
        assert all(len(line) == 10 for line in app.lines)


# --- divided between two people ----------------------------------------------------------------------------------


class Divided(App[None]):
    def compose(self) -> ComposeResult:
        yield BigPrompt(names=("Left", "Right"))

    @property
    def lines(self) -> list[str]:
        prompt = self.query_one(BigPrompt)
        return [prompt.render_line(y).text for y in range(prompt.size.height)]


@pytest.mark.parametrize("size", [(80, 15), (40, 10), (120, 40), (20, 4)])
@pytest.mark.parametrize(
    ("halves", "drawn"), [(("d", ""), (True, False)), (("", "k"), (False, True)), (("d", "k"),) * 2]
)
async def test_a_half_shows_what_is_its_own_and_stays_inside(
    size: tuple[int, int], halves: tuple[str, str], drawn: tuple[object, object]
) -> None:
    app = Divided()
    async with app.run_test(size=size):
        app.query_one(BigPrompt).show("", "Left: d  Right: k", halves=halves)
        assert all(len(line) == size[0] for line in app.lines)
        wall = (size[0] - 1) // 2
        assert all(line[wall] == "│" for line in app.lines[:3])
        assert (app.lines[0][:wall].strip(), app.lines[0][wall + 1 :].strip()) == ("Left", "Right")
        if size[1] >= 10:
            body = app.lines[2:-2]
            inked = tuple(
                any(part.strip() for part in parts)
                for parts in zip(*((line[:wall], line[wall + 1 :]) for line in body), strict=True)
            )
            assert inked == tuple(map(bool, drawn))
            assert app.lines[-1].strip() == "Left: d  Right: k"


async def test_a_divided_prompt_that_is_cleared_has_its_fixation_point_on_the_wall() -> None:
    app = Divided()
    async with app.run_test(size=(80, 15)):
        prompt = app.query_one(BigPrompt)
        prompt.show("", "Left: d", halves=("d", ""))
        prompt.clear()
        points = [(y, line.index(FIXATION)) for y, line in enumerate(app.lines) if FIXATION in line]
        assert [x for _, x in points] == [39]
        assert all("█" not in line for line in app.lines)


async def test_the_name_of_a_half_can_tell_whose_turn_it_is_and_a_prompt_stays_up() -> None:
    app = Divided()
    async with app.run_test(size=(80, 15)):
        prompt = app.query_one(BigPrompt)
        prompt.show("", "Left: d", halves=("d", ""))
        prompt.name_halves(("Left: your turn", "Right"))
        assert app.lines[0].split("│")[0].strip() == "Left: your turn"
        assert any("█" in line for line in app.lines)
