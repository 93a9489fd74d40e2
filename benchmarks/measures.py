"""Movement measures beside the truth of simulated reaches, and beside those of monalysa on reaches
of people.

Simulated reaches are of ten kinds, about many axes, or of minimum jerk about one axis. Reaches of
people are those in ``tests/data/real-reaches``, each in the window around its label. monalysa
(https://github.com/siva82kb/monalysa) measures smoothness: SPARC and LDLJ; it has no measures of
the path or of times of a reach.
"""

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from benchmarks.reaches import is_same, windows
from benchmarks.real_recordings import EXERCISES, labels, read_exercise
from benchmarks.true_measures import (
    at_true_times,
    bounds_of,
    measured_between,
    true_measures,
    true_trunk_excursion_deg,
)
from sar_tui.motion.analysis import measures as fields
from sar_tui.motion.arrays import lengths
from sar_tui.motion.detection import detect, find
from sar_tui.motion.detector_names import COLUMN_NAMES
from sar_tui.motion.imperfections import PERFECT, Vector
from sar_tui.motion.measures import PEAKS_HZ, TURN_WITHIN_S
from sar_tui.motion.measures import measure as measure_reaches
from sar_tui.motion.orientation import OrientationParameters
from sar_tui.motion.reach import Detected, Hand, Reach
from sar_tui.motion.reach_kinds import KINDS
from sar_tui.motion.samples import Floats, Recording
from sar_tui.motion.smoothness import ldlj, sparc
from sar_tui.motion.synthesis import (
    TABLE_4_1,
    Profile,
    ReachShape,
    minimum_jerk,
    simulate,
)
from sar_tui.motion.trajectories import PLACEMENTS, SimulatedReaches, simulate_reaches
from sar_tui.perception.reach import trunk_excursion_deg

Errors = Mapping[str, Sequence[float]]
Range = tuple[float, float]
REACHES = 50
"""Simulated reaches of each kind."""


STOPPING = ("lift-extend-touch", "drinking", "submovements")
"""Kinds with stops on the way, one of which may be taken for the target."""


class Limit(NamedTuple):
    """Largest median, and 95th percentile, of the errors of a measure in each kind of reach.

    ``except_for``: kinds whose 95th percentile may be larger.
    """

    median: float
    most: float
    except_for: tuple[str, ...] = ()


LIMITS: Mapping[str, Limit] = {
    "excursion_deg": Limit(0.2, 0.5, ("forearm-rotation",)),
    "return_error_deg": Limit(0.2, 0.5, ("forearm-rotation",)),
    "inclination_rest_deg": Limit(0.5, 1.0),
    "inclination_target_deg": Limit(
        0.5, 1.0, ("lift-extend-touch", "submovements", "forearm-rotation")
    ),
    "straightness": Limit(0.02, 0.05, STOPPING),
    "sparc_out": Limit(0.05, 0.3, STOPPING),
}
LARGEST_TRUNK_DEG, LARGEST_BIASED_DEG, LARGEST_SPARC_CHANGE = 1.0, 2.0, 0.01
LARGEST_DIFFERENCE = 1e-6
WAYS_S = (0.5, 1.0, 1.5, 2.0)
RATES_HZ = (50.0, 100.0, 250.0, 1000.0)
NOISES_DEG_S = (0.0, 0.5, 1.0, 2.0)
JERK_HZ = 100.0
WAY = ReachShape(out_s=1.0, back_s=1.0, dwell_s=0.3, peak_out=1.5, peak_back=-1.5)
SHARES = (0.01, 0.02, 0.05)
"""Shares of its largest rate, at which a way may be taken to begin."""
SHAKEN_S, TREMOR_HZ, TREMOR_RAD_S = (1.0, 1.5), 5.0, 0.15
BIASED = ReachShape(out_s=0.85, back_s=0.85, dwell_s=0.3, peak_out=1.5, peak_back=-1.5)
_WAYS = ("out", "back")
PEOPLE = (
    "sparc",
    "ldlj_out",
    "ldlj_back",
    "straightness",
    "excursion_deg",
    "reach_time_ms",
    "time_to_peak_ms",
    "movement_units",
)


def measure(quick: bool, measured: Callable[[], None]) -> dict[str, Any]:
    """Return all figures; ``measured`` is called after each kind of reach and each recording."""
    kinds = {}
    for kind in KINDS:
        kinds[kind] = errors_of(kind, 8 if quick else REACHES)
        measured()
    noisy = {
        (noise_deg_s, rate_hz): smoothness(rate_hz, noise_deg_s, 2 if quick else 20)
        for noise_deg_s, rate_hz in product(NOISES_DEG_S, RATES_HZ)
    }
    measured()
    reaches = []
    for name in EXERCISES[:2] if quick else EXERCISES:
        reaches += list(people(name))
        measured()
    figures = {
        "kinds": {kind: _by_measure(errors) for kind, errors in kinds.items()},
        "exact": exactness(kinds),
        "begins_ms": {
            f"{share:.0%}": 500.0 * (1.0 - math.sqrt(1.0 - math.sqrt(share))) for share in SHARES
        },
        "noise": [
            {"noise_deg_s": noise_deg_s, "rate_hz": rate_hz, "sparc": found[0], "ldlj": found[1]}
            for (noise_deg_s, rate_hz), found in noisy.items()
        ],
        "smooth": {"true boundaries": minimum_jerk_smoothness()} | detectors_smoothness(),
        "tremor": [tremor_indices(takes_s, 5 if quick else 20) for takes_s in SHAKEN_S],
        "biased_deg": largest_biased_deg(),
        "people": distribution(reaches),
        "monalysa": beside_monalysa(reaches),
    }
    return figures | {"checks": _checks(figures, quick)}


def _checks(figures: Mapping[str, Any], quick: bool) -> dict[str, bool]:
    """Return whether the errors are within their limits, by name; without 95 % of few reaches."""
    exact, kinds, theirs = figures["exact"], figures["kinds"].values(), figures["monalysa"]
    sparcs = [each["sparc"] for each in figures["noise"]]
    found = {
        "measures: median errors of every kind are within their limits": all(
            exact[name]["median"] <= limit.median for name, limit in LIMITS.items()
        ),
        f"measures: the trunk's excursion is off by at most {LARGEST_TRUNK_DEG:g}°": all(
            each["trunk_deg"] <= LARGEST_TRUNK_DEG for each in kinds
        ),
        f"measures: noise and rate change SPARC by at most {LARGEST_SPARC_CHANGE:g}": (
            max(sparcs) - min(sparcs) <= LARGEST_SPARC_CHANGE
        ),
        f"measures: a bias of 1 °/s changes angles by at most {LARGEST_BIASED_DEG:g}°": (
            max(figures["biased_deg"].values()) <= LARGEST_BIASED_DEG
        ),
    }
    if not quick:
        found["measures: 95 % of errors are within theirs, exceptions aside"] = all(
            exact[name]["most"] <= limit.most for name, limit in LIMITS.items()
        )
    for name in ("sparc", "ldlj"):
        same = f"measures: {name.upper()} differs from monalysa's by at most {LARGEST_DIFFERENCE:g}"
        found[same] = theirs[name]["most"] <= LARGEST_DIFFERENCE
    return found


def steps(quick: bool) -> int:
    """Return the number of calls of ``measured``."""
    return len(KINDS) + 1 + (2 if quick else len(EXERCISES))


# --- simulated reaches about many axes


def errors_of(kind: str, reaches: int) -> dict[str, list[float]]:
    """Return the sizes of the errors of each measure, of the reaches of a kind that are found.

    With ``other_stop_deg``: the error of the excursion of each reach whose turn is not in the true
    rest at the target. With ``steady_rad_s``: not an error, but `tremor_action_rad_s` without noise and tremor.
    """
    errors: dict[str, list[float]] = defaultdict(list)
    for seed in range(reaches):
        arm: Hand = "left" if seed % 2 else "right"
        placement = seed // 2 % len(PLACEMENTS)
        made = simulate_reaches(kind, seed, arm=arm, placement=placement, sternum=True)
        ideal = simulate_reaches(kind, seed, arm=arm, placement=placement, imperfections=PERFECT)
        steady = at_true_times(ideal).tremor_action_rad_s
        if steady is not None:
            errors["steady_rad_s"].append(steady)
        found = detect(made.recording, hand=arm)
        if len(found) != 1:
            continue
        (reach,) = found
        true = true_measures(made, ideal) | {"trunk_deg": true_trunk_excursion_deg(made)}
        own = {name: getattr(reach, name) for name in LIMITS} | {"trunk_deg": _trunk(made, reach)}
        for name, value in own.items():
            truth = true[name]
            if value is not None and truth is not None:
                errors[name].append(abs(value - truth))
        (times,) = made.times
        early_s, late_s = times.arrival_s - reach.turn_s, reach.turn_s - times.departure_s
        if max(early_s, late_s) > TURN_WITHIN_S:
            errors["other_stop_deg"].append(errors["excursion_deg"][-1])
    return errors


def _trunk(made: SimulatedReaches, reach: Reach) -> float | None:
    assert made.sternum is not None
    return trunk_excursion_deg(made.sternum, reach.onset_s, reach.end_s)


def _by_measure(errors: Errors) -> dict[str, Any]:
    """Return the figures of a kind of reach."""
    found = len(errors["excursion_deg"])
    return {name: _percentiles(errors[name], 50, 95) for name in LIMITS} | {
        "found": found,
        "other_stop": len(errors["other_stop_deg"]) / found,
        "other_stop_deg": max(errors["other_stop_deg"], default=None),
        "trunk_deg": max(errors["trunk_deg"]),
        "steady_rad_s": _percentiles(errors["steady_rad_s"], 50, 100),
    }


def exactness(kinds: Mapping[str, Errors]) -> dict[str, Any]:
    """Return for each measure the largest median of a kind, the largest 95th percentile of the
    kinds without exceptions, and those of the exceptions.
    """
    found = {}
    for name, limit in LIMITS.items():
        both = {kind: _percentiles(errors[name], 50, 95) for kind, errors in kinds.items()}
        found[name] = {
            "median": max(median for median, _ in both.values()),
            "most": max(most for kind, (_, most) in both.items() if kind not in limit.except_for),
            "except": {kind: both[kind][1] for kind in limit.except_for},
        }
    return found


# --- minimum-jerk movements about one axis


def minimum_jerk_smoothness() -> dict[str, Range]:
    """Return the least and the largest SPARC and LDLJ of a minimum-jerk speed, without a sensor."""
    speeds = [
        (minimum_jerk(np.linspace(0.0, 1.0, round(way_s * rate_hz) + 1)), rate_hz)
        for way_s, rate_hz in product(WAYS_S, RATES_HZ)
    ]
    return {
        name: _range(smooth(speed, rate_hz) for speed, rate_hz in speeds)
        for name, smooth in (("sparc", sparc), ("ldlj", ldlj))
    }


def smoothness(rate_hz: float, noise_deg_s: float, recordings: int) -> tuple[float, float]:
    """Return SPARC and LDLJ of the same slow way out, mean of recordings that begin between two
    samples.
    """
    profile = Profile(noise_rad_s=math.radians(noise_deg_s))
    ways = []
    for seed in range(recordings):
        onset_s = 2.0 + (seed + 0.5) / recordings / rate_hz
        recording = simulate([WAY], profile, rate_hz=rate_hz, rest_s=onset_s, seed=seed).recording
        reach = measured_between(recording, bounds_of(WAY, onset_s))
        ways.append((reach.sparc_out, reach.ldlj_out))
    means: Floats = np.array(ways, dtype=float).mean(axis=0)
    return float(means[0]), float(means[1])


def detectors_smoothness() -> dict[str, dict[str, Range]]:
    """Return by detector the least and the largest SPARC and LDLJ of the ways of the thesis' eight
    reaches, as of minimum jerk and without noise.
    """
    recordings = [simulate([row.shape]).recording for row in TABLE_4_1]
    found: dict[str, dict[str, Range]] = {}
    for detector in COLUMN_NAMES:
        reaches = [reach for recording in recordings for reach in detect(recording, detector)]
        found[detector] = {
            name: _range(getattr(reach, f"{name}_{way}") for reach in reaches for way in _WAYS)
            for name in ("sparc", "ldlj")
        }
    return found


def tremor_indices(takes_s: float, recordings: int) -> dict[str, float]:
    """Return the tremor index of a minimum-jerk reach that takes so long, without tremor and with
    it: the median of tremors of different phases.
    """
    shape = ReachShape(out_s=takes_s / 2, back_s=takes_s / 2, peak_out=2.0, peak_back=-2.0)

    def index(profile: Profile) -> float:
        recordings_of = (simulate([shape], profile, seed=seed) for seed in range(recordings))
        reaches = [measured_between(each.recording, bounds_of(shape)) for each in recordings_of]
        return float(np.median(np.array([reach.tremor_index for reach in reaches], dtype=float)))

    shaken = Profile(tremor_hz=TREMOR_HZ, tremor_rad_s=TREMOR_RAD_S)
    return {"takes_s": takes_s, "without": index(Profile()), "with": index(shaken)}


def largest_biased_deg() -> dict[str, float]:
    """Return the largest error of angles of a reach by the fixed-threshold detector, which leaves
    the bias, among biases of 1 °/s in all directions.
    """
    true = detect(simulate([BIASED]).recording)[0]
    largest: dict[str, float] = defaultdict(float)
    for x, y, z in product((-1.0, 0.0, 1.0), repeat=3):
        if (length := math.hypot(x, y, z)) == 0:
            continue
        per_axis = math.radians(1.0) / length
        bias: Vector = (x * per_axis, y * per_axis, z * per_axis)
        (reach,) = detect(simulate([BIASED], Profile(bias_rad_s=bias)).recording, "fixed-threshold")
        for name in ("excursion_deg", "return_error_deg"):
            off = abs(getattr(reach, name) - getattr(true, name))
            largest[name] = max(largest[name], off)
    return dict(largest)


# --- reaches of people


class Labelled(NamedTuple):
    """A labelled reach of a person with its measures, and the speed on its ways out and back."""

    manner: str
    reach: Reach
    rate_hz: float
    out: Floats
    back: Floats


def people(name: str) -> Iterator[Labelled]:
    """Yield the labelled reaches in a recording that are found in the windows around them."""
    whole = read_exercise(name)
    for part in labels(name):
        for label, window in windows(part):
            inside = (whole.time_s >= window.from_s) & (whole.time_s < window.to_s)
            assert whole.acceleration is not None
            recording = Recording(
                whole.time_s[inside], whole.rate[inside], whole.acceleration[inside]
            )
            # as in a session: it begins at home
            found = find(recording, parameters=OrientationParameters(home_s=0.0))
            same = tuple(
                bounds for bounds in found.reaches if is_same((bounds.onset_s, bounds.end_s), label)
            )
            for reach in measure_reaches(found._replace(reaches=same[:1]), recording):
                yield Labelled(part.manner, reach, found.rate_hz, *_ways(found, reach))


def _ways(found: Detected, reach: Reach) -> tuple[Floats, Floats]:
    """Return the speed between a reach's boundaries, about any axis, without noise above
    ``PEAKS_HZ``.
    """
    assert found.spectrum is not None
    speed = lengths(found.spectrum.below(min(PEAKS_HZ, found.rate_hz / 4)))
    arrival_s, departure_s = reach.onset_s + reach.out_s, reach.end_s - reach.back_s
    out = (found.time_s >= reach.onset_s) & (found.time_s <= arrival_s + 1e-9)
    back = (found.time_s >= departure_s - 1e-9) & (found.time_s <= reach.end_s)
    return speed[out], speed[back]


def distribution(reaches: Sequence[Labelled]) -> dict[str, dict[str, Any]]:
    """Return by manner the quartiles of each measure."""
    found: dict[str, dict[str, Any]] = {}
    for manner in dict.fromkeys(each.manner for each in reaches):
        own = [fields(each.reach) for each in reaches if each.manner == manner]
        found[manner] = {"reaches": len(own)}
        for name in PEOPLE:
            known = np.array([each[name] for each in own], dtype=float)
            found[manner][name] = _percentiles(known[~np.isnan(known)], 25, 50, 75)
    return found


def beside_monalysa(reaches: Sequence[Labelled]) -> dict[str, Any]:
    """Return the differences of smoothness from that of monalysa, of the same speed on the same
    way.

    LDLJ depends on the sample rate, so ours is defined at 100 samples a second. It is compared on
    speeds that a cubic spline brought there, and as stored with monalysa's at the recording's rate.
    """
    # import slowly, and are development dependencies
    from monalysa.quality import smoothness as monalysa
    from scipy.interpolate import CubicSpline

    differences: dict[str, list[float]] = defaultdict(list)
    for each in reaches:
        for way, speed in zip(_WAYS, (each.out, each.back), strict=True):
            ours = {name: getattr(each.reach, f"{name}_{way}") for name in ("sparc", "ldlj")}
            if None in ours.values():
                continue
            theirs = monalysa.sparc(speed, each.rate_hz)[0]
            differences["sparc"].append(abs(ours["sparc"] - theirs))
            theirs = monalysa.log_dimensionless_jerk(speed, each.rate_hz)
            differences["ldlj, recorded rate"].append(abs(ours["ldlj"] - theirs))
            time_s = np.arange(len(speed)) / each.rate_hz
            often = CubicSpline(time_s, speed)(np.arange(0.0, time_s[-1], 1.0 / JERK_HZ))
            theirs = monalysa.log_dimensionless_jerk(often, JERK_HZ)
            differences["ldlj"].append(abs((ldlj(often, JERK_HZ) or math.inf) - theirs))
            differences["ldlj, spline"].append(abs(ours["ldlj"] - theirs))
    return {
        name: {"ways": len(each), "median": float(np.median(each)), "most": max(each)}
        for name, each in differences.items()
    }


# --- figures


def _percentiles(values: Sequence[float] | Floats, *shares: float) -> list[float]:
    found: list[float] = np.percentile(values, shares).tolist()
    return found


def _range(values: Iterable[float | None]) -> Range:
    known = [value for value in values if value is not None]
    return min(known), max(known)
