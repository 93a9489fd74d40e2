"""The small chart of a participant's sessions."""

from collections.abc import Sequence
from datetime import date, timedelta

from textual.content import Content

from sar_tui.app.home.chart import Bar, Chart, charted, draw
from sar_tui.loop.task import Task
from sar_tui.model.language import Language
from sar_tui.model.trial_types import Metric
from sar_tui.progress.lines import SessionResults
from sar_tui.progress.task_level import AttemptResult
from sar_tui.reports.progress import progress
from tests.progress.session_results import adapted, at_one_level, session

ENGLISH = Language()


def chart(*levels: float) -> Chart:
    began = date(2026, 11, 3)
    bars = [
        Bar(began + timedelta(days=2 * n), level / 4, f"{level:.1f}", "12/20")
        for n, level in enumerate(levels)
    ]
    return Chart("Level at goal", bars)


def rows(drawn: Sequence[Content]) -> list[str]:
    return [row.plain.rstrip() for row in drawn]


def drawn_of(keyboard: type[Task], *sessions: SessionResults) -> Chart:
    return charted(progress("P01", sessions, {"keyboard": keyboard}.get).lines[-1], ENGLISH)


def test_the_smallest_chart_has_a_caption_bars_and_levels() -> None:
    drawn = draw(chart(1, 2, 4), 39, 3, ENGLISH)
    assert rows(drawn) == [
        "Level at goal, last 3 sessions",
        "             ▂▂▂    ▄▄▄    ███",
        "             1.0    2.0    4.0",
    ]
    assert rows(draw(chart(1), 39, 3, ENGLISH))[0] == "Level at goal"


def test_more_room_adds_goals_reached_and_dates_and_higher_bars() -> None:
    assert rows(draw(chart(1, 2, 4), 39, 9, ENGLISH)) == [
        "",
        "Level at goal, last 3 sessions",
        "                           ███",
        "                           ███",
        "                    ███    ███",
        "             ███    ███    ███",
        "             1.0    2.0    4.0",
        "Reached     12/20  12/20  12/20",
        "            3 Nov  5 Nov  7 Nov",
    ]


def test_the_bar_of_the_last_session_stands_out() -> None:
    bars = draw(chart(1, 2, 4), 39, 3, ENGLISH)[1]
    (accent,) = (span for span in bars.spans if span.style == "$accent")
    assert bars.plain[accent.start : accent.end].strip() == "███"
    assert accent.start > bars.plain.index("▄▄▄")


def test_the_newest_sessions_are_drawn_as_far_as_there_is_room() -> None:
    caption, _, values = rows(draw(chart(*range(1, 30)), 39, 3, ENGLISH))
    assert values.split() == ["26.0", "27.0", "28.0", "29.0"]
    assert caption == "Level at goal, last 4 sessions"


def test_without_sessions_there_is_no_chart() -> None:
    assert draw(Chart(), 39, 6, ENGLISH) == []


def test_a_session_that_was_all_too_easy_is_above_all_others(keyboard: type[Task]) -> None:
    hard = session(3, [AttemptResult(1, 1400.0, 20), AttemptResult(2, 1500.0, 20)])
    found = drawn_of(
        keyboard,
        session(0, adapted(0)),
        session(1, adapted(1)),
        session(2, at_one_level(2, 400.0)),
        hard,
    )
    assert found.label == "Level at goal"
    assert [bar.value for bar in found.bars] == ["3.3", "3.3", ">3", "<1"]
    found = [bar.height == max(each.height for each in found.bars) for bar in found.bars]
    assert found == [False, False, True, False]


def test_without_goals_reached_their_row_is_left_out(keyboard: type[Task]) -> None:
    drawn = draw(drawn_of(keyboard, session(0, adapted(0), reached=None)), 39, 6, ENGLISH)
    assert not [row for row in rows(drawn) if row.startswith("Reached")]


def test_at_one_level_a_better_result_has_a_higher_bar(keyboard: type[Task]) -> None:
    def heights(means: Sequence[float], metric: Metric) -> list[float]:
        played = [
            session(n, [AttemptResult(3, mean, 20)] * 6, metric=metric)
            for n, mean in enumerate(means)
        ]
        found = drawn_of(keyboard, *played)
        assert found.label.startswith("Result")
        return [round(bar.height, 2) for bar in found.bars]

    assert heights([800.0, 400.0], Metric("reaction_time", "ms", "lower")) == [0.5, 1.0]
    assert heights([8.0, 4.0], Metric("taps", "taps", "higher")) == [1.0, 0.5]
    assert heights([8.0, -4.0], Metric("effect", "ms", "lower")) == [0.0, 0.0]
