"""Tells keys that are pressed for what stands on the screen from those that were pressed for what
stood there before.

One rule for all that a participant sees: a key that was down when it appeared, its repeats, and
presses within `UNREAD` of its appearance do nothing; and an attempt is begun only after `QUIET`
without keys.
"""

from typing import NamedTuple

from sar_tui.model.units import MS
from sar_tui.rules.held_key import HeldKey

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

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all: another run began, whose stamps cannot be compared."""
        self._appeared = _NEVER
        self._key = ""
        self._held = HeldKey()
        self._began = self._last = _NEVER

    def appeared(self, at: int) -> None:
        """Note that something else appeared on the screen."""
        self._appeared = at

    def press(self, key: str, at: int) -> GuardedPress:
        """Judge a press."""
        if key != self._key:
            self._key, self._held = key, HeldKey()
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
