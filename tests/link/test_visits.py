"""Live visits: the clinic's router, a home and a panel as real processes, with real certificates."""

import asyncio
import json
import os
import signal
import subprocess
import sys
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import msgspec
import pytest
import zenoh

from sar_tui.link import client
from sar_tui.link.admission import ASKING, DECLINED, VISIT_ENDED
from sar_tui.link.authority import Authority
from sar_tui.link.client import NOBODY_THERE, NOT_ADMITTED_BY_ROUTER, probe
from sar_tui.link.discovery import JoinableSession
from sar_tui.link.errors import LinkError
from sar_tui.link.invitation import Invitation, home_file, write
from sar_tui.link.peer import Connection, Welcome
from sar_tui.link.router import settings_of
from sar_tui.link.visits import HomeFinder, HomeVisit, keep_home, open_visits, remove_home
from sar_tui.link.zenoh_settings import (
    Endpoint,
    Guest,
    LinkKeys,
    config,
    home_link,
    network_settings,
    router_settings,
)
from sar_tui.loop.bus import Bus
from sar_tui.loop.node import Node, on
from sar_tui.loop.topics import KEY, NOTE_ADDED, PRESENCE, VISIT, VISIT_DECIDED
from sar_tui.model import messages as m
from tests.link.test_link_faults import LOST_MS, LinkSession, Panel, until
from tests.link.tls_fixtures import eventually, free_port, without_certificate

ANNA = "operator.anna"
SESSION = JoinableSession(session="s1", task="keyboard", link="", pid=0)


class Clinic:
    """Data folder of a clinic, and those who are invited: homes P01 and P02, Anna, Ben, and Eve, who
    observes.
    """

    def __init__(self, data: Path) -> None:
        self.data = data
        self.where = Endpoint("127.0.0.1", free_port())
        self.authority = Authority.open_or_create(data)
        self.anna = self.invite(Guest("anna", "operator"))
        self.ben = self.invite(Guest("ben", "operator"))
        self.eve = self.invite(Guest("eve", "observer"))
        self.p01 = self.invite(Guest("p01", "home"))
        self.p02 = self.invite(Guest("p02", "home"))
        self.router: subprocess.Popen[bytes] | None = None

    def invite(self, guest: Guest) -> Invitation:
        return self.authority.invite(guest, [self.where], 30, router=True)

    def keys(self, home: str) -> LinkKeys:
        return LinkKeys(home_link(self.authority.link, home))

    def start_router(self) -> None:
        """Run the router as a person does, and go on at once."""
        words = ["link", "router", "--listen", self.where.locator, "--data", str(self.data)]
        self.router = subprocess.Popen(
            [sys.executable, "-m", "sar_tui", *words], stdin=subprocess.DEVNULL
        )

    def end_router(self, how: signal.Signals = signal.SIGTERM) -> int:
        assert self.router
        self.router.send_signal(how)
        code = self.router.wait(30)
        self.router = None
        return code


@pytest.fixture
def clinic(tmp_path: Path) -> Iterator[Clinic]:
    clinic = Clinic(tmp_path / "clinic")
    yield clinic
    if clinic.router:
        clinic.end_router(signal.SIGKILL)


class Decider(Node):
    """Publishes what the participant decides, which is derived from a key."""

    name = "decider"
    emits = (VISIT_DECIDED,)

    def attach(self, bus: Bus) -> None:
        super().attach(bus)
        self._decided: m.VisitDecided | None = None

    @on(KEY)
    def pressed(self, _: m.KeyPressed) -> None:
        self.emit(VISIT_DECIDED, self._decided)

    def decide(self, decided: m.VisitDecided) -> None:
        self._decided = decided
        self.bus.publish(KEY, m.KeyPressed(key="enter", at=0))


class Home(LinkSession):
    """A session at home that dials out. Its participant is asked by nobody."""

    def __init__(self, broker: object, link: str) -> None:
        super().__init__(broker, msgspec.structs.replace(SESSION, link=link))  # type: ignore[arg-type]
        self.decider = Decider()
        self.decider.attach(self.bus)

    @property
    def requests(self) -> list[tuple[str, str]]:
        return [(request.actor, request.state) for request in self.of(VISIT)]

    def decide(self, outcome: str, *peers: str) -> None:
        self.decider.decide(m.VisitDecided(outcome=outcome, peers=peers))  # type: ignore[arg-type]

    async def visit(self, invitation: Invitation) -> Panel:
        """Open a panel that asks to watch, and wait until the participant is to be asked."""
        panel = self.panel_of(invitation)
        await until(lambda: (panel.peer.name, "asked") in self.requests)
        return panel

    def panel_of(self, invitation: Invitation) -> Panel:
        where = HomeVisit(invitation, self.live.link.rpartition("/")[2])
        self.panels.append(panel := Panel(where))  # type: ignore[arg-type]
        return panel


@pytest.fixture
async def at_home(clinic: Clinic, tmp_path: Path) -> AsyncIterator[Callable[[Invitation], Home]]:
    """Begin sessions at home, each in a data folder of its own."""
    with ExitStack() as stack:
        homes: list[Home] = []

        def begin(invitation: Invitation) -> Home:
            data = tmp_path / f"home-{len(homes)}"
            file = tmp_path / f"{len(homes)}.sar-link"
            write(invitation, file)
            keep_home(data, file)
            broker = stack.enter_context(open_visits(data, LOST_MS))
            homes.append(home := Home(broker, broker.link))
            return home

        yield begin
        for home in homes:
            home.leave()


@pytest.fixture
async def home(clinic: Clinic, at_home: Callable[[Invitation], Home]) -> Home:
    """A session at the home P01, while the router runs."""
    clinic.start_router()
    return at_home(clinic.p01)


def whys(panel: Panel) -> list[str]:
    return [each.why for each in panel.events if isinstance(each, Connection)]


def is_told_nothing(panel: Panel) -> bool:
    """Return True if the panel has received nothing of the session."""
    return all(isinstance(each, Connection) for each in panel.events)


# --- a visit


async def test_nothing_leaves_the_home_before_the_yes_and_then_the_operator_sees_and_acts(
    home: Home, clinic: Clinic
) -> None:
    panel = await home.visit(clinic.anna)
    await until(lambda: ASKING in whys(panel))
    panel.peer.send(NOTE_ADDED, m.NoteAdded(text="too early"))
    assert is_told_nothing(panel)
    assert home.of(PRESENCE) == []
    home.decide("agreed", ANNA)
    await until(lambda: "connected" in panel.states)
    welcome = next(each for each in panel.events if isinstance(each, Welcome))
    assert (welcome.name, welcome.session) == (ANNA, "s1")
    panel.peer.send(NOTE_ADDED, m.NoteAdded(text="well", at=panel.peer.now()))
    await until(lambda: [note.text for note in home.of(NOTE_ADDED)] == ["well"])
    await until(lambda: "well" in [getattr(each.message, "text", "") for each in panel.frames])
    panel.peer.close()
    await until(lambda: home.states(ANNA) == ["joined", "baton", "left"])


async def test_no_is_for_everybody_and_nobody_is_asked_twice(home: Home, clinic: Clinic) -> None:
    anna = await home.visit(clinic.anna)
    home.decide("declined", ANNA)
    await until(lambda: DECLINED in whys(anna))
    anna.peer.close()
    again, ben = home.panel_of(clinic.anna), home.panel_of(clinic.ben)
    await until(lambda: DECLINED in whys(again) and DECLINED in whys(ben))
    assert home.requests == [(ANNA, "asked")]
    assert all(map(is_told_nothing, (anna, again, ben)))


async def test_who_leaves_before_the_answer_does_not_ask_any_longer(
    home: Home, clinic: Clinic
) -> None:
    panel = await home.visit(clinic.anna)
    panel.peer.close()
    await until(lambda: home.requests == [(ANNA, "asked"), (ANNA, "withdrawn")])
    silent = await home.visit(clinic.ben)
    silent.peer.close(says_goodbye=False)
    await until(
        lambda: home.requests[2:] == [("operator.ben", "asked"), ("operator.ben", "withdrawn")]
    )
    assert home.of(PRESENCE) == []


async def test_the_participant_ends_a_visit(home: Home, clinic: Clinic) -> None:
    panel = await home.visit(clinic.anna)
    home.decide("agreed", ANNA)
    await until(lambda: "connected" in panel.states)
    home.decide("ended")
    assert home.states(ANNA)[-1] == "left"
    await until(lambda: VISIT_ENDED in whys(panel))
    received = len(panel.frames)
    home.bus.publish(NOTE_ADDED, m.NoteAdded(text="private"))
    again = home.panel_of(clinic.ben)
    await until(lambda: VISIT_ENDED in whys(again))
    assert len(panel.frames) == received


async def test_each_visitor_is_agreed_to_by_name_and_an_observer_only_watches(
    home: Home, clinic: Clinic
) -> None:
    anna = await home.visit(clinic.anna)
    home.decide("agreed", ANNA)
    await until(lambda: "connected" in anna.states)
    eve = await home.visit(clinic.eve)
    assert is_told_nothing(eve)
    home.decide("agreed", "observer.eve")
    await until(lambda: "connected" in eve.states)
    eve.peer.send(NOTE_ADDED, m.NoteAdded(text="from an observer"))
    await until(lambda: any(who == "observer.eve" for who, _ in home.refusals))
    assert home.of(NOTE_ADDED) == []


# --- what fails


async def test_a_router_that_ends_stops_nothing_and_the_visit_goes_on_unasked_when_it_is_back(
    home: Home, clinic: Clinic
) -> None:
    panel = await home.visit(clinic.anna)
    home.decide("agreed", ANNA)
    await until(lambda: "connected" in panel.states)
    assert clinic.end_router(signal.SIGKILL) == -signal.SIGKILL
    await until(lambda: home.states(ANNA)[-1] == "lost")
    home.bus.publish(NOTE_ADDED, m.NoteAdded(text="meanwhile"))
    clinic.start_router()
    await until(lambda: home.states(ANNA)[-3:] == ["lost", "joined", "baton"])
    await until(lambda: panel.states[-1] == "connected")
    assert home.requests == [(ANNA, "asked")]


async def test_a_router_that_is_away_at_the_start_delays_nothing(
    clinic: Clinic, at_home: Callable[[Invitation], Home]
) -> None:
    home = at_home(clinic.p01)
    panel = home.panel_of(clinic.anna)
    assert is_told_nothing(panel)
    clinic.start_router()
    await until(lambda: (ANNA, "asked") in home.requests)
    assert clinic.end_router() == 0


async def test_a_broker_process_that_is_killed_comes_back_and_nobody_is_asked_again(
    home: Home, clinic: Clinic
) -> None:
    panel = await home.visit(clinic.anna)
    home.decide("agreed", ANNA)
    await until(lambda: "connected" in panel.states)
    assert home.broker.pid
    os.kill(home.broker.pid, signal.SIGKILL)
    await until(lambda: home.states(ANNA)[-3:] == ["lost", "joined", "baton"])
    assert home.requests == [(ANNA, "asked")]


async def test_the_router_drops_whom_the_clinic_revokes(home: Home, clinic: Clinic) -> None:
    panel = await home.visit(clinic.anna)
    home.decide("agreed", ANNA)
    await until(lambda: "connected" in panel.states)
    clinic.authority.revoke("anna")
    await until(lambda: home.states(ANNA)[-1] == "lost")
    settings = network_settings(clinic.where, clinic.anna.credentials, through_router=True)
    with pytest.raises(LinkError) as refused:
        probe(settings, home_link(clinic.authority.link, "-"), ANNA)
    assert str(refused.value) == NOT_ADMITTED_BY_ROUTER
    ben = await home.visit(clinic.ben)
    assert is_told_nothing(ben)


async def test_a_revoked_home_and_one_of_another_clinic_are_seen_by_nobody(
    clinic: Clinic,
    at_home: Callable[[Invitation], Home],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(client, "_ADMISSION_TIMEOUT_S", 0.2)
    clinic.authority.revoke("p01")
    clinic.start_router()
    stranger = Authority.open_or_create(tmp_path / "elsewhere").invite(
        Guest("p02", "home"), [clinic.where], 30
    )
    revoked, foreign = at_home(clinic.p01), at_home(stranger)
    good = at_home(clinic.p02)
    await good.visit(clinic.ben)
    panel = revoked.panel_of(clinic.anna)
    await until(lambda: NOBODY_THERE in whys(panel))
    assert revoked.requests == foreign.requests == []


async def test_homes_where_somebody_trains_are_found(
    clinic: Clinic, at_home: Callable[[Invitation], Home]
) -> None:
    clinic.start_router()
    finder = HomeFinder(clinic.eve, lambda: None)
    finder.open()
    at_home(clinic.p02)
    at_home(clinic.p01)
    await until(lambda: finder.homes == ("p01", "p02"))
    finder.close()


# --- invitations


def test_a_home_keeps_one_invitation_for_a_home(clinic: Clinic, tmp_path: Path) -> None:
    data, file, new = tmp_path / "home", tmp_path / "p01.sar-link", tmp_path / "p02.sar-link"
    write(clinic.p01, file)
    write(clinic.p02, new)
    keep_home(data, file)
    assert home_file(data).stat().st_mode & 0o077 == 0
    assert keep_home(data, new).name == "p02"
    other = tmp_path / "anna.sar-link"
    write(clinic.anna, other)
    with pytest.raises(LinkError, match="invites an operator"):
        keep_home(data, other)
    assert remove_home(data)
    assert not remove_home(data)


def test_a_panel_does_not_use_the_invitation_of_a_home(clinic: Clinic) -> None:
    with pytest.raises(LinkError, match="is for a home"):
        client.connect(
            HomeVisit(clinic.p01, "p01"), "", "operator", print, asyncio.new_event_loop()
        )


# --- access


@contextmanager
def routing(clinic: Clinic) -> Iterator[zenoh.Session]:
    files = clinic.authority.host_files([clinic.where])
    made = router_settings(clinic.authority.link, [clinic.where], files, clinic.authority.guests())
    with zenoh.open(config(msgspec.json.encode(made).decode())) as router:
        yield router


@contextmanager
def dialling(*invitations: Invitation) -> Iterator[list[zenoh.Session]]:
    with ExitStack() as stack:
        yield [
            stack.enter_context(
                zenoh.open(
                    config(network_settings(each.where[0], each.credentials, through_router=True))
                )
            )
            for each in invitations
        ]


def hears(session: zenoh.Session, key: str) -> list[str]:
    """Return a list to which the keys of what is received are added, each with its payload."""
    heard: list[str] = []
    session.declare_subscriber(
        key, lambda sample: heard.append(f"{sample.key_expr}: {sample.payload.to_string()}")
    )
    return heard


def test_a_home_reaches_its_own_keys_only(clinic: Clinic) -> None:
    own, other = clinic.keys("p01"), clinic.keys("p02")
    invited = clinic.p01, clinic.p01, clinic.p02, clinic.anna
    with routing(clinic), dialling(*invited) as [p01, spy, p02, anna]:
        for_anna = hears(anna, other.reply(ANNA)), hears(anna, own.reply(ANNA))
        spied = [hears(spy, key) for key in (other.act("*"), other.ping("*"), other.reply("*"))]
        spied += [hears(spy, key) for key in (other.all, "**", "sar-tui/**")]
        heard = hears(p02, other.act("*"))
        forged = other.reply(ANNA), other.act(ANNA), other.broadcast, own.act(ANNA)

        def speak() -> bool:
            for key in forged:
                p01.put(key, "forged")
            anna.put(other.act(ANNA), "act")
            p02.put(other.reply(ANNA), "answer")
            p01.put(own.reply(ANNA), "answer")
            return bool(heard and for_anna[0] and for_anna[1])

        assert eventually(speak)
        assert set(heard) == {f"{other.act(ANNA)}: act"}
        assert set(for_anna[0]) == {f"{other.reply(ANNA)}: answer"}
        assert not any(spied), spied


def test_a_visitor_acts_and_listens_under_their_own_name_only(clinic: Clinic) -> None:
    keys = clinic.keys("p01")
    invited = clinic.p01, clinic.anna, clinic.eve, clinic.eve
    with routing(clinic), dialling(*invited) as [p01, anna, eve, spy]:
        at_p01 = hears(p01, keys.act("*")), hears(p01, keys.ping("*"))
        for_anna = hears(anna, keys.reply(ANNA))
        spied = [hears(spy, key) for key in (keys.reply(ANNA), keys.reply("*"), keys.all, "**")]
        spied += [hears(spy, key) for key in (keys.broadcast, keys.act(ANNA))]

        def speak() -> bool:
            for forged in (keys.act(ANNA), keys.ping(ANNA), keys.reply(ANNA), keys.broadcast):
                eve.put(forged, "forged")
            eve.put(keys.act("observer.eve"), "own")
            anna.put(keys.ping(ANNA), "own")
            p01.put(keys.reply(ANNA), "session")
            p01.put(keys.broadcast, "to all")
            return bool(at_p01[0] and at_p01[1] and for_anna)

        assert eventually(speak)
        assert set(at_p01[0]) == {f"{keys.act('observer.eve')}: own"}
        assert set(at_p01[1]) == {f"{keys.ping(ANNA)}: own"}
        assert set(for_anna) == {f"{keys.reply(ANNA)}: session"}
        assert not any(spied), spied


def test_without_a_certificate_of_the_clinic_nobody_reaches_the_router(
    clinic: Clinic, tmp_path: Path
) -> None:
    stranger = Authority.open_or_create(tmp_path / "elsewhere").invite(
        Guest("p01", "home"), [clinic.where], 30
    )
    mixed = msgspec.structs.replace(
        stranger.credentials, authority=clinic.p01.credentials.authority
    )
    with routing(clinic):
        for settings in (
            without_certificate(clinic.p01),
            network_settings(clinic.where, stranger.credentials),
            network_settings(clinic.where, mixed),
        ):
            with pytest.raises(zenoh.ZError):
                zenoh.open(config(settings))
        with dialling(clinic.p01):
            pass


@pytest.mark.parametrize("who", ["anna", "p01"])
def test_an_invitation_is_checked_at_the_router(clinic: Clinic, who: str) -> None:
    invitation: Invitation = getattr(clinic, who)
    settings = network_settings(clinic.where, invitation.credentials, through_router=True)
    link = home_link(clinic.authority.link, who if invitation.role == "home" else "-")
    with pytest.raises(LinkError, match=r"Nothing listens there\. Is the router running\?"):
        probe(settings, link, str(invitation.guest))
    with routing(clinic):
        probe(settings, link, str(invitation.guest))


def test_zenohd_is_given_the_settings_of_the_router(clinic: Clinic) -> None:
    printed = subprocess.run(
        [
            sys.executable,
            "-m",
            "sar_tui",
            "link",
            "router",
            "--listen",
            clinic.where.locator,
            "--zenohd",
            "--data",
            str(clinic.data),
        ],
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    ).stdout
    assert printed == settings_of(clinic.authority, [clinic.where]) + "\n"
    settings = json.loads(printed)
    assert settings["access_control"]["default_permission"] == "deny"
    assert settings["transport"]["link"]["tls"]["enable_mtls"] is True
    assert "PRIVATE" not in printed
    zenoh.Config.from_json5(printed)
