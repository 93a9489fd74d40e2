"""Tells a key that is held down from one that is tapped. A terminal reports presses only, never releases."""

from typing import Literal

from sar_tui.framework.clock import MS

LONGEST_DELAY = 700 * MS
"""A press within this time of the one before may be the first repeat of a held key: keyboards begin to repeat after 250
to 660 ms."""
LONGEST_INTERVAL = 250 * MS
"""Repeats of a held key are closer together than this."""

Press = Literal["first", "held", "tapped"]


class HeldKey:
    """Judges the presses of one key.

    A held key begins to repeat after one longer time, and then repeats quickly. A second longer time in succession
    means that the key is released in between.
    """

    def __init__(self) -> None:
        self._last: int | None = None
        self._was_longer = False

    def release(self) -> None:
        """Forget the last press: another run began, whose stamps cannot be compared."""
        self._last, self._was_longer = None, False

    def press(self, at: int) -> Press:
        """Return how the key was pressed at ``at`` (ns): first for a while, perhaps held, or tapped again."""
        last, self._last = self._last, at
        was_longer, self._was_longer = self._was_longer, False
        if last is None or at - last >= LONGEST_DELAY:
            return "first"
        self._was_longer = at - last >= LONGEST_INTERVAL
        return "tapped" if was_longer and self._was_longer else "held"
