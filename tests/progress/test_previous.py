"""A session that has just ended beside the earlier ones that can be compared with it, in words for
its participant.
"""

from collections.abc import Sequence
from datetime import date, timedelta

import pytest

from sar_tui.loop.task import Task
from sar_tui.model.language import Language
from sar_tui.progress.lines import SessionResults, lines
from sar_tui.progress.task_level import AttemptResult
from sar_tui.reports.progress import progress
from sar_tui.rules.parameters import build
from sar_tui.runs.previous import beside_previous, line_with
from tests.progress.session_results import START, adapted, session

KIND = "Some times go better than others, and that is all right."
PRAISE = "That is better than your first times, and more than chance and practice. Well done."


@pytest.fixture
def task(keyboard: type[Task]) -> Task:
    return keyboard(build(keyboard.Parameters, {}))


def alike(mean: float) -> list[AttemptResult]:
    return [AttemptResult(3, mean, 20)] * 6


def said(
    earlier: Sequence[SessionResults],
    results: Sequence[AttemptResult],
    task: Task,
    today: date = date(2026, 3, 20),
) -> str:
    line = line_with(earlier, task, "now", results)
    return beside_previous(line, today, task.tr) if line else ""


def test_only_earlier_live_sessions_with_the_same_settings_are_on_its_line(task: Task) -> None:
    played = [
        session(0, adapted(0)),
        session(2, adapted(2), {"threshold": 900.0}),
        session(4, adapted(4), mode="simulated"),
        session(5, []),
        session(6, adapted(6)),
        session(7, adapted(7)),
    ]
    line = line_with(played, task, "session006", adapted(6))
    assert line is not None
    assert [point.results.session for point in line.points] == ["session000", "session006"]
    assert line_with(played[:1], task, "session000", adapted(0)) is None
    assert line_with(played, task, "now", []) is None


def test_today_and_an_earlier_day_are_told_in_the_measure_of_the_line(task: Task) -> None:
    began = START.date()
    earlier = [session(0, alike(540.0)), session(1, alike(200.0), on_day=0, status="aborted")]
    for days, before in {
        4: "Friday",
        0: "earlier today",
        1: "yesterday",
        12: "12 days ago",
    }.items():
        told = said(earlier, alike(480.0), task, began + timedelta(days=days))
        assert told == f"Today 0.48 seconds, {before} 0.54 seconds. {KIND}"
    first = [session(0, adapted(0, base=600.0))]
    by_level = said(first, adapted(1), task, began + timedelta(days=1))
    assert by_level.startswith("Level at goal: today 3.")
    assert ", yesterday 2." in by_level


def test_the_words_are_also_spanish(task: Task) -> None:
    spanish = type(task)(build(type(task).Parameters, {"language": "es"}))
    told = said([session(0, alike(540.0))], alike(480.0), spanish, date(2026, 3, 3))
    assert told.startswith("Hoy 0,48 segundos; el viernes, 0,54 segundos. ")


def test_the_verdict_is_of_the_line_and_its_words_are_kind_in_both_directions(task: Task) -> None:
    means = (541.0, 538.0, 542.0, 540.0, 540.0)
    earlier = [session(day, alike(mean)) for day, mean in enumerate(means)]
    assert said(earlier, alike(480.0), task).endswith(PRAISE)
    assert said(earlier, alike(700.0), task) == said(earlier, alike(541.0), task) == KIND
    assert said(earlier, alike(540.0), task) == "Today 0.54 seconds, 17 days ago 0.54 seconds."
    assert said(earlier[:3], alike(480.0), task).endswith(KIND), "the noise is not yet known"


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("base", [50.0, 450.0, 750.0])
def test_a_participant_reads_no_other_verdict_than_a_therapist(
    keyboard: type[Task], task: Task, base: float, seed: int
) -> None:
    earlier = [session(number, adapted(number + 9 * seed)) for number in range(6)]
    now = adapted(100 + seed, base=base)
    words = said(earlier, now, task)
    found = progress("P01", [*earlier, session(9, now)], {"keyboard": keyboard}.get).lines[0]
    assert words
    assert words.endswith(PRAISE) == (found.verdict == "more")
    last, previous = found.sessions[-1].value, found.sessions[-2].value
    assert last is not None
    assert previous is not None
    assert words.startswith("Level at goal") == (last >= previous)


def test_a_session_that_was_all_too_easy_is_not_called_worse_after_a_worse_one(
    keyboard: type[Task], task: Task
) -> None:
    def earlier(base: float) -> list[SessionResults]:
        return [*(session(n, adapted(n)) for n in range(5)), session(5, adapted(5, base=base))]

    (worse,) = lines(earlier(750.0), {"keyboard": keyboard}.get)
    assert worse.verdict == "less"
    for base, now in ((750.0, AttemptResult(3, 400.0, 20)), (50.0, AttemptResult(1, 1400.0, 20))):
        line = line_with(earlier(base), task, "now", [now] * 12)
        assert line is not None
        assert line.verdict == "not yet known"
        assert base < 100 or beside_previous(line, date(2026, 3, 20), Language()) == ""
