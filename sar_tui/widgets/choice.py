"""A field for one of a few values, with a list that opens on demand."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from textual import on
from textual.binding import Binding, BindingType
from textual.content import Content
from textual.events import Click, Key
from textual.message import Message
from textual.reactive import reactive
from textual.widget import Widget

from sar_tui.widgets.lists import OptionList


class ChoiceList(OptionList):
    """List of the values. It closes when it loses the focus."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "close", "Close the list", id="close-list")
    ]

    def action_close(self) -> None:
        """Leave the value as it was."""
        if isinstance(self.parent, Choice):
            self.screen.set_focus(self.parent)
        elif self.parent:
            self.screen.set_focus(self.parent.query_exactly_one("Input"))

    def on_blur(self) -> None:
        """Close the list; a click on the value that caused this must not open it again."""
        self.suppress_click()
        self.remove()

    def on_key(self, event: Key) -> None:
        """Go to the next value that begins with the typed letter."""
        if not event.is_printable or event.key == "space":
            return
        event.stop()
        event.prevent_default()
        prompts = [str(option.prompt).lower() for option in self.options]
        start = (self.highlighted or 0) + 1
        for at in [*range(start, len(prompts)), *range(start)]:
            if prompts[at].startswith((event.character or "").lower()):
                self.highlighted = at
                return


class Choice(Widget, can_focus=True):
    """One line: the value, and an arrow that opens the others.

    Args:
        values: to choose from.
        value: the current one; it need not be one of ``values``.
        labels: values as they are shown; others are shown as they are.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("enter,space", "open", "Show", show=False, id="choices")
    ]
    ALLOW_SELECT = False
    DEFAULT_CSS = """
    Choice { height: 1; padding: 0 1 0 0; background: $surface; color: $foreground; pointer: pointer; }
    Choice:focus { background-tint: $foreground 5%; }
    Choice > ChoiceList {
        width: 1fr; height: auto; max-height: 12; overlay: screen; constrain: none inside; background: $surface;
    }
    Choice > ChoiceList > .option-list--option { padding: 0 1; }
    """

    value: reactive[str] = reactive("", init=False)

    class Changed(Message):
        """Another value was chosen."""

        def __init__(self, value: str) -> None:
            super().__init__()
            self.value = value

    def __init__(self, values: Sequence[str], value: str, labels: Mapping[str, str] = {}) -> None:
        super().__init__()
        self._values = values
        self._labels = labels
        self.set_reactive(Choice.value, value)

    def render(self) -> Content:
        """Draw the value, cut to fit, and the arrow."""
        arrow = "▲" if self.children else "▼"
        words = Content(self._label(self.value)).truncate(
            self.content_size.width - 2, ellipsis=True, pad=True
        )
        return Content.assemble(words, " ", (arrow, "$foreground 50%"))

    def _label(self, value: str) -> str:
        return self._labels.get(value, value)

    def watch_value(self) -> None:
        """Report the new value."""
        self.post_message(self.Changed(self.value))

    def action_open(self) -> None:
        """Show the list, with the cursor on the value."""
        if self.children:
            return
        values = ChoiceList(*(Content(self._label(value)) for value in self._values), compact=True)
        if self.value in self._values:
            values.highlighted = self._values.index(self.value)
        self.mount(values)
        values.focus(scroll_visible=False)
        self.refresh()

    def on_click(self, event: Click) -> None:
        """Open the list, as Enter does."""
        event.stop()
        self.action_open()

    @on(OptionList.OptionSelected)
    def _chosen(self, event: OptionList.OptionSelected) -> None:
        event.stop()
        self.value = self._values[event.option_index]
        self.focus()

    @on(OptionList.OptionHighlighted)
    def _looked_at(self, event: OptionList.OptionHighlighted) -> None:
        event.stop()
