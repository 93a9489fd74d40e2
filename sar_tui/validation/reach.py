"""Seeded reaches under each difficulty of ``motion.scenarios``, detected by both detectors."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from sar_tui.motion.detection import detect
from sar_tui.motion.detector_names import STORED_NAMES, DetectorName
from sar_tui.motion.scenarios import Scenario, scenarios
from sar_tui.validation.report import Claim, Column, Conditions, Report, Row

NEVER_ENDED = frozenset({"endless", "timed_out", "cut"})
"""Flags of a reach that did not end by itself."""
LEAST_PERCENT = 99.0
MEDIAN_MS = 50.0


class DetectorResult(NamedTuple):
    """A detector's result for a recording of one reach. ``error_ms``: the duration's, if just that reach was found."""

    endless: bool
    error_ms: float | None


def run(conditions: Conditions) -> Report:
    """Return one row per difficulty."""
    every = scenarios()
    rows = []
    for number, scenario in enumerate(every):
        conditions.progress(f"reach: {scenario.name}", number, len(every))
        rows.append(_row(scenario, conditions.reaches))
    return Report(rows, [_columns()], _claims(rows))


def _row(scenario: Scenario, reaches: int) -> Row:
    results_of: dict[DetectorName, list[DetectorResult]] = {name: [] for name in STORED_NAMES}
    for seed in range(reaches):
        made = scenario.make(seed)
        ((onset, end),) = made.truth
        for detector, results in results_of.items():
            found = detect(made.recording, detector)
            endless = any(NEVER_ENDED & set(reach.flags) for reach in found)
            right = len(found) == 1 and not endless
            results.append(DetectorResult(endless, (found[0].reach_time_s - (end - onset)) * 1000 if right else None))
    row: Row = {"scenario": scenario.name, "reaches": reaches}
    for detector, results in results_of.items():
        name = STORED_NAMES[detector]
        errors = [result.error_ms for result in results if result.error_ms is not None]
        quartiles = np.percentile(errors, (25, 50, 75)).tolist() if errors else None
        row[f"{name}_exactly_one_percent"] = 100 * len(errors) / reaches
        row[f"{name}_endless_percent"] = 100 * sum(result.endless for result in results) / reaches
        row[f"{name}_error_median_ms"] = quartiles[1] if quartiles else None
        row[f"{name}_error_iqr_ms"] = quartiles[2] - quartiles[0] if quartiles else None
    return row


def _claims(rows: list[Row]) -> list[Claim]:
    def claim(sentence: str, holds: Callable[[Row], bool], name: str, form: str) -> Claim:
        wrong = [row for row in rows if not holds(row)]
        return Claim(sentence, ", ".join(f"{row['scenario']}: {_number(row[name], form)}" for row in wrong))

    one, median, endless = "robust_exactly_one_percent", "robust_error_median_ms", "robust_endless_percent"
    return [
        claim(
            f"Under each difficulty the single-axis detector finds exactly one reach in {LEAST_PERCENT:g} % or more.",
            lambda row: row[one] >= LEAST_PERCENT, one, ".1f",
        ),
        claim(
            f"The median error of its durations is within {MEDIAN_MS:g} ms.",
            lambda row: row[median] is not None and abs(row[median]) <= MEDIAN_MS, median, "+.0f",
        ),
        claim("Not one of its reaches is endless.", lambda row: row[endless] == 0, endless, ".1f"),
    ]  # fmt: skip


def _number(value: float | None, form: str) -> str:
    return "none" if value is None else format(value, form)


def _columns() -> list[Column]:
    columns = [Column("difficulty", lambda row: str(row["scenario"]), is_number=False)]
    for detector, name in STORED_NAMES.items():
        columns += [
            Column(f"{detector}:\none, %", partial(_percent, f"{name}_exactly_one_percent")),
            Column("error (IQR),\nms", partial(_error, name)),
            Column("endless,\n%", partial(_percent, f"{name}_endless_percent")),
        ]
    return columns


def _percent(name: str, row: Row) -> str:
    return f"{row[name]:.1f}"


def _error(name: str, row: Row) -> str | None:
    median, spread = row[f"{name}_error_median_ms"], row[f"{name}_error_iqr_ms"]
    return None if median is None else f"{median:+.0f} ({spread:.0f})"
