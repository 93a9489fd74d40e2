"""Measures of simulated reaches about many axes, against the truth of their trajectories."""

from collections.abc import Callable
from functools import partial
from typing import Literal, NamedTuple

import numpy as np

from sar_tui.motion.detection import detect
from sar_tui.motion.imperfections import PERFECT
from sar_tui.motion.measures import measure
from sar_tui.motion.quaternions import angle, conjugate, multiply, rotate
from sar_tui.motion.reach import Bounds, Detected, Hand, Reach
from sar_tui.motion.reach_kinds import KINDS
from sar_tui.motion.repetitions import count_repetitions
from sar_tui.motion.trajectories import PLACEMENTS, SimulatedReaches, simulate_reaches
from sar_tui.validation.report import Claim, Conditions, Report, Row

MOST_REACHES = 50
"""Largest number of reaches of each kind."""
TRUTH_S = 0.002
"""Step in which the true orientation is followed."""
FINGERS = (0.0, 1.0, 0.0)
SWINGS = (2, 5, 12, 40)
"""Repetitions of a limb that swings out and back."""


class Measure(NamedTuple):
    """A measure, and the claim that the median error, or 95 % of the errors, are ``within`` this in
    each kind.
    """

    name: str
    head: str
    form: str
    within: float | None = None
    share: Literal["median", "95"] = "95"


ANGLES = (
    Measure("excursion_deg", "excursion,\n°", ".1f", 1.0),
    Measure("return_error_deg", "return\nerror, °", ".1f", 2.0),
    Measure("inclination_rest_deg", "inclination\nat rest, °", ".1f", 2.0),
    Measure("inclination_target_deg", "the same at\nthe target, °", ".1f", 1.0, "median"),
)
SHAPES = (
    Measure("straightness", "straightness", ".3f", 0.05, "median"),
    Measure("sparc_out", "SPARC out", ".3f", 0.05, "median"),
    Measure("ldlj_out", "LDLJ out", ".2f"),
)
MEASURES = ANGLES + SHAPES


def run(conditions: Conditions) -> Report:
    """Return one row for each kind of reach."""
    reaches = min(conditions.reaches, MOST_REACHES)
    rows = []
    for number, kind in enumerate(KINDS):
        conditions.progress(f"measures: {kind}", number, len(KINDS))
        rows.append(row_of(kind, reaches))
    claims = [
        _claim(measure, measure.within, rows) for measure in MEASURES if measure.within is not None
    ]
    miscounted = [
        f"{counted} of {true}" for true in SWINGS if (counted := _counted_swings(true)) != true
    ]
    claims.append(
        Claim(
            f"Repetitions of a swing are counted ({', '.join(map(str, SWINGS))}).",
            "; ".join(miscounted),
        )
    )
    return Report(rows, (), claims)


def _counted_swings(repetitions: int, period_s: float = 2.0, rate_hz: float = 100.0) -> int:
    """Return the number of repetitions counted in a limb that swings out by a radian and back so
    many times.
    """
    cycles = np.arange(0, repetitions, 1 / (period_s * rate_hz))
    rate = np.outer(np.gradient((1 - np.cos(2 * np.pi * cycles)) / 2) * rate_hz, (0.2, -0.4, 0.9))
    return count_repetitions(rate, None, rate_hz).count


def row_of(kind: str, reaches: int) -> Row:
    """Return the errors of each measure, of the reaches of a kind that are found; None if none
    is.
    """
    errors: dict[str, list[float]] = {measure.name: [] for measure in MEASURES}
    found = 0
    for seed in range(reaches):
        arm: Hand = "left" if seed % 2 else "right"
        placement = seed // 2 % len(PLACEMENTS)
        make: Callable[..., SimulatedReaches] = partial(
            simulate_reaches, kind, seed, arm=arm, placement=placement
        )
        simulated = make()
        measured = detect(simulated.recording, hand=simulated.site.arm)
        if len(measured) != 1:
            continue
        found += 1
        for name, true in true_measures(simulated, make(imperfections=PERFECT)).items():
            value = getattr(measured[0], name)
            if value is not None and true is not None:
                errors[name].append(abs(value - true))
    row: Row = {"scenario": kind, "reaches": reaches, "found": found}
    for name, sizes in errors.items():
        median, most = np.percentile(sizes, (50, 95)).tolist() if sizes else (None, None)
        row[f"{name}_error_median"], row[f"{name}_error_95"] = median, most
    return row


def true_measures(simulated: SimulatedReaches, ideal: SimulatedReaches) -> dict[str, float | None]:
    """Return the measures of a reach between its true boundaries: angles of its trajectory, in
    degrees, and smoothness in the recording of an ideal sensor.
    """
    (times,) = simulated.times
    time_s = np.arange(times.onset_s, times.end_s, TRUTH_S)
    orientation = simulated.movement.pose(simulated.site, time_s).orientation
    turned = np.degrees(angle(multiply(conjugate(orientation[0]), orientation)))
    arrival, departure = np.searchsorted(time_s, (times.arrival_s, times.departure_s)).tolist()
    path = np.degrees(
        angle(multiply(conjugate(orientation[:arrival]), orientation[1 : arrival + 1]))
    ).sum()
    up = rotate(orientation[[0, (arrival + departure) // 2]], np.array(FINGERS))[:, 2]
    at_rest, at_target = np.degrees(np.arcsin(up)).tolist()
    reach = between_true_times(ideal)
    return {
        "excursion_deg": float(turned[:departure].max()),
        "straightness": float(turned[arrival] / path),
        "return_error_deg": float(turned[-1]),
        "inclination_rest_deg": at_rest,
        "inclination_target_deg": at_target,
        "sparc_out": reach.sparc_out,
        "ldlj_out": reach.ldlj_out,
    }


def between_true_times(simulated: SimulatedReaches) -> Reach:
    """Return the measures of a reach by the norm of the angular rate as recorded, between its true
    boundaries.
    """
    (times,) = simulated.times
    recording = simulated.recording
    bounds = Bounds(**times._asdict(), axis=(0.0, 0.0, 1.0))
    detected = Detected(
        recording.time_s, recording.rate, recording.rate_hz, (bounds,), by_norm=True
    )
    (reach,) = measure(detected, recording)
    return reach


def _claim(measure: Measure, within: float, rows: list[Row]) -> Claim:
    error = f"{measure.name}_error_{measure.share}"
    off = [row for row in rows if row[error] is not None and row[error] > within]
    sentence = (
        f"The median error of {measure.name} is within {within:g} in each kind."
        if measure.share == "median"
        else f"In 95 % of the reaches of each kind the error of {measure.name} is within "
        f"{within:g}."
    )
    return Claim(
        sentence, ", ".join(f"{row['scenario']}: {row[error]:{measure.form}}" for row in off)
    )
