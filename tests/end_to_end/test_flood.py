"""A flood of messages at the link disturbs no trial."""

import subprocess
import sys
from pathlib import Path
from statistics import median

import pytest

from sar_tui.link.zenoh_settings import socket_settings
from tests.end_to_end.operator_terminal import Participant, SessionTerminals
from tests.end_to_end.participant_terminal import only_session, rows

MOST_ERROR_MS = 30
RATE, SECONDS = 10_000, 2
SENT = RATE * SECONDS
_FLOOD = f"""
import sys, time, zenoh
from sar_tui.model.messages import NoteAdded
from sar_tui.link import protocol
from sar_tui.link.zenoh_settings import LinkKeys, config
act = protocol.encode(
    protocol.ActRequest("flood", "operator/note", protocol.msgspec.Raw(protocol.encode(NoteAdded(text="x"))))
)
key = LinkKeys(sys.argv[2]).act("operator.flood")
with zenoh.open(config(sys.argv[1])) as session:
    started, sent = time.monotonic(), 0
    while sent < {SENT}:
        while sent < min({SENT}, (time.monotonic() - started) * {RATE}):
            session.put(key, act, congestion_control=zenoh.CongestionControl.BLOCK)
            sent += 1
        time.sleep(0.001)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals")
def test_flood_of_messages_disturbs_no_trial_and_is_counted(data: Path) -> None:
    # On a busy machine, a prompt may be shown long before this reads it.
    settings = {
        "prompts_per_attempt": 20,
        "attempts": 1,
        "response_timeout_ms": 20_000,
        "outputs": "",
        "encouragement": "no",
    }
    with SessionTerminals(data) as terminals:
        participant, _ = terminals.both(**settings)
        session = only_session(data)
        socket = terminals.runtime / "sar-tui" / f"{session}.sock"
        participant.answer(1)
        words = [sys.executable, "-c", _FLOOD, socket_settings(socket), session]
        flood = subprocess.Popen(words)
        try:
            participant.answer(19)
            assert flood.wait(60) == 0
        finally:
            flood.kill()
            flood.wait()
        check_every_press(terminals, participant)
        terminals.until(lambda: _refused(terminals) >= 0.9 * SENT, "the excess has been counted")
        assert _refused(terminals) <= SENT
        assert len(terminals.reported("operator/refused")) < 100, "in few reports"
        assert terminals.is_operated, "the operator is still there"
    assert rows(data, "SELECT count(*) FROM notes WHERE author='operator.flood'") == [(0,)], (
        "it is not in control"
    )


def check_every_press(terminals: SessionTerminals, participant: Participant) -> None:
    """Check that each press is a trial with its correctness and reaction time."""
    query = (
        "SELECT stimulus, response, correct, reaction_time_ms FROM trials ORDER BY attempt, trial"
    )
    presses = participant.script.presses
    terminals.until(
        lambda: len(rows(terminals.data, query)) >= len(presses), "all trials are stored"
    )
    trials = rows(terminals.data, query)
    assert [trial[:3] for trial in trials] == [
        (press.expected, press.key, press.key == press.expected) for press in presses
    ]
    errors = [
        abs(recorded - press.reaction_time_ms)
        for (_, _, _, recorded), press in zip(trials, presses, strict=True)
    ]
    assert median(errors) < MOST_ERROR_MS, "no key had to wait for the link"


def _refused(terminals: SessionTerminals) -> int:
    return sum(each.get("count", 1) for each in terminals.reported("operator/refused"))
