"""The footer is composed only when its keys change; lists turn over by pages at any time."""

from typing import Any, ClassVar

from rich.style import Style
from textual import events
from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.pilot import Pilot
from textual.widgets import Button

from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.lists import OptionList


class Saving(App[None]):
    """Two buttons, and a key that works only while there is something to save."""

    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+s", "save", "Save"),
        Binding("escape", "back", "Back"),
        Binding("x", "back", "Hidden", show=False),
    ]
    can_save: bool | None = False

    def compose(self) -> ComposeResult:
        yield Button("One")
        yield Button("Two")
        yield KeyFooter()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        return self.can_save if action == "save" else True

    @property
    def keys(self) -> dict[str, bool]:
        """The descriptions of the keys shown, with True if the key works."""
        return {key.description: not key._disabled for key in self.query("FooterKey")}  # type: ignore[attr-defined]


async def composed(app: Saving, pilot: Pilot[None]) -> None:
    """Wait until the footer shows its keys."""
    await pilot.pause()
    while not app.keys:
        await pilot.pause()


async def test_it_lists_the_keys_that_work() -> None:
    app = Saving()
    async with app.run_test() as pilot:
        await composed(app, pilot)
        assert app.keys == {"Back": True}
        for can_save, keys in (
            (True, {"Save": True, "Back": True}),
            (None, {"Save": False, "Back": True}),
        ):
            app.can_save = can_save
            app.refresh_bindings()
            await pilot.pause()
            assert app.keys == keys


async def test_it_keeps_its_widgets_while_the_focus_moves() -> None:
    app = Saving()
    async with app.run_test() as pilot:
        await composed(app, pilot)
        before, focused = list(app.query("FooterKey")), app.focused
        await pilot.press("tab")
        await pilot.pause()
        assert app.focused is not focused
        assert list(app.query("FooterKey")) == before


async def test_its_keys_can_be_clicked() -> None:
    app = Saving()
    app.can_save = True
    pressed: list[str] = []
    app.action_save = lambda: pressed.append("save")  # type: ignore[attr-defined]
    async with app.run_test() as pilot:
        await composed(app, pilot)
        back, save = app.query("FooterKey")
        assert app.keys == {"Back": True, "Save": True}
        assert back.region.x < save.region.x, "the way back comes first"
        await pilot.click(save)
    assert pressed == ["save"]


class Plain(App[None]):
    """No keys of its own, only the command palette."""

    def compose(self) -> ComposeResult:
        yield KeyFooter()


async def test_without_other_keys_the_palette_is_shown() -> None:
    app = Plain()
    async with app.run_test() as pilot:
        await pilot.pause()
        await pilot.pause()
        assert "palette" in [key.description for key in app.query("FooterKey")]  # type: ignore[attr-defined]


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
