"""Compares derived messages with recorded ones, except for wording that only people read."""

from typing import Any

import msgspec

from sar_tui.framework.messages import Message

WORDING = frozenset({"text", "spoken", "hint", "notice", "detail", "goal", "attempt_name", "remark", "why"})
"""Fields whose texts are for people only, so that a corrected sentence does not prevent a resume."""


def is_same(recorded: Message, derived: Message) -> bool:
    """Return True if both messages are equal except for their wording."""
    if recorded == derived:
        return True
    return type(recorded) is type(derived) and _without_wording(recorded) == _without_wording(derived)


def _without_wording(message: Message) -> Any:
    return _blank(msgspec.to_builtins(message))


def _blank(value: Any) -> Any:
    """Replace each string under a wording field by an empty one, at any depth."""
    if isinstance(value, dict):
        return {name: "" if name in WORDING and isinstance(part, str) else _blank(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_blank(part) for part in value]
    return value
