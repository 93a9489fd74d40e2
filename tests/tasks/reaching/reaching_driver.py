"""Drives the reaching task with a simulated hand on a virtual clock."""

from collections.abc import Iterable, Iterator
from typing import Any

import msgspec
import numpy as np

from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.sensor import Imu
from sar_tui.inputs.simulated import SimulatedSource
from sar_tui.loop.bus import Record, Topic
from sar_tui.loop.node import Node
from sar_tui.loop.topics import IMU, REACH, TRIAL
from sar_tui.model.messages import ImuBlock, ReachPerceived, TrialEnded
from sar_tui.model.units import MS
from sar_tui.motion.analysis import AnalysisParameters, Finding, Window, analyse
from sar_tui.motion.reach_kinds import end_of
from sar_tui.motion.samples import Samples, unpack
from sar_tui.motion.synthesis import PROFILES, Profile, ReachShape, SimulatedHand
from sar_tui.motion.trajectories import SimulatedArm
from sar_tui.plugins import Catalogue
from tests.loop_driver import LoopDriver

REACH_OUT = ReachShape(out_s=0.5, back_s=0.5, peak_out=1.5, peak_back=-1.5)
"""A reach of one second."""
FLICK = ReachShape(out_s=0.15, back_s=0.15, peak_out=3.0, peak_back=-3.0)
"""A twitch of the wrist: the hand goes nowhere."""
PATIENCE_MS = 60_000


class ReachingDriver(LoopDriver):
    """A session of reaches, by default two attempts of one each.

    Args:
        sensor: a profile of the hand and its sensor, or its name; or a hand of another kind.
        history: an earlier record, to resume.
        rate_hz: samples per second.
    """

    def __init__(
        self,
        *,
        sensor: str | Profile | SimulatedHand = "drifting",
        history: Iterable[Record] | None = None,
        seed: int = 1,
        rate_hz: float = 250.0,
        extra: Iterable[Node] = (),
        **parameters: Any,
    ) -> None:
        catalogue = Catalogue()
        if isinstance(sensor, str):
            sensor = PROFILES[sensor]
        hand = SimulatedHand(sensor, rate_hz, seed=3) if isinstance(sensor, Profile) else sensor
        super().__init__(
            catalogue.task("reaching"),
            catalogue.theme("calm"),
            seed=seed,
            history=history,
            extra=self._sensing(hand, extra),
            **{"attempts": 2, **parameters},
        )

    def _sensing(self, hand: SimulatedHand, extra: Iterable[Node]) -> Iterator[Node]:
        """Yield the sensor; called once the clock exists."""
        self.hand = SimulatedSource(hand, self.clock)
        self.feed = ImuFeed(self.hand, self.clock.now)
        yield Imu(self.feed)
        yield from extra

    # --- actions

    def start_session(self, rest_ms: float = 3000) -> None:
        """Continue from the instructions until the first reach can be started, with the hand at
        rest.
        """
        self.wait(100)
        self.enter()
        self.begin()
        self.wait(rest_ms)

    def begin(self) -> None:
        """Begin the next attempt."""
        assert (self.waiting.what, self.waiting.stage) == ("enter", "attempt"), self.waiting
        self.press("enter")
        self.wait(300)

    def move(self, after_ms: float = 0, shape: ReachShape = REACH_OUT) -> None:
        """Move the hand after a time (ms); a negative time is in the past."""
        self.hand.move(self.clock.now() + round(after_ms * MS), shape)

    def start(self) -> None:
        """Press space to start a reach, and wait for the prompt."""
        assert self.waiting.what == "start", self.waiting
        self.press("space")
        self.to_prompt()

    def reach(self, shape: ReachShape = REACH_OUT) -> TrialEnded:
        """Do a whole reach: space, out and back, space."""
        self.start()
        self.move(300, shape)
        return self.finish(300 + shape.duration_s * 1000 + 400)

    def finish(self, after_ms: float) -> TrialEnded:
        """Press space after a time (ms), and continue until the trial is a row."""
        self.wait(after_ms)
        self.press("space")
        return self.to_row()

    def to_row(self, ms: float = PATIENCE_MS) -> TrialEnded:
        """Continue until the current trial is a row."""
        before = len(self.all(TRIAL))
        self._until(lambda: len(self.all(TRIAL)) > before, ms)
        return self.last(TRIAL)

    def to_start(self, ms: float = PATIENCE_MS) -> None:
        """Continue until a reach can be started."""
        self._until(lambda: self.waiting.what == "start", ms)

    def _until(self, is_so: Any, ms: float) -> None:
        """Continue until a condition holds, as a sensor always has something due."""
        until = self.clock.now() + round(ms * MS)
        while not is_so():
            assert self.clock.step(until), (
                f"{ms:g} ms have passed; the session waits for {self.waiting}"
            )

    # --- results

    @property
    def percept(self) -> ReachPerceived:
        return self.last(REACH)

    @property
    def samples(self) -> Samples:
        """All samples that the sensor has published."""
        blocks = [
            unpack(record.message.samples)
            for record in self.records
            if isinstance(record.message, ImuBlock)
        ]
        return np.concatenate(blocks)


def arm_that_holds(kind: str, hold_s: float, seed: int = 1) -> tuple[SimulatedArm, ReachShape]:
    """Return the arm of ``--imu simulated:kind=KIND``, with a hold at the marker, and the shape to
    ask it for.
    """
    arm = SimulatedArm(kind, PROFILES["steady"], seed=seed)
    out, back = arm._person.out, arm._person.back
    later = hold_s - (min(stroke.begin_s for stroke in back) - end_of(out))
    back = tuple(msgspec.structs.replace(stroke, begin_s=stroke.begin_s + later) for stroke in back)
    arm._person = arm._person._replace(back=back)
    return arm, ReachShape(out_s=end_of(back) / 2, back_s=end_of(back) / 2)


def analysed_again(samples: Samples, details: Any) -> Finding:
    """Return a reach, analysed again in the window and by the parameters that its details name."""
    window = Window(
        from_ns=details["window_from_ns"],
        started_ns=details["window_started_ns"],
        to_ns=details["window_to_ns"],
    )
    asked = {
        "hand": details["hand"],
        details["detector"]: msgspec.json.decode(details["detector_parameters"]),
    }
    return analyse(samples, window, msgspec.convert(asked, AnalysisParameters))


def ms(stamp: int) -> float:
    return stamp / MS


def merged(records: Iterable[Record], *topics: Topic[ImuBlock]) -> list[Record]:
    """Return the records with blocks of a sensor joined that have no other message between them, as
    in the database.
    """
    found: list[Record] = []
    last: dict[Topic[ImuBlock], int] = {}
    for record in records:
        index = last.get(record.topic)
        if index is not None and found[index].seq == record.seq:
            assert isinstance(record.message, ImuBlock)
            joined = found[index].message
            assert isinstance(joined, ImuBlock)
            found[index] = record._replace(
                message=ImuBlock(samples=joined.samples + record.message.samples)
            )
            continue
        if record.topic in (topics or (IMU,)):
            last[record.topic] = len(found)
        found.append(record)
    return found
