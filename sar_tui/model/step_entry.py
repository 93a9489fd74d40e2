"""An answer that is being given with the keyboard: what each key changes. Nothing is chosen until a
key chooses it.
"""

from typing import Literal, NamedTuple

import msgspec
from msgspec.structs import replace

from sar_tui.model.step import LONGEST_TEXT, SCALES, Point, Step, points

Answer = int | float | str | tuple[str, ...] | None
DECLINE_KEY = "tab"
"""Key of those who would rather not say."""
FULL = 100
"""The right end of a line."""
_NEXT, _PREVIOUS = ("right", "down"), ("left", "up")
_LEAP = 10


class Entry(msgspec.Struct, frozen=True, omit_defaults=True):
    """Everything that has been chosen or typed so far.

    Attributes:
        chosen: indices of points, in order.
        place: on a line, 0 to ``FULL``; in several choices, the option that the cursor is at.
        typed: digits of a number, or the words of a text.
        is_missing: True if Enter was pressed before anything was chosen.
    """

    chosen: tuple[int, ...] = ()
    place: int | None = None
    typed: str = ""
    is_missing: bool = False


class Given(NamedTuple):
    """An answer that is given, or declined."""

    status: Literal["answered", "declined"]
    answer: Answer


def press(step: Step, entry: Entry, key: str) -> Entry | Given:
    """Return what a key makes of an entry: the same if it means nothing.

    Args:
        step: the question.
        entry: so far.
        key: as in `messages.KeyPressed`.
    """
    if key == DECLINE_KEY:
        return Given("declined", None)
    if key == "enter":
        answer = _answer(step, entry)
        return replace(entry, is_missing=True) if answer is None else Given("answered", answer)
    changed = _changed(step, replace(entry, is_missing=False), key)
    return entry if changed is None else changed


def _answer(step: Step, entry: Entry) -> Answer:
    """Return the answer that Enter gives; None if nothing was chosen."""
    match step.kind:
        case "line":
            return entry.place
        case "text":
            return entry.typed.strip() or None
        case "choices":
            return tuple(str(points(step)[index].value) for index in sorted(entry.chosen)) or None
    return points(step)[entry.chosen[0]].value if entry.chosen else None


def _changed(step: Step, entry: Entry, key: str) -> Entry | None:
    match step.kind:
        case "line":
            return _moved(entry, key)
        case "text":
            return _typed(entry, key)
        case "choices":
            return _toggled(entry, key, len(step.labels))
        case kind if kind in SCALES:
            return _pointed(entry, key, points(step))
    return None


def _pointed(entry: Entry, key: str, scale: tuple[Point, ...]) -> Entry | None:
    """Choose a point: with the arrows, which begin at either end, or by its digits."""
    at = entry.chosen[0] if entry.chosen else None
    if key in _NEXT:
        return Entry(chosen=(0 if at is None else min(at + 1, len(scale) - 1),))
    if key in _PREVIOUS:
        return Entry(chosen=(len(scale) - 1 if at is None else max(at - 1, 0),))
    key = "." if key == "," else key
    for typed in (entry.typed + key, key):
        if any(point.typed.startswith(typed) for point in scale):
            exact = tuple(index for index, point in enumerate(scale) if point.typed == typed)
            return Entry(chosen=exact, typed=typed)
    return None


def _toggled(entry: Entry, key: str, count: int) -> Entry | None:
    """Move the cursor, or choose an option or not: with the space bar, or by its number."""
    at = entry.place
    if key in _NEXT:
        return replace(entry, place=0 if at is None else min(at + 1, count - 1))
    if key in _PREVIOUS:
        return replace(entry, place=count - 1 if at is None else max(at - 1, 0))
    index = at if key == "space" else int(key) - 1 if key in "123456789" else None
    if index is None or not 0 <= index < count:
        return None
    chosen = tuple(sorted({index}.symmetric_difference(entry.chosen)))
    return replace(entry, chosen=chosen, place=index)


def _moved(entry: Entry, key: str) -> Entry | None:
    """Move the mark on a line. The first arrow puts it at an end, a digit at a tenth of the
    line.
    """
    at = entry.place
    if key in ("right", "left") and at is None:
        return Entry(place=0 if key == "right" else FULL)
    steps = {"right": 1, "left": -1, "up": _LEAP, "down": -_LEAP}
    if key in steps and at is not None:
        return Entry(place=min(max(at + steps[key], 0), FULL))
    if key in ("home", "end"):
        return Entry(place=0 if key == "home" else FULL)
    if len(key) == 1 and key in "0123456789":
        return Entry(place=_LEAP * int(key))
    return None


def _typed(entry: Entry, key: str) -> Entry | None:
    if key == "backspace":
        return Entry(typed=entry.typed[:-1])
    char = " " if key == "space" else key
    if len(char) != 1 or not char.isprintable() or len(entry.typed) >= LONGEST_TEXT:
        return None
    return Entry(typed=entry.typed + char)
