"""Keys that are held, and keys that count.

Tells keys that are pressed for what stands on the screen from those that were pressed for what
stood there before.

One rule for all that a participant sees: a key that was down when it appeared, its repeats, and
presses within `UNREAD` of its appearance do nothing; and an attempt is begun only after `QUIET`
without keys.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Literal, NamedTuple

from sar_tui.model.units import MS

UNREAD = 600 * MS
"""Nobody has read what appeared and pressed a key for it within this time."""
QUIET = 700 * MS
"""Time without keys before the one that begins an attempt."""
_NEVER = -(2**63)


class GuardedPress(NamedTuple):
    """A press, judged by those before it.

    Attributes:
        is_new: it is no repeat of a key that is held, and not the second of a doubled press.
        counts: it, or the press that it repeats, was made for what is on the screen.
        is_left_over: it repeats a press from before that appeared.
        after_quiet: there was no key for `QUIET` before it.
    """

    is_new: bool
    counts: bool
    is_left_over: bool
    after_quiet: bool


class KeyGuard:
    """Judges presses in their order. All times are stamps of one clock, in ns."""

    def __init__(self, bounce: int = 0) -> None:
        self._bounce = bounce
        self.reset()

    @property
    def bounce(self) -> int:
        """The time within which two presses of one key are one."""
        return self._bounce

    @bounce.setter
    def bounce(self, bounce: int) -> None:
        self._bounce = self._held.bounce = bounce

    def reset(self) -> None:
        """Forget all: another run began, whose stamps cannot be compared."""
        self._appeared = _NEVER
        self._key = ""
        self._held = HeldKey(self._bounce)
        self._began = self._last = _NEVER

    def appeared(self, at: int) -> None:
        """Note that something else appeared on the screen."""
        self._appeared = at

    def press(self, key: str, at: int) -> GuardedPress:
        """Judge a press."""
        if key != self._key:
            self._key, self._held = key, HeldKey(self._bounce)
        is_new = self._held.press(at) != "held"
        if is_new:
            self._began = at
        after_quiet, self._last = at - self._last >= QUIET, max(at, self._last)
        age = self._began - self._appeared
        return GuardedPress(
            is_new,
            counts=age >= UNREAD,
            is_left_over=age <= 0 and not is_new,
            after_quiet=after_quiet,
        )


# --- a key that is held


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

    Args:
        bounce: a press within this time (ns) of the one before is a bounce: a part of it, as if the
            key were held.
    """

    def __init__(self, bounce: int = 0) -> None:
        self.bounce = bounce
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
        if last is not None and at - last < self.bounce:
            return "held"
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
