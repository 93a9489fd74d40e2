"""Sessions share a line only if they can be compared, and each has an estimate, a side, or
nothing.
"""

import math

import pytest

from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.progress.lines import Line, lines
from sar_tui.progress.task_level import AttemptResult, on_axis, places, to_level
from tests.progress.session_results import adapted, at_one_level, session


@pytest.fixture
def reaching(catalogue: Catalogue) -> type[Task]:
    return catalogue.task("reaching")


def found(keyboard: type[Task], *sessions: object) -> list[Line]:
    return lines(sessions, {"keyboard": keyboard}.get)  # type: ignore[arg-type]


def test_sessions_with_the_same_settings_share_a_line(keyboard: type[Task]) -> None:
    (line,) = found(keyboard, *(session(number, adapted(number)) for number in range(3)))
    assert [point.results.session for point in line.points] == [f"session00{n}" for n in range(3)]
    assert all(point.estimate for point in line.points)
    assert line.measure == "level"


def test_sessions_that_measured_otherwise_never_share_a_line(keyboard: type[Task]) -> None:
    measured: list[dict[str, object]] = [
        {"threshold": 900.0},
        {"choice_set": "left hand"},
        {"prompts_per_attempt": 10},
        {"response_timeout_ms": 3000},
    ]
    others = [{"seat": "B"}, {"mode": "simulated"}, {"task_version": "0"}, {"task": "other"}]
    first = session(1, adapted(1))
    second = [session(2, adapted(2), parameters) for parameters in measured]
    for other in (*second, *(session(2, adapted(2), **more) for more in others)):
        assert [len(line.points) for line in found(keyboard, first, other)] == [1, 1], other


def test_defaults_and_what_does_not_bear_on_times_leave_the_line_whole(
    keyboard: type[Task],
) -> None:
    for parameters in (
        {"attempts": 5}, {"start_level": 4}, {"feedback_every": 3}, {"language": "es"},
        {"threshold": 1000.0, "levels": []},
    ):  # fmt: skip
        (line,) = found(keyboard, session(1, adapted(1)), session(2, adapted(2), parameters))
        assert len(line.points) == 2, parameters


def test_the_line_with_the_newest_session_comes_last(keyboard: type[Task]) -> None:
    fast = session(2, adapted(2), {"threshold": 800.0})
    both = found(keyboard, session(1, adapted(1)), fast, session(3, adapted(3)))
    assert [len(line.points) for line in both] == [1, 2]


def test_a_session_on_one_side_of_the_goal_says_so(keyboard: type[Task]) -> None:
    easy, hard = at_one_level(1, 500.0), at_one_level(2, 1900.0)
    (line,) = found(keyboard, session(1, easy), session(2, hard))
    sides = [(point.estimate, point.side) for point in line.points]
    assert sides == [(None, "easier"), (None, "harder")]


def test_fast_attempts_with_too_many_errors_are_not_too_easy(keyboard: type[Task]) -> None:
    hasty = [*at_one_level(1, 500.0), AttemptResult(3, 450.0, 6), AttemptResult(3, None, 0)]
    (line,) = found(keyboard, session(1, hasty, reached=12))
    assert line.points[0].side == ""


def test_where_the_level_never_changed_the_result_is_the_measure(keyboard: type[Task]) -> None:
    slow, fast = session(1, at_one_level(1, 960.0)), session(2, at_one_level(2, 900.0))
    (line,) = found(keyboard, slow, fast)
    assert (line.measure, line.fixed_level) == ("result", 3)
    first, second = (line.value(point) for point in line.points)
    assert first is not None
    assert second is not None
    assert second > first


def test_attempts_without_a_result_are_kept_but_not_measured(keyboard: type[Task]) -> None:
    assert found(keyboard, session(1, [])) == []
    results = [*adapted(1), AttemptResult(2, None, 0)]
    (line,) = found(keyboard, session(1, results))
    (alone,) = found(keyboard, session(1, results[:-1]))
    assert line.points[0].estimate == alone.points[0].estimate


def test_a_task_or_a_setting_that_is_gone_leaves_results_without_an_estimate(
    keyboard: type[Task], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(self: Task, level: int) -> float:
        raise ZeroDivisionError

    (not_installed,) = lines([session(1, adapted(1))], lambda name: None)
    (not_accepted,) = found(keyboard, session(1, adapted(1), {"choice_set": "feet"}))
    monkeypatch.setattr(keyboard, "difficulty", broken)
    (not_placed,) = found(keyboard, session(1, adapted(1)), session(2, adapted(2)))
    for line in (not_installed, not_accepted, not_placed):
        assert line.task is None
        assert all(point.mean is not None and point.estimate is None for point in line.points)
    assert not_installed.measure == ""


def test_reaction_times_lie_over_the_information_in_the_choice(keyboard: type[Task]) -> None:
    task = keyboard(keyboard.Parameters(levels=("fj", "dfjk")))
    (attempt,) = on_axis(task, [AttemptResult(2, 950.0, 18)])
    assert (attempt.difficulty, attempt.weight, attempt.distance) == (2.0, 18.0, -50.0)
    assert task.axis.show(math.log2(10.4)) == "10.4 keys"


def test_reach_times_lie_over_the_distance_beside_the_markers_goal(reaching: type[Task]) -> None:
    task = reaching(reaching.Parameters())
    (attempt,) = on_axis(task, [AttemptResult(6, 2000.0, 1)])
    assert attempt.difficulty == 40.0
    assert attempt.distance == pytest.approx(2000.0 - task.target(6).threshold)
    assert task.axis.show(28.94) == "28.9 cm"


def test_a_place_on_the_axis_is_a_place_between_levels(reaching: type[Task]) -> None:
    rising = places(reaching(reaching.Parameters()))
    assert [to_level(rising, cm) for cm in (15.0, 17.5, 20.0, 40.0)] == [1.0, 1.5, 2.0, 6.0]
    assert (to_level(rising, 14.9), to_level(rising, 41.0)) == (None, None)


def test_levels_not_getting_harder_one_by_one_have_no_places_between(keyboard: type[Task]) -> None:
    task = keyboard(keyboard.Parameters(levels=("asdf", "jk")))
    assert places(task) == []
    assert to_level([], 1.0) is None
