"""Data of prompts: what a task keeps with a trial and never shows."""

from typing import Any

import msgspec

LONGEST_DATA = 10_000
"""Most bytes that the data of one prompt take as JSON."""


def problem(data: dict[str, Any]) -> str:
    """Return a sentence that says why the data of a prompt cannot be stored as they are; empty if
    they can.
    """
    if not isinstance(data, dict):
        return f"The data of a prompt are a dictionary, not {data!r:.60}."
    try:
        stored = msgspec.json.encode(data)
    except (TypeError, ValueError, RecursionError) as error:
        return f"The data of a prompt cannot be stored as JSON: {error}."
    if msgspec.json.decode(stored) != data:
        return (
            f"The data of a prompt would change in JSON: {data!r:.60}. Its keys are texts, its "
            "values texts, finite "
            "numbers, lists and dictionaries."
        )
    if len(stored) > LONGEST_DATA:
        return (
            f"The data of a prompt take {len(stored)} bytes as JSON; {LONGEST_DATA} are possible."
        )
    return ""
