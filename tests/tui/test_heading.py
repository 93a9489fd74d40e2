"""A screen's sentence is drawn as large as the window allows, and its key stands above the footer."""

import pytest
from textual.app import App, ComposeResult
from textual.widgets import Footer

from sar_tui.tui.base_app import DESIGN
from sar_tui.tui.heading import Heading, in_blocks, spaced
from sar_tui.tui.key_line import KeyLine


class Page(App[None]):
    """A screen with a sentence and a key."""

    CSS_PATH = [DESIGN]

    def __init__(self, text: str, **how: object) -> None:
        super().__init__()
        self.heading = Heading(text, **how)  # type: ignore[arg-type]

    def compose(self) -> ComposeResult:
        yield self.heading
        yield KeyLine("Press Enter to go on.", "Enter")
        yield Footer()


@pytest.mark.parametrize(("size", "rows"), [((80, 24), 1), ((100, 30), 4), ((160, 48), 8)])
async def test_a_short_sentence_grows_with_the_window(size: tuple[int, int], rows: int) -> None:
    app = Page("Well done", largest=8)
    async with app.run_test(size=size) as pilot:
        await pilot.pause()
        assert app.heading.size.height == rows


async def test_the_key_is_in_the_row_above_the_footer() -> None:
    app = Page("Well done")
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()
        line, footer = app.query_one(KeyLine), app.query_one(Footer)
        assert line.region.bottom == footer.region.y
        left = line.render_line(0).text.index("Enter")
        assert 30 < left < 40


def test_a_long_sentence_is_broken_between_words_and_a_longer_one_is_not_drawn() -> None:
    assert len(in_blocks("How much pain do you have?", 160, 12)) == 9, "two lines of four rows"
    assert in_blocks("How much pain do you have?", 160, 8) == []
    long = "A sentence that goes on and on, and then on, and on again"
    assert in_blocks(long, 160, 9) == []
    assert len(in_blocks(long, 160, 20)) == 19, "four lines of four rows"


def test_a_text_without_large_letters_is_not_drawn() -> None:
    assert in_blocks("你好", 160, 20) == []
    assert in_blocks("", 160, 20) == []


def test_praise_is_spaced_where_there_is_room() -> None:
    assert spaced("Well done", 80) == "W E L L   D O N E"
    assert spaced("Well done", 10) == "Well done"
