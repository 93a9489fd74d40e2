"""Compares derived messages with recorded ones, except for wording that only people read, and for absent values."""

from typing import Any

import msgspec

from sar_tui.framework.messages import Message, TrialEnded

WORDING = frozenset({"text", "spoken", "hint", "notice", "detail", "goal", "attempt_name", "remark", "advice", "why"})
"""Fields whose texts are for people only, so that a corrected sentence does not prevent a resume."""


def is_same(recorded: Message, derived: Message) -> bool:
    """Return True if both messages are equal except for their wording and the way in which a value is absent."""
    if recorded == derived:
        return True
    return type(recorded) is type(derived) and _without_wording(recorded) == _without_wording(derived)


def _without_wording(message: Message) -> Any:
    values = _blank(msgspec.to_builtins(message))
    if isinstance(message, TrialEnded):  # earlier versions stored absent details, and empty responses, in two ways
        values["response"] = message.response or None
        values["details"] = {name: value for name, value in values["details"].items() if value is not None}
    return values


def _blank(value: Any) -> Any:
    """Replace each string under a wording field by an empty one, at any depth."""
    if isinstance(value, dict):
        return {name: "" if name in WORDING and isinstance(part, str) else _blank(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_blank(part) for part in value]
    return value
