"""Perception of a hand that moves to and fro: the moments at which it turns back."""

from collections.abc import Sequence

import numpy as np

from sar_tui.api.node import (
    IMU,
    PROMPT,
    REACH,
    SENSOR,
    TIMER,
    TRIAL,
    VOIDED,
    Floats,
    ImuBlock,
    KeptSamples,
    Prompt,
    PromptVoided,
    ReachPerceived,
    Samples,
    SensorChanged,
    TimedNode,
    TrialEnded,
    on,
    turning_points,
)

LEAST_RAD = 0.15
"""A smaller movement is no swing."""
WOBBLE = 0.35
"""A movement smaller than this share of a typical swing belongs to the swing that it interrupts."""
SMOOTH_S = 0.1
"""The angular rate is averaged over this time: a tremor moves a slow turn by little then."""
_FEWEST = 20
_GAP_STEPS = 5.0


class Turns(TimedNode):
    """Keeps the samples of a prompt, and reports each turn at its end, as a reach with nothing but
    a ``turn``.

    A last report, closed by ``timeout``, says that all turns were reported, or in ``invalid`` why
    there are none.

    Args:
        rest_ms: the reports come so long before the prompt's time for the response is over.
    """

    name = "turns"
    emits = (TIMER, REACH)

    def __init__(self, rest_ms: float) -> None:
        super().__init__()
        self._rest_ns = round(rest_ms * 1e6)
        self._kept = KeptSamples()
        self._is_watching = False

    @property
    def seat(self) -> str:
        """The participant whose hand it watches."""
        return "A"

    def foresee(self, samples: Samples, ends: Sequence[int]) -> int | None:
        """Return None: no sample makes it react (see `inputs.simulated_sensor.Foresight`)."""
        return None

    @on(PROMPT)
    def prompted(self, prompt: Prompt) -> None:
        self._kept.clear()
        self._is_watching = True
        self.set_timer("over", self.now + prompt.timeout - self._rest_ns)

    @on(IMU)
    def add_samples(self, block: ImuBlock) -> None:
        if self._is_watching:
            self._kept.add(block.samples)

    @on(SENSOR)
    def sensor_changed(self, sensor: SensorChanged) -> None:
        if sensor.state == "attached":
            self._kept.clear()

    @on(VOIDED)
    def voided(self, _: PromptVoided) -> None:
        self._stop()

    @on(TRIAL)
    def trial_ended(self, _: TrialEnded) -> None:
        self._stop()

    def _stop(self) -> None:
        self._is_watching = False
        self.cancel_timers()

    def timer(self, name: str, late: int) -> None:
        """Report the turns."""
        samples = self._kept.all()
        self._stop()
        last = int(samples["at"][-1]) if len(samples) else self.now
        invalid = fault(samples)
        for at in () if invalid else turn_times(samples):
            self.emit(
                REACH, ReachPerceived(at=at, delay=self.now - last, turn=at, closed="stillness")
            )
        self.emit(
            REACH, ReachPerceived(at=last, delay=self.now - last, closed="timeout", invalid=invalid)
        )


def fault(samples: Samples) -> str:
    """Return why turns cannot be found in samples: there are too few, or some are missing; empty if
    they can.
    """
    if len(samples) < _FEWEST:
        return "samples"
    steps = np.diff(samples["device_ms"])
    return "gap" if float(steps.max()) > _GAP_STEPS * float(np.median(steps)) else ""


def turn_times(samples: Samples) -> list[int]:
    """Return when a hand that swings to and fro turned back, in ns of the session's clock.

    Its angle is followed about the main axis of its swings, the first principal component of the
    angular rate. Where a first swing begins from rest, and where a last one ends, is no turn.

    Args:
        samples: dtype SAMPLE, `_FEWEST` or more.
    """
    at = samples["at"].astype(float)
    rate = samples["rate"].astype(float)
    rate -= rate.mean(axis=0)  # the sensor's bias: the hand comes back
    axis = np.linalg.eigh(rate.T @ rate)[1][:, -1]
    step_s = float(np.median(np.diff(at))) / 1e9
    turning = _smoothed(rate @ axis, max(1, round(SMOOTH_S / step_s)))
    angle = np.cumsum(turning) * step_s
    swings = np.abs(np.diff(angle[turning_points(angle.tolist(), LEAST_RAD)]))
    if not len(swings):
        return []
    found = turning_points(angle.tolist(), max(LEAST_RAD, WOBBLE * float(np.median(swings))))
    return [_crossing(at, turning, index) for index in found[1:-1]]


def _smoothed(values: Floats, width: int) -> Floats:
    """Return a moving average over an odd number of samples, without delay."""
    half = width // 2
    padded = np.pad(values, half, mode="edge")
    return np.convolve(padded, np.full(2 * half + 1, 1 / (2 * half + 1)), mode="valid")


def _crossing(at: Floats, turning: Floats, index: int) -> int:
    """Return when the angular rate was 0 between an extreme of the angle and the sample after it,
    ns.
    """
    if index + 1 >= len(at) or turning[index] * turning[index + 1] >= 0:
        return int(at[index])
    share = turning[index] / (turning[index] - turning[index + 1])
    return int(at[index] + share * (at[index + 1] - at[index]))
