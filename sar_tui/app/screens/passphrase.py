"""Asks for the therapist's passphrase."""

import math
from typing import ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static

from sar_tui.model.language import in_language
from sar_tui.store.database import StoreError
from sar_tui.store.passphrase import Passphrase
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.language import language_of

_LONGEST = 200
_SHOWN_SECONDS = 60.0
"""Without a key for this long the question goes away: a participant may have opened it by
mistake.
"""


class PassphraseScreen(DismissedOnce[bool], ModalScreen[bool]):
    """Asks for the passphrase; the result is True if it was right. Enter on an empty field goes
    back.

    Args:
        passphrase: of the data folder.
        where: what it opens, for the log of the tries.
    """

    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape", "back", "Back", id="back")]

    def __init__(self, passphrase: Passphrase, where: str) -> None:
        super().__init__()
        self._passphrase = passphrase
        self._where = where

    def compose(self) -> ComposeResult:
        self.tr = language_of(self.app)
        with Vertical(id="passphrase"):
            yield Static(self.tr("For the therapist"), classes="headline", markup=False)
            yield Static(self.tr("Please enter the passphrase."), markup=False)
            yield Input(password=True, max_length=_LONGEST, id="secret")
            yield Static("", id="problem", markup=False)
            yield Static(self.tr("Enter: confirm. Esc: back."), classes="muted", markup=False)

    def on_mount(self) -> None:
        self._idle = self.set_timer(_SHOWN_SECONDS, self.action_back)
        self.set_interval(1.0, self._show_wait)
        self._is_waiting = False
        self._show_wait()

    def action_back(self) -> None:
        """Go back without a passphrase."""
        self.dismiss(False)

    @on(Input.Changed)
    def _typed(self) -> None:
        self._idle.reset()

    @on(Input.Submitted)
    def _entered(self, event: Input.Submitted) -> None:
        event.stop()
        if not event.value:
            self.action_back()
            return
        self.query_one(Input).value = ""
        if self._passphrase.wait_s > 0:
            self._show_wait()
            return
        try:
            is_right = self._passphrase.check(event.value, self._where)
        except StoreError as error:
            self._say(in_language(error, self.tr))
            return
        if is_right:
            self.dismiss(True)
        else:
            self._say(self.tr("That is not the passphrase."))
            self._show_wait()

    def _show_wait(self) -> None:
        """Say how long the next try has to wait, as long as it has to."""
        if (wait := self._passphrase.wait_s) > 0:
            self._is_waiting = True
            self._say(self.tr("Please wait {seconds} s, then try again.", seconds=math.ceil(wait)))
        elif self._is_waiting:
            self._is_waiting = False
            self._say("")

    def _say(self, text: str) -> None:
        self.query_one("#problem", Static).update(text)
