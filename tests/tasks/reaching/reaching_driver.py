"""Drives the reaching task with a simulated hand on a virtual clock."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from sar_tui.framework.bus import Record, Topic
from sar_tui.framework.clock import MS, SECOND
from sar_tui.framework.messages import ImuBlock, ReachPerceived, TrialEnded
from sar_tui.framework.node import Node
from sar_tui.framework.topics import IMU, REACH, TRIAL
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.sensor import Imu
from sar_tui.inputs.simulated import SimulatedSource
from sar_tui.motion.samples import Samples, unpack
from sar_tui.motion.shapes import ReachShape
from sar_tui.motion.synthesis import PROFILES, Profile, SimulatedHand
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
        sensor: a profile of the hand and its sensor, or its name.
        history: an earlier record, to resume.
        rate_hz: samples per second.
    """

    def __init__(
        self,
        *,
        sensor: str | Profile = "drifting",
        history: Iterable[Record] | None = None,
        seed: int = 1,
        rate_hz: float = 250.0,
        extra: Iterable[Node] = (),
        **parameters: Any,
    ) -> None:
        catalogue = Catalogue()
        profile = PROFILES[sensor] if isinstance(sensor, str) else sensor
        super().__init__(
            catalogue.task("reaching"),
            catalogue.theme("calm"),
            seed=seed,
            history=history,
            extra=self._sensing(profile, rate_hz, extra),
            **{"attempts": 2, **parameters},
        )

    def _sensing(self, profile: Profile, rate_hz: float, extra: Iterable[Node]) -> Iterator[Node]:
        """Yield the sensor; called once the clock exists."""
        self.hand = SimulatedSource(SimulatedHand(profile, rate_hz, seed=3), self.clock)
        self.feed = ImuFeed(self.hand, self.clock.now)
        yield Imu(self.feed)
        yield from extra

    # --- actions --------------------------------------------------------------------------------------------

    def start_session(self, rest_ms: float = 3000) -> None:
        """Continue from the instructions until the first reach can be started, with the hand at rest."""
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
        self.wait(300 + shape.duration_s * 1000 + 400)
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
            assert self.clock.step(until), f"{ms:g} ms have passed; the session waits for {self.waiting}"

    # --- results ----------------------------------------------------------------------------------------------

    @property
    def percept(self) -> ReachPerceived:
        return self.last(REACH)

    @property
    def samples(self) -> Samples:
        """All samples that the sensor has published."""
        blocks = [unpack(record.message.samples) for record in self.records if isinstance(record.message, ImuBlock)]
        return np.concatenate(blocks)


def ms(stamp: int) -> float:
    return stamp / MS


def merged(records: Iterable[Record], *topics: Topic[ImuBlock]) -> list[Record]:
    """Return the records with blocks of a sensor joined that have no other message between them, as in the database."""
    found: list[Record] = []
    last: dict[Topic[ImuBlock], int] = {}
    for record in records:
        index = last.get(record.topic)
        if index is not None and found[index].seq == record.seq:
            assert isinstance(record.message, ImuBlock)
            joined = found[index].message
            assert isinstance(joined, ImuBlock)
            found[index] = record._replace(message=ImuBlock(samples=joined.samples + record.message.samples))
            continue
        if record.topic in (topics or (IMU,)):
            last[record.topic] = len(found)
        found.append(record)
    return found


__all__ = ["FLICK", "REACH_OUT", "SECOND", "ReachingDriver", "merged", "ms"]
