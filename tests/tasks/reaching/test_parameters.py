"""Invalid settings of the reaching task are refused with a reason."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.parameters import build

CM = "marker_distances_cm"


def make(**parameters: object) -> Task:
    kind = Catalogue().task("reaching")
    return kind(build(kind.Parameters, parameters))


@pytest.mark.parametrize(
    ("parameters", "name", "part"),
    [
        ({CM: []}, CM, "1 to 200 cm away; name one or more"),
        ({CM: [0.5, 20]}, CM, "1 to 200 cm"),
        ({CM: [20, 201]}, CM, "1 to 200 cm"),
        ({CM: [20, float("nan")]}, CM, "1 to 200 cm"),
        ({CM: [20, 15]}, CM, "from the nearest marker to the farthest"),
        ({CM: [15, 15]}, CM, "from the nearest marker to the farthest"),
        ({"goal_times_ms": [900]}, "goal_times_ms", "6 markers, and 1 goals"),
        ({CM: [15, 20], "goal_times_ms": [900, 99]}, "goal_times_ms", "between 100 and 60000 ms"),
        ({CM: [15], "goal_times_ms": [60_001]}, "goal_times_ms", "between 100 and 60000 ms"),
        ({CM: [15, 20], "start_level": 3}, "start_level", "there is no level 3"),
        ({CM: [15, 20], "min_level": 3, "start_level": 3}, "min_level", "there is no level 3"),
        ({"still_ms": 999}, "still_ms", "1000 to 60000"),
        ({"imu": ""}, "imu", ""),
    ],
)
def test_invalid_settings_are_reported(parameters: dict[str, object], name: str, part: str) -> None:
    with pytest.raises(ParameterError) as caught:
        make(**parameters)
    assert part in caught.value.problems[name]


@pytest.mark.parametrize(
    "parameters",
    [
        {"marker_distances_cm": [1, 200]},
        {"marker_distances_cm": [30]},
        {"marker_distances_cm": "15 20", "goal_times_ms": "900 1000", "start_level": "2"},
        {"goal_times_ms": [900, 900, 900, 900, 900, 900]},
        {"imu": "recorded:reaches.csv?speed=fast"},
    ],
)
def test_valid_settings_are_accepted(parameters: dict[str, object]) -> None:
    assert make(**parameters).levels >= 1


# --- a goal for each marker


@pytest.mark.parametrize(
    ("parameters", "goals"),
    [
        ({"threshold": 1200}, [1200, 1386, 1549, 1697, 1833, 1960]),
        ({CM: [10, 40], "threshold": 1000}, [1000, 2000]),
        ({CM: [10, 20], "goal_times_ms": [900, 800], "threshold": 5000}, [900, 800]),
    ],
)
def test_each_marker_is_a_level_with_its_goal_and_a_share_of_it_as_neutral_band(
    parameters: dict[str, object], goals: list[float]
) -> None:
    task = make(neutral_band=5, **parameters)
    targets = [task.target(level) for level in range(1, task.levels + 1)]
    assert [target.threshold for target in targets] == goals
    assert [target.neutral_band for target in targets] == [5 * goal / 100 for goal in goals]


@given(
    st.lists(st.floats(1, 200), min_size=2, max_size=8, unique=True).map(sorted),
    st.floats(300, 5000),
)
def test_a_farther_marker_never_has_less_time(markers: list[float], threshold: float) -> None:
    task = make(marker_distances_cm=markers, threshold=threshold)
    goals = [task.target(level).threshold for level in range(1, task.levels + 1)]
    assert all(near <= far for near, far in pairwise(goals))
    assert goals[0] == pytest.approx(threshold, abs=0.5)
