"""Compares derived messages with recorded ones, except for wording that only people read, and for
absent values.

Numbers may differ in their last digits: another version of NumPy, or another processor, rounds
logarithms and Fourier transforms differently, and must not keep a session from being resumed.
"""

import math
from collections import deque
from collections.abc import Iterable
from typing import Any, NamedTuple

import msgspec

from sar_tui.loop.bus import Record
from sar_tui.model.messages import Fault, Message

WORDING = frozenset(
    {
        "text",
        "spoken",
        "hint",
        "notice",
        "detail",
        "goal",
        "attempt_name",
        "remark",
        "advice",
        "why",
    }
)
"""Fields whose texts are for people only, so that a corrected sentence does not prevent a
resume.
"""

ROUNDING = 1e-9
"""Largest difference of two numbers, relative and absolute, that comes from rounding."""


class Difference(NamedTuple):
    """The first message that is not as recorded. ``recorded`` or ``derived`` is None if one of them
    is missing.
    """

    recorded: Record | None
    derived: Record | None

    @property
    def seq(self) -> int:
        """The number of the message."""
        return (self.recorded or self._only_derived).seq

    @property
    def topic(self) -> str:
        """The name of the topic of the recorded message, or of the derived one if nothing was
        recorded.
        """
        return (self.recorded or self._only_derived).topic.name

    @property
    def _only_derived(self) -> Record:
        assert self.derived
        return self.derived


class Comparison:
    """Compares a record with what nodes derive, as far as there are both.

    Attributes:
        same: number of messages that are as recorded.
        difference: the first difference; None if there is none yet.
    """

    def __init__(self) -> None:
        self.same = 0
        self.difference: Difference | None = None
        self._recorded: deque[Record] = deque()
        self._derived: deque[Record] = deque()

    def expect(self, record: Record) -> None:
        """Add a recorded message."""
        self._recorded.append(record)

    def derive(self, records: Iterable[Record]) -> None:
        """Add messages that the nodes derived, and compare as far as there are both."""
        self._derived.extend(records)
        while self._recorded and self._derived and not self.difference:
            was, now = self._recorded.popleft(), self._derived.popleft()
            if was.topic is now.topic and is_same(was.message, now.message):
                self.same += 1
            else:
                self.difference = Difference(was, now)

    def finish(self) -> None:
        """Note what is left over: it was recorded and not derived, or derived and not recorded."""
        if not self.difference and (self._recorded or self._derived):
            self.difference = Difference(
                self._recorded[0] if self._recorded else None,
                self._derived[0] if self._derived else None,
            )


def is_same(recorded: Message, derived: Message) -> bool:
    """Return True if both messages are equal except for wording, rounding and the way in which a
    value is absent.
    """
    if recorded == derived:
        return True
    return type(recorded) is type(derived) and _is_close(
        _without_wording(recorded), _without_wording(derived)
    )


def _without_wording(message: Message) -> Any:
    values = _blank(msgspec.to_builtins(message))
    if isinstance(message, Fault):  # where the code stands, on the machine of the session
        values["place"] = values["trace"] = ""
    return values


def _is_close(recorded: Any, derived: Any) -> bool:
    """Compare two values of dictionaries, lists and numbers."""
    match recorded, derived:
        case (dict(), dict()):
            same_names = recorded.keys() == derived.keys()
            return same_names and all(_is_close(recorded[name], derived[name]) for name in derived)
        case (list(), list()):
            return len(recorded) == len(derived) and all(map(_is_close, recorded, derived))
        case (float(), float()):
            return math.isclose(recorded, derived, rel_tol=ROUNDING, abs_tol=ROUNDING)
    return bool(recorded == derived)


def _blank(value: Any) -> Any:
    """Replace each string under a wording field by an empty one, at any depth."""
    if isinstance(value, dict):
        return {
            name: "" if name in WORDING and isinstance(part, str) else _blank(part)
            for name, part in value.items()
        }
    if isinstance(value, list | tuple):
        return [_blank(part) for part in value]
    return value
