"""Drives the pairs task with keys, or with reaches and one sensor per participant."""

from collections.abc import Iterator
from typing import Any

from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.sensor import Imu
from sar_tui.inputs.simulated import SimulatedSource
from sar_tui.loop.node import Node
from sar_tui.loop.topics import SENSOR, TRIAL
from sar_tui.model import messages as m
from sar_tui.model.units import MS
from sar_tui.motion.synthesis import PROFILES, ReachShape, SimulatedHand
from sar_tui.plugins import Catalogue
from tests.loop_driver import LoopDriver

SHORT: dict[str, object] = {"prompts_per_attempt": 2, "attempts": 2, "foreperiod_min_ms": 500}
REACH = ReachShape(out_s=0.5, back_s=0.5, peak_out=1.5, peak_back=-1.5)
"""A reach of one second."""
SLOW = ReachShape(out_s=1.0, back_s=1.0, peak_out=1.0, peak_back=-1.0)
TWITCH = ReachShape(out_s=0.15, back_s=0.15, peak_out=3.0, peak_back=-3.0)
"""A movement without a reach."""
Reach = tuple[str, float] | tuple[str, float, ReachShape]
"""Seat, time after the prompt (ms) and shape."""


class PairsDriver(LoopDriver):
    """Session in which two participants press keys at given times."""

    def press_after(self, *presses: tuple[float, str]) -> list[m.TrialEnded]:
        """Press keys at times after the next prompt (ms) and return the resulting rows."""
        self.to_prompt()
        onset = self.clock.now()
        known = len(self.all(TRIAL))
        for delay_ms, key in sorted(presses):
            self.clock.advance(max(0, onset + round(delay_ms * MS) - self.clock.now()))
            self.press(key)
        return self.all(TRIAL)[known:]

    @property
    def keys(self) -> tuple[str, str]:
        """Return the keys prompted from A and B; "" for a seat without a prompt."""
        prompt = self.to_prompt()
        left, right = prompt.halves
        return left, right

    def by_seat(self, rows: list[m.TrialEnded]) -> dict[str, m.TrialEnded]:
        assert len({row.seat for row in rows}) == len(rows)
        return {row.seat: row for row in rows}

    def both(self, a_ms: float, b_ms: float) -> dict[str, m.TrialEnded]:
        """Press the correct key of each seat at times after the prompt (ms)."""
        left, right = self.keys
        return self.by_seat(self.press_after((a_ms, left), (b_ms, right)))


class PairsReachingDriver(PairsDriver):
    """A session of reaches of two, by default two attempts of two prompts."""

    def __init__(self, policy: str, **parameters: Any) -> None:
        catalogue = Catalogue()
        super().__init__(
            catalogue.task("pairs"),
            catalogue.theme("calm"),
            extra=self._sensing(),
            **(SHORT | {"policy": policy, "respond_with": "reaches"} | parameters),
        )

    def _sensing(self) -> Iterator[Node]:
        """Yield the sensors; called once the clock exists."""
        self.hands: dict[str, SimulatedSource] = {}
        for number, seat in enumerate("AB"):
            hand = SimulatedHand(PROFILES["steady"], 100.0, seed=number)
            self.hands[seat] = SimulatedSource(hand, self.clock)
            yield Imu(ImuFeed(self.hands[seat], self.clock.now), seat)

    def start_session(self) -> m.Prompt:
        """Continue from the instructions to the first prompt, with the hands at rest."""
        self.wait(1500)
        return self.start()

    def to_prompt(self) -> m.Prompt:
        """Continue for at most half a minute, as a sensor always has something due."""
        until = self.clock.now() + 30_000 * MS
        while self.screen.onset is None:
            assert self.clock.step(until), f"the session waits for {self.screen.waiting}"
        assert self.screen.prompt is not None
        return self.screen.prompt

    def reach(self, *reaches: Reach) -> dict[str, m.TrialEnded]:
        """Move hands at times after the next prompt (ms) and return the resulting rows, by seat."""
        self.to_prompt()
        onset, known = self.clock.now(), len(self.all(TRIAL))
        for seat, after_ms, *shape in reaches:
            self.hands[seat].move(onset + round(after_ms * MS), shape[0] if shape else REACH)
        until = onset + 30_000 * MS
        while len(self.all(TRIAL)) == known:
            assert self.clock.step(until), f"the session waits for {self.screen.waiting}"
        return self.by_seat(self.all(TRIAL)[known:])

    def sensor(self, seat: str, state: m.SensorState, detail: str = "") -> None:
        """Publish a change of a seat's sensor."""
        changed = m.SensorChanged(
            seat=seat, state=state, at=self.clock.now(), detail=detail, rate_hz=100.0
        )
        self.session.bus.publish(SENSOR, changed)
