"""Practice in a terminal: a recorded session plays on the panel, and the trainee is told at the end."""

import json
from pathlib import Path

import pytest

from tests.end_to_end.operator_terminal import Panel, SessionTerminals
from tests.end_to_end.participant_terminal import command, rows
from tests.played import simulated

PROTOCOL = """
name = "train"
version = 1

[[steps]]
at = "start"
do = "say greeting"

[[steps]]
at = "after attempt 1"
do = "veto feedback"
"""


@pytest.mark.slow
def test_a_trainee_practises_on_a_recorded_session(data: Path, tmp_path: Path) -> None:
    settings = {"attempts": 2, "prompts_per_attempt": 1, "operator_feedback": "approve"}
    session = simulated(data, operator="careful", **settings)
    before = rows(data, "SELECT session, seq, message FROM events")
    file, result = tmp_path / "protocol.toml", tmp_path / "eve.json"
    file.write_text(PROTOCOL)
    with SessionTerminals(data) as terminals:
        words = ["practise", session, "--protocol", str(file), "--name", "eve", "--speed", "8"]
        words += ["--to", str(result), "--data", str(data)]
        terminal = terminals.start_program(command("wizard", *words), 100, 30)
        panel = Panel(terminals, terminal)
        terminals.until(lambda: "say greeting at the start" in panel.sees(), "a step is due")
        terminals.look(0.3)
        panel.does("tick")
        terminals.until(lambda: "veto feedback after attempt 1" in panel.sees(), "it plays")
        terminals.until(lambda: "FEEDBACK" in panel.sees(), "a proposal waits")
        terminals.look(0.5)
        panel.does("tick")
        terminals.until(lambda: "Done veto feedback" in panel.sees().replace(":", ""), "ticked")
        terminals.until(lambda: "The session is over" in panel.sees(), "all is played")
        panel.does("close")
        terminals.until(lambda: terminal.ended, "the panel is left")
        said = terminal.output.decode(errors="replace")
    assert "As the protocol says: 1 of 1." in said
    found = json.loads(result.read_text())
    assert (found["is_complete"], found["as_protocol"]) == (True, {"same": 1, "of": 1})
    assert [item["outcome"] for item in found["adherence"]["items"]] == ["done", "done"]
    assert rows(data, "SELECT session, seq, message FROM events") == before
    (line,) = (data / "wizard-practice.jsonl").read_text().splitlines()
    assert json.loads(line)["operator"] == "eve"
