"""Labels of the reaches in a recording: what a detector found, corrected by hand."""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Literal, NamedTuple

import msgspec

from sar_tui.motion.reach import Reach

State = Literal["found", "accepted", "dropped", "moved", "added"]
"""``found``: nobody has looked at it yet. All others are by hand."""
SURE, FAIRLY_SURE = 0.9, 0.8
"""Least confidences of reaches that are called so. About one of twenty reaches in recordings of
healthy people is below the second.
"""
SHORTEST_S = 0.2
"""Shortest reach that edges can be moved to."""
USUAL_S = 2.0
"""Duration of an added reach if no other is known."""
LATEST_S = 9e9
"""Times of labels are within so many s of 0, as those of recordings."""


class Label(msgspec.Struct, frozen=True, kw_only=True):
    """A reach in a recording, with times in s on the recording's own time axis.

    ``was``: of a dropped reach, its state before. ``confidence``: the detector's, 0 to 1; None for
    an added reach, or if the detector has none. ``excursion_deg``: how far the hand turned; None if
    that is not measured.
    """

    start_s: float
    end_s: float
    state: State = "found"
    was: State | None = None
    confidence: float | None = None
    excursion_deg: float | None = None

    @property
    def reach_time_s(self) -> float:
        """Its duration."""
        return self.end_s - self.start_s

    @property
    def middle_s(self) -> float:
        """The middle of its time."""
        return (self.start_s + self.end_s) / 2

    @property
    def counts(self) -> bool:
        """True if it is a reach, as far as is known."""
        return self.state != "dropped"

    @property
    def is_unsure(self) -> bool:
        """True if the detector was not sure of it."""
        return self.confidence is not None and self.confidence < FAIRLY_SURE


def labelled(reaches: Iterable[Reach]) -> tuple[Label, ...]:
    """Return labels of reaches that were found."""
    return tuple(
        Label(
            start_s=reach.onset_s,
            end_s=reach.end_s,
            confidence=reach.confidence,
            excursion_deg=reach.excursion_deg,
        )
        for reach in reaches
    )


def confirmed(labels: Iterable[Label]) -> tuple[Label, ...]:
    """Return the reaches that somebody has looked at, and left in."""
    return tuple(label for label in labels if label.counts and label.state != "found")


def mistake(labels: Sequence[Label]) -> str:
    """Return what cannot be in labels, as a clause; empty if all is well."""
    for number, label in enumerate(labels, 1):
        if not label.start_s < label.end_s:
            return f"reach {number} does not end after its start"
        if max(-label.start_s, label.end_s) > LATEST_S:
            return f"reach {number} is at a time that no recording has"
        if (label.was is None) == (label.state == "dropped") or label.was == "dropped":
            return f"what reach {number} was before it was dropped is not clear"
    counting = [label for label in labels if label.counts]
    starts = [label.start_s for label in labels]
    if starts != sorted(starts):
        return "its reaches are not in order of time"
    if any(two.start_s < one.end_s for one, two in pairwise(counting)):
        return "two of its reaches overlap"
    return ""


class _Edit(NamedTuple):
    """The labels before an edit, and the reach that it changed or added."""

    before: tuple[Label, ...]
    label: Label


class Correction:
    """The labels of a recording while they are corrected, in order of time. Those that count never
    overlap.

    An edit takes the index of a label, and returns the index that it has afterwards; None if the
    edit is not possible, and then nothing is changed. All edits can be taken back.

    Args:
        labels: to begin with, in order of time.
        begins_s, ends_s: times of the recording's first and last sample.
    """

    def __init__(self, labels: Iterable[Label], begins_s: float, ends_s: float) -> None:
        self.labels = list(labels)
        self.begins_s, self.ends_s = begins_s, ends_s
        self._saved = tuple(self.labels)
        self._edits: list[_Edit] = []

    @property
    def is_changed(self) -> bool:
        """True if it differs from what was saved last."""
        return tuple(self.labels) != self._saved

    def saved(self) -> None:
        """Note that the labels are saved as they are."""
        self._saved = tuple(self.labels)

    # --- edits

    def accept(self, index: int) -> int | None:
        """Confirm a reach. One that was dropped is taken back, if that is possible."""
        label = self.labels[index]
        if not label.counts and not self._has_room(index):
            return None
        state = label.was or label.state
        return self._replace(index, state="accepted" if state == "found" else state, was=None)

    def drop(self, index: int) -> int | None:
        """Drop a reach, or take that back, which is not possible where another has been added."""
        label = self.labels[index]
        if label.counts:
            return self._replace(index, state="dropped", was=label.state)
        if not self._has_room(index):
            return None
        return self._replace(index, state=label.was, was=None)

    def move(self, index: int, edge: Literal["start", "end"], by_s: float) -> int | None:
        """Move an edge, as far as there is room. The excursion is to be measured again."""
        label = self.labels[index]
        from_s, to_s = self._room(index)
        start_s, end_s = label.start_s, label.end_s
        if edge == "start":
            start_s = max(from_s, min(start_s + by_s, end_s - SHORTEST_S))
        else:
            end_s = min(to_s, max(end_s + by_s, start_s + SHORTEST_S))
        is_as_asked = (start_s - label.start_s + end_s - label.end_s) * by_s > 0
        if not label.counts or not is_as_asked:
            return None
        state: State = "added" if label.state == "added" else "moved"
        return self._replace(index, start_s=start_s, end_s=end_s, state=state, excursion_deg=None)

    def insert(self, at_s: float) -> int | None:
        """Add a reach of the usual duration around a time, as far as there is room."""
        if self.at(at_s, only_counting=True) is not None:
            return None
        counting = [label for label in self.labels if label.counts]
        times = sorted(label.reach_time_s for label in counting)
        lasts_s = times[len(times) // 2] if times else USUAL_S
        from_s = max((e.end_s for e in counting if e.end_s <= at_s), default=self.begins_s)
        to_s = min((e.start_s for e in counting if e.start_s >= at_s), default=self.ends_s)
        start_s = max(from_s, at_s - lasts_s / 2)
        end_s = min(to_s, start_s + lasts_s)
        start_s = max(from_s, end_s - lasts_s)
        if end_s - start_s < SHORTEST_S:
            return None
        added = Label(start_s=start_s, end_s=end_s, state="added")
        self._edits.append(_Edit(tuple(self.labels), added))
        return self._put(added)

    def undo(self) -> Label | None:
        """Take back the last edit. Returns the reach that it changed, as it is again, or the one
        that it added, which is gone; None if there is no edit.
        """
        if not self._edits:
            return None
        before, label = self._edits.pop()
        self.labels = list(before)
        return label

    def _replace(self, index: int, **changes: object) -> int:
        label = self.labels[index]
        changed = msgspec.structs.replace(label, **changes)
        if changed == label:
            return index
        self._edits.append(_Edit(tuple(self.labels), label))
        del self.labels[index]
        return self._put(changed)

    def _put(self, label: Label) -> int:
        self.labels.append(label)
        self.labels.sort(key=lambda each: (each.start_s, each.end_s))
        return self.labels.index(label)

    def _room(self, index: int) -> tuple[float, float]:
        """Return from when to when a reach may last: the end of the one before, and the start of
        the next.
        """
        middle_s = self.labels[index].middle_s
        others = [each for at, each in enumerate(self.labels) if at != index and each.counts]
        before = [each.end_s for each in others if each.middle_s <= middle_s]
        after = [each.start_s for each in others if each.middle_s > middle_s]
        return max(before, default=self.begins_s), min(after, default=self.ends_s)

    def _has_room(self, index: int) -> bool:
        label, (from_s, to_s) = self.labels[index], self._room(index)
        return from_s <= label.start_s and label.end_s <= to_s

    # --- ways through them

    def at(self, time_s: float, *, only_counting: bool = False) -> int | None:
        """Return the index of the reach at a time, rather one that counts; None if there is none."""
        here = [
            index
            for index, label in enumerate(self.labels)
            if label.start_s <= time_s <= label.end_s and (label.counts or not only_counting)
        ]
        return min(here, key=lambda index: not self.labels[index].counts, default=None)

    def next(
        self, step: int, *, after: int | None, at_s: float, only_unsure: bool = False
    ) -> int | None:
        """Return the index of the next reach, or with a ``step`` of -1 of the one before; None if
        there is none.

        Args:
            step: 1 or -1.
            after: index of the reach to go on from; None: from a time.
            at_s: that time.
            only_unsure: leave out those that the detector was sure of.
        """
        for index in range(len(self.labels))[::step]:
            label = self.labels[index]
            ahead = label.start_s - at_s if after is None else index - after
            if ahead * step > 0 and (label.is_unsure or not only_unsure):
                return index
        return None
