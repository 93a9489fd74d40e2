"""The dialogs of the screen on which reaches are corrected."""

import re
from typing import Any, ClassVar, Literal

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static
from textual.widgets.option_list import Option

from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.language import language_of
from sar_tui.widgets.lists import OptionList

Answer = Literal["save", "leave", "go on"]


def seconds_of(text: str) -> float | None:
    """Return a time that was typed, such as ``1:02:03.5``, ``2:03`` or ``123``, in s; None if it is
    none.
    """
    if not re.fullmatch(r"(\d{1,6}:){0,2}\d{1,9}([.,]\d{1,6})?", text.strip(), re.ASCII):
        return None
    seconds = 0.0
    for part in text.strip().replace(",", ".").split(":"):
        seconds = 60 * seconds + float(part)
    return seconds


class GoToScreen(DismissedOnce[float | None], ModalScreen[float | None]):
    """Asks for a time in the recording; its result is in s, or None."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(None)", "Cancel", id="cancel")
    ]

    app: Any

    def compose(self) -> ComposeResult:
        tr = language_of(self.app)
        with Vertical(classes="dialog"):
            yield Static(tr("Which time in the recording?"), classes="headline", markup=False)
            yield Input(placeholder="12:30", max_length=20)
            yield Static("", id="problem", classes="needs-a-look", markup=False)
            yield Static(tr("Press Enter to go there, Esc to cancel."), classes="muted")

    @on(Input.Submitted)
    def _go(self, event: Input.Submitted) -> None:
        seconds = seconds_of(event.value)
        if seconds is None:
            tr = language_of(self.app)
            said = tr("Type minutes and seconds, such as 12:30.")
            self.query_one("#problem", Static).update(said)
        else:
            self.dismiss(seconds)


class UnsavedScreen(DismissedOnce[Answer], ModalScreen[Answer]):
    """Asks what to do with corrections that could not be saved, and tells why."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss('go on')", "Go on", id="go-on")
    ]

    def __init__(self, why: str) -> None:
        super().__init__()
        self._why = why

    def compose(self) -> ComposeResult:
        tr = language_of(self.app)
        menu = OptionList(
            Option(f"{self._why}\n", disabled=True),
            Option(tr("Save and leave"), id="save"),
            Option(tr("Leave without saving"), id="leave"),
            Option(tr("Go on"), id="go on"),
            id="unsaved",
            markup=False,
        )
        menu.border_title = tr("Your corrections are not saved.")
        menu.border_subtitle = tr("arrows to choose, Enter to confirm")
        menu.highlighted = 1
        yield menu

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        event.stop()
        answers: dict[str | None, Answer] = {"save": "save", "leave": "leave"}
        self.dismiss(answers.get(event.option.id, "go on"))
