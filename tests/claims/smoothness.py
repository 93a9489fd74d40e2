"""Smoothness of the same movement, seen by sensors of different rate and noise."""

import math
from collections.abc import Sequence

import numpy as np

from sar_tui.motion.measures import measure
from sar_tui.motion.reach import Bounds, Detected
from sar_tui.motion.synthesis import Profile, ReachShape, simulate
from sar_tui.validation.report import Claim, Conditions, Report, Row

RATES_HZ = (50, 100, 250, 1000)
NOISES_DEG_S = (0.0, 0.3, 1.0, 2.0)
MOVEMENTS = {
    "0.5 s, peak 2.5 rad/s": ReachShape(
        out_s=0.5, back_s=0.5, dwell_s=0.3, peak_out=2.5, peak_back=-2.5
    ),
    "1 s, peak 1.5 rad/s": ReachShape(
        out_s=1.0, back_s=1.0, dwell_s=0.3, peak_out=1.5, peak_back=-1.5
    ),
}
RECORDINGS = 20
REST_S = 2.0
SAME = 0.02
"""Largest difference in SPARC of the same movement."""
MINIMUM_JERK = {"sparc": -1.4058, "ldlj": -5.2241}
"""Smoothness of a minimum-jerk movement at 100 samples a second, as the package monalysa computes
them.
"""
ROUNDED = {"sparc": 0.01, "ldlj": 0.2}
"""Largest difference from these: a recording does not begin with the movement."""


def run(conditions: Conditions) -> Report:
    """Return one row for each movement and each sensor."""
    rows = []
    for number, (name, shape) in enumerate(MOVEMENTS.items()):
        conditions.progress(f"smoothness: {name}", number, len(MOVEMENTS))
        rows += [
            row_of(name, shape, noise, rate_hz) for noise in NOISES_DEG_S for rate_hz in RATES_HZ
        ]
    sparc = [row["sparc"] for row in rows]
    ldlj = [row["ldlj"] for row in rows]
    claims = [
        Claim(
            f"SPARC of the same smooth movement differs by less than {SAME:g} between all these "
            "sensors.",
            "" if max(sparc) - min(sparc) < SAME else f"{min(sparc):.3f} to {max(sparc):.3f}",
        ),
        Claim(
            "LDLJ does not: it differs by more than 1.",
            "" if max(ldlj) - min(ldlj) > 1.0 else f"{min(ldlj):.2f} to {max(ldlj):.2f}",
        ),
        *(_is_known(name, rows) for name in MINIMUM_JERK),
    ]
    return Report(rows, (), claims)


def _is_known(name: str, rows: Sequence[Row]) -> Claim:
    """Return the claim that a measure has the value that others compute for a movement without
    noise.
    """
    ideal = [row[name] for row in rows if (row["noise_deg_s"], row["rate_hz"]) == (0.0, 100)]
    off = [value for value in ideal if abs(value - MINIMUM_JERK[name]) > ROUNDED[name]]
    sentence = (
        f"{name.upper()} of a minimum-jerk movement is {MINIMUM_JERK[name]:.4f}, within "
        f"{ROUNDED[name]:g}."
    )
    return Claim(sentence, ", ".join(f"{value:.4f}" for value in off))


def row_of(name: str, shape: ReachShape, noise_deg_s: float, rate_hz: int) -> Row:
    """Return mean and standard deviation over recordings that begin at different moments between
    two samples.
    """
    smoothness = []
    profile = Profile(noise_rad_s=math.radians(noise_deg_s))
    for seed in range(RECORDINGS):
        onset_s = REST_S + (seed + 0.5) / RECORDINGS / rate_hz
        recording = simulate([shape], profile, rate_hz=rate_hz, rest_s=onset_s, seed=seed).recording
        arrival_s = onset_s + shape.out_s
        departure_s, end_s = arrival_s + shape.dwell_s, onset_s + shape.duration_s
        bounds = Bounds(
            onset_s=onset_s,
            arrival_s=arrival_s,
            departure_s=departure_s,
            end_s=end_s,
            axis=(0.0, 0.0, 1.0),
        )
        detected = Detected(
            recording.time_s, recording.rate, float(rate_hz), (bounds,), by_norm=True
        )
        (reach,) = measure(detected, recording)
        smoothness.append((reach.sparc_out, reach.ldlj_out))
    values = np.array(smoothness, dtype=float)
    (sparc, ldlj), (sparc_sd, ldlj_sd) = (
        values.mean(axis=0).tolist(),
        values.std(axis=0, ddof=1).tolist(),
    )
    return {
        "movement": name,
        "noise_deg_s": noise_deg_s,
        "rate_hz": rate_hz,
        "sparc": sparc,
        "sparc_sd": sparc_sd,
        "ldlj": ldlj,
        "ldlj_sd": ldlj_sd,
    }
