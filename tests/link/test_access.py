"""Access over the network with real Zenoh sessions, TLS over loopback."""

from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest
import zenoh

from sar_tui.link import client
from sar_tui.link.client import NOT_ADMITTED, probe
from sar_tui.link.errors import LinkError
from sar_tui.link.invitation import Invitation
from sar_tui.link.peer import Connection
from sar_tui.link.zenoh_settings import (
    Endpoint,
    Guest,
    TlsFiles,
    config,
    host_settings,
    network_settings,
    socket_settings,
)
from tests.link.tls_fixtures import (
    FakeBroker,
    LinkGuests,
    eventually,
    free_port,
    hosting,
    invite_guests,
    visiting,
)


@pytest.fixture(scope="module")
def at(tmp_path_factory: pytest.TempPathFactory) -> LinkGuests:
    return invite_guests(tmp_path_factory.mktemp("link"))


@pytest.fixture(scope="module")
def running_broker(at: LinkGuests) -> Iterator[FakeBroker]:
    with hosting(at) as host:
        yield host


@pytest.fixture
def host(running_broker: FakeBroker) -> FakeBroker:
    """The host, with its records cleared."""
    for records in (running_broker.received, running_broker.queries, running_broker.liveliness):
        records.clear()
    return running_broker


def settings_of(invited: Invitation, **changes: object) -> str:
    settings = msgspec.json.decode(network_settings(invited.where[0], invited.credentials))
    return msgspec.json.encode(settings | changes).decode()


def collect(guest: zenoh.Session, key: str, into: list[str]) -> None:
    """Add the keys of what a guest receives to a list."""
    guest.declare_subscriber(key, lambda sample: into.append(str(sample.key_expr)))


def received_before_last(
    host: FakeBroker, at: LinkGuests, guest: zenoh.Session, name: str
) -> list[str]:
    """Return the keys that the host received before a final ping: nothing sent earlier can still
    come.
    """
    guest.put(at.keys.ping(name), b"last")
    assert eventually(lambda: (at.keys.ping(name), b"last") in host.received)
    return [key for key, payload in host.received if payload != b"last"]


# --- admission


def test_liveliness_of_an_operator_is_seen(at: LinkGuests, host: FakeBroker) -> None:
    key = at.keys.ping("operator.anna")
    with visiting(at.anna) as [anna]:
        token = anna.liveliness().declare_token(key)
        assert eventually(lambda: host.liveliness == [key])
        token.undeclare()
    assert eventually(lambda: host.liveliness == [key, key])


@pytest.mark.parametrize("is_new", [False, True], ids=["revoked", "made after the session began"])
def test_panel_that_is_not_admitted_reports_why(
    at: LinkGuests, host: FakeBroker, is_new: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(client, "_ADMISSION_TIMEOUT_S", 0.2)
    invitation = (
        at.authority.invite(Guest("newcomer", "operator"), [at.where], 30) if is_new else at.gone
    )
    received: list[object] = []
    panel = client.Transport(
        client.connection_target(invitation), str(invitation.guest), received.append
    )
    panel.open()
    try:
        assert eventually(lambda: panel.send_ping(b"hello") or received)
    finally:
        panel.close(awaits_answer=False)
    assert received == [Connection("connecting", NOT_ADMITTED)]
    assert host.received == []


def cannot_visit(at: LinkGuests, elsewhere: Endpoint, files: TlsFiles) -> None:
    with (
        zenoh.open(config(host_settings("00000000", listen=[elsewhere], files=files))),
        pytest.raises(zenoh.ZError),
    ):
        zenoh.open(config(network_settings(elsewhere, at.anna.credentials)))


def test_guest_certificate_cannot_be_used_as_host(at: LinkGuests, tmp_path: Path) -> None:
    files = TlsFiles(*(tmp_path / name for name in ("authority", "certificate", "key")))
    for path, text in zip(files, msgspec.structs.astuple(at.eve.credentials), strict=True):
        path.write_text(text)
    cannot_visit(at, Endpoint("127.0.0.1", free_port()), files)


def test_guest_rejects_host_with_another_name(at: LinkGuests) -> None:
    cannot_visit(at, Endpoint("127.0.0.2", free_port()), at.authority.host_files([]))


# --- permissions


@pytest.mark.parametrize("mode", ["client", "peer"])
def test_observer_cannot_act_in_another_name(at: LinkGuests, host: FakeBroker, mode: str) -> None:
    keys = at.keys
    targets = [
        *(keys.act(name) for name in ("operator.anna", "*", "**")),
        *(keys.ping("operator.anna"), keys.reply("operator.anna"), keys.broadcast, keys.all),
        *("**", "other/thing"),
    ]
    connect = {"endpoints": [at.where.locator], "timeout_ms": 2000, "exit_on_failure": True}
    with zenoh.open(config(settings_of(at.eve, mode=mode, connect=connect))) as eve:
        for target in targets:
            eve.put(target, b"evil")
            eve.delete(target)
            assert not [reply for reply in eve.get(target, timeout=0.02) if reply.ok]
        short = eve.declare_keyexpr(keys.act("operator.anna"))
        eve.put(short, b"by a short key")
        publisher = eve.declare_publisher(keys.act("operator.anna"))
        publisher.put(b"by a publisher")
        publisher.delete()
        token = eve.liveliness().declare_token(keys.ping("operator.anna"))
        eve.declare_queryable("**", lambda query: query.reply(query.key_expr, b"evil"))
        assert not [reply for reply in host.session.get(keys.broadcast, timeout=0.02) if reply.ok]
        assert received_before_last(host, at, eve, "observer.eve") == []
        token.undeclare()
    assert host.liveliness == []
    assert [query for query in host.queries if query != keys.broadcast] == []


def test_operator_cannot_act_under_another_name(at: LinkGuests, host: FakeBroker) -> None:
    with visiting(at.anna) as [anna]:
        anna.put(at.keys.act("operator.ben"), b"not mine")
        anna.put(at.keys.act("*"), b"everybody's")
        anna.put(at.keys.ping("operator.ben"), b"I am Ben")
        assert received_before_last(host, at, anna, "operator.anna") == []


def test_guest_does_not_receive_messages_of_others(at: LinkGuests, host: FakeBroker) -> None:
    received: list[str] = []
    with visiting(at.anna, at.eve) as [anna, eve]:
        keys = at.keys
        for key in ("**", keys.all, keys.act("*"), keys.reply("operator.anna"), keys.ping("*")):
            collect(eve, key, received)
        collect(eve, at.keys.broadcast, received)
        anna.put(at.keys.act("operator.anna"), b"veto")
        host.session.put(at.keys.reply("operator.anna"), b"to anna")

        def reached() -> bool:
            host.session.put(at.keys.broadcast, b"to all")
            return at.keys.broadcast in received

        assert eventually(reached)
    assert set(received) == {at.keys.broadcast}


def test_revoked_guest_neither_sends_nor_receives(at: LinkGuests, host: FakeBroker) -> None:
    received: list[str] = []
    received_by_anna: list[str] = []
    with visiting(at.gone, at.anna) as [gone, anna]:
        collect(gone, at.keys.broadcast, received)
        collect(anna, at.keys.broadcast, received_by_anna)
        gone.put(at.keys.act("operator.gone"), b"still here")
        gone.put(at.keys.ping("operator.gone"), b"still here")

        def reached() -> bool:
            host.session.put(at.keys.broadcast, b"to all")
            return bool(received_by_anna)

        assert eventually(reached)
        received_before_last(host, at, anna, "operator.anna")
    assert b"still here" not in [payload for _, payload in host.received]
    assert received == []


def test_without_guests_everything_is_denied(at: LinkGuests, tmp_path: Path) -> None:
    elsewhere = Endpoint("127.0.0.1", free_port())
    settings = host_settings(
        at.authority.link, listen=[elsewhere], files=at.authority.host_files([elsewhere])
    )
    received: list[str] = []
    with (
        zenoh.open(config(settings)) as session,
        zenoh.open(config(network_settings(elsewhere, at.anna.credentials))) as anna,
    ):
        collect(session, "**", received)
        anna.put(at.keys.act("operator.anna"), b"veto")
        anna.put(at.keys.ping("operator.anna"), b"hello")
        assert not list(anna.liveliness().get(at.keys.broadcast, timeout=0.2))
    assert received == []


def test_socket_allows_only_keys_of_the_link(tmp_path: Path) -> None:
    path = tmp_path / "s.sock"
    received: list[str] = []
    with zenoh.open(config(host_settings("abc", socket=path))) as session:
        collect(session, "**", received)
        with zenoh.open(config(socket_settings(path))) as operator:
            operator.put("sar-tui/other/act/operator.anna", b"")
            operator.put("sar-tui/abc/act/operator.anna", b"")
            assert eventually(lambda: received)
    assert received == ["sar-tui/abc/act/operator.anna"]


# --- probe


@pytest.fixture
def present(at: LinkGuests, host: FakeBroker) -> Iterator[None]:
    """The session announces itself."""
    token = host.session.liveliness().declare_token(at.keys.broadcast)
    yield
    token.undeclare()


def probe_with(invited: Invitation) -> None:
    probe(network_settings(invited.where[0], invited.credentials), invited.link)


@pytest.mark.usefixtures("present")
def test_probe_of_invited_guest_succeeds_and_of_others_says_why_not(at: LinkGuests) -> None:
    probe_with(at.eve)
    for guest, why in ((at.gone, "it was revoked, or made after"), (at.late, "has expired")):
        with pytest.raises(LinkError, match=why):
            probe_with(guest)


def test_probe_fails_where_nothing_listens_whatever_modules_the_working_directory_has(
    at: LinkGuests, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "zenoh.py").write_text("open(0).read(); print('admitted')")
    monkeypatch.chdir(tmp_path)
    nowhere = Endpoint("127.0.0.1", free_port())
    with pytest.raises(LinkError, match="Nothing listens there"):
        probe(network_settings(nowhere, at.anna.credentials), at.anna.link)
