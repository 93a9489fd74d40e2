"""The parts of a difficulty policy."""

from collections.abc import Callable
from typing import Any, NamedTuple

import msgspec

from sar_tui.framework.declaration import Settings
from sar_tui.framework.messages import Outcome


class Difficulty(msgspec.Struct, frozen=True):
    """The level of the next attempt.

    ``memory`` is the policy's own state. It is None at the start of a session and after an operator sets the level.
    """

    level: int
    memory: Any = None


class Bounds(NamedTuple):
    """The lowest and the highest level, inclusive."""

    lowest: int
    highest: int


class DifficultyPolicy(NamedTuple):
    """A rule for the level of the next attempt.

    ``step`` returns the difficulty after one more attempt, from the one before, the attempt's outcome, the policy's own
    ``settings`` and the bounds. It must be pure: a resumed session computes it again.
    """

    step: Callable[[Difficulty, Outcome, Any, Bounds], Difficulty]
    settings: type[Settings] = Settings
