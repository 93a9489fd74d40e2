"""A terminal that is frozen: its operator is lost in time, and comes back."""

import signal
import sys
from pathlib import Path

import pytest

from tests.end_to_end.operator_terminal import Panel, SessionTerminals
from tests.end_to_end.participant_terminal import command

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="pseudo-terminals as of Linux")

LOST_MS = 3000
ANA = "operator.ana"
SETTINGS = {
    "attempts": 2,
    "prompts_per_attempt": 1,
    "outputs": "",
    "encouragement": "no",
    "filler": "never",
    "operator_feedback": "approve",
    "operator_time_ms": 60_000,
    "operator_lost_ms": LOST_MS,
}


@pytest.mark.parametrize(
    ("freeze", "thaw"),
    [
        (signal.SIGUSR1, signal.SIGUSR2),
        pytest.param(signal.SIGSTOP, signal.SIGCONT, marks=pytest.mark.slow),
    ],
    ids=["ssh", "terminal"],
)
def test_an_operator_behind_a_frozen_connection_is_lost_and_comes_back(data: Path, freeze: int, thaw: int) -> None:
    with SessionTerminals(data) as terminals:
        participant = terminals.participant("--operator", **SETTINGS)
        relay = [sys.executable, "-m", "tests.end_to_end.terminal_relay"]
        wizard = command("wizard", "--wait", "--name", "ana", "--data", str(data))
        panel = Panel(terminals, terminals.start_program([*relay, *wizard], 100, 30))
        participant.terminal.wait_for("Press Enter to go on.")
        terminals.until(lambda: terminals.is_operated, "the operator steers")
        participant.answer(1)
        panel.wait_for_proposal()

        panel.kill(freeze)
        terminals.until(lambda: (ANA, "lost") in terminals.presence(), "the operator is lost")
        terminals.until(lambda: terminals.actions("feedback")[0]["decided_ns"], "the agent goes on alone")
        (row,) = terminals.actions("feedback")
        assert (row["decision"], row["actor"], row["ground"]) == ("accepted", "agent", "no operator")
        (lost,) = [each for each in terminals.reported("operator/presence") if each["state"] == "lost"]
        assert (lost["operated"], lost["detail"]) == (False, f"Its terminal did not answer for {LOST_MS} ms.")

        panel.kill(thaw)
        terminals.until(lambda: terminals.is_operated, "the operator is back")
        terminals.until(lambda: "This terminal did not answer for" in panel.sees(), "and is told")
        participant.answer(1)
        panel.wait_for_proposal(row["id"])
        panel.does("approve")
        terminals.until(lambda: terminals.actions("feedback")[-1]["decided_ns"], "a decision is accepted again")
        assert terminals.actions("feedback")[-1]["actor"] == ANA
        states = [state for actor, state in terminals.presence() if actor == ANA]
    assert states == ["joined", "baton", "lost", "joined", "baton"]
