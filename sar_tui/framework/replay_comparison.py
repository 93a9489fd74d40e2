"""Compares derived messages with recorded ones, except for wording that only people read, and for absent values.

Numbers may differ in their last digits: another version of NumPy, or another processor, rounds logarithms and Fourier
transforms differently, and must not keep a session from being resumed.
"""

import math
from typing import Any

import msgspec

from sar_tui.framework.messages import Message, TrialEnded

WORDING = frozenset({"text", "spoken", "hint", "notice", "detail", "goal", "attempt_name", "remark", "advice", "why"})
"""Fields whose texts are for people only, so that a corrected sentence does not prevent a resume."""

ROUNDING = 1e-9
"""Largest difference of two numbers, relative and absolute, that comes from rounding."""


def is_same(recorded: Message, derived: Message) -> bool:
    """Return True if both messages are equal except for wording, rounding and the way in which a value is absent."""
    if recorded == derived:
        return True
    return type(recorded) is type(derived) and _is_close(_without_wording(recorded), _without_wording(derived))


def _without_wording(message: Message) -> Any:
    values = _blank(msgspec.to_builtins(message))
    if isinstance(message, TrialEnded):  # earlier versions stored absent details, and empty responses, in two ways
        values["response"] = message.response or None
        values["details"] = {name: value for name, value in values["details"].items() if value is not None}
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
        return {name: "" if name in WORDING and isinstance(part, str) else _blank(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_blank(part) for part in value]
    return value
