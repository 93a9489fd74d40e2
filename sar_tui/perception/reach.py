"""Perception of reaches: turns the samples of the hand's sensor into one reach, out and back
(thesis 4.2.2).
"""

import math
from collections.abc import Iterator, Sequence
from typing import Literal, NamedTuple

import msgspec
import numpy as np

from sar_tui.loop.clock import STALLED
from sar_tui.loop.node import TimedNode, on
from sar_tui.loop.topics import (
    IMU,
    PERCEIVED,
    PROMPT,
    REACH,
    SENSOR,
    TIMER,
    TRIAL,
    TRUNK_IMU,
    TRUNK_SENSOR,
    VOIDED,
)
from sar_tui.model.messages import (
    ImuBlock,
    KeyPerceived,
    Prompt,
    PromptVoided,
    ReachPerceived,
    SensorChanged,
    TrialEnded,
)
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.analysis import EARLY_NS, NS, AnalysisParameters, Measured, Window, analyse
from sar_tui.motion.filters import LEAST_RATE_HZ
from sar_tui.motion.quaternions import angle, integrate
from sar_tui.motion.rest import even
from sar_tui.motion.samples import Recording, Samples, join, recording
from sar_tui.motion.segmentation import segment
from sar_tui.motion.segmenter import Segmenter, home_since
from sar_tui.motion.single_axis import SingleAxisParameters
from sar_tui.motion.trace import trace_of
from sar_tui.perception.kept_samples import EVER, KeptSamples
from sar_tui.rules.keys import HeldKey


class Hand(NamedTuple):
    """State of a hand: its time at rest, s; True if it has been out and back; the start of its
    movement, s.
    """

    rested_s: float
    reached: bool
    began_s: float | None


STILL = Hand(0.0, False, None)
"""A hand whose movement is not known."""


class Foreseen:
    """Samples that came and samples that are to come, segmented at once.

    Args:
        samples: dtype SAMPLE.
        known: number of samples that came.
        rate_hz: samples per second; below 20 nothing is known of the hand's movement.
        parameters: as for ``single_axis.find``.
    """

    def __init__(
        self, samples: Samples, known: int, rate_hz: float, parameters: SingleAxisParameters
    ) -> None:
        self._samples = samples
        self._known = known
        usable = rate_hz >= LEAST_RATE_HZ
        rate = samples["rate"].astype(float)
        self._found = segment(samples["at"] / 1e9, rate, rate_hz, parameters) if usable else None

    def continues_with(self, samples: Samples) -> bool:
        """Return True if these are the samples that come next."""
        expected = self._samples[self._known : self._known + len(samples)]
        return expected.tobytes() == samples.tobytes()

    def take(self, count: int, since_s: float) -> Hand:
        """Return the state of the hand after the next ``count`` samples, which have come; reached
        since a time (s).
        """
        (hand,) = self.hands((count,), since_s)
        self._known += count
        return hand

    def at_rest(self, counts: Sequence[int], rest_s: float) -> list[int]:
        """Return those of some numbers of samples to come after which the hand has rested for a
        time (s).
        """
        if self._found is None:
            return []
        found = np.array(counts)
        return found[self._found.still_for_s[self._known - 1 + found] >= rest_s].tolist()  # type: ignore[no-any-return]

    def hands(self, counts: Sequence[int], since_s: float) -> Iterator[Hand]:
        """Yield the state of the hand after each of some numbers of samples to come; reached since
        a time (s).
        """
        if self._found is None:
            yield from [STILL] * len(counts)
            return
        index = self._known - 1 + np.array(counts, dtype=np.int_)
        reached = self._found.has_reached(index, since_s)
        began = [
            None if math.isnan(began_s) else began_s
            for began_s in self._found.began_s[index].tolist()
        ]
        yield from map(Hand, self._found.still_for_s[index].tolist(), reached.tolist(), began)


REST = 3 * SECOND
"""Time before a reach from which samples are kept, since the reach before at the most: the hand at
rest shows the sensor's bias.
"""
TAIL = 4 * SECOND
"""Longest wait for the hand to come to rest after the key that ends a reach."""
SETTLED_S = 0.85
"""Stillness after which the hand counts as at rest; longer if the fixed-threshold detector needs
more.
"""
MARGIN_S = 0.05
"""Added to the stillness that the fixed-threshold detector needs."""
PATIENCE = 300 * MS
"""Longest wait for samples after the tail."""
UNMOVED = 1500 * MS
"""A key within this time of the start, without any movement, was pressed by mistake."""


class ReachPerception(TimedNode):
    """Watches the hand from the key that starts a reach to the key that ends it, and reports the
    reach.

    A reach without that second key (forgotten, or not asked for) ends by itself when the hand is
    back and has rested for ``still_ms``, at the latest at the time-out. A reach out of turn is
    reported as soon as it is seen, and not measured.

    Args:
        analysis: how reaches are found and measured.
        still_ms: the time at rest after which a reach ends without a key, in ms.
        seat: the participant; each of two has their own node.
    """

    name = "reach_perception"
    emits = (TIMER, REACH)

    def __init__(self, analysis: AnalysisParameters, still_ms: int, seat: str = "A") -> None:
        super().__init__()
        self._seat = seat
        if seat != "A":
            self.name = f"{self.name}_{seat.lower()}"
        # the samples that are analysed begin at a rest: see `_forget_earlier_movement`
        orientation = msgspec.structs.replace(analysis.orientation, home_s=0.0)
        self._analysis = msgspec.structs.replace(analysis, orientation=orientation)
        self._still_s = still_ms / 1000
        self._settled_s = max(SETTLED_S, analysis.fixed_threshold.still_ms / 1000 + MARGIN_S)
        self._kept = KeptSamples()
        self._over = EVER
        """End of the last reach, ns."""
        self._trunk = Trunk()
        self._rate_hz = 0.0
        self._key = HeldKey()
        self._clear()

    def _clear(self) -> None:
        self._prompt: Prompt | None = None
        self._started = 0
        self._ended: int | None = None
        self._flags: list[str] = []
        self._segmenter: Segmenter | None = None
        self._foreseen: Foreseen | None = None
        self._hand = STILL
        self._dismissed: float | None = None
        self.cancel_timers()

    @property
    def seat(self) -> str:
        """The participant whose hand it watches."""
        return self._seat

    # --- the sensor

    @on(SENSOR)
    def sensor_changed(self, sensor: SensorChanged) -> None:
        """Forget samples from before a sensor was attached; flag faults during a reach."""
        if sensor.seat != self._seat:
            return
        if sensor.state == "attached":
            self._kept.clear()
            self._over = EVER
            self._rate_hz = sensor.rate_hz
        elif (
            self._prompt
            and sensor.state in ("saturated", "error")
            and sensor.state not in self._flags
        ):
            self._flags.append(sensor.state)

    @on(IMU)
    def add_samples(self, block: ImuBlock) -> None:
        if block.seat != self._seat:
            return
        samples = self._kept.add(block.samples)
        newest = int(samples["at"][-1])
        if self._prompt is None:
            self._kept.forget_before(max(newest - REST, self._over))
            return
        hand = self._look(samples)
        match self._reaction(newest, hand):
            case "unprompted":
                self._report_unprompted(newest)
            case "moving":
                self._flags.append("moving")
                self._report("key")
            case "key" | "stillness" as closed:
                self._report(closed)

    @on(TRUNK_SENSOR)
    def trunk_sensor_changed(self, sensor: SensorChanged) -> None:
        if sensor.seat == self._seat:
            self._trunk.sensor_changed(sensor)

    @on(TRUNK_IMU)
    def add_trunk_samples(self, block: ImuBlock) -> None:
        if block.seat == self._seat:
            self._trunk.add(block.samples, REST if self._prompt is None else None)

    def foresee(self, samples: Samples, ends: Sequence[int]) -> int | None:
        """Return the first of ``ends`` at which a reach will be reported (see
        `inputs.simulated_sensor.Foresight`).
        """
        if self._prompt is None:
            return None
        if self._foreseen is None or not self._foreseen.continues_with(samples[: ends[-1]]):
            self._foreseen = self._segmented(samples)
        if self._is_prompted and self._ended is None:
            ends = self._foreseen.at_rest(ends, self._still_s)
        stamps = [int(samples["at"][end - 1]) for end in ends]
        hands = self._foreseen.hands(ends, self._started / 1e9)
        for end, newest, hand in zip(ends, stamps, hands, strict=True):
            if self._reaction(newest, hand):
                return end
        return None

    def _reaction(
        self, newest: int, hand: Hand
    ) -> Literal["unprompted", "key", "moving", "stillness"] | None:
        """Return what the node does after the samples up to ``newest`` (ns): report a reach, and
        why; or nothing.
        """
        if not self._is_prompted:
            return "unprompted" if hand.reached else None
        if self._ended is not None:
            if newest >= self._ended and hand.rested_s >= self._settled_s:
                return "key"
            return "moving" if newest >= self._ended + TAIL else None
        if hand.reached and hand.rested_s >= self._still_s and hand.began_s != self._dismissed:
            return "stillness"
        return None

    def _look(self, samples: Samples) -> Hand:
        """Return the state of the hand after the next samples, which are in the last block.

        A sensor too slow for this is reported by the analysis when the reach is over.
        """
        if self._rate_hz < LEAST_RATE_HZ:
            return STILL
        started_s = self._started / 1e9
        if self._foreseen and self._foreseen.continues_with(samples):
            self._hand = self._foreseen.take(len(samples), started_s)
            return self._hand
        self._foreseen = None
        if self._segmenter is None:
            self._segmenter = Segmenter(self._rate_hz, self._analysis.single_axis)
            samples = self._kept.all()
        segmenter = self._segmenter
        segmenter.push(samples["at"] / 1e9, samples["rate"].astype(float))
        self._hand = Hand(
            segmenter.still_for_s, segmenter.has_reached(started_s), segmenter.began_s
        )
        return self._hand

    def _segmented(self, samples: Samples) -> Foreseen:
        """Segment the samples so far and those that come next."""
        before = self._kept.all()
        return Foreseen(
            join((before, samples)), len(before), self._rate_hz, self._analysis.single_axis
        )

    # --- the trial

    @on(PROMPT)
    def prompted(self, prompt: Prompt) -> None:
        """Start watching for a reach. It may have begun with the key that started the trial."""
        self._clear()
        self._prompt = prompt
        self._started = self.now if prompt.started is None else prompt.started
        if self._is_prompted:
            self.set_timer("timeout", self.now + prompt.timeout)
            self._forget_earlier_movement()

    def _forget_earlier_movement(self) -> None:
        """Keep the samples since the hand came to the rest from which it starts now.

        A movement before, such as a way back that belongs to no reach, could be taken for a part of
        this one.
        """
        home = home_since(self._kept.all(), self._started, self._analysis.orientation)
        if home is not None:
            self._kept.forget_before(home)

    @property
    def _is_prompted(self) -> bool:
        """True if the present prompt is for this hand."""
        return self._prompt is not None and self._prompt.seat in ("", self._seat)

    @on(PERCEIVED)
    def key_pressed(self, press: KeyPerceived) -> None:
        """End the reach: the second press means that the hand is back."""
        if press.seat != self._seat:
            return
        if press.gap is None:
            self._key.release()
        how = self._key.press(press.at)
        prompt = self._prompt
        if prompt is None or not self._is_prompted or self._ended is not None:
            return
        if press.repeat or press.key != prompt.expected:
            return
        if how == "held" or (how == "tapped" and not self._has_moved):
            return
        if self._has_moved or press.at >= self._started + UNMOVED:
            self._ended = press.at
            self.set_timer("tail", press.at + TAIL + PATIENCE)

    @property
    def _began_s(self) -> float | None:
        """Start of the present or last movement, in s of the session's clock."""
        return self._hand.began_s

    @property
    def _has_moved(self) -> bool:
        return self._began_s is not None and self._began_s * SECOND >= self._started - EARLY_NS

    @on(VOIDED)
    def voided(self, _: PromptVoided) -> None:
        self._clear()

    @on(TRIAL)
    def trial_ended(self, _: TrialEnded) -> None:
        self._clear()

    def timer(self, name: str, late: int) -> None:
        """End the reach. If the program itself is late, the event handler repeats the trial
        instead.
        """
        if name == "timeout" and late > STALLED:
            return
        self._report("timeout" if self._ended is None else "key")

    def _report_unprompted(self, at: int) -> None:
        """Report a reach out of turn at ``at`` (ns), without measures."""
        self.emit(
            REACH, ReachPerceived(seat=self._seat, at=at, delay=self.now - at, closed="stillness")
        )
        self._clear()

    def _report(self, closed: Literal["key", "stillness", "timeout"]) -> None:
        """Report the reach found in all the samples."""
        assert self._prompt
        samples = self._kept.all()
        first, last = (
            (samples["at"][[0, -1]].tolist()) if len(samples) else (self._started, self._started)
        )
        window = Window(
            from_ns=max(first, self._started - REST),
            started_ns=self._started,
            to_ns=last + 1,
            flags=tuple(self._flags),
        )
        found = analyse(samples, window, self._analysis)
        if closed == "stillness" and found.onset_ns is None and not found.invalid:
            # a small movement such as a flick of the wrist: keep waiting for the reach
            self._dismissed = self._began_s
            return
        if found.end_ns is not None:
            self._over = found.end_ns
            self._kept.forget_before(self._over)
        at = next(stamp for stamp in (found.end_ns, self._ended, self.now) if stamp is not None)
        turned = found.details.get("excursion_deg")
        hand_deg = turned if isinstance(turned, float) else None
        details = found.details | self._trunk.measures(
            window.from_ns, found.onset_ns, found.end_ns, hand_deg
        )
        trace = None
        if found.onset_ns is not None and found.end_ns is not None:
            trace = trace_of(samples, found.onset_ns, found.end_ns, found.details)
        self.emit(
            REACH,
            ReachPerceived(
                seat=self._seat,
                at=at,
                delay=self.now - last,
                onset=found.onset_ns,
                turn=found.turn_ns,
                end=found.end_ns,
                closed=closed,
                details=details,
                flags=found.flags,
                invalid=found.invalid,
                trace=tuple(trace.rate) if trace else (),
                trace_hz=trace.rate_hz if trace else 0.0,
                trace_marks=(trace.onset_s, trace.arrival_s, trace.departure_s, trace.end_s)
                if trace
                else None,
            ),
        )
        self._clear()


# --- the trunk


_AFTER = 100 * MS
"""Time after a reach whose samples are used too."""


class Trunk:
    """The samples of a participant's trunk sensor, and what they tell of a reach.

    Nothing depends on that sensor: without it, or if it fails, the reach is measured all the same.
    """

    def __init__(self) -> None:
        self._kept = KeptSamples()
        self._has_sensor = False

    def sensor_changed(self, sensor: SensorChanged) -> None:
        """Forget samples from before the sensor was attached."""
        if sensor.state == "attached":
            self._has_sensor = True
            self._kept.clear()

    def add(self, block: bytes, keep_ns: int | None) -> None:
        """Add packed samples; while no reach is watched, forget those older than ``keep_ns`` before
        the newest.
        """
        newest = int(self._kept.add(block)["at"][-1])
        if keep_ns is not None:
            self._kept.forget_before(newest - keep_ns)

    def measures(
        self, from_ns: int, onset_ns: int | None, end_ns: int | None, hand_deg: float | None
    ) -> Measured:
        """Return the measures of the trunk, as fields; none if there never was a sensor.

        Args:
            from_ns: where the samples begin that are used.
            onset_ns: of the reach; None if none was found.
            end_ns: of the reach.
            hand_deg: excursion of the hand in it; None if it was not measured.
        """
        if not self._has_sensor:
            return {}
        excursion_deg = share = None
        if onset_ns is not None and end_ns is not None:
            samples = self._kept.all()
            inside = samples[(samples["at"] >= from_ns) & (samples["at"] < end_ns + _AFTER)]
            if len(inside) > 1:
                whole = recording(inside, from_ns)
                excursion_deg = trunk_excursion_deg(
                    whole, (onset_ns - from_ns) / NS, (end_ns - from_ns) / NS
                )
            share = compensation_share(excursion_deg, hand_deg)
        return {
            "trunk_excursion_deg": None if excursion_deg is None else round(excursion_deg, 4),
            "compensation_share": None if share is None else round(share, 4),
        }


REST_S = 1.0
"""Stillness of the trunk that gives the sensor's bias."""


def trunk_excursion_deg(recording: Recording, onset_s: float, end_s: float) -> float | None:
    """Return the largest angle of the sternum from its orientation at the onset of a reach, in
    degrees.

    It is an angle about any axis: leaning forward, to the side, and turning all count. After a
    stroke, many people move the trunk even to reach targets within arm's length ("Use of the trunk
    for reaching targets placed within and beyond the reach in adult hemiparesis", Levin et al.
    2002, Exp Brain Res). Such studies measure displacement; this is a rotation, so the figures
    cannot be compared.

    None if the recording does not cover the reach, misses more than `grid.GAP_S` of it, or has no
    rest of ``REST_S``.

    Args:
        recording: of the sensor on the sternum, with a rest, on the clock of the hand's sensor.
        onset_s, end_s: the reach, as found by the sensor on the hand.
    """
    grid = even(recording)
    if len(grid.time_s) < 2 or not grid.time_s[0] <= onset_s < end_s <= grid.time_s[-1]:
        return None
    if grid.has_hole(onset_s, end_s):
        return None
    rest, rate, _ = grid.unbiased(REST_S)
    inside = (grid.time_s >= onset_s) & (grid.time_s <= end_s)
    if not rest.whole or not inside.any():
        return None
    return math.degrees(float(angle(integrate(rate[inside], 1.0 / grid.rate_hz)).max()))


def compensation_share(trunk_deg: float | None, hand_deg: float | None) -> float | None:
    """Return the trunk's share in the turning of a reach: its excursion over the sum of its and the
    hand's, 0 to 1.

    It is defined here, to compare a person with themselves; the share that studies report is of
    displacement. The sensor on the hand turns with the trunk too, so the share stays below one half
    unless the arm hardly moves.

    None if either excursion is not known, or both are 0.
    """
    if trunk_deg is None or hand_deg is None or not trunk_deg + hand_deg:
        return None
    return trunk_deg / (trunk_deg + hand_deg)
