"""Screens that close themselves only, although two keys of one burst ask for it."""

from typing import TypeVar

from textual.await_complete import AwaitComplete
from textual.screen import Screen

T = TypeVar("T")


class DismissedOnce(Screen[T]):
    """Base of screens that keys close.

    `Screen.dismiss` closes whatever screen is on top. That is another one if a second key of the
    same burst asks for it, or if a dialog was opened after the key was typed and before it was
    handled.
    """

    def dismiss(self, result: T | None = None) -> AwaitComplete:
        """Close the screen, unless that has been done or another screen covers it; once it has all
        its parts.
        """
        # closed while it opens, it would look for parts that it does not get any more
        if not self.is_mounted:
            self.call_later(self._dismiss_now, result)
            return AwaitComplete()
        return super().dismiss(result) if self.is_active else AwaitComplete()

    def _dismiss_now(self, result: T | None) -> None:
        self.dismiss(result)  # not awaited, as the screen itself calls it
