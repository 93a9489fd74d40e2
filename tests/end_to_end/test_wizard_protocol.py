"""A session and a panel in two terminals: the operator works by a protocol, and the report tells how
closely.
"""

import json
from pathlib import Path

import pytest

from sar_tui.reports.logged_messages import read
from sar_tui.reports.wizard import report
from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.end_to_end.operator_terminal import Panel, SessionTerminals, plain
from tests.end_to_end.participant_terminal import replays_identically, rows

SETTINGS = {
    "attempts": 2,
    "prompts_per_attempt": 1,
    "difficulty_policy": "fixed",
    "encouragement": "no",
    "filler": "never",
    "operator_feedback": "approve",
    "operator_time_ms": 60_000,
}
WORDS = "Nice to see you here today."
PROTOCOL = f"""
name = "kind"
version = 4
late_after_s = 600
phrases = ["{WORDS}"]

[[steps]]
at = "start"
do = "say phrase 1"

[[steps]]
at = "after attempt 1"
do = "Offer a glass of water."

[[rules]]
when = "accuracy < 1 %"
do = "say phrase 1"

[[rules]]
when = "accuracy > 99 %"
do = "level +1"
"""


def wait_for_due(terminals: SessionTerminals, panel: Panel, text: str) -> None:
    """Wait until something is due and can have been read."""
    terminals.until(lambda: plain(text) in panel.sees(), f"{text} is due")
    terminals.look(0.3)


@pytest.mark.slow
def test_an_operator_follows_a_protocol_and_vetoes_with_a_reason(
    data: Path, tmp_path: Path
) -> None:
    file = tmp_path / "protocol.toml"
    file.write_text(PROTOCOL)
    with SessionTerminals(data) as terminals:
        participant = terminals.participant("--operator", **SETTINGS)
        panel = terminals.panel("--name", "ana", "--wait", "--protocol", str(file))
        participant.terminal.wait_for("Press Enter to go on.")
        wait_for_due(terminals, panel, f"say “{WORDS}” (at the start)")
        panel.does("tick")
        terminals.until(lambda: participant.sees(WORDS), "the phrase is seen")

        participant.answer(1)
        vetoed = panel.wait_for_proposal()
        panel.does("veto")
        terminals.until(lambda: "Why? A digit" in panel.sees(), "the panel asks for a reason")
        panel.does("pick-2")
        terminals.until(lambda: terminals.reported("operator/reason"), "the reason is stored")
        wait_for_due(terminals, panel, "Offer a glass of water.")
        panel.does("leave-out")
        wait_for_due(terminals, panel, "level +1 (accuracy > 99 %)")
        panel.does("tick")
        terminals.until(lambda: terminals.reported("event_handler/level"), "the level is raised")
        panel.does("pick-1")
        terminals.until(lambda: len(terminals.actions("remark")) == 2, "a phrase is said")
        terminals.until(
            lambda: len(terminals.reported("operator/answered")) == 9, "each act is answered"
        )
        seen = participant.has_seen()

    for word in ("protocol", "due", "wrong content", "Why", "tick"):
        assert not any(word in line for line in seen), "the participant never sees a trace of it"
    (given,) = terminals.reported("operator/reason")
    assert (given["action"], given["digit"], given["text"]) == (vetoed["id"], 2, "wrong content")
    (chosen,) = terminals.reported("operator/protocol")
    used = chosen["protocol"]
    assert (used["name"], used["version"], len(used["hash"])) == ("kind", 4, 64)

    ((session,),) = rows(data, "SELECT id FROM sessions")
    database = connect(data)
    row = sessions.find(database, data, session)
    made, _ = report(session, row["parameters"], read(database, session))
    assert made.protocol
    assert [(item.do, item.outcome) for item in made.protocol.items] == [
        ("say phrase 1", "done"),
        ("Offer a glass of water.", "not done"),
        ("level +1", "done"),
    ]
    assert made.protocol.latency_s
    assert made.protocol.outside == {"say": 1, "veto": 1}
    assert made.protocol.reasons == {"vetoed": {"wrong content": 1}}
    assert json.dumps(made.answers) == '{"done": 9}'
    assert replays_identically(data)
