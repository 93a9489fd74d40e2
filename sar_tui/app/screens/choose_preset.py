"""Offers the presets of a task."""

from collections.abc import Mapping
from typing import ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.content import Content
from textual.screen import ModalScreen
from textual.widgets import Static
from textual.widgets.option_list import Option

from sar_tui.model.language import Language
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.option_list import OptionList


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
