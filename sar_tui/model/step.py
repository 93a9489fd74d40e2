"""A step between attempts, as a task, a therapist or a file declares it."""

from collections.abc import Callable
from typing import Literal, NamedTuple, get_args

import msgspec
from msgspec.structs import replace

from sar_tui.model.visible_text import control_problem

Kind = Literal[
    "screen", "rest", "calibration", "number", "likert", "borg", "line", "choice", "choices", "text"
]  # fmt: skip
QUESTIONS: frozenset[Kind] = frozenset(
    ("number", "likert", "borg", "line", "choice", "choices", "text")
)
"""Kinds that ask for an answer; ``screen`` is read, ``rest`` and ``calibration`` end by
themselves.
"""
TIMED: frozenset[Kind] = frozenset(("rest", "calibration"))
SCALES: frozenset[Kind] = frozenset(("number", "likert", "borg", "choice"))
"""Kinds of which one point is chosen."""
LONGEST_S = 600.0
MOST_LABELS = 9
LONGEST_TEXT = 500
"""Most characters of a text that is typed as an answer."""
BORG = (
    "0", "0.3", "0.5", "0.7", "1", "1.5", "2", "2.5", "3", "4", "5", "6", "7", "8", "9", "10", "11",
)  # fmt: skip
"""Points of Borg's category-ratio scale CR10 (Borg 1998, Borg's Perceived Exertion and Pain
Scales).
"""
BORG_WORDS = {
    0.0: "nothing at all", 0.5: "extremely weak", 1.0: "very weak", 2.0: "weak", 3.0: "moderate",
    5.0: "strong", 7.0: "very strong", 10.0: "extremely strong",
}  # fmt: skip
"""Its words, by point; the others have none."""


USUAL_SCALE = (0, 10, 1)
"""The lowest and the highest point of a number, and the distance between two."""
_MOST_POINTS = 101


class Step(
    msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True
):
    """Something between attempts. Without ``before``, ``every`` and ``after`` it comes after the
    last attempt.

    Args:
        name: stored with its answers: a short name, without spaces.
        text: the question, or what is to be read: one or two sentences.
        kind: ``number`` (a point of ``scale``), ``likert`` (one of ``labels``, in order), ``line``
            (a visual analogue scale, 0 to 100), ``choice`` (one of ``labels``), ``choices``
            (several), ``text`` (words); ``screen`` (read it, then Enter), ``rest`` and
            ``calibration`` (they last for ``seconds``). ``borg`` is Borg's CR10, whose use needs a
            licence: tasks and sessions of earlier releases have it.
        labels: the options; of ``number`` and ``line`` the words at both ends, or none; of
            ``number`` also those of each point.
        scale: of ``number``: the lowest and the highest point, and the distance between two.
        seconds: duration of a rest or a calibration.
        before: True to come before the first attempt.
        every: come after each so many attempts.
        after: come after these attempts; practice is not counted.
        at_end: True to come after the last attempt as well.
        required: of a ``choice`` before the first attempt, such as consent: the label that must be
            chosen. Any other answer ends the session, which is kept as ``refused``. Such a question
            comes before all others.
    """

    name: str
    text: str
    kind: Kind = "screen"
    labels: tuple[str, ...] = ()
    scale: tuple[int, int, int] = USUAL_SCALE
    seconds: float = 0.0
    before: bool = False
    every: int = 0
    after: tuple[int, ...] = ()
    at_end: bool = False
    required: str = ""

    def is_due(self, done: int, total: int) -> bool:
        """Return True if it comes after ``done`` of ``total`` attempts (without practice); 0:
        before the first.
        """
        if done == 0:
            return self.before
        is_last = self.at_end or not (self.before or self.every or self.after)
        return (
            done in self.after
            or (self.every > 0 and done % self.every == 0)
            or (is_last and done == total)
        )

    @property
    def is_question(self) -> bool:
        """True if it asks for an answer."""
        return self.kind in QUESTIONS


class Point(NamedTuple):
    """A point of a scale, or an option: how it is typed, its words, and what is stored if it is
    chosen.
    """

    typed: str
    label: str
    value: int | float | str


def points(step: Step) -> tuple[Point, ...]:
    """Return the points of a scale, or the options of a choice; none for other kinds."""
    match step.kind:
        case "number":
            low, high, by = step.scale
            values = range(low, high + 1, by)
            labels = step.labels
            if len(labels) != len(values):
                first, last = labels or ("", "")
                labels = (first, *("",) * (len(values) - 2), last)
            return tuple(Point(str(n), label, n) for n, label in zip(values, labels, strict=True))
        case "borg":
            words = step.labels or [BORG_WORDS.get(float(typed), "") for typed in BORG]
            return tuple(
                Point(typed, label, float(typed)) for typed, label in zip(BORG, words, strict=True)
            )
        case "likert":
            return tuple(Point(str(n), label, n) for n, label in enumerate(step.labels, 1))
        case "choice" | "choices":
            return tuple(Point(str(n), label, label) for n, label in enumerate(step.labels, 1))
    return ()


def translated(step: Step, tr: Callable[[str], str]) -> Step:
    """Return a step with its texts in the session's language; also with the words of Borg's
    scale.
    """
    labels = [point.label for point in points(step)] if step.kind == "borg" else step.labels
    return msgspec.structs.replace(
        step,
        text=tr(step.text),
        labels=tuple(tr(label) if label else "" for label in labels),
        required=tr(step.required) if step.required else "",
    )


def spoken(step: Step) -> str:
    """Return what a voice says of a step: its text, and the words that can be chosen."""
    ends = [
        step.text,
        *filter(None, (point.label for point in points(step))),
        *(step.labels * (step.kind == "line")),
    ]
    return " ".join(
        part if part[-1] in ".?!…" else f"{part}." for part in (end.strip() for end in ends)
    )


def problem(step: Step) -> str:
    """Return why a step cannot be used, in one sentence; empty if it can."""
    if step.kind not in get_args(Kind):
        return (
            f"The step {step.name!r} has the kind {step.kind!r:.40}. Choose one of: "
            f"{', '.join(get_args(Kind))}."
        )
    try:
        msgspec.convert(msgspec.to_builtins(step), Step)
    except (msgspec.ValidationError, TypeError) as error:
        return f"The step {step.name!r} cannot be used: {error}."
    shown = control_problem(
        f"What the step {step.name!r} shows", "".join((step.text, *step.labels))
    )
    name = f"The step {step.name!r}"
    wrong = shown or _contents_problem(step) or _scale_problem(step, name)
    return wrong or _labels_problem(step, name)


def _contents_problem(step: Step) -> str:
    name = f"The step {step.name!r}"
    if not step.name or not all(char.isalnum() or char in "_-" for char in step.name):
        return f"The name of a step is letters, digits, - and _, not {step.name!r}."
    if not step.text.strip():
        return f"{name} has no text."
    if step.every < 0 or any(number < 1 for number in step.after):
        return f"{name}: every is 0 or more, and after names attempts from 1."
    if step.kind in TIMED and not 0 < step.seconds <= LONGEST_S:
        return f"{name} lasts seconds = 1 to {LONGEST_S:g}, not {step.seconds:g}."
    if step.kind not in TIMED and step.seconds:
        return f"{name} is of the kind {step.kind}, which has no seconds."
    return _required_problem(step, name) if step.required else ""


def _scale_problem(step: Step, name: str) -> str:
    low, high, by = step.scale
    if by < 1 or not 2 <= (high - low) // by + 1 <= _MOST_POINTS or (high - low) % by:
        return f"{name} has a scale of 2 to {_MOST_POINTS} points, such as [1, 7, 1]."
    if step.kind != "number" and step.scale != USUAL_SCALE:
        return f"{name} is of the kind {step.kind}, which has no scale."
    return ""


def _required_problem(step: Step, name: str) -> str:
    if step.kind != "choice" or step.required not in step.labels:
        return (
            f"{name} requires {step.required!r}: it must be one of the labels, and the kind choice."
        )
    if not step.before or step.every or step.after or step.at_end:
        return f"{name} requires an answer: it comes before the first attempt only (before = true)."
    return ""


def _labels_problem(step: Step, name: str) -> str:
    count = len(step.labels)
    if step.kind in ("likert", "choice", "choices"):
        if not 2 <= count <= MOST_LABELS:
            return f"{name} needs 2 to {MOST_LABELS} labels, and has {count}."
        if not all(label.strip() for label in step.labels) or len(set(step.labels)) < count:
            return f"{name}: each label is a different word or sentence."
    elif step.kind in ("number", "line"):
        points_count = len(range(step.scale[0], step.scale[1] + 1, step.scale[2]))
        if count not in (0, 2) and (step.kind == "line" or count != points_count):
            return f"{name} needs two labels, for its ends, or none; it has {count}."
    elif count:
        return f"{name} is of the kind {step.kind}, which has no labels."
    return ""


# --- keys of a question


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
    key = {",": ".", "minus": "-"}.get(key, key)
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
