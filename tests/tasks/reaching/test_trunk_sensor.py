"""A second sensor, on the trunk, measures how far it turns in a reach; nothing depends on it."""

import math
from collections.abc import Iterator
from typing import Any

import msgspec
import pytest

from sar_tui.inputs.imu import Status
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.sensor import TrunkImu
from sar_tui.inputs.simulated import SimulatedSource
from sar_tui.loop.session import ReplayError
from sar_tui.loop.topics import FEEDBACK, IMU, TRUNK_IMU, TRUNK_SENSOR
from sar_tui.model.messages import TrialEnded
from sar_tui.model.units import MS
from sar_tui.motion.synthesis import PROFILES, SimulatedHand
from tests.tasks.reaching.reaching_driver import REACH_OUT, ReachingDriver, merged


class Losable(SimulatedSource):
    """A simulated trunk whose sensor can be unplugged."""

    is_lost = False

    def _measure(self, now: int) -> int:
        return now + 10 * MS if self.is_lost else super()._measure(now)

    def unplug(self, now: int) -> None:
        self.is_lost = True
        self._on_status(Status(state="detached", at=now))


class TrunkDriver(ReachingDriver):
    """A session of reaches with a sensor on the trunk as well."""

    def __init__(self, **parameters: Any) -> None:
        super().__init__(**{"imu_trunk": "simulated", **parameters})

    def _sensing(self, *given: Any) -> Iterator[Any]:
        yield from super()._sensing(*given)
        self.trunk = Losable(SimulatedHand(PROFILES["steady"], 100.0, seed=5), self.clock)
        yield TrunkImu(ImuFeed(self.trunk, self.clock.now, part="trunk"))

    def lean(
        self, degrees: float, unplugged_after_ms: float | None = None, *, forgets: bool = False
    ) -> TrialEnded:
        """Reach, and lean forward by some degrees with it; press the second key, or forget it."""
        peak = 1.875 * math.radians(degrees) / REACH_OUT.out_s
        self.start()
        self.move(300)
        onset = self.clock.now() + 300 * MS
        self.trunk.move(onset, msgspec.structs.replace(REACH_OUT, peak_out=peak, peak_back=-peak))
        whole_ms = 300 + REACH_OUT.duration_s * 1000 + 400
        if unplugged_after_ms is not None:
            self.wait(unplugged_after_ms)
            self.trunk.unplug(self.clock.now())
            whole_ms -= unplugged_after_ms
        self.wait(whole_ms)
        if not forgets:
            self.press("space")
        return self.to_row()


@pytest.mark.parametrize("degrees", [2.0, 30.0])
def test_the_lean_of_the_trunk_is_stored_with_the_reach_and_not_flagged_without_a_limit(
    degrees: float,
) -> None:
    driver = TrunkDriver()
    driver.start_session()
    row = driver.lean(degrees)
    assert "trunk_compensation" not in row.timing.flags
    stored = row.details
    assert stored["trunk_excursion_deg"] == pytest.approx(degrees, abs=0.5)
    assert stored["compensation_share"] == pytest.approx(
        stored["trunk_excursion_deg"] / (stored["trunk_excursion_deg"] + stored["excursion_deg"]),
        abs=1e-3,
    )


@pytest.mark.parametrize("after_ms", [100, 700])
def test_a_reach_counts_when_the_trunk_sensor_is_lost_in_it(after_ms: float) -> None:
    driver = TrunkDriver()
    driver.start_session()
    whole = driver.lean(10.0)
    driver.begin()
    driver.to_start()
    row = driver.lean(10.0, unplugged_after_ms=after_ms)
    assert (row.correct, row.trial) == (True, 1)
    assert row.value == pytest.approx(whole.value, rel=0.05)
    assert (row.details["trunk_excursion_deg"], row.details["compensation_share"]) == (None, None)
    assert driver.last(TRUNK_SENSOR).state == "detached"
    assert driver.waiting.reason != "sensor"


def test_a_session_does_not_wait_for_a_trunk_sensor() -> None:
    driver = TrunkDriver()
    driver.trunk.is_lost = True  # it never attaches
    driver.start_session()
    row = driver.reach()
    assert row.correct
    assert "trunk_excursion_deg" not in row.details


def test_a_reach_beyond_the_limit_is_flagged_and_corrected_in_a_sentence() -> None:
    driver = TrunkDriver(trunk_limit_deg=12)
    driver.start_session()
    row = driver.lean(20.0)
    assert row.correct
    assert row.timing.flags.count("trunk_compensation") == 1
    assert "mark" not in row.details  # the therapist's key is a mark of its own
    assert "your back" in driver.last(FEEDBACK).correction
    driver.begin()
    driver.to_start()
    row = driver.lean(5.0)
    assert "trunk_compensation" not in row.timing.flags
    assert driver.last(FEEDBACK).correction == ""


def test_a_session_with_a_trunk_sensor_can_be_resumed_however_its_samples_are_divided() -> None:
    driver = TrunkDriver()
    driver.start_session()
    driver.lean(15.0, forgets=True)  # its samples are one block
    records = merged(driver.records, IMU, TRUNK_IMU)
    hand_first = sorted(records, key=lambda record: (record.seq, record.topic is TRUNK_IMU))
    trunk_first = sorted(records, key=lambda record: (record.seq, record.topic is not TRUNK_IMU))
    with pytest.raises(ReplayError):
        TrunkDriver(history=hand_first)
    again = TrunkDriver(history=trunk_first)
    again.wait(3000)
    again.press("enter")
    again.wait(300)
    again.begin()
    again.to_start()
    assert again.lean(15.0).details["trunk_excursion_deg"] == pytest.approx(15.0, abs=0.5)


def test_a_limit_without_a_sensor_is_refused() -> None:
    with pytest.raises(Exception, match="A trunk limit needs a trunk sensor"):
        ReachingDriver(trunk_limit_deg=10)
