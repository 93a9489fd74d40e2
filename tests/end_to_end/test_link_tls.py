"""On the network, invited operators control a session and others are refused."""

from pathlib import Path

import msgspec
import pytest
import zenoh

from sar_tui.link import invitation
from sar_tui.link.authority import Authority
from sar_tui.link.invitation import Invitation
from sar_tui.link.zenoh_settings import Guest, config, network_settings
from tests.end_to_end.operator_terminal import SessionTerminals
from tests.link.tls_fixtures import LinkGuests, invite_guests, visiting

SETTINGS = {
    "attempts": 1,
    "prompts_per_attempt": 1,
    "filler": "never",
    "operator_feedback": "approve",
    "operator_time_ms": 60_000,
}


@pytest.fixture
def at(data: Path) -> LinkGuests:
    return invite_guests(data)


def file_of(invited: Invitation, folder: Path, name: str) -> str:
    path = folder / f"{name}.sar-link"
    invitation.write(invited, path)
    return str(path)


def without_certificate(invited: Invitation) -> str:
    """Return a guest's settings without their certificate."""
    settings = msgspec.json.decode(network_settings(invited.where[0], invited.credentials))
    for name in ("connect_certificate_base64", "connect_private_key_base64", "enable_mtls"):
        del settings["transport"]["link"]["tls"][name]
    return msgspec.json.encode(settings).decode()


def test_only_invited_guests_join_and_only_in_their_role(
    at: LinkGuests, data: Path, tmp_path: Path
) -> None:
    stranger = Authority.open_or_create(tmp_path / "elsewhere").invite(
        Guest("anna", "operator"), [at.where], 30
    )
    with SessionTerminals(data) as terminals:
        participant = terminals.participant("--listen", at.where.locator, **SETTINGS)
        participant.terminal.wait_for("Press Enter to go on.")
        other = terminals.panel("--link", file_of(stranger, tmp_path, "stranger"))
        eve = terminals.panel("--link", file_of(at.eve, tmp_path, "eve"))
        anna = terminals.panel("--link", file_of(at.anna, tmp_path, "anna"))
        terminals.until(lambda: terminals.is_operated, "the operator steers")
        terminals.until(
            lambda: ("observer.eve", "joined") in terminals.presence(), "the observer watches"
        )

        participant.answer(1)
        anna.wait_for_proposal()
        terminals.until(lambda: "FEEDBACK" in eve.sees(), "the observer sees the proposal, too")
        eve.does("approve")
        with visiting(at.eve) as (forger,):
            forger.put(at.keys.act("operator.anna"), b"in another's name")
            forger.put(at.keys.act("observer.eve"), b"in their own")
            terminals.until(
                lambda: len(refusals(terminals, "observer.eve")) == 2,
                "what the observer sends is refused",
            )
        assert terminals.pending_proposal(), "an observer decides nothing"
        anna.does("approve")
        terminals.until(
            lambda: terminals.actions("feedback")[0]["decided_ns"], "the operator decides"
        )
        eve.does("stop")
        terminals.until(
            lambda: ("stop", "observer.eve") in stops(terminals), "the observer stops the agent"
        )

        pretender = msgspec.structs.replace(
            stranger.credentials, authority=at.anna.credentials.authority
        )
        for settings in (
            without_certificate(at.anna),
            network_settings(at.where, at.late.credentials),
            network_settings(at.where, pretender),
        ):
            with pytest.raises(zenoh.ZError):
                zenoh.open(config(settings))
        terminals.until(
            lambda: len(set(refusals(terminals, "unknown"))) == 4,
            "rejected connections are in the log",
        )
        terminals.until(
            lambda: "not the one that made this" in other.sees(), "the stranger's panel says why"
        )
        reasons = " ".join(refusals(terminals, "unknown"))
        presence = {actor for actor, _ in terminals.presence()}
        (feedback,) = terminals.actions("feedback")
        seen = {word for line in participant.has_seen() for word in line.lower().split()}

    assert "no certificate" in reasons
    assert "expired" in reasons
    assert "made by another authority" in reasons
    assert "does not trust this host's certificate" in reasons, (
        "another authority's guest refuses us in turn"
    )
    assert presence == {"operator.anna", "observer.eve"}
    assert (feedback["decision"], feedback["actor"]) == ("accepted", "operator.anna")
    assert "attempt" in seen
    assert not seen & {"anna", "eve", "operator", "observer", "link", "listening"}, (
        "the participant sees nothing of the operators"
    )


def stops(terminals: SessionTerminals) -> list[tuple[str, str]]:
    """Return the commands of the session, with their actors."""
    return [(each["command"], each["actor"]) for each in terminals.reported("operator/act")]


def refusals(terminals: SessionTerminals, actor: str) -> list[str]:
    """Return the reasons of refusals of a peer."""
    return [
        each["why"] for each in terminals.reported("operator/refused") if each["actor"] == actor
    ]
