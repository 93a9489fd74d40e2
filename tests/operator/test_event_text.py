"""The panel's log says why the level or the goal has changed, and if markers are lost."""

import pytest

from sar_tui.loop import topics as t
from sar_tui.loop.bus import Topic
from sar_tui.model import messages as m
from sar_tui.operator.event_text import event_line
from tests.operator import panel_driver as b

TARGET = "18 of 20 prompts reached the goal; the target is 70 %."


@pytest.mark.parametrize(
    ("topic", "message", "text"),
    [
        (
            t.LEVEL,
            m.LevelChanged(previous=3, level=4, reason="target", why=TARGET),
            f"Level 3 → 4 (18 of 20{TARGET[8:-1]}).",
        ),
        (
            t.LEVEL,
            m.LevelChanged(
                previous=3, level=2, reason="failure", why="Goal missed 2 times in a row."
            ),
            "Level 3 → 2 (goal missed 2 times in a row).",
        ),
        (
            t.LEVEL,
            m.LevelChanged(previous=3, level=4, reason="success"),
            "Level 3 → 4 (goal reached).",
        ),
        (
            t.LEVEL,
            m.LevelChanged(previous=3, level=4, reason="operator", why="Set by hand."),
            "Level 3 → 4 (an operator).",
        ),
        (
            t.GOAL,
            m.GoalChanged(
                previous=1000,
                goal=843.218,
                unit="ms",
                reason="percentile",
                why="The goal is a result.",
            ),
            "Goal 1000 → 843.2 ms (the goal is a result).",
        ),
        (
            t.MARKERS,
            m.MarkersChanged(
                destination="serial:COM3",
                state="failing",
                at=0,
                detail="The port takes no markers.",
            ),
            "No markers go to serial:COM3: The port takes no markers.",
        ),
        (
            t.MARKERS,
            m.MarkersChanged(destination="serial:COM3", state="working", at=0),
            "Markers go to serial:COM3 again.",
        ),
    ],
    ids=[
        "target",
        "in a row",
        "of an earlier program",
        "by hand",
        "goal",
        "no markers",
        "markers again",
    ],
)
def test_a_change_is_logged_with_its_reason(
    topic: Topic[m.Message], message: m.Message, text: str
) -> None:
    line = event_line(b.frame(topic, message), None, None)
    assert line is not None
    assert line.text == text
