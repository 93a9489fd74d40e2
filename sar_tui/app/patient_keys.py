"""The keys that the screens of patient mode list."""

import dataclasses
from typing import Any

from textual.binding import ActiveBinding


def keys_in_mode(app: Any, bindings: dict[str, ActiveBinding]) -> dict[str, ActiveBinding]:
    """Return a screen's bindings; in patient mode the key that leaves the app, which does nothing
    there, is hidden.
    """
    return {
        key: active._replace(binding=dataclasses.replace(active.binding, show=False))
        if app.patient and active.binding.id == "quit"
        else active
        for key, active in bindings.items()
    }
