"""The session continues alone if an operator's panel or the link fails, and the operator
reconnects.
"""

import os
import signal
import subprocess
import sys
from pathlib import Path
from statistics import median

import pytest

from sar_tui.link.zenoh_settings import socket_settings
from sar_tui.loop.clock import host_now
from sar_tui.model.units import MS
from tests.end_to_end.operator_terminal import (
    Panel,
    Participant,
    SessionTerminals,
    children,
    is_running,
)
from tests.end_to_end.participant_terminal import only_session, rows

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="finds processes in /proc")

LOST_MS = 700
MOST_ERROR_MS = 30
LATE_MS = 3000
"""Tolerance for a busy machine."""
SETTINGS = {
    "prompts_per_attempt": 1,
    "outputs": "",  # no waiting for the agent's gestures
    "encouragement": "no",
    "filler": "never",
    "operator_feedback": "approve",
    "operator_time_ms": 60_000,
    "operator_lost_ms": LOST_MS,
}
ANA = "operator.ana"


def broker_of(participant: Participant) -> int:
    """Return the process id of the broker."""
    found = children(participant.terminal.process.pid)
    (broker,) = [pid for pid, command in found.items() if "sar_tui.link.broker" in command]
    return broker


def approves_one(terminals: SessionTerminals, participant: Participant, panel: Panel) -> None:
    """Run an attempt whose feedback the operator approves."""
    before = [row["id"] for row in terminals.actions("feedback")]
    participant.answer(1)
    panel.wait_for_proposal(before[-1] if before else "")
    panel.does("approve")
    terminals.until(
        lambda: terminals.actions("feedback")[len(before)]["decided_ns"], "it is decided"
    )
    row = terminals.actions("feedback")[len(before)]
    assert (row["decision"], row["actor"], row["ground"]) == ("accepted", ANA, "operator")


def falls_back(terminals: SessionTerminals, since: int, within_ms: int) -> None:
    """Check that the pending approval is decided without an operator, soon enough after ``since``
    (ns).
    """
    terminals.until(
        lambda: terminals.actions("feedback")[-1]["decided_ns"], "it is decided without an operator"
    )
    row = terminals.actions("feedback")[-1]
    assert (row["decision"], row["actor"], row["ground"]) == ("accepted", "agent", "no operator")
    assert row["final"]["text"] == row["proposed"]["text"]
    assert row["decided_ns"] - max(since, row["proposed_ns"]) < (within_ms + LATE_MS) * MS


def check_every_press(terminals: SessionTerminals, participant: Participant) -> None:
    """Check that each press is a trial with its correctness and reaction time."""
    terminals.until(
        lambda: len(_trials(terminals)) >= len(participant.script.presses), "all trials are stored"
    )
    trials = _trials(terminals)
    assert [trial[:3] for trial in trials] == [
        (press.expected, press.key, press.key == press.expected)
        for press in participant.script.presses
    ]
    errors = [
        abs(recorded - press.reaction_time_ms)
        for (_, _, _, recorded), press in zip(trials, participant.script.presses, strict=True)
    ]
    assert median(errors) < MOST_ERROR_MS, "no key had to wait for the link"


def _trials(terminals: SessionTerminals) -> list[tuple[str, str, int, float]]:
    query = (
        "SELECT stimulus, response, correct, reaction_time_ms FROM trials ORDER BY attempt, trial"
    )
    return rows(terminals.data, query)


def test_killed_panel_is_lost_at_once_and_can_be_replaced(data: Path) -> None:
    with SessionTerminals(data) as terminals:
        participant, panel = terminals.both(attempts=4, **SETTINGS)
        participant.answer(1)
        panel.wait_for_proposal()
        killed = host_now()
        panel.kill()
        falls_back(terminals, killed, LOST_MS)
        participant.answer(1)
        terminals.until(
            lambda: len(terminals.actions("feedback")) == 2, "the next feedback is given"
        )
        falls_back(terminals, killed, 0)

        back = terminals.panel("--name", "ana")
        terminals.until(lambda: terminals.is_operated, "the operator is back")
        approves_one(terminals, participant, back)
        back.does("close")
        terminals.until(lambda: "Leave the panel?" in back.sees(), "it asks once")
        back.does("close")
        assert back.terminal.wait() == 0
        participant.answer(1)
        terminals.until(
            lambda: len(terminals.actions("feedback")) == 4, "the last feedback is given"
        )
        falls_back(terminals, host_now(), 0)
        check_every_press(terminals, participant)
        states = [state for actor, state in terminals.presence() if actor == ANA]
    assert states == ["joined", "baton", "lost", "joined", "baton", "left"]


@pytest.mark.slow
def test_frozen_panel_is_lost_and_reconnects(data: Path) -> None:
    with SessionTerminals(data) as terminals:
        participant, panel = terminals.both(attempts=4, **SETTINGS)
        participant.answer(1)
        panel.wait_for_proposal()
        frozen = host_now()
        panel.kill(signal.SIGSTOP)
        falls_back(terminals, frozen, LOST_MS)
        participant.answer(1)
        falls_back(terminals, frozen, 0)
        (lost,) = [
            each for each in terminals.reported("operator/presence") if each["state"] == "lost"
        ]
        assert not lost["operated"]
        assert lost["detail"]

        panel.kill(signal.SIGCONT)
        terminals.until(lambda: terminals.is_operated, "the operator is back")
        terminals.until(lambda: "in control" in panel.sees(), "and sees that")
        approves_one(terminals, participant, panel)
        check_every_press(terminals, participant)
        states = [state for actor, state in terminals.presence() if actor == ANA]
    assert states == ["joined", "baton", "lost", "joined", "baton"]


@pytest.mark.slow
def test_killed_broker_is_restarted_and_the_operator_reconnects(data: Path) -> None:
    with SessionTerminals(data) as terminals:
        participant, panel = terminals.both(attempts=3, **SETTINGS)
        participant.answer(1)
        panel.wait_for_proposal()
        killed = host_now()
        broker = broker_of(participant)
        os.kill(broker, signal.SIGKILL)
        falls_back(terminals, killed, LOST_MS)
        terminals.until(lambda: terminals.is_operated, "the operator is back")
        assert broker_of(participant) != broker
        terminals.until(lambda: "in control" in panel.sees(), "and sees that")
        approves_one(terminals, participant, panel)
        check_every_press(terminals, participant)
        states = [state for actor, state in terminals.presence() if actor == ANA]
        broker = broker_of(participant)
        participant.terminal.kill()
        participant.terminal.wait()
        terminals.until(
            lambda: not is_running(broker),
            "the link's process ends with the program, even with kill -9",
        )
    assert states == ["joined", "baton", "lost", "joined", "baton"]


# --- a flood

RATE, SECONDS = 10_000, 2
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
    while sent < {RATE * SECONDS}:
        while sent < min({RATE * SECONDS}, (time.monotonic() - started) * {RATE}):
            session.put(key, act, congestion_control=zenoh.CongestionControl.BLOCK)
            sent += 1
        time.sleep(0.001)
"""


@pytest.mark.slow
def test_flood_of_messages_disturbs_no_trial_and_is_counted(data: Path) -> None:
    with SessionTerminals(data) as terminals:
        participant, _ = terminals.both(**SETTINGS | {"prompts_per_attempt": 20}, attempts=1)
        session = only_session(data)
        settings = socket_settings(terminals.runtime / "sar-tui" / f"{session}.sock")
        participant.answer(1)
        flood = subprocess.Popen([sys.executable, "-c", _FLOOD, settings, session])
        try:
            participant.answer(19)
            assert flood.wait(60) == 0
        finally:
            flood.kill()
            flood.wait()
        check_every_press(terminals, participant)
        terminals.until(
            lambda: _refused(terminals) >= 0.9 * RATE * SECONDS, "the excess has been counted"
        )
        assert _refused(terminals) <= RATE * SECONDS
        assert len(terminals.reported("operator/refused")) < 100, "in few reports"
        assert terminals.is_operated, "the operator is still there"
    assert rows(data, "SELECT count(*) FROM notes WHERE author='operator.flood'") == [(0,)], (
        "it is not in control"
    )


def _refused(terminals: SessionTerminals) -> int:
    return sum(each.get("count", 1) for each in terminals.reported("operator/refused"))
