"""Fields that were renamed in code keep the names under which they are stored and sent."""

from typing import Any

import msgspec
import pytest

from sar_tui.loop import topics
from sar_tui.loop.bus import Topic
from sar_tui.loop.topics import ACTING, ALL, ARBITER_STATE, REPORT

PROPOSAL = {
    "seat": "A",
    "id": "a1",
    "kind": "feedback",
    "text": "Well done.",
    "priority": 40,
    "policy": "interrupt",
}
STORED: list[tuple[Topic[Any], dict[str, Any], str, Any]] = [
    (ACTING, {"seat": "A", "acting": False, "owing": True}, "awaits_operator", True),
    (
        REPORT,
        {
            "seat": "A",
            "action": "a1",
            "output": "speech",
            "deed": "say",
            "state": "done",
            "at": 7,
            "detail": "",
        },
        "part",
        "say",
    ),
    (
        ARBITER_STATE,
        {
            "seat": "A",
            "modes": {"feedback": "approve"},
            "operated": True,
            "offers": [
                {
                    "seat": "A",
                    "proposal": PROPOSAL,
                    "mode": "approve",
                    "deadline": 9,
                    "otherwise": "drop",
                }
            ],
            "queued": [],
            "current": None,
        },
        "pending",
        "approve",
    ),
]
TOPICS = {
    "theme/worn": "THEME",
    "arbiter/offered": "PENDING_APPROVAL",
    "arbiter/standing": "ARBITER_STATE",
    "arbiter/stalling": "FILLER_DUE",
    "arbiter/level_ruled": "LEVEL_DECIDED",
    "operator/act": "COMMAND",
    "operator/setting": "SETTING",
    "arbiter/missed": "LATE_DECISION",
    "operator/noted": "NOTE_ADDED",
}


@pytest.mark.parametrize(("topic", "stored", "field", "value"), STORED)
def test_a_stored_message_is_read_and_written_with_its_stored_names(
    topic: Topic[Any], stored: dict[str, Any], field: str, value: Any
) -> None:
    message = msgspec.json.decode(msgspec.json.encode(stored), type=topic.type)
    found = getattr(message, field)
    assert (found[0].mode if field == "pending" else found) == value
    written = msgspec.json.decode(msgspec.json.encode(message))
    assert written.keys() == stored.keys()


@pytest.mark.parametrize("name", TOPICS)
def test_a_topic_keeps_its_stored_name(name: str) -> None:
    assert ALL[name] is getattr(topics, TOPICS[name])
