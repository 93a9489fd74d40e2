"""Examination of a motion sensor: whether it is fit for the reaching task."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from sar_tui.app.sensor_advice import ENOUGH, FEW_LOST, LARGE_BIAS_RAD_S, placing
from sar_tui.app.sensor_monitor import SensorWatch
from sar_tui.inputs.recording_file import LOWEST_RATE_HZ
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.samples import Samples, join

LOOK = 20 * MS
"""Time between two looks for samples."""
WAIT = 30 * SECOND
"""Longest wait for a sensor."""
PATIENCE = 10 * SECOND
"""Longest wait for the hand to rest."""
REST = 5 * SECOND
"""Time at rest that is measured."""
LIFT = 8 * SECOND
"""Longest wait for the hand to be lifted and laid down."""

GOOD_RATE_HZ = 100.0
LARGE_NOISE_RAD_S = 0.02
"""A fifth of the threshold of the fixed-threshold detector."""
_MOVING_RAD_S = 0.3
_LEAST_LIFT_DEG, _MOST_LIFT_DEG = 15.0, 150.0
_GRAVITY_M_S2, _GRAVITY_ERROR_M_S2 = 9.81, 2.0

_FLAT = "Lay the hand flat on the table, palm down, and keep it still."
_LIFT = "Now lift the fingers, with the wrist on the table, and lay them down again."
_NOT_UP = (
    "With the palm on the table, z does not point up: the sensor is turned over, or lies on its "
    "side."
)
_WRONG_AXIS = {
    "-x": "It points to the wrist: turn it round, so that y points along the fingers.",
    "+y": "It lies across the hand: turn it by a quarter, so that y points along the fingers.",
    "-y": "It lies across the hand: turn it by a quarter, so that y points along the fingers.",
    "+z": "The hand turned flat on the table, or z does not point out of the back of the hand.",
    "-z": "The hand turned flat on the table, or z does not point out of the back of the hand.",
}

Pause = Callable[[int], None]
Say = Callable[[str], None]
Verdict = Literal["fit", "with care", "not fit"]


@dataclass(kw_only=True)
class Examined:
    """Result of an examination.

    ``lost``: samples that never arrived; ``dropped``: those that could not be used. Noise is the
    standard deviation at rest, over the three axes; None if the hand did not rest. ``lifted``: the
    axis about which the hand turned when its fingers were lifted, and by how much.
    """

    source: str
    model: str = ""
    serial: str = ""
    rate_hz: float | None = None
    nominal_hz: float | None = None
    received: int = 0
    lost: int = 0
    dropped: int = 0
    saturated: int = 0
    bias_rad_s: float | None = None
    noise_rad_s: float | None = None
    noise_m_s2: float | None = None
    lifted: str = ""
    lifted_deg: float | None = None
    verdict: Verdict = "fit"
    problems: list[str] = field(default_factory=list)

    def mind(self, problem: str, verdict: Verdict = "with care") -> None:
        """Note a problem; the verdict is never better than before."""
        self.problems.append(problem)
        if self.verdict != "not fit":
            self.verdict = verdict


def examine(
    source: str, watch: SensorWatch, pause: Pause, say: Say, *, at_rest: bool = False
) -> Examined:
    """Examine a sensor: at rest, and while the fingers are lifted.

    Args:
        source: its name.
        watch: watches its feed, which has been started.
        pause: waits for a time in ns.
        say: shows a line to the person.
        at_rest: True to leave the movement out.
    """
    found = Examined(source=source)
    if not _attach(watch, pause, say):
        missing = "" if watch.state == "failed" else "No sensor was found. "
        found.mind(f"{missing}{watch.detail}".strip(), "not fit")
        return found
    info = watch.feed.info
    if info:
        found.model, found.serial, found.nominal_hz = info.model, info.serial, info.rate_hz
    say(_FLAT)
    up = _rest(found, watch, pause)
    is_simulated = hasattr(watch.feed.source, "move")
    if not (at_rest or is_simulated or not watch.attached or watch.too_slow):
        say(_LIFT)
        _lift(found, watch, pause)
    _count(found, watch)
    if not watch.attached or watch.stalled or not found.received:
        found.mind(watch.detail or "It stopped sending.", "not fit")
        return found
    _judge_samples(found, too_slow=watch.too_slow)
    _judge_rest(found)
    _judge_axes(found, up)
    if watch.trouble:
        found.mind(watch.trouble)
    return found


def _attach(watch: SensorWatch, pause: Pause, say: Say) -> bool:
    """Wait for the sensor, and say what is waited for; return True if there is one."""
    said, waited = "", 0
    while not watch.attached and waited < WAIT:
        pause(LOOK)
        waited += LOOK
        watch.look()
        if waited > SECOND and watch.detail not in ("", said):
            said = watch.detail
            say(said)
    return watch.attached


def _rest(found: Examined, watch: SensorWatch, pause: Pause) -> list[float] | None:
    """Measure rate and noise while the hand rests; return the acceleration, which points up.

    It is None if the hand did not rest, or the sensor does not measure it.
    """
    blocks, until = [], watch.waited + PATIENCE
    while watch.attached and watch.waited < until and (watch.still_s or 0.0) * SECOND < REST:
        pause(LOOK)
        blocks.append(watch.look())
    found.rate_hz = round(watch.feed.rate_hz, 1)
    samples = _joined(blocks)
    if not watch.still_s or len(samples) < 2:
        return None
    still = samples[samples["at"] > samples["at"][-1] - watch.still_s * SECOND]
    rate, acceleration = still["rate"].astype(float), still["acceleration"].astype(float)
    found.bias_rad_s = round(float(np.linalg.norm(rate.mean(axis=0))), 5)
    found.noise_rad_s = round(float(np.linalg.norm(rate.std(axis=0))), 5)
    if not np.isfinite(acceleration).all():
        return None
    found.noise_m_s2 = round(float(np.linalg.norm(acceleration.std(axis=0))), 4)
    up: list[float] = acceleration.mean(axis=0).tolist()
    return up


def _lift(found: Examined, watch: SensorWatch, pause: Pause) -> None:
    """Find the axis about which the hand turns when its fingers are lifted."""
    bias, begun, blocks, has_moved = watch.bias, watch.waited, [], False
    while watch.attached and watch.waited - begun < LIFT:
        pause(LOOK)
        blocks.append(watch.look())
        has_moved = has_moved or watch.still_s == 0.0
        if has_moved and (watch.still_s or 0.0) >= 1.0:
            break
    axis, degrees = turned(_joined(blocks), bias)
    found.lifted_deg = round(degrees, 1)
    if degrees >= _LEAST_LIFT_DEG:
        found.lifted = axis


def turned(samples: Samples, bias: tuple[float, float, float] | None) -> tuple[str, float]:
    """Return the axis about which the hand first turned farthest, such as ``+x``, and the angle in
    degrees.
    """
    if len(samples) < 2:
        return "", 0.0
    rate = samples["rate"].astype(float) - np.array(bias or (0.0, 0.0, 0.0))
    moving = np.flatnonzero(np.linalg.norm(rate, axis=1) > _MOVING_RAD_S)
    if not len(moving):
        return "", 0.0
    steps_s = np.diff(samples["at"], prepend=samples["at"][0]) / 1e9
    angle = np.cumsum((rate * steps_s[:, None])[moving[0] :], axis=0)
    farthest = angle[np.linalg.norm(angle, axis=1).argmax()]
    axis = int(np.abs(farthest).argmax())
    sign = "+" if farthest[axis] > 0 else "-"
    return f"{sign}{'xyz'[axis]}", float(np.degrees(np.linalg.norm(farthest)))


def _joined(blocks: list[Samples]) -> Samples:
    return join([block for block in blocks if len(block)])


# --- the verdict


def _count(found: Examined, watch: SensorWatch) -> None:
    feed = watch.feed
    found.received, found.dropped = feed.received, feed.dropped
    found.lost = max(0, feed.lost - watch.unmeasured)
    found.saturated = watch.saturated


def _judge_samples(found: Examined, *, too_slow: bool) -> None:
    rate_hz, nominal_hz = found.rate_hz or 0.0, found.nominal_hz or 0.0
    if too_slow or rate_hz < LOWEST_RATE_HZ:
        found.mind("It sends too few samples a second to see a reach.", "not fit")
    elif rate_hz < GOOD_RATE_HZ:
        found.mind("It sends fewer than 100 samples a second: times are less exact.")
    elif rate_hz < ENOUGH * nominal_hz:
        found.mind("It sends fewer samples a second than it should.")
    if found.lost + found.dropped > FEW_LOST * found.received:
        found.mind(
            "More than 1 % of its samples are missing: try another cable, port or network.",
            "not fit",
        )


def _judge_rest(found: Examined) -> None:
    if found.noise_rad_s is None:
        found.mind("The hand did not rest, so noise and bias were not measured.")
    elif found.noise_rad_s > LARGE_NOISE_RAD_S:
        found.mind("It is noisy at rest: was the hand still?")
    if (found.bias_rad_s or 0.0) > LARGE_BIAS_RAD_S:
        found.mind("Its bias is large: the fixed-threshold detector does not work with it.")


def _judge_axes(found: Examined, up: list[float] | None) -> None:
    is_up = True
    if up:
        size = math.hypot(*up)
        if abs(size - _GRAVITY_M_S2) > _GRAVITY_ERROR_M_S2:
            found.mind(
                f"At rest it measures {size:.1f} m/s² in place of 9.8: its acceleration has "
                "another unit."
            )
        elif not (is_up := placing((up[0], up[1], up[2])).mark == "right"):
            found.mind(_NOT_UP)
    if found.lifted_deg is None:
        return
    if not found.lifted:
        found.mind(
            "The fingers were not lifted, so its axes were not checked: do it again. If they were "
            "lifted, its rates have another unit."
        )
    elif found.lifted_deg > _MOST_LIFT_DEG:
        found.mind(
            f"The hand cannot turn by {found.lifted_deg:.0f}°: the sensor must send rad/s, and "
            "seems to send deg/s.",
            "not fit",
        )
    elif is_up and (wrong := _WRONG_AXIS.get(found.lifted)):
        found.mind(wrong)
