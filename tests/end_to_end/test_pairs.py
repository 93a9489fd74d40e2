"""A session of two in a real terminal: the onset of each prompt is the time of its flush."""

import json
import re
import time
from pathlib import Path

import pytest

from sar_tui.timing.pty import Terminal
from tests.end_to_end.participant_terminal import (
    QUICK,
    ScreenReader,
    command,
    rows,
    see_the_summary,
)

_ASKED = re.compile(r"^ *(?:Left: (\w))? *(?:Right: (\w))?$", re.MULTILINE)
_PATIENCE = 60.0


def asked(terminal: Terminal, reader: ScreenReader) -> list[str]:
    """Return the keys that the next prompt asks for, once its plain line stands on the screen."""
    deadline = time.monotonic() + _PATIENCE
    while time.monotonic() < deadline:
        terminal.read(time.monotonic_ns() + 20_000_000)
        for found in _ASKED.finditer(reader.text()):
            if any(found.groups()):
                return [key for key in found.groups() if key]
    raise AssertionError(f"no prompt came up:\n{reader.text()}")


@pytest.mark.slow
def test_a_session_of_two_in_a_real_terminal(data: Path) -> None:
    settings = QUICK | {
        "policy": "joint attention",
        "attempts": 1,
        "prompts_per_attempt": 2,
        "cue_lead_ms": 60,
    }
    given = [f"--set={name}={value}" for name, value in settings.items()]
    words = command(
        "run", "pairs", "-p", "P01", "-p", "P02", "--data", str(data), "--seed", "7", *given
    )
    with Terminal(words) as terminal:
        reader = ScreenReader(terminal)
        terminal.wait_for("Press Enter to go on.")
        terminal.confirm()
        terminal.wait_for("Press Enter to begin")
        terminal.settle()
        terminal.confirm()
        pressed = []
        for number in (1, 2):
            keys = asked(terminal, reader)
            terminal.settle(silence_ms=100)  # slower than an anticipation
            for key in keys:
                terminal.press(key)
                terminal.settle(silence_ms=30)
            pressed.append(keys)
            terminal.wait_for(f"Prompts {number} of 2")
        see_the_summary(terminal)
        terminal.confirm()
        assert terminal.wait() == 0
    stored_rows = rows(
        data,
        "SELECT trial, seat, response, correct, timing, details FROM trials ORDER BY trial, seat",
    )
    assert [response for _, _, response, *_ in stored_rows] == [
        key for keys in pressed for key in keys
    ]
    for _, _, _, correct, timing, details in stored_rows:
        assert correct
        assert json.loads(timing)["onset_source"] == "flush"
        assert json.loads(timing)["flags"] == []
        assert json.loads(details)["cue_lead_ms"] >= 60
    assert {seat for _, seat, *_ in stored_rows} <= {"A", "B"}
    assert rows(data, "SELECT count(*) FROM events WHERE topic='framework/fault'") == [(0,)]
