"""State of a motion sensor before a session: attached or not, at rest or moving, and a test
reach.
"""

import math
from collections import deque
from collections.abc import Callable
from typing import Literal

from sar_tui.inputs.imu import Status, Vector
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.model.language import Sentence
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.analysis import AnalysisParameters, Finding, Window, analyse
from sar_tui.motion.detection import LEAST_SHARE
from sar_tui.motion.reach import Hand
from sar_tui.motion.samples import Samples, join
from sar_tui.motion.segmenter import Segmenter
from sar_tui.motion.synthesis import TABLE_4_1
from sar_tui.motion.trace import Trace, trace_of

_TOO_FAST = "The hand was faster than the sensor can measure."
SETTLED_S = 1.0
"""A hand that has not moved for this long is at rest."""
OVER_S = 2.5
"""A hand that has moved and then rested for this long has finished the reach."""
REST = 3 * SECOND
"""Time before a test reach whose samples are kept, to measure the hand at rest."""
REST_PATIENCE = 8 * SECOND
"""Longest time that a test reach waits for rest; then it continues without."""
REACH_PATIENCE = 15 * SECOND
"""A test reach ends after this time in any case."""
State = Literal["none", "attached", "unplugged", "failed", "ended"]
CALIBRATING = 3
"""Number of reaches by which a person's least turn is estimated."""
LEAST_TURN_DEG = 3.0
"""Smallest estimate: less is the unrest of a hand."""
USABLE = frozenset(("disagree", "low_rate", "no_rest", "reversed"))
"""Flags of a reach whose turn is right all the same."""
RECENT = 5 * SECOND
"""Time for which trouble is shown."""

_SIMULATED_REACTION = 700 * MS
_SIMULATED_REACH = TABLE_4_1[2].shape
_LATEST_S, _UP_S, _BIAS_S = 0.1, 0.5, 1.0


class ReachTest:
    """A reach to test the sensor with: first rest, then out and back, then the result.

    ``step``: ``rest`` (waits until the hand rests), ``reach`` (waits until it has been out and
    back, and rests), ``done`` (there is a ``finding``, and a ``trace`` if there was a reach),
    ``lost`` (the sensor is gone).
    """

    def __init__(self, now: int) -> None:
        self.step: Literal["rest", "reach", "done", "lost"] = "rest"
        self.since = now
        self.flags: list[str] = []
        self.finding: Finding | None = None
        self.trace: Trace | None = None

    @property
    def is_running(self) -> bool:
        """True while it waits for the hand."""
        return self.step in ("rest", "reach")


class Calibration:
    """A person's own reaches, and the least turn of the hand that follows from them.

    Attributes:
        turned_deg: largest angle of each reach that is used.
        refused: the last reach, if it cannot be used.
    """

    def __init__(self) -> None:
        self.turned_deg: list[float] = []
        self.refused: Finding | None = None

    @property
    def is_over(self) -> bool:
        """True if there are enough reaches."""
        return len(self.turned_deg) >= CALIBRATING

    @property
    def least_turn_deg(self) -> float:
        """The least turn, in whole degrees."""
        return max(LEAST_TURN_DEG, float(round(LEAST_SHARE * min(self.turned_deg))))

    def add(self, found: Finding) -> None:
        """Use a reach, unless it is in doubt."""
        turned = found.details.get("excursion_deg")
        if USABLE.issuperset(found.flags) and not found.invalid and isinstance(turned, float):
            self.turned_deg.append(turned)
            self.refused = None
        else:
            self.refused = found


class SensorWatch:
    """Drains a started feed, and follows the state of its sensor. It has no timer.

    Args:
        feed: the sensor's feed.
        now: the time, in ns of the feed's clock.
        hand: the hand with the sensor.

    Attributes:
        state: ``none`` (no sensor yet), ``attached``, ``unplugged``, ``failed`` (``detail`` says
            why), ``ended`` (a recording is over).
        since: the time that state began.
        detail: message of the source about it.
        stalled: True if an attached sensor sends nothing.
        too_slow: True if it sends too few samples a second to measure a reach.
        saturated: number of samples beyond its range; ``unmeasured``: those of them that were not
            sent.
        test: the test reach, once there was one.
        calibration: by some test reaches, while it is under way.
        calibrated: the last one that was finished, and not forgotten.
        least_confidence: a test reach of which the detector is less sure is flagged ``unsure``.
        before: model and serial number of the sensor that the participant wore last time; None if
            there was none.
    """

    def __init__(self, feed: ImuFeed, now: Callable[[], int], hand: Hand) -> None:
        self.feed = feed
        self.hand: Hand = hand
        self.state: State = "none"
        self.since = now()
        self.detail = ""
        self.stalled = self.too_slow = False
        self.saturated = self.unmeasured = 0
        self.test: ReachTest | None = None
        self.calibration: Calibration | None = None
        self.calibrated: Calibration | None = None
        self.least_confidence = 0.0
        self.before: tuple[str, str] | None = None
        self._now = now
        self._trouble: tuple[int, str] | None = None
        self._blocks: deque[Samples] = deque()
        self._segmenter: Segmenter | None = None

    def look(self) -> Samples:
        """Take the samples and reports that arrived since the last look; return the samples."""
        samples, statuses = self.feed.drain()
        for status in statuses:
            self._on_status(status)
        if len(samples) and self.attached:
            self._blocks.append(samples)
            if self._segmenter:
                self._segmenter.push(samples["at"] / 1e9, samples["rate"].astype(float))
        self._forget()
        if self.test and self.test.is_running:
            self._continue_test(self.test)
        return samples

    # --- state

    @property
    def attached(self) -> bool:
        """True if there is a sensor."""
        return self.state == "attached"

    @property
    def waited(self) -> int:
        """Time in the present state, in ns."""
        return self._now() - self.since

    @property
    def trouble(self) -> str:
        """Recent trouble that the attached sensor reported; empty for none."""
        at, words = self._trouble or (0, "")
        return words if self._now() - at < RECENT else ""

    @property
    def still_s(self) -> float | None:
        """Time the hand has rested, in s, 0 while it moves; None if that is not known."""
        return self._segmenter.still_for_s if self._segmenter and self._is_measuring else None

    @property
    def rate(self) -> Vector | None:
        """Present angular rate of the hand, rad/s; None if nothing is measured."""
        return self._mean("rate", _LATEST_S)

    @property
    def bias(self) -> Vector | None:
        """Bias: the rate measured while the hand rests, rad/s; None while it moves."""
        return self._mean("rate", _BIAS_S) if (self.still_s or 0.0) >= SETTLED_S else None

    @property
    def up(self) -> Vector | None:
        """Recent acceleration, m/s², which points up at rest; None if it is not measured."""
        return self._mean("acceleration", _UP_S)

    @property
    def _is_measuring(self) -> bool:
        return self.attached and not self.stalled and bool(self._blocks)

    def _mean(self, what: str, latest_s: float) -> Vector | None:
        if not self._is_measuring:
            return None
        samples = self._samples(round(latest_s * SECOND))
        x, y, z = samples[what].astype(float).mean(axis=0).tolist()
        return (x, y, z) if math.isfinite(x + y + z) else None

    def _samples(self, latest: int) -> Samples:
        """Return the samples of the last ``latest`` ns."""
        newest = int(self._blocks[-1]["at"][-1])
        blocks = []
        for block in reversed(self._blocks):
            blocks.append(block)
            if block["at"][0] <= newest - latest:
                break
        samples = join(blocks[::-1])
        return samples[samples["at"] > newest - latest]

    def _forget(self) -> None:
        """Forget all samples except those of the last seconds and of a test reach."""
        oldest = int(self._blocks[-1]["at"][-1]) - REST if self._blocks else 0
        if self.test and self.test.step == "reach":
            oldest = self.test.since - REST
        while self._blocks and self._blocks[0]["at"][-1] < oldest:
            self._blocks.popleft()

    # --- the sensor

    def _on_status(self, status: Status) -> None:
        match status.state:
            case "attached":
                self._enter("attached", "")
                self._attach()
            case "detached":
                self._enter("none" if self.state == "none" else "unplugged", status.detail)
            case "ended":
                self._enter("ended", status.detail)
            case "stalled" | "flowing":
                self.stalled = status.state == "stalled"
            case "saturated":
                self.saturated += status.count
                self.unmeasured += status.count if status.duration_ms else 0
                self._trouble = (self._now(), Sentence(_TOO_FAST))
                self._flag("saturated")
            case "error" if self.attached:
                self._trouble = (self._now(), status.detail)
                self._flag("error")
            case "error":
                self._enter("failed", status.detail)

    def _enter(self, state: State, detail: str) -> None:
        """Enter a state, and forget what was measured before."""
        if state != self.state:
            self.since = self._now()
        self.state, self.detail = state, detail
        self.stalled = self.too_slow = False
        self._trouble = self._segmenter = None
        self._blocks.clear()
        if self.test and self.test.is_running:
            self.test.step = "lost"

    def _attach(self) -> None:
        info = self.feed.info
        try:
            self._segmenter = Segmenter(info.rate_hz if info else 0.0)
        except ValueError:
            self.too_slow = True

    def _flag(self, flag: str) -> None:
        if self.test and self.test.step == "reach" and flag not in self.test.flags:
            self.test.flags.append(flag)

    # --- the test reach

    @property
    def keeps_bias(self) -> bool:
        """True if the sensor is known to be none that can take its present rate as zero."""
        return bool(getattr(self.feed.source, "keeps_bias", False))

    def zero(self) -> None:
        """Ask the sensor to take its present rate as zero."""
        self.feed.source.zero()

    def begin_test(self) -> None:
        """Begin a test reach, or begin it again. Without a sensor it is ``lost`` at once."""
        self.calibration = None
        self._begin_reach()

    def begin_calibration(self) -> None:
        """Begin the test reaches by which a person's least turn is estimated, or begin them again."""
        self.calibration = Calibration()
        self._begin_reach()

    def forget_calibration(self) -> None:
        """Forget the calibration that is under way, and a finished one."""
        self.calibration = self.calibrated = self.test = None

    def _begin_reach(self) -> None:
        self.test = ReachTest(self._now())
        if not self.attached:
            self.test.step = "lost"

    def _continue_test(self, test: ReachTest) -> None:
        waited, rested = self.waited_in(test), (self.still_s or 0.0) >= SETTLED_S
        if test.step == "rest":
            if rested or waited >= REST_PATIENCE:
                test.step, test.since = "reach", self._now()
                self._move_simulated(test.since + _SIMULATED_REACTION)
            return
        if waited >= REACH_PATIENCE or (
            self._segmenter and self._is_over(self._segmenter, test.since / 1e9)
        ):
            self._close(test)

    def _is_over(self, segmenter: Segmenter, since_s: float) -> bool:
        """True if the hand has been out and back, or moved otherwise, and rests."""
        if segmenter.has_reached(since_s):
            return segmenter.still_for_s >= SETTLED_S
        return (segmenter.began_s or 0.0) > since_s and segmenter.still_for_s >= OVER_S

    def waited_in(self, test: ReachTest) -> int:
        """Return the time a test reach has been in its step, in ns."""
        return self._now() - test.since

    def _move_simulated(self, at: int) -> None:
        """Let a simulated hand make the reach."""
        if move := getattr(self.feed.source, "move", None):
            move(at, _SIMULATED_REACH)

    def _close(self, test: ReachTest) -> None:
        samples = join(self._blocks)
        window = Window(
            from_ns=test.since - REST,
            started_ns=test.since,
            to_ns=self._now() + 1,
            flags=tuple(test.flags),
        )
        parameters = AnalysisParameters(hand=self.hand, least_confidence=self.least_confidence)
        test.finding = found = analyse(samples, window, parameters)
        if found.onset_ns is not None and found.end_ns is not None:
            test.trace = trace_of(
                samples, found.onset_ns, found.end_ns, found.details, "test reach"
            )
        test.step = "done"
        if self.calibration:
            self.calibration.add(found)
            if self.calibration.is_over:
                self.calibrated, self.calibration = self.calibration, None
            else:
                self._begin_reach()
