"""An operator and an observer with invitations join a session over the network."""

from pathlib import Path

import pytest

from sar_tui.link import invitation
from tests.end_to_end.operator_terminal import Panel, SessionTerminals
from tests.link.tls_fixtures import invite_guests

SETTINGS = {
    "attempts": 1,
    "prompts_per_attempt": 1,
    "filler": "never",
    "operator_feedback": "approve",
    "operator_time_ms": 60_000,
}


@pytest.mark.slow
def test_invited_guests_act_in_their_role_and_the_participant_sees_nothing_of_them(
    data: Path, tmp_path: Path
) -> None:
    at = invite_guests(data)
    with SessionTerminals(data) as terminals:
        participant = terminals.participant("--listen", at.where.locator, **SETTINGS)
        participant.terminal.wait_for("Press Enter to go on.")
        panels: list[Panel] = []
        for invited in (at.eve, at.anna):
            path = tmp_path / f"{invited.name}.sar-link"
            invitation.write(invited, path)
            panels.append(terminals.panel("--link", str(path)))
        eve, anna = panels
        terminals.until(lambda: terminals.is_operated, "the operator steers")
        terminals.until(
            lambda: ("observer.eve", "joined") in terminals.presence(), "the observer watches"
        )
        participant.answer(1)
        anna.wait_for_proposal()
        terminals.until(lambda: "FEEDBACK" in eve.sees(), "the observer sees the proposal, too")
        eve.does("approve")
        anna.does("approve")
        terminals.until(
            lambda: terminals.actions("feedback")[0]["decided_ns"], "the operator decides"
        )
        eve.does("stop")
        terminals.until(lambda: terminals.reported("operator/act"), "the observer stops the agent")
        seen = {word for line in participant.has_seen() for word in line.lower().split()}
        presence = {actor for actor, _ in terminals.presence()}
        (stop,) = terminals.reported("operator/act")
        (feedback,) = terminals.actions("feedback")

    assert presence == {"operator.anna", "observer.eve"}
    assert (stop["command"], stop["actor"]) == ("stop", "observer.eve")
    assert (feedback["decision"], feedback["actor"]) == ("accepted", "operator.anna"), (
        "the observer's key decides nothing"
    )
    assert "attempt" in seen
    assert not seen & {"anna", "eve", "operator", "observer", "link", "listening"}
