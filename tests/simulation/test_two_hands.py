"""Reaches of two participants with a sensor each are stored for the right seat."""

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node
from sar_tui.loop.session import Session
from sar_tui.loop.topics import REACH, SENSOR, WAITING
from sar_tui.model import messages as m
from sar_tui.model.trial_types import Again, Trial
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.rules.declaration import ParameterError, meta
from sar_tui.rules.parameters import build, changed
from sar_tui.runs.plan import make_plan
from sar_tui.runs.sensors import open_sensor, open_sensors
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import imu, sessions
from sar_tui.store.database import connect
from tests.loop_driver import LoopDriver

REACHING: Any = Catalogue().task("reaching")
REACH_PERCEPTION: Any = type(REACHING(build(REACHING.Parameters, {"imu": "simulated"})).nodes()[0])


class TwoHandsParameters(REACHING.Parameters, frozen=True, kw_only=True):
    """Parameters for a sensor per seat."""

    imu_b: Annotated[
        str, meta("Motion sensor on the right", help="As Motion sensor.", min_length=1)
    ] = "simulated"


class TwoHands(REACHING):  # type: ignore[misc]
    """Both participants reach independently; the trial ends when both hands are back."""

    name = "two hands"
    seats = ("A", "B")
    start_key = ""
    has_foreperiod = True
    Parameters = TwoHandsParameters

    def nodes(self) -> tuple[Node, ...]:
        return tuple(
            REACH_PERCEPTION(self.analysis(), self.parameters.still_ms, seat) for seat in self.seats
        )

    def perceived(self, trial: Trial, percept: Any) -> Any:
        found = {
            one.seat: one for one in (*trial.percepts, percept) if isinstance(one, m.ReachPerceived)
        }
        if set(found) < {"A", "B"}:
            return None
        judged = {seat: super(TwoHands, self).perceived(trial, found[seat]) for seat in self.seats}
        again = [result for result in judged.values() if isinstance(result, Again)]
        return again[0] if again else judged


def parameters(**more: object) -> Any:
    return build(
        TwoHands.Parameters, {"imu": "simulated", "attempts": 2, "reaches_per_attempt": 2, **more}
    )


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("two") / "data"


@pytest.fixture(scope="module")
def played(data: Path) -> str:
    settings = changed(parameters())
    plan = make_plan(Catalogue(), TwoHands, ["P01", "P02"], settings, seed=5, mode="simulated")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sar_tui.runs.run.task_code", lambda kind: Path(__file__).parent / "nowhere")
        return simulate(plan, PEOPLE["competent"], data, Catalogue(), partner=PEOPLE["poor"])


def test_each_reach_has_the_seat_of_its_hand(data: Path, played: str) -> None:
    database = connect(data)
    trials = sessions.rows(database, "trials", played)
    streams = sessions.rows(database, "imu_streams", played)
    samples = {seat: imu.samples(database, played, seat=seat) for seat in "AB"}
    history = list(sessions.history(database, played))
    database.close()
    assert [(row["seat"], row["stream"]) for row in streams] == [("A", 1), ("B", 2)]
    assert [(row["attempt"], row["trial"], row["seat"]) for row in trials] == [
        (attempt, trial, seat) for attempt in (1, 2) for trial in (1, 2) for seat in "AB"
    ]
    for row in trials:
        assert row["correct"]
        for seat, measured in samples.items():
            moved = measured[
                (measured["at"] >= row["onset_ns"]) & (measured["at"] < row["response_ns"])
            ]
            assert len(moved) > 50, seat
    times = {
        seat: np.mean([row["details"]["reach_time_ms"] for row in trials if row["seat"] == seat])
        for seat in "AB"
    }
    assert times["A"] < times["B"]
    reaches = [record.message for record in history if record.topic is REACH]
    assert {reach.seat for reach in reaches} == {"A", "B"}


def test_the_samples_of_each_are_their_own_and_in_order(data: Path, played: str) -> None:
    database = connect(data)
    samples = {seat: imu.samples(database, played, seat=seat) for seat in "AB"}
    database.close()
    for measured in samples.values():
        assert np.all(np.diff(measured["at"]) > 0)
        assert 240 < len(measured) / (measured["at"][-1] - measured["at"][0]) * 1e9 < 260
    assert not np.array_equal(samples["A"]["rate"], samples["B"]["rate"])


def test_a_session_with_two_sensors_replays_identically(data: Path, played: str) -> None:
    database = connect(data)
    history = list(sessions.history(database, played))
    database.close()
    replayed = Session(TwoHands(parameters()), Catalogue().theme("calm"), VirtualClock(), 5)
    replayed.replay(history)
    assert replayed.ended


def test_the_session_waits_for_the_sensor_of_either(calm: Any) -> None:
    driver = LoopDriver(TwoHands, calm, imu="simulated")
    publish = driver.session.bus.publish
    publish(SENSOR, m.SensorChanged(seat="A", state="attached", at=driver.clock.now(), rate_hz=250))
    driver.enter()
    assert (driver.last(WAITING).stage, driver.last(WAITING).what) == ("paused", "sensor")
    publish(SENSOR, m.SensorChanged(seat="B", state="attached", at=driver.clock.now(), rate_hz=250))
    assert (driver.last(WAITING).stage, driver.last(WAITING).what) == ("attempt", "enter")
    publish(
        SENSOR,
        m.SensorChanged(seat="A", state="detached", at=driver.clock.now(), detail="Unplugged."),
    )
    assert (driver.last(WAITING).what, driver.last(WAITING).detail) == ("sensor", "Unplugged.")
    publish(SENSOR, m.SensorChanged(seat="B", state="flowing", at=driver.clock.now()))
    assert driver.last(WAITING).what == "sensor"
    publish(SENSOR, m.SensorChanged(seat="A", state="attached", at=driver.clock.now(), rate_hz=250))
    assert driver.last(WAITING).stage == "attempt"


def test_a_stored_session_gives_each_seat_its_own_samples(data: Path, played: str) -> None:
    database = connect(data)
    measured = {seat: imu.samples(database, played, seat=seat) for seat in "AB"}
    database.close()
    clock = VirtualClock()
    given = parameters(imu=f"session:{played}?speed=fast", imu_b=f"session:{played}?speed=fast")
    for feed, seat in zip(open_sensors(TwoHands, given, 1, clock, data), "AB", strict=True):
        feed.start()
        clock.advance(SECOND)
        drained, _ = feed.drain()
        assert len(drained) > 100
        assert np.array_equal(drained["rate"][:100], measured[seat]["rate"][:100])
        feed.stop()


def test_each_seat_names_its_sensor_and_a_wrong_name_is_reported_by_its_parameter(
    data: Path,
) -> None:
    clock = VirtualClock()
    given = parameters(imu_b="recorded")
    assert open_sensor(given, 1, clock, data, "A").source is not None
    with pytest.raises(ParameterError) as raised:
        open_sensor(given, 1, clock, data, "B")
    assert set(raised.value.problems) == {"imu_b"}
