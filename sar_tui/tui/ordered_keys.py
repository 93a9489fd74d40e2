"""Each key is done with before the next is looked at, also where many come at once: over a slow line, or pasted."""

from typing import Any, TypeVar

from textual import events
from textual.app import App
from textual.screen import Screen

T = TypeVar("T")


class OrderedScreen(Screen[T]):
    """A screen whose keys may ask for words: those that follow in the same burst are these words.

    Textual puts a key on the queue of what has the focus, so that keys which are read together go where the focus was
    before the first of them.
    """

    def takes(self, event: events.Key | events.Paste) -> bool:
        """Type it, if it is to be typed; whether it was. A key that is not is looked for among the bindings."""
        raise NotImplementedError


async def in_order(app: App[Any], event: events.Event) -> bool:
    """Do at once what a key means on an `OrderedScreen`; whether there is nothing more to be done about it."""
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
