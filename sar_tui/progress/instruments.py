"""Instruments of others, whose scores are entered by hand, and what is published of their changes.

Only values that a source states are here, with the people they hold for. Nothing is published for a single goal of GAS,
and for the times of the WMFT none could be determined.
"""

from collections.abc import Sequence
from typing import Literal

import msgspec


class Published(msgspec.Struct, frozen=True):
    """A published minimal detectable change (``MDC``) or minimal important difference (``MCID``).

    ``low`` and ``high`` are equal for a single value. ``of``: the people it holds for.
    """

    kind: Literal["MDC", "MCID"]
    low: float
    high: float
    of: str
    source: str


class Instrument(msgspec.Struct, frozen=True):
    """An instrument: the range of its score, and its direction."""

    name: str
    title: str
    lowest: float
    highest: float
    unit: str
    better: Literal["higher", "lower"]
    published: tuple[Published, ...] = ()


_FMA_2023 = "2023, doi:10.1177/15459683231186985"
_LANG = "Lang 2008, PMC2819021"
_CHEN = "Chen 2009, doi:10.1177/1545968308331146"
_BACK_PAIN = "doi:10.1055/a-1304-3677"

INSTRUMENTS: dict[str, Instrument] = {
    each.name: each
    for each in (
        Instrument(
            "FMA-UE",
            "Fugl-Meyer assessment, upper extremity",
            0,
            66,
            "points",
            "higher",
            (
                Published("MDC", 6.8, 6.8, "acute to subacute stroke", _FMA_2023),
                Published("MCID", 9, 13, "acute to subacute stroke", _FMA_2023),
                Published("MCID", 9, 10, "subacute stroke", "Arya 2011"),
            ),
        ),
        Instrument(
            "ARAT",
            "Action Research Arm Test",
            0,
            57,
            "points",
            "higher",
            (
                Published("MCID", 12, 12, "early after stroke, dominant side affected", _LANG),
                Published("MCID", 17, 17, "early after stroke, other side affected", _LANG),
            ),
        ),
        Instrument(
            "BBT",
            "Box and Block Test",
            0,
            150,
            "blocks",
            "higher",
            (
                Published("MDC", 5.5, 5.5, "stroke, more affected hand", _CHEN),
                Published("MDC", 7.8, 7.8, "stroke, less affected hand", _CHEN),
            ),
        ),
        Instrument(
            "WMFT",
            "Wolf Motor Function Test, functional ability",
            0,
            5,
            "points",
            "higher",
            (
                Published("MCID", 1.0, 1.0, "early after stroke, dominant side affected", _LANG),
                Published("MCID", 1.2, 1.2, "early after stroke, other side affected", _LANG),
            ),
        ),
        Instrument("WMFT-TIME", "Wolf Motor Function Test, time", 0, 120, "s", "lower"),
        Instrument("GAS", "Goal Attainment Scaling, one goal", -2, 2, "", "higher"),
        Instrument(
            "NRS",
            "Numeric rating scale of pain",
            0,
            10,
            "points",
            "lower",
            (
                Published("MDC", 1.77, 1.77, "specific back pain", _BACK_PAIN),
                Published("MCID", 2, 2, "specific back pain", _BACK_PAIN),
            ),
        ),
    )
}
"""The instruments by name."""


class Score(msgspec.Struct, frozen=True):
    """A score, entered by hand. ``date``: when it was measured."""

    instrument: str
    date: str
    score: float
    note: str = ""


class Reached(msgspec.Struct, frozen=True):
    """A published value, and whether a change reached it."""

    published: Published
    reached: bool


class InstrumentChange(msgspec.Struct, frozen=True):
    """The scores of an instrument, oldest first. ``change``: last minus first; None with one score."""

    instrument: Instrument
    scores: list[Score]
    change: float | None
    reached: list[Reached]


def changes(scores: Sequence[Score]) -> list[InstrumentChange]:
    """Return the scores by instrument, in the order of `INSTRUMENTS`."""
    found = []
    for instrument in INSTRUMENTS.values():
        own = sorted((score for score in scores if score.instrument == instrument.name), key=lambda score: score.date)
        if own:
            change = own[-1].score - own[0].score if len(own) > 1 else None
            gain = (change or 0.0) * (1 if instrument.better == "higher" else -1)
            compared = [] if change is None else [_reached(each, gain) for each in instrument.published]
            found.append(InstrumentChange(instrument, own, change, compared))
    return found


def _reached(published: Published, gain: float) -> Reached:
    """Compare a gain: an MDC is exceeded in either direction, an MCID holds for an improvement only."""
    gain = round(gain, 6)
    return Reached(published, abs(gain) > published.low if published.kind == "MDC" else gain >= published.low)
