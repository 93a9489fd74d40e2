"""Changes of the scores of other instruments, beside what is published of such changes.

What is published stands with the kinds of record (`records/kinds`), with the people it holds for.
Only values that a source states, and that were read there, are there; docs/progress.md names those
that were not found.
"""

from collections.abc import Iterable, Sequence

import msgspec

from sar_tui.records.kind import Field, Kind, Published


class Score(msgspec.Struct, frozen=True):
    """A score of a day, and its record."""

    record: str
    instrument: str
    date: str
    score: float
    note: str = ""


class Reached(msgspec.Struct, frozen=True):
    """A published value, and whether a change reached it."""

    published: Published
    reached: bool


class InstrumentChange(msgspec.Struct, frozen=True):
    """The scores of an instrument, oldest first. ``change``: last minus first; None with one
    score.
    """

    instrument: Kind
    scores: list[Score]
    change: float | None
    reached: list[Reached]

    @property
    def field(self) -> Field:
        """The declaration of the score."""
        assert self.instrument.score
        return self.instrument.score


def changes(kinds: Iterable[Kind], scores: Sequence[Score]) -> list[InstrumentChange]:
    """Return the scores by instrument, in the order of the kinds."""
    found = []
    for kind in kinds:
        own = [score for score in scores if score.instrument == kind.name]
        own.sort(key=lambda score: score.date)
        if own and kind.score:
            change = own[-1].score - own[0].score if len(own) > 1 else None
            gain = (change or 0.0) * (1 if kind.score.better == "higher" else -1)
            compared = [] if change is None else [_reached(each, gain) for each in kind.published]
            found.append(InstrumentChange(kind, own, change, compared))
    return found


def _reached(published: Published, gain: float) -> Reached:
    """Compare a gain: an MDC is exceeded in either direction, an MCID holds for an improvement
    only.
    """
    gain = round(gain, 6)
    is_reached = gain >= published.low if published.kind == "MCID" else abs(gain) > published.low
    return Reached(published, is_reached)
