"""Texts, results and simulated participants of the reaching task."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.task import Task
from sar_tui.model.messages import KeyPerceived, ReachPerceived
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Again, Performance, Result, Situation, Trial
from sar_tui.model.units import SECOND
from sar_tui.motion.synthesis import ReachShape
from sar_tui.plugins import Catalogue
from tests.tasks.reaching.test_parameters import make


def situation(level: int = 1) -> Situation:
    return Situation(1, 1, level, RandomStreams(1, 1, 1), RandomStreams(1))


def percept(**facts: Any) -> ReachPerceived:
    return ReachPerceived(**{"at": 9 * SECOND, "closed": "key", **facts})


def judged(task: Task, what: Any, level: int = 1) -> Result | Again | None:
    trial = Trial(
        situation(level), task.stimulus(situation(level)), onset=5 * SECOND, started=5 * SECOND
    )
    return task.perceived(trial, what)


# --- words


def test_waiting_for_a_signal_is_mentioned_only_if_there_is_one() -> None:
    for signal in (True, False):
        task = make(go_signal=signal)
        assert ("signal" in task.instructions()) is signal
        assert ("GO" in task.start(1)) is signal
        assert (task.stimulus(situation()).glyph == "GO") is signal
        assert task.stimulus(situation()).signals is task.has_foreperiod is signal


def test_every_level_is_described_by_its_marker_and_goal() -> None:
    task = make()
    expected = (("15 cm", "1.20"), ("20 cm", "1.39"), ("25 cm", "1.55"))
    for level, (far, seconds) in enumerate(expected, 1):
        assert f"marker {level} ({far})" in task.goal(level)
        assert f"less than {seconds} seconds" in task.goal(level)
        assert f"marker {level} ({far})" in task.start(level)
        assert task.stimulus(situation(level)).text == f"Reach: {far}"

    assert "marker 3" in task.notice(3, 2)
    assert task.notice(3, 2) != task.notice(3, 4)
    alone = make(marker_distances_cm=[22.5])
    assert "the marker (22.5 cm)" in alone.goal(1)


# --- judging


def test_a_reach_is_timed_from_onset_to_end() -> None:
    details = {"reach_time_ms": 1000.0, "hand": "right"}
    times = {"onset": 6 * SECOND, "turn": 6 * SECOND + 1, "end": 7 * SECOND}
    result = judged(make(), percept(details=details, **times), level=2)
    assert isinstance(result, Result)
    assert (result.correct, result.response, result.value) == (True, "reach", 1000.0)
    assert (result.onset_at, result.response_at) == (6 * SECOND, 7 * SECOND)
    added = {"marker_cm": 20.0, "closed": "key", "turn_ns": 6 * SECOND + 1}
    assert result.details == details | added


def test_without_a_reach_there_is_no_response_and_a_notice() -> None:
    seen = percept(closed="timeout", details={"samples": 500}, flags=("saturated",))
    result = judged(make(), seen)
    assert isinstance(result, Result)
    assert (result.correct, result.flags) == (False, ("saturated", "no_reach"))
    assert result.response is result.response_at is result.value is None
    assert (result.details["samples"], result.details["closed"]) == (500, "timeout")


@pytest.mark.parametrize("reason", ["samples", "gap", "rate"])
def test_a_reach_that_the_sensor_missed_is_repeated_and_the_notice_blames_the_sensor(
    reason: str,
) -> None:
    again = judged(make(), percept(invalid=reason, onset=6 * SECOND, end=7 * SECOND))
    assert isinstance(again, Again)
    assert again.reason == reason
    assert "sensor" in again.text


@pytest.mark.parametrize("key", ["space", "enter", "x"])
def test_a_key_alone_is_no_reach(key: str) -> None:
    assert judged(make(), KeyPerceived(key=key, at=6 * SECOND)) is None


def test_a_therapist_can_report_faults_that_the_sensor_cannot_detect() -> None:
    marks = {mark.name: mark.counts for mark in make().marks}
    assert marks == {"whole": True, "missed": False, "compensated": True, "assisted": False}
    assert len({mark.key for mark in make().marks}) == len(marks)


# --- rehearsing


def rehearsed(level: int, performance: Performance, seed: int = 1) -> list[Any]:
    task = make()
    return task.rehearse(task.stimulus(situation(level)), performance, RandomStreams(seed))


PERFORMANCES = st.builds(
    Performance,
    reaction_ms=st.floats(120, 2000),
    pace=st.floats(0.5, 3),
    unsteadiness=st.floats(0, 1),
)


@given(PERFORMANCES, st.integers(1, 6), st.integers(0, 500))
def test_a_simulated_reach_is_completed_before_the_key_is_pressed(
    performance: Performance, level: int, seed: int
) -> None:
    (at, shape), (press, key) = rehearsed(level, performance, seed)
    assert isinstance(shape, ReachShape)
    assert at == pytest.approx(performance.reaction_ms)
    assert key == "space"
    assert press > at + shape.duration_s * 1000
    assert shape.peak_out > 0 > shape.peak_back


def test_a_simulated_slip_is_a_forgotten_key() -> None:
    acts = rehearsed(1, Performance(300.0, slips=True))
    assert [type(act) for _, act in acts] == [ReachShape]


def test_a_simulated_reach_to_a_farther_marker_takes_longer_at_any_pace() -> None:
    def takes(level: int, pace: float = 1.0) -> float:
        return float(rehearsed(level, Performance(300.0, pace=pace))[0][1].duration_s)

    times = [takes(level) for level in range(1, 7)]
    assert times == sorted(set(times))
    assert takes(1, pace=1.5) == pytest.approx(1.5 * takes(1))


def test_the_sensor_of_the_task_is_declared() -> None:
    task = make()
    assert task.sensors == ("imu",)
    (node,) = task.nodes()
    assert task.nodes()[0] is not node, "a node belongs to one session"
    assert node.name == "reach_perception"


def test_the_default_is_the_thesis_session() -> None:
    it = Catalogue().task("reaching").Parameters()
    assert (it.attempts, it.thesis_threshold_rad_s, it.thesis_still_ms) == (20, 0.1, 800)
