"""Reaches that each detector finds in simulated daily life, where nobody reaches."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from sar_tui.motion.analysis import AnalysisParameters
from sar_tui.motion.detection import detect
from sar_tui.motion.detector_names import COLUMN_NAMES, DetectorName
from sar_tui.motion.reach import Reach
from sar_tui.validation.report import Claim, Conditions, Report, Row
from tests.motion.daily_life import KINDS, MINUTES, simulate
from tests.motion.wrist_motion import Trip

PEOPLE = range(1, 4)
QUICK_PEOPLE, QUICK_MINUTES = range(1, 2), 2.0
MOST_A_MINUTE = 1.0
SHARED = 0.5
"""A find is a trip if what they share is at least this part of either."""
JUDGED: DetectorName = AnalysisParameters().detector
"""The claim is about the default detector."""


class Count(NamedTuple):
    """Numbers of finds: those that are no trip, and those that are one."""

    false: int
    trips: int


def run(conditions: Conditions) -> Report:
    """Return one row for each kind of daily life."""
    rows = []
    for number, kind in enumerate(KINDS):
        conditions.progress(f"quiet: {kind}", number, len(KINDS))
        rows.append(_row(kind, conditions.is_quick))
    column = f"{COLUMN_NAMES[JUDGED]}_false_per_minute"
    loud = [row for row in rows if row[column] >= MOST_A_MINUTE]
    overlaps = f"{COLUMN_NAMES[JUDGED]}_overlapping"
    doubled = [row for row in rows if row[overlaps]]
    claims = [
        Claim(
            f"In each kind of daily life the {JUDGED} detector finds less than {MOST_A_MINUTE:g} "
            "false reach a minute.",
            ", ".join(f"{row['kind']}: {row[column]:.1f}" for row in loud),
        ),
        Claim(
            "No two of its reaches overlap in time.",
            ", ".join(f"{row['kind']}: {row[overlaps]}" for row in doubled),
        ),
    ]
    return Report(rows, (), claims)


def count(reaches: Sequence[Reach], trips: Sequence[Trip]) -> Count:
    """Return the number of finds that are no trip, and of those that are one."""
    real = sum(any(_is_same(reach, trip) for trip in trips) for reach in reaches)
    return Count(len(reaches) - real, real)


def _is_same(reach: Reach, trip: Trip) -> bool:
    shared_s = min(reach.end_s, trip.to_s) - max(reach.onset_s, trip.from_s)
    return shared_s >= SHARED * max(reach.reach_time_s, trip.to_s - trip.from_s)


def overlapping(reaches: Sequence[Reach]) -> int:
    """Return the number of reaches, in order of time, that begin before the one before them
    ends.
    """
    return sum(after.onset_s < before.end_s for before, after in pairwise(reaches))


def _row(kind: str, is_quick: bool) -> Row:
    people, minutes = (QUICK_PEOPLE, QUICK_MINUTES) if is_quick else (PEOPLE, MINUTES)
    lives = [simulate(kind, seed, minutes=minutes) for seed in people]
    row: Row = {
        "kind": kind,
        "minutes": minutes * len(people),
        "trips": sum(len(life.trips) for life in lives),
    }
    for detector, name in COLUMN_NAMES.items():
        found = [detect(life.recording, detector) for life in lives]
        counts = [count(reaches, life.trips) for reaches, life in zip(found, lives, strict=True)]
        row[f"{name}_false_per_minute"] = sum(each.false for each in counts) / row["minutes"]
        row[f"{name}_trips"] = sum(each.trips for each in counts)
        row[f"{name}_overlapping"] = sum(map(overlapping, found))
    return row
