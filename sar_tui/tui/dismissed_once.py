"""Screens that are closed once, although two keys of one burst ask for it."""

from typing import TypeVar

from textual.await_complete import AwaitComplete
from textual.screen import Screen

T = TypeVar("T")


class DismissedOnce(Screen[T]):
    """Base of screens that keys close: a second key of the same burst would close the screen below as well."""

    def dismiss(self, result: T | None = None) -> AwaitComplete:
        """Close the screen, unless that has been done or another screen covers it."""
        return super().dismiss(result) if self.is_current else AwaitComplete()
