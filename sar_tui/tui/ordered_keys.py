"""Handles each key completely before the next, also if many arrive at once: over a slow line, or
pasted.
"""

from typing import Any, TypeVar

from textual import events
from textual.app import App
from textual.screen import Screen

T = TypeVar("T")


class OrderedScreen(Screen[T]):
    """A screen on which a key may open a text field, so that the keys after it in the same burst
    are typed there.

    Textual queues a key for the focused widget, so that keys read together would all go to the
    widget that had the focus before the first of them.
    """

    def takes(self, event: events.Key | events.Paste) -> bool:
        """Type a key if a field takes it; return True if so. Other keys are looked up in the
        bindings: here, all.
        """
        return False


async def in_order(app: App[Any], event: events.Event) -> bool:
    """Handle a key on an `OrderedScreen` at once; returns True if it was handled."""
    if not isinstance(event, (events.Key, events.Paste)) or event.is_forwarded:
        return False
    screen = app.screen
    if not isinstance(screen, OrderedScreen):
        return False
    app.app_focus = True
    if not screen.takes(event) and isinstance(event, events.Key):
        for is_first in (True, False):
            if await app._check_bindings(event.key, priority=is_first):
                break
    return True
