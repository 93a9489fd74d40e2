"""Tells a key that is held down from one that is tapped. A terminal reports presses only, never
releases.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Literal

from sar_tui.model.units import MS

LONGEST_DELAY = 700 * MS
"""A press within this time of the one before may be the first repeat of a held key: keyboards begin
to repeat after 250 to 660 ms.
"""
LONGEST_INTERVAL = 250 * MS
"""Repeats of a held key are closer together than this."""

STREAM, STREAM_LASTS = 5, 220 * MS
"""So many presses of one key within this time, about 20 a second, are made by the keyboard: no
finger taps half as often again as the fastest, 12 a second.
"""
_NEIGHBOUR = 75 * MS
"""A repeat is as close as this to the one before or after it, also if a busy machine reads some of
them late.
"""

Press = Literal["first", "held", "tapped"]


class HeldKey:
    """Judges the presses of one key.

    A held key begins to repeat after one longer time, and then repeats quickly. A second longer
    time in succession means that the key is released in between.
    """

    def __init__(self) -> None:
        self._last: int | None = None
        self._was_longer = False

    def release(self) -> None:
        """Forget the last press: another run began, whose stamps cannot be compared."""
        self._last, self._was_longer = None, False

    def press(self, at: int) -> Press:
        """Return how the key was pressed at ``at`` (ns): first for a while, perhaps held, or tapped
        again.
        """
        last, self._last = self._last, at
        was_longer, self._was_longer = self._was_longer, False
        if last is None or at - last >= LONGEST_DELAY:
            return "first"
        self._was_longer = at - last >= LONGEST_INTERVAL
        return "tapped" if was_longer and self._was_longer else "held"


def is_stream(stamps: Sequence[int]) -> bool:
    """Return True if the last presses of a key, at these times (ns), come as fast as a held key is
    repeated.
    """
    return len(stamps) >= STREAM and stamps[-1] - stamps[-STREAM] <= STREAM_LASTS


def repeats(stamps: Sequence[int]) -> set[int]:
    """Return those of the presses of one key (ns, in order) that its keyboard made while it was
    held.

    The first of them comes a good while after the key went down, so it can be told from a tap by
    what follows only.
    """
    fast = {
        each
        for first in range(len(stamps) - STREAM + 1)
        if is_stream(stamps[first : first + STREAM])
        for each in range(first, first + STREAM)
    }
    close = [after - before <= _NEIGHBOUR for before, after in pairwise(stamps)]
    found = {at for at in fast if any(close[max(0, at - 1) : at + 1])}
    return {stamps[at] for at in found if at > 0}
