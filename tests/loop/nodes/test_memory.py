"""Memory answers recalls of scored attempts and earlier bests."""

from typing import Any

import pytest

from sar_tui.loop.bus import Bus, Topic
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.loop.nodes.memory import Memory
from sar_tui.loop.topics import ATTEMPT_ENDED, RECALL, SESSION
from sar_tui.model.messages import AttemptEnded, Message, Recall, RecalledAttempts, SessionStarted
from tests.facts import each


class Done(Message, frozen=True, kw_only=True):
    ended: AttemptEnded


DONE = Topic("test/done", Done, origin="input")


class Handler(Node):
    """Stub of the event handler."""

    name = "handler"
    emits = (ATTEMPT_ENDED,)

    @on(DONE)
    def done(self, done: Done) -> None:
        self.emit(ATTEMPT_ENDED, done.ended)


@pytest.fixture
def bus() -> Bus:
    """Return the memory of a session whose earlier bests are 500 ms at level 1 and 700 ms at level
    3.
    """
    bus = Bus(VirtualClock())
    for node in (Memory(), Handler()):
        node.attach(bus)
    best = {"1": 500.0, "3": 700.0}
    bus.publish(SESSION, SessionStarted(run=1, task="lift", theme="calm", seed=1, best=best))
    return bus


def end(bus: Bus, attempt: int, level: int = 1, metric: float | None = 600.0, **more: Any) -> None:
    score: Any = {"metric_unit": "ms", "accuracy": 1.0, "correct": 1, "trials": 1}
    rest: Any = {"outcome": "success", "feedback": "none", "started": 0, "ended": 1}
    known = {"practice": False, **score, **rest, **more}
    ended = AttemptEnded(attempt=attempt, level=level, metric=metric, **known)
    bus.publish(DONE, Done(ended=ended))


def recall(
    bus: Bus, level: int | None = None, seat: str = "A", condition: str | None = None
) -> RecalledAttempts:
    return bus.call(RECALL, Recall(level=level, seat=seat, condition=condition))


@pytest.mark.parametrize(
    ("asked", "attempts"),
    [
        ({}, [2, 3, 4]),
        ({"level": 1}, [2, 4]),
        ({"level": 4}, []),
        ({"level": 1, "condition": "cued"}, [4]),
        ({"level": 1, "condition": ""}, [2]),
        ({"seat": "B"}, [5]),
    ],
)
def test_a_recall_returns_scored_attempts_of_its_level_condition_and_seat_oldest_first(
    bus: Bus, asked: dict[str, Any], attempts: list[int]
) -> None:
    end(bus, 1, practice=True)
    end(bus, 2)
    end(bus, 3, level=2)
    end(bus, 4, condition="cued")
    end(bus, 5, seat="B")
    assert each(recall(bus, **asked).attempts, "attempt") == attempts


def test_an_attempt_scored_again_keeps_its_place(bus: Bus) -> None:
    end(bus, 1, metric=600.0)
    end(bus, 2)
    end(bus, 1, metric=900.0)
    assert each(recall(bus).attempts, "attempt metric") == [(1, 900.0), (2, 600.0)]


@pytest.mark.parametrize(("level", "best"), [(1, 500.0), (2, None), (3, 700.0), (None, None)])
def test_the_best_of_earlier_sessions_is_returned_for_a_level(
    bus: Bus, level: int | None, best: float | None
) -> None:
    end(bus, 1, metric=300.0)
    assert recall(bus, level).earlier_best == best


def test_the_best_of_a_new_run_replaces_it_and_each_condition_has_its_own(bus: Bus) -> None:
    best = {"1": 450.0, "1 cued": 400.0}
    bus.publish(SESSION, SessionStarted(run=2, task="lift", theme="calm", seed=1, best=best))
    found = [recall(bus, 1, condition=name).earlier_best for name in (None, "", "cued", "uncued")]
    assert found == [450.0, 450.0, 400.0, None]
