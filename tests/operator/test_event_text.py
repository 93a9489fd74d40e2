"""The panel's log says what has happened, and why."""

from typing import Any

import pytest
from msgspec.structs import replace

from sar_tui.loop import topics as t
from sar_tui.loop.bus import Topic
from sar_tui.model import messages as m
from sar_tui.operator.event_text import event_line
from tests.operator import panel_driver as b

TARGET = "18 of 20 prompts reached the goal; the target is 70 %."
MISSED = "Goal missed 2 times in a row."
ME = b.welcome()
BEFORE = b.arbiter_state(
    b.approval("p1", kind="encouragement"),
    b.approval("l1", level=5),
    replace(b.approval("l2", level=6), mode="veto"),
    queued=(b.action("s1", kind="filler"),),
)
"""The actions that waited for a decision before."""


def level(level: int, reason: Any, why: str = "") -> m.LevelChanged:
    return m.LevelChanged(previous=3, level=level, reason=reason, why=why)


def decided(id: str, **parts: Any) -> m.LevelDecided:
    usual: dict[str, Any] = {"decision": "accepted", "level": 5, "ground": "deadline"}
    return m.LevelDecided(id=id, at=0, **{"actor": "agent"} | usual | parts)


def unapproved(**parts: Any) -> m.Action:
    return b.action("a1", **{"mode": "approve", "ground": "deadline"} | parts)


def markers(state: Any, detail: str = "") -> m.MarkersChanged:
    return m.MarkersChanged(destination="serial:COM3", state=state, at=0, detail=detail)


LOST = m.OperatorChanged(
    actor="operator.ben", state="lost", operated=False, detail="The connection broke."
)


EVENTS: list[tuple[Topic[Any], m.Message, str | None]] = [
    # the level and the goal
    (t.LEVEL, level(4, "target", TARGET), f"Level 3 → 4 (18 of 20{TARGET[8:-1]})."),
    (t.LEVEL, level(2, "failure", MISSED), "Level 3 → 2 (goal missed 2 times in a row)."),
    (t.LEVEL, level(4, "success"), "Level 3 → 4 (goal reached)."),
    (t.LEVEL, level(4, "operator", "Set by hand."), "Level 3 → 4 (an operator)."),
    (
        t.GOAL,
        m.GoalChanged(
            previous=1000, goal=843.218, unit="ms", reason="percentile", why="Of results."
        ),
        "Goal 1000 → 843.2 ms (of results).",
    ),
    (
        t.SETTING,
        m.SettingChanged(name="threshold", value=700.0),
        "The therapist set the goal to 700 from the next attempt on.",
    ),
    (t.LEVEL_DECIDED, decided("l1"), "The next level is 5 (nobody decided in time)."),
    (t.LEVEL_DECIDED, decided("l2"), None),
    (t.LEVEL_DECIDED, decided("l1", ground="operator"), None),
    (
        t.LEVEL_DECIDED,
        decided("l1", decision="rejected", ground="mode", level=0),
        "The level stays (nobody decided).",
    ),
    # proposals
    (t.ACTION, unapproved(), "Nobody decided in time: the feedback was sent unchanged."),
    (t.ACTION, unapproved(mode="veto"), None),
    (t.ACTION, unapproved(ground="operator", actor=b.ANNA), None),
    (
        t.DROPPED,
        m.Dropped(id="p1", reason="late"),
        "The encouragement came too late: the session had moved on.",
    ),
    (
        t.DROPPED,
        m.Dropped(id="p9", reason="expired"),
        "The proposal expired: nobody decided in time.",
    ),
    (t.DROPPED, m.Dropped(id="p1", reason="vetoed", actor=b.ANNA), None),
    (t.DROPPED, m.Dropped(id="s1", reason="late"), None),
    # operators
    (t.PRESENCE, b.presence(), "You have control."),
    (t.PRESENCE, b.presence("baton", "operator.ben"), "ben has control."),
    (
        t.PRESENCE,
        replace(b.presence("unproven"), detail="the terminal answers no queries."),
        "Your presence is not proven: the terminal answers no queries.",
    ),
    (t.PRESENCE, LOST, "ben lost the connection: The connection broke."),
    (
        t.REFUSED,
        m.PeerRequestRefused(
            actor="observer.cara", what="a command", why="An observer cannot act.", count=3
        ),
        "Refused for cara: a command (3 times). An observer cannot act.",
    ),
    # devices
    (
        t.STORAGE,
        m.StorageChanged(working=False, reason="The disk is full."),
        "Cannot write to the disk: The disk is full.",
    ),
    (t.MARKERS, markers("failing", "No port."), "No markers go to serial:COM3: No port."),
    (t.MARKERS, markers("working"), "Markers go to serial:COM3 again."),
]


@pytest.mark.parametrize(
    ("topic", "message", "text"),
    EVENTS,
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_happens_is_logged_with_its_reason_or_not_at_all(
    topic: Topic[m.Message], message: m.Message, text: str | None
) -> None:
    line = event_line(b.frame(topic, message), ME, BEFORE)
    assert (line and line.text) == text
