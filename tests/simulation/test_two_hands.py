"""Reaches of two participants with a sensor each are stored for the right seat."""

from contextlib import closing
from pathlib import Path
from statistics import fmean
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest

from sar_tui.loop.bus import Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node
from sar_tui.loop.topics import REACH, SENSOR, WAITING
from sar_tui.model import messages as m
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Again, Trial
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.samples import Samples
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


class Played(NamedTuple):
    """A stored session of two, and the samples of each seat."""

    data: Path
    name: str
    trials: list[sessions.Row]
    streams: list[sessions.Row]
    samples: dict[str, Samples]
    history: list[Record]


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> Played:
    data = tmp_path_factory.mktemp("two") / "data"
    settings = changed(parameters())
    plan = make_plan(Catalogue(), TwoHands, ["P01", "P02"], settings, seed=5, mode="simulated")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sar_tui.runs.run.task_code", lambda kind: Path(__file__).parent / "nowhere")
        patch.setattr("sar_tui.inputs.simulated.STEP", 40 * MS)
        patch.setattr("sar_tui.inputs.sensor.DRAIN", 40 * MS)
        name = simulate(plan, PEOPLE["competent"], data, Catalogue(), partner=PEOPLE["poor"])
    with closing(connect(data)) as database:
        return Played(
            data,
            name,
            trials=sessions.rows(database, "trials", name),
            streams=sessions.rows(database, "imu_streams", name),
            samples={seat: imu.samples(database, name, seat=seat) for seat in "AB"},
            history=list(sessions.history(database, name)),
        )


def test_each_reach_has_the_seat_of_its_hand(played: Played) -> None:
    assert [(row["seat"], row["stream"]) for row in played.streams] == [("A", 1), ("B", 2)]
    assert [(row["attempt"], row["trial"], row["seat"]) for row in played.trials] == [
        (attempt, trial, seat) for attempt in (1, 2) for trial in (1, 2) for seat in "AB"
    ]
    assert all(row["correct"] for row in played.trials)
    times = {
        seat: fmean(row["details"]["reach_time_ms"] for row in played.trials if row["seat"] == seat)
        for seat in "AB"
    }
    assert times["A"] < times["B"]
    reaches = [record.message for record in played.history if record.topic is REACH]
    assert {reach.seat for reach in reaches} == {"A", "B"}


def test_the_samples_of_each_are_their_own_and_in_order(played: Played) -> None:
    for measured in played.samples.values():
        assert np.all(np.diff(measured["at"]) > 0)
        assert 240 < len(measured) / (measured["at"][-1] - measured["at"][0]) * 1e9 < 260
        for row in played.trials:
            since, until = row["onset_ns"], row["response_ns"]
            assert np.sum((measured["at"] >= since) & (measured["at"] < until)) > 50
    assert not np.array_equal(played.samples["A"]["rate"], played.samples["B"]["rate"])


def test_a_stored_session_gives_each_seat_its_own_samples(played: Played) -> None:
    clock = VirtualClock()
    source = f"session:{played.name}?speed=fast"
    given = parameters(imu=source, imu_b=source)
    for feed, seat in zip(open_sensors(TwoHands, given, 1, clock, played.data), "AB", strict=True):
        feed.start()
        clock.advance(SECOND)
        drained, _ = feed.drain()
        assert len(drained) > 100
        assert np.array_equal(drained["rate"][:100], played.samples[seat]["rate"][:100])
        feed.stop()


def test_the_session_waits_for_the_sensor_of_either(calm: Theme) -> None:
    driver = LoopDriver(TwoHands, calm, imu="simulated")

    def waits_after(seat: str, state: m.SensorState, detail: str = "") -> tuple[str, str, str]:
        changed = m.SensorChanged(
            seat=seat, state=state, at=driver.clock.now(), detail=detail, rate_hz=250
        )
        driver.session.bus.publish(SENSOR, changed)
        waiting = driver.last(WAITING)
        return waiting.stage, waiting.what, waiting.detail

    waits_after("A", "attached")
    driver.enter()
    assert driver.last(WAITING).what == "sensor"
    assert waits_after("B", "attached") == ("attempt", "enter", "")
    assert waits_after("A", "detached", "Unplugged.") == ("paused", "sensor", "Unplugged.")
    assert waits_after("B", "flowing")[1] == "sensor"
    assert waits_after("A", "attached")[0] == "attempt"


def test_each_seat_names_its_sensor_and_a_wrong_name_is_reported_by_its_parameter(
    tmp_path: Path,
) -> None:
    clock = VirtualClock()
    given = parameters(imu_b="recorded")
    assert open_sensor(given, 1, clock, tmp_path, "A").source is not None
    with pytest.raises(ParameterError) as raised:
        open_sensor(given, 1, clock, tmp_path, "B")
    assert set(raised.value.problems) == {"imu_b"}
