"""A session beside the last one that can be compared with it, in words."""

from datetime import date, timedelta

import pytest

from sar_tui.framework.language import Language
from sar_tui.framework.parameters import build
from sar_tui.framework.task import Task
from sar_tui.progress.previous import beside_previous, earlier_sessions, kind_word
from sar_tui.progress.task_level import AttemptResult
from tests.progress.session_results import START, adapted, session


@pytest.fixture
def task(keyboard: type[Task]) -> Task:
    return keyboard(build(keyboard.Parameters, {}))


def test_earlier_sessions_are_the_completed_ones_with_the_same_settings(task: Task) -> None:
    played = [
        session(0, adapted(0)),
        session(1, adapted(1)),
        session(2, adapted(2), {"threshold": 900.0}),
        session(3, adapted(3), status="ended early"),
        session(4, adapted(4), mode="simulated"),
        session(5, []),
        session(6, adapted(6)),
        session(7, adapted(7)),
    ]
    found = earlier_sessions(played, task, before="session006")
    assert [each.session for each in found] == ["session000", "session001"]
    assert earlier_sessions(played[:1], task, before="session000") == []
    assert earlier_sessions([], task) == []


def test_today_and_an_earlier_day_are_told_in_seconds() -> None:
    began = START.date()
    earlier = session(0, [AttemptResult(1, 540.0, 20), AttemptResult(1, None, 0)])

    def told(days: int, *results: AttemptResult) -> str:
        return beside_previous(results, earlier, began + timedelta(days=days), Language())

    now = AttemptResult(1, 480.0, 20)
    assert told(4, now) == "Today 0.48 seconds, Friday 0.54 seconds."
    assert told(0, now) == "Today 0.48 seconds, earlier today 0.54 seconds."
    assert told(1, now) == "Today 0.48 seconds, yesterday 0.54 seconds."
    assert told(12, now) == "Today 0.48 seconds, 12 days ago 0.54 seconds."
    harder = AttemptResult(2, 480.0, 20)
    assert told(1, harder) == "Today 0.48 seconds at level 2, yesterday 0.54 seconds at level 1."
    assert told(1, AttemptResult(1, None, 0)) == ""


def test_the_words_are_also_spanish(task: Task) -> None:
    spanish = type(task)(build(type(task).Parameters, {"language": "es"})).tr
    earlier = session(0, [AttemptResult(1, 540.0, 20)])
    said = beside_previous([AttemptResult(1, 480.0, 20)], earlier, date(2026, 3, 3), spanish)
    assert said == "Hoy 0,48 segundos; el viernes, 0,54 segundos."


def test_the_comparison_is_kind_in_both_directions() -> None:
    earlier = [session(day, [AttemptResult(1, metric, 20)]) for day, metric in enumerate((541, 538, 542, 540, 540))]

    def kind(level: int, metric: float | None) -> str:
        return kind_word([AttemptResult(level, metric, 20)], earlier, Language())

    assert kind(1, 480.0) == "That is more than chance. Well done."
    assert kind(1, 700.0) == "Some times go better than others, and that is all right."
    assert kind(1, 540.0) == kind(2, 700.0) == kind(1, None) == ""


@pytest.mark.parametrize("before", [(540.0,), (600.0, 480.0, 550.0, 520.0, 540.0)], ids=["one session", "noise"])
def test_a_session_that_is_better_by_chance_is_not_praised(before: tuple[float, ...]) -> None:
    earlier = [session(day, [AttemptResult(1, metric, 20)]) for day, metric in enumerate(before)]
    said = kind_word([AttemptResult(1, 480.0, 20)], earlier, Language())
    assert said == "Some times go better than others, and that is all right."


def test_sessions_at_another_level_are_not_part_of_the_noise() -> None:
    levels = (1, 2, 1, 2, 1, 2, 1, 2, 1)
    earlier = [
        session(day, [AttemptResult(level, 540.0 + day if level == 1 else 900.0, 20)])
        for day, level in enumerate(levels)
    ]
    assert kind_word([AttemptResult(1, 480.0, 20)], earlier, Language()).endswith("Well done.")
