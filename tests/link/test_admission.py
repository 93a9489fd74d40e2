"""What peers send is handed on, or refused: without Zenoh."""

import msgspec
import pytest

from sar_tui.framework import messages as m
from sar_tui.framework.clock import MS, SECOND
from sar_tui.framework.messages import Message
from sar_tui.framework.topics import NOTE_ADDED
from sar_tui.link import protocol
from sar_tui.link.admission import Admission
from sar_tui.link.protocol import (
    ActReceived,
    BrokerEvent,
    PeerJoined,
    PeerLeft,
    Ping,
    Pong,
    RequestRefused,
    SessionMessage,
    SnapshotRequested,
)

ANNA, OLAF = "operator.anna", "observer.olaf"
NOTE = m.NoteAdded(text="well")


class Bench:
    """A desk, and what it said."""

    def __init__(self) -> None:
        self.told: list[BrokerEvent] = []
        self.answers: list[tuple[str, SessionMessage]] = []
        self.admission = Admission(
            2 * SECOND, self.told.append, lambda name, answer: self.answers.append((name, answer)), "here"
        )

    def hello(self, name: str, now: int, who: str = "1", *, wants: bool = False, leaves: bool = False) -> None:
        self.admission.receive_ping(name, protocol.encode(Ping(who, 77, wants, leaves)), now)

    def act(self, name: str, now: int, message: Message = NOTE, topic: str = NOTE_ADDED.name, who: str = "1") -> None:
        self.admission.receive_act(
            name, protocol.encode(protocol.ActRequest(who, topic, msgspec.Raw(protocol.encode(message)))), now
        )

    def take(self) -> list[BrokerEvent]:
        told, self.told[:] = list(self.told), []
        return told


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_a_peer_that_says_hello_has_come_and_is_answered_with_the_clock(bench: Bench) -> None:
    bench.admission.number = 5
    bench.hello(ANNA, 3 * SECOND, wants=True)
    assert bench.take() == [PeerJoined(ANNA), SnapshotRequested(ANNA)]
    assert bench.answers == [(ANNA, Pong(77, 3 * SECOND, "here", 5, "1"))]


def test_a_peer_that_wants_to_be_greeted_time_and_again_is_greeted_once_a_second(bench: Bench) -> None:
    for at in range(0, 1000, 50):
        bench.hello(ANNA, at * MS, wants=True)
    assert bench.take().count(SnapshotRequested(ANNA)) == 3


def test_a_peer_that_leaves_has_left_and_one_that_is_silent_is_lost(bench: Bench) -> None:
    bench.hello(ANNA, 0)
    bench.hello(OLAF, 0)
    bench.hello(OLAF, 0, leaves=True)
    bench.admission.tick(2 * SECOND + 1)
    assert bench.take()[2:] == [PeerLeft(OLAF, "left"), PeerLeft(ANNA, "lost", "No heartbeat for 2000 ms.")]


def test_a_peer_whose_connection_breaks_is_lost_at_once(bench: Bench) -> None:
    bench.hello(ANNA, 0)
    bench.admission.disconnect(ANNA)
    bench.admission.disconnect(ANNA)
    assert bench.take()[1:] == [PeerLeft(ANNA, "lost", "The connection broke.")]


def test_an_act_is_handed_on(bench: Bench) -> None:
    bench.hello(ANNA, 0)
    bench.act(ANNA, 1)
    assert bench.take()[1:] == [ActReceived(ANNA, NOTE_ADDED.name, msgspec.Raw(protocol.encode(NOTE)))]


def test_an_act_is_a_sign_of_life(bench: Bench) -> None:
    bench.act(ANNA, 0)
    assert isinstance(bench.take()[0], PeerJoined)


def test_a_second_program_of_a_name_is_told_so_and_cannot_act(bench: Bench) -> None:
    bench.hello(ANNA, 0)
    bench.hello(ANNA, 1, who="2", wants=True)
    bench.act(ANNA, 2, who="2")
    assert isinstance(pong := bench.answers[-1][1], Pong)
    assert (pong.client_id, "name is in use" in pong.refusal) == ("2", True)
    assert [type(news) for news in bench.take()] == [PeerJoined, RequestRefused]


def test_an_observer_cannot_act_whatever_it_sends(bench: Bench) -> None:
    bench.hello(OLAF, 0)
    bench.act(OLAF, 1)
    assert bench.take()[1:] == [RequestRefused(OLAF, "an act", "An observer cannot act.", 1)]


@pytest.mark.parametrize("name", ["*", "**", "anna", "director.anna", "operator.", "operator.a/b", "operator.\x1b"])
def test_who_has_no_name_is_refused(bench: Bench, name: str) -> None:
    bench.hello(name, 0)
    bench.act(name, 0)
    refused = bench.take()
    assert [type(news) for news in refused] == [RequestRefused, RequestRefused]
    assert all(isinstance(news, RequestRefused) and news.name == "unknown" for news in refused), "nobody has to read it"
    assert bench.answers == []


def test_what_does_not_decode_is_refused(bench: Bench) -> None:
    bench.admission.receive_act(ANNA, b"\xc1nonsense", 0)
    bench.admission.receive_ping(ANNA, b"", 0)
    assert bench.take() == [
        RequestRefused(ANNA, "an act", "It cannot be read.", 1),
        RequestRefused(ANNA, "a heartbeat", "It cannot be read.", 1),
    ]


def test_a_note_of_a_hundred_kilobytes_is_refused(bench: Bench) -> None:
    bench.act(ANNA, 0, m.NoteAdded(text="x" * 100_000))
    assert bench.take() == [RequestRefused(ANNA, "an act", "It is longer than 20000 bytes.", 1)]


def test_of_ten_thousand_acts_in_a_second_a_few_are_handed_on_and_the_rest_are_counted(bench: Bench) -> None:
    bench.hello(ANNA, 0)
    bench.take()
    for number in range(10_000):
        bench.act(ANNA, number * SECOND // 10_000)
    bench.admission.tick(2 * SECOND)
    told = bench.take()
    handed_on = [news for news in told if isinstance(news, ActReceived)]
    refused = [news for news in told if isinstance(news, RequestRefused)]
    assert len(handed_on) <= 90
    assert len(refused) <= 2
    assert len(handed_on) + sum(news.count for news in refused) == 10_000
