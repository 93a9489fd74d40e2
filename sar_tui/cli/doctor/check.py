"""What `sar-tui doctor` has to say of one thing."""

from typing import Literal

import msgspec

State = Literal["ok", "care", "bad"]


class Finding(msgspec.Struct, frozen=True):
    """What was found. ``care``: it works, but not as well as it might; ``mend`` says what to do."""

    name: str
    state: State
    found: str
    mend: str = ""
