"""Dialogs of the settings: find one, choose a preset, say why they change."""

from collections.abc import Mapping, Sequence
from typing import ClassVar, NamedTuple

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
from sar_tui.store.programmes import LONGEST_TEXT
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.lists import OptionList


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


_LINES = 8
"""Largest number of changes that are listed."""


class Reason(NamedTuple):
    """Why a programme changes, and who changes it."""

    reason: str
    author: str


class SaveReasonScreen(DismissedOnce[Reason | None], ModalScreen[Reason | None]):
    """Lists the changes, and asks for a reason; its result is None if nothing is to be saved.

    Args:
        changes: in words.
        author: the name to begin with.
        warning: shown first; empty for none.
        tr: the language of the changes.
        what: is done; empty: the settings change.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(None)", "Cancel", id="cancel"),
        Binding("down", "app.focus_next", "Next", show=False, id="down"),
        Binding("up", "app.focus_previous", "Previous", show=False, id="up"),
    ]

    def __init__(
        self, changes: Sequence[str], author: str, warning: str, tr: Language, what: str = ""
    ) -> None:
        super().__init__()
        self.tr = tr
        self._changes = changes
        self._author = author
        self._warning = warning
        self._what = what

    def compose(self) -> ComposeResult:
        tr = self.tr
        listed = [f"● {change}" for change in self._changes[:_LINES]]
        if (more := len(self._changes) - _LINES) > 0:
            listed.append("  " + tr("and {count} more", count=more))
        with Vertical(classes="dialog"):
            yield Static(self._what or tr("Why this change?"), classes="headline", markup=False)
            if self._warning:
                yield Static(self._warning, id="warning", markup=False)
            yield Static("\n".join(listed), id="changes", markup=False)
            yield Input(
                placeholder=tr("such as: reached the goal four times"),
                max_length=LONGEST_TEXT,
                id="reason",
            )
            yield Static(tr("Your name or initials:"), markup=False)
            yield Input(self._author, max_length=80, id="author", compact=True)
            yield Static("", id="problem", markup=False)
            yield Static(tr("Enter saves, Esc goes back to the settings."), classes="muted")

    @on(Input.Submitted)
    def _save(self) -> None:
        reason = self.query_one("#reason", Input).value.strip()
        if not reason:
            self.query_one("#problem", Static).update(self.tr("A few words are enough."))
            self.query_one("#reason", Input).focus()
            return
        self.dismiss(Reason(reason, self.query_one("#author", Input).value.strip()))


class ChoosePresetScreen(DismissedOnce[str | None], ModalScreen[str | None]):
    """A list of presets; its result is the name of one, or None.

    Args:
        summaries: of each preset, by its name.
        tr: the language of the settings.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(None)", "Cancel", id="cancel")
    ]

    def __init__(self, summaries: Mapping[str, str], tr: Language) -> None:
        super().__init__()
        self.tr = tr
        self._summaries = summaries

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog"):
            yield Static(self.tr("Which preset?"), classes="headline")
            yield Static(
                self.tr(
                    "It sets all but what is of the person or the place. Nothing is saved yet."
                ),
                markup=False,
            )
            options = [
                Option(Content(f"{name}\n  {text}"), id=name)
                for name, text in self._summaries.items()
            ]
            yield OptionList(*options, id="presets", markup=False)
            yield Static(self.tr("Arrows and Enter to choose, Esc to cancel."), classes="muted")

    @on(OptionList.OptionSelected)
    def _chosen(self, event: OptionList.OptionSelected) -> None:
        self.dismiss(event.option.id)
