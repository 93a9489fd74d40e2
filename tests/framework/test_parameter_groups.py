"""Parameters of a task are grouped under headings."""

from typing import Annotated

import pytest

from sar_tui.framework.declaration import Field, meta
from sar_tui.framework.parameters import TaskParameters, fields, grouped


class Parameters(TaskParameters, frozen=True, kw_only=True):
    """A task with headings of its own, and with common parameters declared anew."""

    drum: Annotated[bool, meta("Drum", group="Music")] = True
    reach: Annotated[float, meta("Reach", ge=0, le=100)] = 30.5
    slack_ms: Annotated[int, meta("Slack", "ms", group="Timing", ge=0, le=100)] = 10
    threshold: Annotated[float, meta("Goal", "cm", ge=0, le=100)] = 20.0
    rest_every: Annotated[int, meta("Rest", group="Music", ge=0, le=9)] = 2


def names(heading: str) -> list[str]:
    return [field.name for field in grouped(Parameters)[heading]]


@pytest.mark.parametrize("field", fields(TaskParameters), ids=lambda field: field.name)
def test_every_common_parameter_has_a_heading(field: Field) -> None:
    assert field.group


def test_headings_are_ordered_from_the_tasks_own_to_the_common_ones() -> None:
    common = ["Session", "Difficulty", "Feedback", "Agent", "Operator", "Timing"]
    assert list(grouped(TaskParameters)) == sorted(grouped(TaskParameters), key=common.index)
    assert list(grouped(Parameters)) == ["", "Music", *grouped(TaskParameters)]
    assert names("") == ["reach"]


def test_each_parameter_has_exactly_one_heading() -> None:
    assert sorted(name for heading in grouped(Parameters) for name in names(heading)) == sorted(
        field.name for field in fields(Parameters)
    )


def test_a_task_may_add_or_move_a_parameter_to_a_common_heading() -> None:
    assert names("Timing")[0] == "slack_ms"
    assert names("Music") == ["drum", "rest_every"]


def test_a_redeclared_common_parameter_keeps_its_heading_and_position() -> None:
    assert names("Difficulty") == [field.name for field in grouped(TaskParameters)["Difficulty"]]
    goal = grouped(Parameters)["Difficulty"][0]
    assert (goal.name, goal.unit, goal.default) == ("threshold", "cm", 20.0)
