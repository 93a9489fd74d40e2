"""Finds a setting by a word of its title, its name or its help."""

from collections.abc import Sequence
from typing import ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.content import Content
from textual.screen import ModalScreen
from textual.widgets import Input, Static
from textual.widgets.option_list import Option

from sar_tui.model.language import Language
from sar_tui.rules.declaration import Field
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.option_list import OptionList


def matching(fields: Sequence[Field], typed: str) -> list[Field]:
    """Return the fields that have every typed word: first that of this name, then those with a word
    in their title.
    """
    words = typed.lower().split()

    def text(field: Field) -> str:
        return f"{field.title} {field.name} {field.group} {field.help}".lower()

    found = [field for field in fields if all(word in text(field) for word in words)]

    def rank(field: Field) -> int:
        return (
            0
            if words == [field.name]
            else 1
            if any(word in field.title.lower() for word in words)
            else 2
        )

    return sorted(found, key=rank)


class FindSettingScreen(DismissedOnce[str | None], ModalScreen[str | None]):
    """Asks for a word, and lists the settings that have it; its result is the name of one, or None.

    Args:
        fields: the settings.
        own: the heading of those that have none.
        tr: the language of the settings.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(None)", "Cancel", id="cancel"),
        Binding("down", "move(1)", "Next", show=False, id="find-next"),
        Binding("up", "move(-1)", "Previous", show=False, id="find-previous"),
    ]

    def __init__(self, fields: Sequence[Field], own: str, tr: Language) -> None:
        super().__init__()
        self.tr = tr
        self._fields = tuple(fields)
        self._own = own

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog"):
            yield Static(self.tr("Find a setting"), classes="headline")
            yield Input(placeholder=self.tr("a word, such as goal"), id="word")
            found = OptionList(id="found", markup=False, compact=True)
            found.can_focus = False
            yield found
            yield Static(
                self.tr("Type a word, choose with the arrows, Enter goes there, Esc cancels."),
                classes="muted",
            )

    def on_mount(self) -> None:
        self._find("")

    @on(Input.Changed)
    def _typed(self, event: Input.Changed) -> None:
        self._find(event.value)

    def _find(self, typed: str) -> None:
        found = self.query_one("#found", OptionList)
        found.clear_options()
        lines = [
            (field.name, f"{field.title:<26}{field.group or self._own}")
            for field in matching(self._fields, typed)
        ]
        found.add_options([Option(Content(line), id=name) for name, line in lines])
        found.highlighted = 0 if lines else None

    def action_move(self, step: int) -> None:
        """Move the cursor in the list; the focus stays in the input."""
        found = self.query_one("#found", OptionList)
        if found.option_count:
            found.highlighted = ((found.highlighted or 0) + step) % found.option_count

    @on(Input.Submitted)
    def _go(self) -> None:
        found = self.query_one("#found", OptionList)
        if found.highlighted is not None:
            self.dismiss(found.get_option_at_index(found.highlighted).id)

    @on(OptionList.OptionSelected)
    def _clicked(self, event: OptionList.OptionSelected) -> None:
        self.dismiss(event.option.id)
