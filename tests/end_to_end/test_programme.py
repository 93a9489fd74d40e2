"""A therapist changes a programme in a real terminal; the next session runs it, and history tells
both.
"""

import json
import subprocess
from pathlib import Path

import pytest

from sar_tui.timing.pty import Terminal
from sar_tui.timing.scripted_participant import ScriptedParticipant, random_answers
from tests.end_to_end.participant_terminal import QUICK, command, rows, see_the_summary

ENTER, CTRL_Q, CTRL_S = b"\r", b"\x11", b"\x13"
START = {**QUICK, "attempts": 2, "prompts_per_attempt": 3, "threshold": 900.0}


def set_value(terminal: Terminal, name: str, value: str, meaning: str) -> None:
    """Find a setting, see what it means, and type another value in place of the selected one."""
    before = len(terminal.output)
    terminal.write(b"/")
    terminal.wait_for("Find a setting", since=before)
    terminal.settle()
    terminal.write(name.encode())
    terminal.settle()
    before = len(terminal.output)
    terminal.write(ENTER)
    terminal.wait_for(meaning, since=before)
    terminal.settle()
    terminal.write(value.encode())
    terminal.wait_for(value, since=before)
    terminal.settle()


def called(*words: str) -> str:
    return subprocess.run(command(*words), capture_output=True, text=True, check=True).stdout


@pytest.mark.slow
def test_a_therapist_raises_goal_and_feedback_frequency_and_the_next_session_runs_with_them(
    data: Path,
) -> None:
    file = data.parent / "start.toml"
    file.write_text(
        'task = "keyboard"\n[parameters]\nfeedback_every = 5\n'
        + "".join(f"{name} = {value}\n" for name, value in START.items())
    )
    where = ("--data", str(data))
    called(
        "programme",
        "import",
        "P07",
        "keyboard",
        str(file),
        "--new",
        "--reason",
        "First visit",
        "--author",
        "Ana",
        *where,
    )

    with Terminal(command(*where)) as terminal:
        terminal.wait_for("P07 · Keyboard reaction")
        terminal.settle()
        terminal.press("f2")
        terminal.wait_for("version 1")
        terminal.settle()
        set_value(terminal, "threshold", "1100", "The mean reaction time of an attempt")
        set_value(terminal, "feedback_every", "3", "For every and summary")
        terminal.write(CTRL_S)
        terminal.wait_for("Why this change?")
        terminal.settle()
        terminal.write(b"Tired" + ENTER)
        terminal.wait_for("version 2")
        terminal.settle()
        seen = len(terminal.output)
        terminal.press("escape")
        terminal.wait_for("P07 · Keyboard reaction", since=seen)
        terminal.settle()
        terminal.confirm()
        terminal.settle()
        terminal.confirm()
        ScriptedParticipant(terminal, random_answers(3, 120, 220)).run(6)
        see_the_summary(terminal)
        terminal.confirm()
        terminal.settle()
        terminal.write(CTRL_Q)
        assert terminal.wait() == 0

    ((programme, parameters),) = rows(data, "SELECT programme, parameters FROM sessions")
    ran = json.loads(parameters)
    assert (programme, ran["threshold"], ran["feedback_every"]) == (2, 1100, 3)
    assert rows(data, "SELECT DISTINCT goal FROM attempts") == [(1100,)]
    versions = json.loads(called("programme", "history", "P07", "--json", *where))["versions"]
    assert [(each["version"], each["reason"]) for each in versions] == [
        (2, "Tired"),
        (1, "First visit"),
    ]
    assert [(each["name"], each["before"], each["after"]) for each in versions[0]["changes"]] == [
        ("threshold", 900, 1100),
        ("feedback_every", 5, 3),
    ]
    assert "Programme    version 2" in called("show", "last", *where)
