"""Question before a session is left."""

from typing import ClassVar, Literal, cast

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.screen import ModalScreen
from textual.widgets.option_list import Option

from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.language import language_of
from sar_tui.widgets.option_list import OptionList

Leaving = Literal["go on", "leave", "mistake"]
"""To go on; to leave the session for now; to leave it, as it was started by mistake."""
BY_MISTAKE = "It was started by mistake"


class LeaveScreen(DismissedOnce[Leaving], ModalScreen[Leaving]):
    """Asks whether to leave the session; the result says how. To go on is chosen at first.

    Args:
        can_save: False if the disk cannot be written to.
        may_be_mistake: True in the first attempt, when the session may have been started by
            mistake.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss('go on')", "Go on", id="go-on")
    ]

    def __init__(self, *, can_save: bool = True, may_be_mistake: bool = False) -> None:
        super().__init__()
        self._can_save = can_save
        self._may_be_mistake = may_be_mistake

    def compose(self) -> ComposeResult:
        tr = language_of(self.app)
        kept = tr("What you did is kept. You can go on with this session later.")
        if not self._can_save:
            kept = tr("Your last answer may not be saved yet. If you leave now, it may be lost.")
        menu = OptionList(
            Option(f"{kept}\n", disabled=True),
            Option(tr("Go on"), id="go on"),
            Option(tr("Yes, leave"), id="leave"),
            *(
                [Option(tr(BY_MISTAKE), id="mistake")]
                if self._may_be_mistake and self._can_save
                else []
            ),
            id="leave",
            markup=False,
        )
        menu.border_title = tr("Leave now?")
        menu.border_subtitle = tr("arrows to choose, Enter to confirm")
        menu.highlighted = 1
        yield menu

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        event.stop()
        self.dismiss(cast(Leaving, event.option.id))
