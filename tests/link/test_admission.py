"""Messages of peers are forwarded or refused, tested without Zenoh."""

from typing import Any

import msgspec
import pytest

from sar_tui.link import protocol
from sar_tui.link.admission import Admission
from sar_tui.link.protocol import (
    ActReceived,
    AnswersRequested,
    BrokerEvent,
    PeerJoined,
    PeerLeft,
    PeerUnproven,
    Ping,
    Pong,
    RequestRefused,
    SessionMessage,
    SnapshotRequested,
)
from sar_tui.loop.topics import COMMAND, NOTE_ADDED
from sar_tui.model import messages as m
from sar_tui.model.messages import Message
from sar_tui.model.units import MS, SECOND

ANNA, OLAF = "operator.anna", "observer.olaf"
NOTE = m.NoteAdded(text="well")


def raw(message: Message) -> msgspec.Raw:
    return msgspec.Raw(protocol.encode(message))


class Bench:
    """Admission that records its events and answers."""

    def __init__(self) -> None:
        self.events: list[BrokerEvent] = []
        self.answers: list[tuple[str, SessionMessage]] = []
        self.admission = Admission(
            2 * SECOND, self.events.append, lambda *answer: self.answers.append(answer), "here"
        )

    def ping(self, name: str, now: int, client_id: str = "1", **how: Any) -> None:
        self.admission.receive_ping(name, protocol.encode(Ping(client_id, 77, **how)), now)

    def act(
        self,
        name: str,
        now: int,
        message: Message = NOTE,
        topic: str = NOTE_ADDED.name,
        client_id: str = "1",
        **how: Any,
    ) -> None:
        act = protocol.ActRequest(client_id, topic, raw(message), **how)
        self.admission.receive_act(name, protocol.encode(act), now)

    def refusals(self) -> dict[str, str]:
        """Return why acts were refused, by their ids."""
        messages = [one for _, one in self.answers if isinstance(one, protocol.Answers)]
        found = [answer for message in messages for answer in message.answers]
        assert all(answer.outcome == "refused" for answer in found)
        return {answer.id: answer.why for answer in found}

    def take(self) -> list[BrokerEvent]:
        events, self.events[:] = list(self.events), []
        return events


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_first_ping_admits_a_peer_and_is_answered_with_the_clock(bench: Bench) -> None:
    bench.admission.number = 5
    bench.ping(ANNA, 3 * SECOND, wants_snapshot=True)
    assert bench.take() == [PeerJoined(ANNA), SnapshotRequested(ANNA)]
    assert bench.answers == [(ANNA, Pong(77, 3 * SECOND, "here", 5, "1"))]


def test_snapshots_are_limited_to_one_per_second(bench: Bench) -> None:
    for at in range(0, 1000, 50):
        bench.ping(ANNA, at * MS, wants_snapshot=True)
    assert bench.take().count(SnapshotRequested(ANNA)) == 3


def test_leaving_peer_has_left_and_silent_peer_is_lost(bench: Bench) -> None:
    bench.ping(ANNA, 0)
    bench.ping(OLAF, 0)
    bench.ping(OLAF, 0, is_leaving=True)
    bench.admission.tick(2 * SECOND + 1)
    assert bench.take()[2:] == [
        PeerLeft(OLAF, "left"),
        PeerLeft(ANNA, "lost", "No heartbeat for 2000 ms."),
    ]


def test_peer_whose_connection_breaks_is_lost_at_once(bench: Bench) -> None:
    bench.ping(ANNA, 0)
    bench.admission.disconnect(ANNA, 200 * MS)
    bench.admission.disconnect(ANNA, 200 * MS)
    assert bench.take()[1:] == [PeerLeft(ANNA, "lost", "The connection broke.")]


def test_silent_peer_whose_connection_breaks_is_lost_after_its_time(bench: Bench) -> None:
    bench.ping(ANNA, 0)
    bench.admission.disconnect(ANNA, 900 * MS)
    bench.admission.tick(2 * SECOND)
    assert bench.take() == [PeerJoined(ANNA)]
    bench.admission.tick(2 * SECOND + 1)
    assert bench.take() == [PeerLeft(ANNA, "lost", "No heartbeat for 2000 ms.")]


def test_peer_that_reconnects_in_time_is_not_lost(bench: Bench) -> None:
    bench.ping(ANNA, 0)
    bench.admission.disconnect(ANNA, 900 * MS)
    bench.ping(ANNA, 1900 * MS)
    bench.admission.tick(3 * SECOND)
    assert bench.take() == [PeerJoined(ANNA)]


def test_act_is_forwarded(bench: Bench) -> None:
    bench.ping(ANNA, 0)
    bench.act(ANNA, 1)
    assert bench.take()[1:] == [ActReceived(ANNA, NOTE_ADDED.name, raw(NOTE))]


def test_act_counts_as_heartbeat(bench: Bench) -> None:
    bench.act(ANNA, 0)
    assert isinstance(bench.take()[0], PeerJoined)


def test_an_operator_whose_terminal_is_silent_is_lost_after_its_time(bench: Bench) -> None:
    for at in range(0, 2001, 150):
        bench.ping(ANNA, at * MS, silence=at * MS)
    bench.admission.tick(2 * SECOND)
    assert bench.take() == [PeerJoined(ANNA)]
    bench.admission.tick(2 * SECOND + 1)
    assert bench.take() == [PeerLeft(ANNA, "lost", "Its terminal did not answer for 2000 ms.")]


def test_an_act_of_a_silent_terminal_does_not_bring_it_back(bench: Bench) -> None:
    """A panel reports by itself that it shows a proposal."""
    bench.ping(ANNA, 0, silence=0)
    bench.admission.tick(3 * SECOND)
    bench.take()
    bench.act(ANNA, 3 * SECOND, silence=3 * SECOND)
    assert bench.take() == [
        RequestRefused(ANNA, NOTE_ADDED.name, "The terminal of this panel does not answer.", 1)
    ]
    bench.ping(ANNA, 3 * SECOND, wants_snapshot=True, silence=3 * SECOND)
    assert bench.take() == []
    assert isinstance(pong := bench.answers[-1][1], Pong)
    assert "does not answer" in pong.refusal


def test_an_operator_whose_terminal_is_back_joins_again_with_a_snapshot(bench: Bench) -> None:
    bench.ping(ANNA, 0, silence=0)
    bench.admission.tick(3 * SECOND)
    bench.take()
    bench.ping(ANNA, 4 * SECOND, wants_snapshot=True, silence=MS)
    assert bench.take() == [PeerJoined(ANNA), SnapshotRequested(ANNA)]


def test_an_operator_without_proof_is_reported_once_and_an_observer_not(bench: Bench) -> None:
    for name in (ANNA, OLAF):
        bench.ping(name, 0)
        for at in range(0, 8000, 150):
            bench.ping(name, at * MS)
    bench.take()
    for at in (6, 7):
        bench.admission.tick(at * SECOND)
    assert bench.take() == [PeerUnproven(ANNA, "the terminal answers no queries.")]


def test_a_multiplexer_proves_nothing(bench: Bench) -> None:
    bench.ping(ANNA, 0, silence=0, is_relayed=True)
    bench.admission.tick(1)
    assert bench.take()[1:] == [
        PeerUnproven(ANNA, "tmux, screen, Zellij or mosh answers for the terminal.")
    ]


def test_a_silence_below_zero_is_refused(bench: Bench) -> None:
    bench.ping(ANNA, 0, silence=-1)
    assert bench.take() == [RequestRefused(ANNA, "a heartbeat", "It cannot be read.", 1)]


def test_second_program_with_the_same_name_is_refused(bench: Bench) -> None:
    bench.ping(ANNA, 0)
    bench.ping(ANNA, 1, client_id="2", wants_snapshot=True)
    bench.act(ANNA, 2, client_id="2")
    assert isinstance(pong := bench.answers[-1][1], Pong)
    assert (pong.client_id, "name is in use" in pong.refusal) == ("2", True)
    assert [type(event) for event in bench.take()] == [PeerJoined, RequestRefused]


@pytest.mark.parametrize(
    ("topic", "message"),
    [
        (NOTE_ADDED.name, NOTE),
        (COMMAND.name, m.SessionCommand(command="end")),
        (COMMAND.name, m.SessionCommand(command="skip", reason="stop")),
        (protocol.TAKE_CONTROL, NOTE),
    ],
)
def test_observer_cannot_act(bench: Bench, topic: str, message: Message) -> None:
    bench.ping(OLAF, 0)
    bench.act(OLAF, 1, message, topic)
    (refused,) = bench.take()[1:]
    assert isinstance(refused, RequestRefused)
    assert (refused.name, refused.why) == (OLAF, "An observer can only stop the agent.")


def test_observer_may_stop_the_agent(bench: Bench) -> None:
    stop = m.SessionCommand(command="stop")
    bench.ping(OLAF, 0)
    bench.act(OLAF, 1, stop, COMMAND.name)
    assert bench.take()[1:] == [ActReceived(OLAF, COMMAND.name, raw(stop))]


@pytest.mark.parametrize(
    "name", ["*", "**", "anna", "director.anna", "operator.", "operator.a/b", "operator.\x1b"]
)
def test_invalid_name_is_refused(bench: Bench, name: str) -> None:
    bench.ping(name, 0)
    bench.act(name, 0)
    refused = bench.take()
    assert [type(event) for event in refused] == [RequestRefused, RequestRefused]
    assert all(
        isinstance(event, RequestRefused) and event.name == "unknown" for event in refused
    ), "an invalid name is not repeated"
    assert bench.answers == []


def test_undecodable_message_is_refused(bench: Bench) -> None:
    bench.admission.receive_act(ANNA, b"\xc1nonsense", 0)
    bench.admission.receive_ping(ANNA, b"", 0)
    assert bench.take() == [
        RequestRefused(ANNA, "an act", "It cannot be read.", 1),
        RequestRefused(ANNA, "a heartbeat", "It cannot be read.", 1),
    ]


def test_note_that_is_too_long_is_refused(bench: Bench) -> None:
    bench.act(ANNA, 0, m.NoteAdded(text="x" * 100_000))
    assert bench.take() == [RequestRefused(ANNA, "an act", "It is longer than 20000 bytes.", 1)]


def test_flood_of_acts_is_limited_and_counted(bench: Bench) -> None:
    bench.ping(ANNA, 0)
    bench.take()
    for number in range(10_000):
        bench.act(ANNA, number * SECOND // 10_000)
    bench.admission.tick(2 * SECOND)
    events = bench.take()
    forwarded = [event for event in events if isinstance(event, ActReceived)]
    refused = [event for event in events if isinstance(event, RequestRefused)]
    assert len(forwarded) <= 90
    assert len(refused) <= 2
    assert len(forwarded) + sum(event.count for event in refused) == 10_000


@pytest.mark.parametrize(
    ("name", "message", "why"),
    [
        (OLAF, NOTE, "An observer can only stop the agent."),
        (ANNA, m.NoteAdded(), "A note is empty."),
        (ANNA, m.NoteAdded(text="\x1b"), "A text contains control characters."),
    ],
)
def test_an_act_that_is_not_forwarded_is_answered(
    bench: Bench, name: str, message: Message, why: str
) -> None:
    for id in ("a1", "a2", "a3"):
        bench.act(name, 0, message, id=id)
    assert bench.refusals() == dict.fromkeys(("a1", "a2", "a3"), why)
    assert not [event for event in bench.take() if isinstance(event, ActReceived)]


def test_acts_that_come_too_fast_are_answered_but_not_a_flood_of_them(bench: Bench) -> None:
    for number in range(1000):
        bench.act(ANNA, 0, id=f"{number:x}")
    forwarded = [event.id for event in bench.take() if isinstance(event, ActReceived)]
    refused = bench.refusals()
    assert not set(forwarded) & set(refused)
    assert set(refused.values()) == {"It sends more than 30 messages a second."}
    assert 0 < len(refused) < 100


def test_a_question_for_answers_is_forwarded(bench: Bench) -> None:
    ping = Ping("1", 77, unanswered=("a1", "a2"))
    bench.admission.receive_ping(ANNA, protocol.encode(ping), 0)
    assert bench.take()[-1] == AnswersRequested(ANNA, ("a1", "a2"))


@pytest.mark.parametrize("id", ["x", "a" * 33, "a\n"])
def test_an_id_that_a_panel_would_not_make_is_refused(bench: Bench, id: str) -> None:
    bench.act(ANNA, 0, id=id)
    assert bench.take() == [RequestRefused(ANNA, "an act", "It cannot be read.", 1)]
    assert bench.refusals() == {}
