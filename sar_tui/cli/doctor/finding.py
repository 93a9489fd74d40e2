"""A result of one check of ``sar-tui doctor``."""

from typing import Literal

import msgspec

State = Literal["ok", "care", "bad"]


class Finding(msgspec.Struct, frozen=True, rename={"advice": "mend"}):
    """The state of one thing. ``care``: it works, but could work better. ``advice``: what to do
    about it.
    """

    name: str
    state: State
    found: str
    advice: str = ""
