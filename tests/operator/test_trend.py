"""The plot of the session's attempts on a large panel."""

from pathlib import Path

import pytest

from sar_tui.loop import topics as t
from sar_tui.model.trial_types import NO_METRIC, Metric
from sar_tui.operator.text_charts import trend
from sar_tui.plugins import Catalogue
from tests.operator import panel_driver as b

TIME = Metric("reaction_time", "ms", "lower")
DONE = (
    b.attempt(attempt=1, practice=True, level=1),
    b.attempt(attempt=2, level=1),
    b.attempt(attempt=3, level=2, metric=700.0, outcome="failure"),
    b.attempt(attempt=4, level=2, metric=None, outcome="failure"),
)


def test_it_shows_results_and_levels_without_practice() -> None:
    lines = trend(DONE, TIME, 54, 14).plain.split("\n")
    assert len(lines) == 14
    assert max(map(len, lines)) <= 54
    assert lines[1].strip() == "● reached  ○ missed  × no result  ╌ goal 520"
    assert lines[-3].split() == ["level", "1", "2", "2"]


def test_markers_have_colours_of_their_own() -> None:
    plot = trend(DONE, TIME, 54, 14)
    styles = {plot.plain[span.start]: span.style for span in plot.spans}
    assert (styles["●"], styles["○"], styles["×"]) == ("$success", "$warning", "$warning")


@pytest.mark.parametrize("attempts", [(), DONE[:1]])
def test_before_the_first_attempt_it_says_so(attempts: tuple[object, ...]) -> None:
    assert trend(attempts, TIME, 54, 14).plain == "No attempt finished yet"  # type: ignore[arg-type]


def test_of_a_task_without_a_result_nothing_is_plotted() -> None:
    assert trend(DONE, NO_METRIC, 54, 14).plain == "This task has no result"


def test_attempts_without_goal_have_a_marker_and_no_line() -> None:
    done = [
        b.attempt(attempt=2, goal=None, outcome="none"),
        b.attempt(attempt=3, goal=None, outcome="none"),
    ]
    plot = trend(done, TIME, 54, 14)
    assert "• no goal" in plot.plain
    assert "goal 0" not in plot.plain
    assert "╌" not in plot.plain
    assert {plot.plain[span.start]: span.style for span in plot.spans}["•"] == "$accent"


def test_of_a_session_of_an_earlier_version_nothing_is_plotted() -> None:
    assert trend(DONE, None, 54, 14).plain == "No attempt finished yet"


@pytest.mark.parametrize(
    ("size", "shown"), [((119, 40), False), ((120, 24), True), ((140, 45), True)]
)
async def test_it_stands_beside_the_log_where_there_is_room(
    size: tuple[int, int], shown: bool, catalogue: Catalogue, tmp_path: Path
) -> None:
    async with b.open_panel(catalogue, tmp_path, size=size, joins=False) as driver:
        await driver.join()
        await driver.publish(t.ATTEMPT_ENDED, b.attempt(attempt=3))
        assert ("reaction time (ms)" in driver.text) is shown
        assert "Encourage 1/10" in driver.text
