"""Peers are admitted, lost and limited, and their messages forwarded or refused: without Zenoh."""

from typing import Any

import msgspec
import pytest

from sar_tui.link import protocol
from sar_tui.link.admission import ASKING, Admission, ReportThrottle, TokenBucket
from sar_tui.link.presence import FIRST_ANSWER_WITHIN, MAX_PEERS
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
    VisitAsked,
)
from sar_tui.loop.topics import COMMAND, NOTE_ADDED
from sar_tui.model import messages as m
from sar_tui.model.messages import Message
from sar_tui.model.units import MS, SECOND

ANNA, BEN, OLAF = "operator.anna", "operator.ben", "observer.olaf"
NOTE = m.NoteAdded(text="well")


def raw(message: Message) -> msgspec.Raw:
    return msgspec.Raw(protocol.encode(message))


class Bench:
    """Admission that records its events and answers."""

    def __init__(self, *, is_visit: bool = False) -> None:
        self.events: list[BrokerEvent] = []
        self.answers: list[tuple[str, SessionMessage]] = []
        self.admission = Admission(
            2 * SECOND,
            self.events.append,
            lambda *answer: self.answers.append(answer),
            "here",
            is_visit=is_visit,
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

    def refusal(self) -> str:
        """Return why the last heartbeat was refused; empty if it was not."""
        pong = self.answers[-1][1]
        assert isinstance(pong, Pong)
        return pong.refusal

    def take(self) -> list[BrokerEvent]:
        events, self.events[:] = list(self.events), []
        return events


@pytest.fixture
def bench() -> Bench:
    return Bench()


SILENT = PeerLeft(ANNA, "lost", "No heartbeat for 2000 ms.")
UNATTENDED = PeerLeft(ANNA, "lost", "Its terminal did not answer for 2000 ms.")


# --- presence


def test_first_ping_admits_a_peer_and_is_answered_with_the_clock(bench: Bench) -> None:
    bench.admission.number = 5
    bench.ping(ANNA, 3 * SECOND, wants_snapshot=True)
    assert bench.take() == [PeerJoined(ANNA), SnapshotRequested(ANNA)]
    assert bench.answers == [(ANNA, Pong(77, 3 * SECOND, "here", 5, "1"))]


def test_leaving_peer_has_left_and_silent_peer_is_lost_once(bench: Bench) -> None:
    bench.ping(ANNA, 0)
    bench.ping(OLAF, 0)
    bench.ping(OLAF, 0, client_id="2", is_leaving=True)  # another program's
    assert bench.take() == [PeerJoined(ANNA), PeerJoined(OLAF)]
    bench.ping(OLAF, 0, is_leaving=True)
    for at in (2 * SECOND, 2 * SECOND + 1, 9 * SECOND):
        bench.admission.tick(at)
    assert bench.take() == [PeerLeft(OLAF, "left"), SILENT]
    bench.ping(ANNA, 10 * SECOND)
    assert bench.take() == [PeerJoined(ANNA)]


@pytest.mark.parametrize(
    ("silent_ms", "at_once", "later"),
    [(500, [PeerLeft(ANNA, "lost", "The connection broke.")], []), (501, [], [SILENT])],
    ids=["at once", "after its time if it was silent before"],
)
def test_peer_whose_connection_breaks_is_lost(
    bench: Bench, silent_ms: int, at_once: list[BrokerEvent], later: list[BrokerEvent]
) -> None:
    bench.ping(ANNA, 0)
    for _ in range(2):
        bench.admission.disconnect(ANNA, silent_ms * MS)
    assert bench.take()[1:] == at_once
    bench.admission.tick(2 * SECOND + 1)
    assert bench.take() == later


def test_peer_that_reconnects_in_time_is_not_lost(bench: Bench) -> None:
    bench.ping(ANNA, 0)
    bench.admission.disconnect(ANNA, 900 * MS)
    bench.ping(ANNA, 1900 * MS)
    bench.admission.tick(3 * SECOND)
    assert bench.take() == [PeerJoined(ANNA)]


def test_a_name_belongs_to_one_program_until_it_leaves(bench: Bench) -> None:
    bench.ping(ANNA, 0)
    bench.ping(ANNA, 1, client_id="2", wants_snapshot=True)
    assert "name is in use" in bench.refusal()
    bench.act(ANNA, 2, client_id="2")
    assert [type(event) for event in bench.take()] == [PeerJoined, RequestRefused]
    bench.ping(ANNA, 3, is_leaving=True)
    bench.ping(ANNA, 4, client_id="2")
    assert bench.refusal() == ""
    assert bench.take() == [PeerLeft(ANNA, "left"), PeerJoined(ANNA)]


def test_number_of_peers_is_limited(bench: Bench) -> None:
    for number in range(MAX_PEERS + 1):
        bench.ping(f"observer.{number}", 0)
    assert "Too many people" in bench.refusal()
    assert len(bench.take()) == MAX_PEERS


# --- terminals that do not answer


def test_an_operator_whose_terminal_is_silent_is_lost_after_its_time_though_its_program_runs(
    bench: Bench,
) -> None:
    for at in range(0, 2001, 150):
        bench.ping(ANNA, at * MS, silence=at * MS)
    bench.admission.tick(2 * SECOND)
    assert bench.take() == [PeerJoined(ANNA)]
    bench.admission.tick(2 * SECOND + 1)
    assert bench.take() == [UNATTENDED]


def test_neither_an_act_nor_a_ping_of_a_silent_terminal_brings_it_back_and_its_name_is_free(
    bench: Bench,
) -> None:
    bench.ping(ANNA, 0, silence=0)
    bench.admission.tick(3 * SECOND)
    bench.take()
    bench.act(ANNA, 3 * SECOND, silence=3 * SECOND)  # by itself, for a proposal that it shows
    why = "The terminal of this panel does not answer."
    assert bench.take() == [RequestRefused(ANNA, NOTE_ADDED.name, why, 1)]
    bench.ping(ANNA, 3 * SECOND, wants_snapshot=True, silence=3 * SECOND)
    assert (bench.refusal(), bench.take()) == (why, [])
    bench.ping(ANNA, 4 * SECOND, client_id="2")
    assert bench.take() == [PeerJoined(ANNA)]


def test_an_operator_whose_terminal_is_back_joins_again_with_a_snapshot(bench: Bench) -> None:
    bench.ping(ANNA, 0, silence=0)
    bench.admission.tick(3 * SECOND)
    bench.take()
    bench.ping(ANNA, 4 * SECOND, wants_snapshot=True, silence=2 * SECOND)
    assert bench.take() == [PeerJoined(ANNA), SnapshotRequested(ANNA)]


def test_an_older_answer_of_the_terminal_does_not_count(bench: Bench) -> None:
    for silence in (0, 5 * SECOND, None):
        bench.ping(ANNA, 10 * SECOND, silence=silence)
    bench.admission.tick(12 * SECOND)
    assert bench.take() == [PeerJoined(ANNA)]


def test_an_operator_without_proof_is_reported_once_and_an_observer_not(bench: Bench) -> None:
    for at in (0, FIRST_ANSWER_WITHIN):
        for name in (ANNA, OLAF):
            bench.ping(name, at)
    bench.take()
    bench.admission.tick(FIRST_ANSWER_WITHIN)
    assert bench.take() == []
    for later in (1, 2):
        bench.admission.tick(FIRST_ANSWER_WITHIN + later)
    assert bench.take() == [PeerUnproven(ANNA, "the terminal answers no queries.")]


def test_a_multiplexer_proves_nothing(bench: Bench) -> None:
    bench.ping(ANNA, 0, silence=0, is_relayed=True)
    bench.act(ANNA, 0, silence=0)  # does not say
    bench.ping(BEN, 0, silence=0, is_relayed=False)
    bench.take()
    bench.admission.tick(1)
    why = "tmux, screen, Zellij or mosh answers for the terminal."
    assert bench.take() == [PeerUnproven(ANNA, why)]


# --- acts


def test_act_is_forwarded_and_counts_as_heartbeat(bench: Bench) -> None:
    bench.act(ANNA, 0)
    assert bench.take() == [PeerJoined(ANNA), ActReceived(ANNA, NOTE_ADDED.name, raw(NOTE))]


@pytest.mark.parametrize(
    ("topic", "message"),
    [
        (NOTE_ADDED.name, NOTE),
        (COMMAND.name, m.SessionCommand(command="end")),
        (COMMAND.name, m.SessionCommand(command="skip", reason="stop")),
        (protocol.TAKE_CONTROL, NOTE),
    ],
)
def test_observer_can_only_stop_the_agent(bench: Bench, topic: str, message: Message) -> None:
    bench.ping(OLAF, 0)
    bench.act(OLAF, 1, message, topic)
    (refused,) = bench.take()[1:]
    assert isinstance(refused, RequestRefused)
    assert (refused.name, refused.why) == (OLAF, "An observer can only stop the agent.")
    stop = m.SessionCommand(command="stop")
    bench.act(OLAF, 1, stop, COMMAND.name)
    assert bench.take() == [ActReceived(OLAF, COMMAND.name, raw(stop))]


@pytest.mark.parametrize(
    "name", ["*", "**", "anna", "director.anna", "operator.", "operator.a/b", "operator.\x1b"]
)
def test_invalid_name_is_refused_and_not_repeated(bench: Bench, name: str) -> None:
    bench.ping(name, 0)
    bench.act(name, 0)
    why = "It does not say who sent it."
    assert bench.take() == [
        RequestRefused("unknown", "a heartbeat", why, 1),
        RequestRefused("unknown", "an act", why, 1),
    ]
    assert bench.answers == []


@pytest.mark.parametrize("id", ["x", "a" * 33, "a\n"])
def test_what_a_panel_would_not_send_is_refused(bench: Bench, id: str) -> None:
    bench.admission.receive_ping(ANNA, b"", 0)
    bench.ping(ANNA, 0, silence=-1)
    bench.admission.receive_act(ANNA, b"\xc1nonsense", 0)
    bench.act(ANNA, 0, id=id)
    bench.act(ANNA, 0, m.NoteAdded(text="x" * 100_000))
    assert bench.take() == [
        RequestRefused(ANNA, "a heartbeat", "It cannot be read.", 1),
        RequestRefused(ANNA, "an act", "It cannot be read.", 1),
        RequestRefused(ANNA, "an act", "It is longer than 20000 bytes.", 1),
    ]
    assert bench.answers == []
    bench.admission.tick(SECOND)
    assert [event.count for event in bench.take() if isinstance(event, RequestRefused)] == [1, 1]


# --- answers and limits


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


def test_a_question_for_answers_is_forwarded(bench: Bench) -> None:
    bench.ping(ANNA, 0, unanswered=("a1", "a2"))
    assert bench.take()[-1] == AnswersRequested(ANNA, ("a1", "a2"))


def test_snapshots_are_limited_to_one_per_second(bench: Bench) -> None:
    for at in range(0, 1000, 50):
        bench.ping(ANNA, at * MS, wants_snapshot=True)
    assert bench.take().count(SnapshotRequested(ANNA)) == 3


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


def test_acts_that_come_too_fast_are_answered_but_not_a_flood_of_them(bench: Bench) -> None:
    for number in range(1000):
        bench.act(ANNA, 0, id=f"{number:x}")
    forwarded = [event.id for event in bench.take() if isinstance(event, ActReceived)]
    refused = bench.refusals()
    assert not set(forwarded) & set(refused)
    assert set(refused.values()) == {"It sends more than 30 messages a second."}
    assert 0 < len(refused) < 100


def test_bucket_passes_a_burst_then_the_rate_and_saves_no_more_than_a_burst() -> None:
    bucket = TokenBucket(rate=10, burst=5)
    assert sum(bucket.take(0) for _ in range(100)) == 5
    assert sum(bucket.take(at * MS) for at in range(1, 1001)) == 10
    assert sum(bucket.take(3600 * SECOND) for _ in range(100)) == 5


def test_repeated_event_is_reported_at_once_then_once_a_second_with_count() -> None:
    throttle: ReportThrottle[str] = ReportThrottle()
    assert throttle.add("flood", 0) == 1
    assert throttle.add("another", 1) == 1
    assert [throttle.add("flood", at * MS) for at in range(1, 500)] == [0] * 499
    assert throttle.due(999 * MS) == []
    assert throttle.due(SECOND) == [("flood", 499)]
    assert throttle.due(5 * SECOND) == []
    assert throttle.add("flood", 6 * SECOND) == 1


def test_events_beyond_the_maximum_wait_until_others_are_forgotten() -> None:
    throttle: ReportThrottle[int] = ReportThrottle(max_keys=3)
    assert [throttle.add(thing, 0) for thing in range(1000)] == [1, 1, 1] + [0] * 997
    assert throttle.due(SECOND) == []
    assert throttle.add(999, SECOND) == 1


# --- a visit


def test_before_the_participant_agrees_a_visitor_is_told_that_they_are_asked_and_nothing_else() -> (
    None
):
    bench = Bench(is_visit=True)
    bench.ping(ANNA, SECOND, wants_snapshot=True)
    bench.ping(ANNA, 2 * SECOND, wants_snapshot=True, unanswered=("ab",))
    bench.act(ANNA, 2 * SECOND, id="ab")
    assert bench.answers == [(ANNA, Pong(77, 0, "", 0, "1", ASKING))] * 2
    asked, refused = bench.take()
    assert asked == VisitAsked(ANNA)
    assert isinstance(refused, RequestRefused)
    assert bench.admission.present == []
    bench.admission.admit(ANNA)
    bench.ping(ANNA, 3 * SECOND, wants_snapshot=True)
    bench.act(ANNA, 3 * SECOND)
    joined, requested, act = bench.take()
    assert (joined, requested) == (PeerJoined(ANNA), SnapshotRequested(ANNA))
    assert isinstance(act, ActReceived)
    assert bench.admission.present == [ANNA]


def test_each_visitor_needs_a_yes_and_a_no_is_for_all_also_for_those_who_are_there() -> None:
    bench = Bench(is_visit=True)
    bench.admission.admit(ANNA)
    bench.ping(ANNA, 0)
    bench.ping(BEN, 0)
    assert bench.take() == [PeerJoined(ANNA), VisitAsked(BEN)]
    bench.admission.deny("Not today.")
    assert bench.take() == [PeerLeft(ANNA, "left", "Not today.")]
    for name in (ANNA, BEN, OLAF):
        bench.ping(name, SECOND)
        assert bench.refusal() == "Not today."
    assert bench.take() == []


def test_who_leaves_or_falls_silent_before_the_answer_does_not_ask_any_longer() -> None:
    bench = Bench(is_visit=True)
    bench.ping(ANNA, 0)
    bench.ping(BEN, 0)
    bench.ping(ANNA, SECOND, is_leaving=True)
    bench.admission.tick(2 * SECOND)
    bench.admission.tick(2 * SECOND + 1)
    asked = [VisitAsked(ANNA), VisitAsked(BEN)]
    assert bench.take() == [
        *asked, VisitAsked(ANNA, withdrawn=True), VisitAsked(BEN, withdrawn=True)
    ]  # fmt: skip
    bench.ping(BEN, 3 * SECOND)
    assert bench.take() == [VisitAsked(BEN)]
