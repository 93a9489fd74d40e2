"""Seeded reaches about one axis under each difficulty, and of each kind about many axes, found by
every detector.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from sar_tui.motion.analysis import AnalysisParameters
from sar_tui.motion.detection import detect
from sar_tui.motion.detector_names import COLUMN_NAMES, DetectorName
from sar_tui.motion.reach import Hand
from sar_tui.motion.reach_kinds import KINDS
from sar_tui.motion.samples import Recording
from sar_tui.motion.synthesis import Scenario, scenarios
from sar_tui.motion.trajectories import PLACEMENTS, simulate_reaches
from sar_tui.validation.report import Claim, Column, Conditions, Report, Row

NEVER_ENDED = frozenset({"endless", "timed_out", "cut"})
"""Flags of a reach that did not end by itself."""
JUDGED: DetectorName = AnalysisParameters().detector
"""The claims are about the default detector."""
LEAST_PERCENT = 99.0
ONSET_MS, DURATION_MS, SPREAD_MS = 30.0, 60.0, 80.0
"""Largest median error of onset and duration, and largest range of the middle half of the
errors.
"""


class Trial(NamedTuple):
    """A recording of one reach: its onset and end, s, and the hand with the sensor."""

    recording: Recording
    onset_s: float
    end_s: float
    hand: Hand = "right"


class Group(NamedTuple):
    """Reaches that belong together. ``axes``: the number that the hand turns about, ``one`` or
    ``many``.
    """

    name: str
    axes: str
    make: Callable[[int], Trial]


class DetectorResult(NamedTuple):
    """A detector's result for a recording of one reach. Errors, found minus true: if just that
    reach was found.
    """

    endless: bool
    onset_ms: float | None = None
    duration_ms: float | None = None


def groups() -> list[Group]:
    """Return the difficulties, then the kinds."""
    return [
        *(
            Group(scenario.name, "one", partial(_under_difficulty, scenario))
            for scenario in scenarios()
        ),
        *(Group(kind, "many", partial(_of_kind, kind)) for kind in KINDS),
    ]


def _under_difficulty(scenario: Scenario, seed: int) -> Trial:
    made = scenario.make(seed)
    ((onset_s, end_s),) = made.truth
    return Trial(made.recording, onset_s, end_s)


def _of_kind(kind: str, seed: int) -> Trial:
    """Return the reach of another person for each seed, with either arm, every placement, and
    either kind of sensor.
    """
    hand: Hand = "left" if seed % 2 else "right"
    placement, accelerometer = seed // 2 % len(PLACEMENTS), seed // (2 * len(PLACEMENTS)) % 2 == 0
    made = simulate_reaches(kind, seed, arm=hand, placement=placement, accelerometer=accelerometer)
    ((onset_s, end_s),) = made.truth
    return Trial(made.recording, onset_s, end_s, hand)


def run(conditions: Conditions) -> Report:
    """Return one row for each difficulty and for each kind."""
    every = groups()
    rows = []
    for number, group in enumerate(every):
        conditions.progress(f"reach: {group.name}", number, len(every))
        rows.append(row_of(group, conditions.reaches))
    return Report(rows, list(_tables()), claims(rows))


def row_of(group: Group, reaches: int) -> Row:
    """Return the figures of a number of reaches."""
    results_of: dict[DetectorName, list[DetectorResult]] = {name: [] for name in COLUMN_NAMES}
    for seed in range(reaches):
        trial = group.make(seed)
        for detector, results in results_of.items():
            results.append(_result(trial, detector))
    row: Row = {"scenario": group.name, "axes": group.axes, "reaches": reaches}
    for detector, results in results_of.items():
        name = COLUMN_NAMES[detector]
        durations = [result.duration_ms for result in results if result.duration_ms is not None]
        onsets = [result.onset_ms for result in results if result.onset_ms is not None]
        row[f"{name}_exactly_one_percent"] = 100 * len(durations) / reaches
        row[f"{name}_endless_percent"] = 100 * sum(result.endless for result in results) / reaches
        row[f"{name}_error_median_ms"], row[f"{name}_error_iqr_ms"] = _median_iqr(durations)
        row[f"{name}_onset_error_median_ms"], row[f"{name}_onset_error_iqr_ms"] = _median_iqr(
            onsets
        )
    return row


def _result(trial: Trial, detector: DetectorName) -> DetectorResult:
    found = detect(trial.recording, detector, hand=trial.hand)
    endless = any(NEVER_ENDED & set(reach.flags) for reach in found)
    if endless or len(found) != 1:
        return DetectorResult(endless)
    (reach,) = found
    return DetectorResult(
        endless,
        onset_ms=(reach.onset_s - trial.onset_s) * 1000,
        duration_ms=(reach.reach_time_s - (trial.end_s - trial.onset_s)) * 1000,
    )


def _median_iqr(errors: Sequence[float]) -> tuple[float | None, float | None]:
    if not errors:
        return None, None
    lower, median, upper = np.percentile(errors, (25, 50, 75)).tolist()
    return median, upper - lower


def claims(rows: Sequence[Row]) -> list[Claim]:
    """Return the claims about the default detector."""
    name = COLUMN_NAMES[JUDGED]

    def claim(
        sentence: str,
        figure: str,
        holds: Callable[[float], bool],
        form: str,
        about: Sequence[Row] = rows,
    ) -> Claim:
        column = f"{name}_{figure}"
        wrong = [row for row in about if row[column] is None or not holds(row[column])]
        return Claim(
            sentence, ", ".join(f"{row['scenario']}: {_number(row[column], form)}" for row in wrong)
        )

    kinds = [row for row in rows if row["axes"] == "many"]
    all_but_one = min(100 * (1 - 1 / row["reaches"]) for row in rows)

    def within(most: float) -> Callable[[float], bool]:
        return lambda value: abs(value) <= most

    return [
        claim(
            f"Under each difficulty and of each kind the {JUDGED} detector finds exactly one reach "
            f"in {LEAST_PERCENT:g} % or more, or in all but one.",
            "exactly_one_percent",
            lambda share: share >= min(LEAST_PERCENT, all_but_one),
            ".1f",
        ),
        claim(
            "Not one of its reaches is endless.",
            "endless_percent",
            lambda share: share == 0.0,
            ".1f",
        ),
        claim(
            f"The median error of its onsets is within {ONSET_MS:g} ms.",
            "onset_error_median_ms",
            within(ONSET_MS),
            "+.0f",
        ),
        claim(
            f"The median error of its durations is within {DURATION_MS:g} ms.",
            "error_median_ms",
            within(DURATION_MS),
            "+.0f",
        ),
        claim(
            f"Of each kind, the middle half of its onsets' errors spans at most {SPREAD_MS:g} ms.",
            "onset_error_iqr_ms",
            within(SPREAD_MS),
            ".0f",
            kinds,
        ),
        claim(
            f"Of each kind, the middle half of its durations' errors spans at most {SPREAD_MS:g} "
            "ms.",
            "error_iqr_ms",
            within(SPREAD_MS),
            ".0f",
            kinds,
        ),
    ]


def _number(value: float | None, form: str) -> str:
    return "none" if value is None else format(value, form)


def _tables() -> Iterator[list[Column]]:
    """Yield a table for each figure, with a column for each detector."""
    for title, show in (
        ("exactly one\nreach found, %", _percent),
        ("error of the\nonset (IQR), ms", partial(_error, "onset_error")),
        ("error of the\nduration (IQR), ms", partial(_error, "error")),
    ):
        yield [
            Column(title, lambda row: str(row["scenario"]), is_number=False),
            *(Column(detector, partial(show, name)) for detector, name in COLUMN_NAMES.items()),
        ]


def _percent(name: str, row: Row) -> str:
    return f"{row[f'{name}_exactly_one_percent']:.1f}"


def _error(figure: str, name: str, row: Row) -> str | None:
    median, spread = row[f"{name}_{figure}_median_ms"], row[f"{name}_{figure}_iqr_ms"]
    return None if median is None else f"{median:+.0f} ({spread:.0f})"
