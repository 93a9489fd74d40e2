"""Limits of a programme: a session ends between attempts, or does not begin, with a kind
sentence.
"""

from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.topics import WAITING
from sar_tui.model.messages import Waiting
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.rules.limits import Dose, is_session_over, reached_of_day
from sar_tui.rules.parameters import TaskParameters
from sar_tui.runs.plan import Failed, make_plan
from sar_tui.runs.run import Run, start
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.store.training_days import done_on_day
from tests import played
from tests.played import somebody

NOON = datetime(2026, 11, 22, 12, tzinfo=UTC)
ENOUGH = "That is enough for today. Well done."


@pytest.fixture(autouse=True)
def _at_noon(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every run begin at noon."""
    monkeypatch.setattr("sar_tui.store.sessions.utc", lambda now=None: NOON.isoformat())
    monkeypatch.setattr("sar_tui.runs.run._now", lambda: NOON)


def begin(data: Path, catalogue: Catalogue, **limits: object) -> tuple[Run, VirtualClock]:
    settings = {"attempts": 6, "prompts_per_attempt": 3, "practice_attempts": 1, **limits}
    plan = make_plan(catalogue, "keyboard", ["P07"], settings, seed=3)
    clock = VirtualClock(10 * SECOND)
    return start(plan, data, catalogue, clock, somebody), clock


def play(data: Path, catalogue: Catalogue, **limits: object) -> tuple[int, str]:
    """Play a session; return its attempts, practice included, and what the participant was told at
    the end.
    """
    run, clock = begin(data, catalogue, **limits)
    told: list[str] = []

    def listen(waiting: Waiting) -> None:
        if waiting.stage == "review":
            told.append(waiting.notice)

    run.session.bus.subscribe(WAITING, listen)
    played.play(run, clock)
    with closing(connect(data)) as database:
        done = len(sessions.rows(database, "attempts", run.id))
        assert sessions.find(database, data, run.id)["status"] == "completed"
    return done, told[-1]


def test_without_limits_a_session_is_as_long_as_planned(data: Path, catalogue: Catalogue) -> None:
    assert play(data, catalogue) == (7, "")


@pytest.mark.parametrize(
    ("limits", "attempts"),
    [({"attempts_a_day": 2}, 3), ({"repetitions_a_day": 7}, 3), ({"attempts_a_day": 6}, 7)],
)
def test_a_limit_of_a_day_ends_the_session_after_a_whole_attempt(
    data: Path, catalogue: Catalogue, limits: dict[str, int], attempts: int
) -> None:
    assert play(data, catalogue, **limits) == (attempts, "" if attempts == 7 else ENOUGH)


def test_a_session_that_has_lasted_long_enough_ends(data: Path, catalogue: Catalogue) -> None:
    slow = {"foreperiod_min_ms": 8000, "foreperiod_max_ms": 9000}
    done, told = play(data, catalogue, session_minutes=1, **slow)
    assert 1 < done < 7
    assert told == "The time for this session is over. Well done."


def test_what_was_done_earlier_today_counts_and_another_session_is_refused_kindly(
    data: Path, catalogue: Catalogue
) -> None:
    assert play(data, catalogue, attempts=2, attempts_a_day=3) == (3, "")
    assert play(data, catalogue, attempts=2, attempts_a_day=3) == (2, ENOUGH)
    with pytest.raises(Failed) as refused:
        begin(data, catalogue, attempts_a_day=3)
    assert "the limit of the programme is reached (Attempts a day: 3)" in str(refused.value)
    begin(data, catalogue, attempts_a_day=4)[0].close()


def test_the_dose_of_a_day_is_that_of_its_attempts(data: Path, catalogue: Catalogue) -> None:
    play(data, catalogue, attempts=2)
    with closing(connect(data)) as database:
        today = done_on_day(database, "P07", "keyboard", NOON)
        assert (today.attempts, today.repetitions) == (2, 9)
        assert 0.1 < today.minutes < 2
        for other in (NOON - timedelta(days=1), NOON + timedelta(days=1)):
            assert done_on_day(database, "P07", "keyboard", other) == Dose()
        for code, task in (("P07", "reaching"), ("P08", "keyboard")):
            assert done_on_day(database, code, task, NOON) == Dose()


def test_a_limit_of_0_is_none() -> None:
    much = Dose(1e6, 10**6, 10**6)
    assert reached_of_day(TaskParameters(), much) == ""
    assert not is_session_over(TaskParameters(), 1e6)
    assert reached_of_day(TaskParameters(minutes_a_day=30), Dose(30.0)) == "minutes_a_day"
    assert reached_of_day(TaskParameters(minutes_a_day=30), Dose(29.9)) == ""
