"""Changes between sessions: what is more than noise, and what practice alone does.

Three kinds of change are told apart in rehabilitation: observed, detectable (MDC95), and important
to the person (MCID). Reaction and reach times as measured here have no published MCID, so none is
given. Values of other timed tests, such as the WMFT, do not carry over (see
`progress.scores`).

The MDC95 is 1.96 · √2 · SEM, where the standard error of measurement (SEM) is known from many
people (Weir 2005). Here it comes from a few sessions of one person, so that 1.96 gives way to
Student's t: with the SD of three sessions, 1.96 would call one difference in five a change when
nothing had changed.

The first session is left out of the baseline. Repeated tests get better without any recovery:
reaction times fall with each of four tests (Scharfen 2018), and choice reactions need four to six
sets of 20 before they stand (Parkin 1997; docs/progress.md). Where the baseline itself still rises,
that rise is allowed for in later gains.
"""

import math
import statistics
from collections.abc import Sequence
from typing import Literal

import msgspec

from sar_tui.rules.student import t95

FAMILIARISATION = 1
"""Sessions before the baseline."""
BASELINE = 3
"""Sessions of the baseline; the SD of fewer says nothing."""
_ROUNDING = 1e-9
"""Share of a mean below which a difference is an error of rounding: sessions that are all alike
have no noise.
"""


class Baseline(msgspec.Struct, frozen=True):
    """Baseline of one person.

    Args:
        mean: of its sessions.
        sem: standard error of measurement: the SD between the sessions.
        mdc95: the smallest difference between two sessions that is more than noise.
        practice: mean of the baseline minus the first session: the gain of a retest, which is no
            recovery.
        rise: from the first to the last of its sessions, at least 0: practice may bring as much
            again.
    """

    mean: float
    sem: float
    mdc95: float
    practice: float
    rise: float


def mdc95(sem: float, sessions: int | None = None) -> float:
    """Return the minimal detectable change of an SEM.

    Args:
        sem: standard error of measurement.
        sessions: number of one person's sessions that it comes from; None if it is known from many
            people.
    """
    return (1.96 if sessions is None else t95(sessions - 1)) * math.sqrt(2) * sem


def baseline(values: Sequence[float]) -> Baseline | None:
    """Return the baseline of a line of sessions, first to last; None if there are too few."""
    probes = values[FAMILIARISATION : FAMILIARISATION + BASELINE]
    if len(probes) < BASELINE:
        return None
    mean, sem = statistics.fmean(probes), statistics.stdev(probes)
    return Baseline(
        mean=mean,
        sem=sem,
        mdc95=mdc95(sem, len(probes)),
        practice=mean - statistics.fmean(values[:FAMILIARISATION]),
        rise=max(0.0, probes[-1] - probes[0]),
    )


Verdict = Literal["more", "less", "noise", "not yet known"]


def verdict(value: float, found: Baseline | None) -> Verdict:
    """Judge a session against the baseline: a gain must exceed the MDC95 and what practice may
    still bring.
    """
    if found is None:
        return "not yet known"
    gain, rounding = value - found.mean, _ROUNDING * abs(found.mean)
    if -found.mdc95 - rounding <= gain <= found.mdc95 + found.rise + rounding:
        return "noise"
    return "more" if gain > 0 else "less"


def difference(later: float, earlier: float, found: Baseline | None) -> Verdict:
    """Judge the difference between two sessions after the baseline."""
    if found is None:
        return "not yet known"
    if abs(later - earlier) <= found.mdc95 + _ROUNDING * abs(found.mean):
        return "noise"
    return "more" if later > earlier else "less"
