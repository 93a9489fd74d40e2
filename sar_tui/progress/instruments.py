"""Instruments of others, whose scores are entered by hand, and what is published of their changes.

Only values that a source states, and that were read there, are here, with the people they hold for.
Left out are the MDCs of the WMFT three to nine months after a stroke (Fritz 2009,
doi:10.1177/1545968309335975), which were not read. Of a single goal of GAS nothing is published.
Early after a stroke the MCID of the times of the WMFT was indeterminate where the side that is not
dominant was affected (Lang 2008).
"""

from collections.abc import Sequence
from typing import Literal

import msgspec


class Published(msgspec.Struct, frozen=True):
    """A published minimal detectable change, at 95 % (``MDC``) or 90 % (``MDC90``), or important
    difference (``MCID``).

    ``low`` and ``high`` are equal for a single value. ``of``: the people it holds for.
    """

    kind: Literal["MDC", "MDC90", "MCID"]
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


_HUYNH = "Huynh 2023, doi:10.1177/15459683231186985"
_ARYA = "Arya 2011, doi:10.1310/tsr18s01-599"
_PAGE = "Page 2012, doi:10.2522/ptj.20110009"
_VAN_DER_LEE = "van der Lee 2001, doi:10.1080/165019701750165916"
_LANG = "Lang 2008, doi:10.1016/j.apmr.2008.02.022"
_LIN = "Lin 2009, doi:10.1177/1545968308331144"
_CHEN = "Chen 2009, doi:10.1177/1545968308331146"
_BACK_PAIN = "2022, doi:10.1055/a-1304-3677"
_EARLY = "1 to 6 weeks after stroke, moderate to severe arm impairment"
_CHRONIC = "chronic stroke, upper 95 % limit of agreement"
_TRAINED = "stroke, 3 weeks of training"
_TRAINED_GROUP = "stroke, 3 weeks of training, mean of a group"

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
                Published("MDC", 6.8, 6.8, _EARLY, _HUYNH),
                Published("MCID", 9, 13, _EARLY, _HUYNH),
                Published("MCID", 9, 10, "subacute stroke", _ARYA),
                Published("MDC", 6.6, 6.6, _CHRONIC, _VAN_DER_LEE),
                Published(
                    "MCID", 4.25, 7.25, "chronic stroke, minimal to moderate arm impairment", _PAGE
                ),
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
                Published("MDC", 6.2, 6.2, _CHRONIC, _VAN_DER_LEE),
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
                Published("MDC90", 0.37, 0.37, _TRAINED, _LIN),
                Published("MCID", 0.2, 0.4, _TRAINED_GROUP, _LIN),
            ),
        ),
        Instrument(
            "WMFT-TIME",
            "Wolf Motor Function Test, time",
            0,
            120,
            "s",
            "lower",
            (
                Published("MDC90", 4.36, 4.36, _TRAINED, _LIN),
                Published("MCID", 1.5, 2, _TRAINED_GROUP, _LIN),
            ),
        ),
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
    """The scores of an instrument, oldest first. ``change``: last minus first; None with one
    score.
    """

    instrument: Instrument
    scores: list[Score]
    change: float | None
    reached: list[Reached]


def changes(scores: Sequence[Score]) -> list[InstrumentChange]:
    """Return the scores by instrument, in the order of `INSTRUMENTS`."""
    found = []
    for instrument in INSTRUMENTS.values():
        own = sorted(
            (score for score in scores if score.instrument == instrument.name),
            key=lambda score: score.date,
        )
        if own:
            change = own[-1].score - own[0].score if len(own) > 1 else None
            gain = (change or 0.0) * (1 if instrument.better == "higher" else -1)
            compared = (
                [] if change is None else [_reached(each, gain) for each in instrument.published]
            )
            found.append(InstrumentChange(instrument, own, change, compared))
    return found


def _reached(published: Published, gain: float) -> Reached:
    """Compare a gain: an MDC is exceeded in either direction, an MCID holds for an improvement
    only.
    """
    gain = round(gain, 6)
    return Reached(
        published, abs(gain) > published.low if published.kind != "MCID" else gain >= published.low
    )
