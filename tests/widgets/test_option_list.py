from typing import Any

from rich.style import Style
from textual import events
from textual.app import App, ComposeResult

from sar_tui.widgets.option_list import OptionList


class OneList(App[Any]):
    selected = 0

    def compose(self) -> ComposeResult:
        yield OptionList("one", "two", "three")

    def on_option_list_option_selected(self) -> None:
        self.selected += 1


async def test_a_click_at_an_option_that_has_been_taken_away_selects_nothing() -> None:
    app = OneList()
    async with app.run_test() as pilot:
        options = app.query_one(OptionList)
        options.clear_options().add_option("another")
        for index in (2, 0):
            how = {"screen_x": 1, "screen_y": 1, "style": Style(meta={"option": index})}
            options.post_message(events.Click(options, 1, 1, 0, 0, 1, False, False, False, **how))
        await pilot.pause()
        assert app.selected == 1
