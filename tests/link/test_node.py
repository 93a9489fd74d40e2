"""LinkNode on a virtual clock, with a fake channel to the broker process."""

from collections.abc import Iterator
from typing import Any

import msgspec
import pytest

from sar_tui.link import protocol
from sar_tui.link.broker_process import (
    BrokerEnded,
    BrokerListener,
    Outgoing,
    OutgoingAnswers,
    OutgoingBatch,
    OutgoingSamples,
    OutgoingSnapshot,
)
from sar_tui.link.node import LinkNode
from sar_tui.link.peer import MarkKey, Welcome, session_welcome
from sar_tui.link.protocol import (
    ActReceived,
    AnswersRequested,
    BrokerEvent,
    PeerJoined,
    PeerLeft,
    PeerUnproven,
    RequestRefused,
    SnapshotRequested,
)
from sar_tui.loop.answers import answer_to
from sar_tui.loop.bus import Bus, Record, Topic
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.marks import TrialMark
from sar_tui.loop.node import Node
from sar_tui.loop.topics import (
    ANSWERED,
    COMMAND,
    CUE,
    IMU,
    KEY,
    LEVEL,
    NOTE_ADDED,
    PRESENCE,
    PROMPT,
    PROPOSAL_SEEN,
    PROTOCOL,
    REFUSED,
    SESSION,
    SHOWN,
    WAITING,
)
from sar_tui.model import messages as m
from sar_tui.model.messages import Message
from sar_tui.model.protocol import ProtocolStep, WizardProtocol
from sar_tui.model.units import MS, SECOND
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build

ANNA, BEN, OLAF = "operator.anna", "operator.ben", "observer.olaf"
_OF_TASK: Any = {"task": "keyboard", "title": "Keyboard", "unit": "ms", "decimals": 0}
_LENGTH: Any = {"levels": 5, "attempts": 2, "trials": 3}
_PEER: Any = {"participants": {"A": "P1"}, "name": "", "role": "observer"}
WELCOME = Welcome(link="link", session="s1", **_OF_TASK, **_LENGTH, **_PEER)
STARTED = m.SessionStarted(run=1, task="keyboard", theme="calm", seed=1)
START = 100 * SECOND


_PROMPT: Any = {"level": 1, "stimulus": "f", "expected": "f", "text": "Press: f", "glyph": "f"}
ON_ITS_WAY = m.Prompt(attempt=1, trial=1, presentation=1, choices=2, timeout=SECOND, **_PROMPT)


def raised_to(level: int) -> m.LevelChanged:
    return m.LevelChanged(previous=level - 1, level=level, reason="success")


def raw(message: Message) -> msgspec.Raw:
    return msgspec.Raw(protocol.encode(message))


class FakeChannel:
    """Records what is sent; it can be full."""

    link = "link"

    def __init__(self, *, is_visit: bool = False) -> None:
        self.is_visit = is_visit
        self.sent: list[Outgoing] = []
        self.is_full = False
        self.checks = 0

    def listen(self, listener: BrokerListener) -> None:
        self.notify = listener

    def send(self, message: Outgoing) -> bool:
        if not self.is_full:
            self.sent.append(message)
        return not self.is_full

    def check(self) -> None:
        self.checks += 1


class Publisher(Node):
    """Publishes given derived messages."""

    name = "publisher"

    def attach(self, bus: Bus) -> None:
        super().attach(bus)
        self.due: list[tuple[Topic[Any], Message]] = []
        bus.subscribe(KEY, lambda _: [bus.publish(*each) for each in self.due])

    def publish(self, *messages: tuple[Topic[Any], Message]) -> None:
        self.due = list(messages)
        self.bus.publish(KEY, m.KeyPressed(key="f", at=0))


class Bench:
    """LinkNode on a bus of its own."""

    def __init__(self) -> None:
        self.clock = VirtualClock(START)
        self.bus = Bus(self.clock)
        self.channel = FakeChannel()
        self.node = LinkNode(self.channel)
        self.node.welcome = WELCOME
        self.publisher = Publisher()
        self.publisher.attach(self.bus)
        self.node.attach(self.bus)
        self.records: list[Record] = []
        self.bus.tap(self.records.extend)
        self.bus.publish(SESSION, STARTED)

    def receive(self, *events: BrokerEvent | BrokerEnded) -> None:
        """Deliver events of the broker process."""
        for each in events:
            self.channel.notify(each)
        self.clock.advance(MS)

    def act(self, name: str, topic: Topic[Any], message: Message, id: str = "") -> None:
        self.receive(ActReceived(name, topic.name, raw(message), id))

    def answer(self, act: m.NoteAdded) -> None:
        """Answer an act, as a node of the session does."""
        self.publisher.publish((ANSWERED, answer_to(act, 7)))

    def answers(self) -> list[tuple[str, str, str, str]]:
        """Return the answers sent to single peers: name, id, outcome, reason."""
        sent = [each for each in self.channel.sent if isinstance(each, OutgoingAnswers)]
        return [(each.name, *(a.id, a.outcome, a.why)) for each in sent for a in each.answers]

    def of(self, topic: Topic[Any]) -> list[Any]:
        """Return the messages published on a topic."""
        return [record.message for record in self.records if record.topic is topic]

    def presence(self) -> list[tuple[str, str, bool]]:
        return [(changed.actor, changed.state, changed.operated) for changed in self.of(PRESENCE)]

    def batches(self) -> list[OutgoingBatch]:
        return [sent for sent in self.channel.sent if isinstance(sent, OutgoingBatch)]

    def snapshots(self) -> list[OutgoingSnapshot]:
        return [sent for sent in self.channel.sent if isinstance(sent, OutgoingSnapshot)]


@pytest.fixture
def bench() -> Iterator[Bench]:
    bench = Bench()
    yield bench
    bench.node.detach()


# --- control


@pytest.mark.parametrize("name", [BEN, OLAF])
def test_without_control_everyone_may_stop_the_agent_and_nothing_else(
    bench: Bench, name: str
) -> None:
    bench.receive(PeerJoined(ANNA), PeerJoined(name))
    bench.act(name, COMMAND, m.SessionCommand(command="stop", at=START))
    bench.act(name, COMMAND, m.SessionCommand(command="pause"))
    assert [(act.command, act.actor) for act in bench.of(COMMAND)] == [("stop", name)]
    assert [(refused.actor, refused.what) for refused in bench.of(REFUSED)] == [
        (name, COMMAND.name)
    ]
    assert bench.of(PRESENCE)[-1].holder == ANNA


@pytest.mark.parametrize(
    ("said_ms", "stored_ms"), [(-90_000, -60_000), (-59_000, -59_000), (9_000, 0), (None, 0)]
)
def test_act_is_published_with_the_name_known_to_the_link_and_a_stamp_within_the_last_minute(
    bench: Bench, said_ms: int | None, stored_ms: int
) -> None:
    bench.receive(PeerJoined(ANNA))
    now = bench.clock.now()
    act = m.NoteAdded(text="x", actor=BEN, at=0 if said_ms is None else now + said_ms * MS)
    bench.node.receive(ActReceived(ANNA, NOTE_ADDED.name, raw(act)))
    assert bench.of(NOTE_ADDED) == [m.NoteAdded(text="x", actor=ANNA, at=now + stored_ms * MS)]


def test_an_operator_takes_control_at_once_and_an_observer_never(bench: Bench) -> None:
    bench.receive(PeerJoined(ANNA), PeerJoined(BEN), PeerJoined(OLAF))
    bench.act(BEN, PROPOSAL_SEEN, m.ProposalSeen(action="a1"))
    assert bench.of(PROPOSAL_SEEN) == bench.of(REFUSED) == [], "ignored without control"
    for name in (BEN, OLAF):
        bench.receive(ActReceived(name, protocol.TAKE_CONTROL, msgspec.Raw(b"\xc0")))
    bench.act(BEN, COMMAND, m.SessionCommand(command="skip"))
    assert [refused.actor for refused in bench.of(REFUSED)] == [OLAF]
    bench.act(ANNA, COMMAND, m.SessionCommand(command="pause"))
    assert bench.presence()[-1] == (BEN, "baton", True)
    assert [act.command for act in bench.of(COMMAND)] == ["skip"]


def test_a_mark_that_the_task_does_not_have_is_refused(bench: Bench) -> None:
    bench.node.welcome = msgspec.structs.replace(
        WELCOME, marks=(MarkKey("missed", "Marker missed"),)
    )
    bench.receive(PeerJoined(ANNA))
    for name in ("missed", "nonsense", ""):
        bench.act(ANNA, COMMAND, m.SessionCommand(command="mark", reason=name))
    assert [act.reason for act in bench.of(COMMAND)] == ["missed"]
    assert [refused.why for refused in bench.of(REFUSED)] == ["There is no such mark in this task."]


def test_invalid_acts_and_those_that_the_broker_refused_are_logged_as_refused(bench: Bench) -> None:
    bench.receive(
        PeerJoined(ANNA),
        ActReceived(ANNA, NOTE_ADDED.name, msgspec.Raw(b"\xc1")),
        ActReceived(ANNA, KEY.name, msgspec.Raw(b"\xc0")),
    )
    bench.act(ANNA, NOTE_ADDED, m.NoteAdded(seat="Q", text="x"))
    bench.receive(RequestRefused(OLAF, "an act", "An observer cannot act.", 12))
    *of_anna, refused = bench.of(REFUSED)
    assert [each.actor for each in of_anna] == [ANNA, ANNA, ANNA]
    assert (refused.actor, refused.what, refused.count) == (OLAF, "an act", 12)
    assert refused.why == "An observer cannot act."
    assert bench.of(NOTE_ADDED) == []


def test_a_protocol_with_control_characters_is_refused(
    bench: Bench,
) -> None:
    bench.receive(PeerJoined(ANNA))
    for do in ("say \x1b[2J", "say greeting"):
        steps = (ProtocolStep("start", do),)
        bench.act(
            ANNA, PROTOCOL, m.ProtocolChosen(protocol=WizardProtocol("p", 1, "h", steps=steps))
        )
    assert [each.protocol.steps[0].do for each in bench.of(PROTOCOL)] == ["say greeting"]
    assert [each.what for each in bench.of(REFUSED)] == [PROTOCOL.name]


# --- answers


def test_each_act_that_is_not_let_through_is_answered_and_reported_once_a_second(
    bench: Bench,
) -> None:
    bench.receive(PeerJoined(ANNA), PeerJoined(BEN))
    for id in ("1", "2", "3"):
        bench.act(BEN, NOTE_ADDED, m.NoteAdded(text="hm"), id)
    why = "Another operator is in control."
    assert bench.answers() == [(BEN, id, "refused", why) for id in ("1", "2", "3")]
    bench.clock.advance(3 * SECOND)
    assert [refused.count for refused in bench.of(REFUSED)] == [1, 2]
    assert bench.of(NOTE_ADDED) == []


def test_an_id_is_carried_out_once(bench: Bench) -> None:
    bench.receive(PeerJoined(ANNA))
    note = m.NoteAdded(text="hm")
    bench.act(ANNA, NOTE_ADDED, note, "1")
    bench.act(ANNA, NOTE_ADDED, note, "1")
    (published,) = bench.of(NOTE_ADDED)
    assert (published.id, published.actor) == ("1", ANNA)
    assert bench.answers() == []
    bench.answer(published)
    bench.act(ANNA, NOTE_ADDED, note, "1")
    assert bench.answers() == [(ANNA, "1", "done", "")]
    assert len(bench.of(NOTE_ADDED)) == 1


def test_a_peer_that_asks_gets_the_answers_to_its_acts_that_are_known(bench: Bench) -> None:
    bench.receive(PeerJoined(ANNA), PeerJoined(OLAF))
    for id in ("1", "2"):
        bench.act(ANNA, NOTE_ADDED, m.NoteAdded(text="hm"), id)
    bench.answer(bench.of(NOTE_ADDED)[0])
    bench.receive(AnswersRequested(ANNA, ("1", "2", "3")))
    missing = (ANNA, "3", "refused", "It did not arrive.")
    assert bench.answers() == [(ANNA, "1", "done", ""), missing]
    bench.act(ANNA, NOTE_ADDED, m.NoteAdded(text="late"), "3")
    assert bench.answers()[2:] == [missing], "the answer holds"
    assert len(bench.of(NOTE_ADDED)) == 2
    bench.receive(AnswersRequested(OLAF, ("1",)))
    assert bench.answers()[3:] == [(OLAF, "1", "refused", "It did not arrive.")]


def test_first_operator_is_in_control_and_the_next_when_it_is_lost_and_an_observer_never(
    bench: Bench,
) -> None:
    bench.receive(PeerJoined(OLAF), PeerJoined(ANNA), PeerJoined(ANNA), PeerJoined(BEN))
    assert bench.of(PRESENCE)[-1].peers == {OLAF: "observer", ANNA: "operator", BEN: "operator"}
    bench.receive(PeerLeft(ANNA, "lost", "No heartbeat."), PeerJoined(ANNA), PeerLeft(BEN, "left"))
    bench.receive(PeerLeft(ANNA, "left"), PeerLeft(ANNA, "left"), PeerJoined(BEN))
    changes = [(each.actor, each.state, each.holder) for each in bench.of(PRESENCE)]
    assert changes == [
        (OLAF, "joined", ""),
        (ANNA, "joined", ANNA),
        (ANNA, "baton", ANNA),
        (BEN, "joined", ANNA),
        (ANNA, "lost", BEN),
        (BEN, "baton", BEN),
        (ANNA, "joined", BEN),
        (BEN, "left", ANNA),
        (ANNA, "baton", ANNA),
        (ANNA, "left", ""),
        (BEN, "joined", BEN),
        (BEN, "baton", BEN),
    ]
    assert all(each.operated == bool(each.holder) for each in bench.of(PRESENCE))
    assert [each.detail for each in bench.of(PRESENCE) if each.detail] == ["No heartbeat."]


def test_an_operator_without_proof_still_counts_and_is_reported(bench: Bench) -> None:
    bench.receive(
        PeerJoined(ANNA),
        PeerUnproven(ANNA, "the terminal answers no queries."),
        PeerUnproven(BEN, ""),
    )
    assert bench.presence() == [
        (ANNA, "joined", True),
        (ANNA, "baton", True),
        (ANNA, "unproven", True),
    ]
    assert bench.of(PRESENCE)[-1].detail == "the terminal answers no queries."


def test_all_peers_are_lost_when_the_broker_ends_and_a_final_end_is_reported(bench: Bench) -> None:
    bench.receive(PeerJoined(ANNA), PeerJoined(OLAF))
    bench.records.clear()
    bench.receive(BrokerEnded("It ended."), BrokerEnded("It ended for good.", is_final=True))
    assert bench.presence() == [(ANNA, "lost", False), (OLAF, "lost", False)]
    assert [(refused.actor, refused.why) for refused in bench.of(REFUSED)] == [
        ("link", "It ended for good.")
    ]


# --- to the peers


def test_late_peer_gets_a_snapshot_and_the_mark_of_an_earlier_run(bench: Bench) -> None:
    for level in (2, 3):
        bench.publisher.publish((LEVEL, raised_to(level)))
    bench.node.trial_mark = lambda: TrialMark(done=(2, 1), marks={(2, 1): "missed"})
    bench.receive(PeerJoined(ANNA), SnapshotRequested(ANNA))
    bench.clock.advance(50 * MS)
    (snapshot,) = bench.snapshots()
    welcome = protocol.decode(protocol.encode(snapshot.welcome), Welcome)
    assert (welcome.name, welcome.role, welcome.session) == (ANNA, "operator", "s1")
    assert (welcome.trial_mark.trial, welcome.trial_mark.present) == ((2, 1), "missed")
    messages = [record.message for record in snapshot.records]
    assert STARTED in messages
    assert [each.level for each in messages if isinstance(each, m.LevelChanged)] == [3]
    numbers = [record.seq for record in snapshot.records]
    assert numbers == sorted(numbers)


def test_snapshot_of_resumed_session_omits_former_peers(bench: Bench) -> None:
    resumed = LinkNode(channel := FakeChannel())
    resumed.welcome = WELCOME
    bench.bus.publish(PRESENCE, m.OperatorChanged(actor=BEN, state="joined", operated=True))
    resumed.attach(bench.bus)
    channel.notify(PeerJoined(ANNA))
    channel.notify(SnapshotRequested(ANNA))
    bench.clock.advance(50 * MS)
    resumed.detach()
    (snapshot,) = (sent for sent in channel.sent if isinstance(sent, OutgoingSnapshot))
    messages = [record.message for record in snapshot.records]
    assert STARTED in messages
    assert BEN not in [each.actor for each in messages if isinstance(each, m.OperatorChanged)]


def test_messages_are_sent_in_numbered_batches_once_there_are_peers(bench: Bench) -> None:
    bench.publisher.publish((WAITING, m.Waiting(what="enter", stage="attempt")))
    bench.clock.advance(SECOND)
    assert bench.channel.sent == []
    bench.receive(PeerJoined(ANNA))
    bench.clock.advance(SECOND)
    (presence,) = bench.batches()
    for level in (2, 3):
        bench.publisher.publish((LEVEL, raised_to(level)))
    assert bench.batches() == [presence]
    bench.clock.advance(50 * MS)
    _, levels = bench.batches()
    assert [record.topic for record in levels.records] == [LEVEL, LEVEL]  # the keys stay here
    bench.publisher.publish(
        (CUE, m.CueGiven(attempt=1, trial=1, presentation=1, side="left", gaze="left"))
    )
    bench.clock.advance(50 * MS)
    assert [record.topic for record in bench.batches()[-1].records] == [CUE]
    assert (presence.number, levels.number) == (1, 2)


def test_nothing_is_sent_for_a_short_time_while_a_prompt_is_on_its_way(bench: Bench) -> None:
    bench.receive(PeerJoined(ANNA))
    bench.clock.advance(SECOND)
    before = len(bench.batches())
    bench.publisher.publish((PROMPT, ON_ITS_WAY))
    bench.clock.advance(300 * MS)
    assert len(bench.batches()) == before
    bench.bus.publish(
        SHOWN, m.Shown(attempt=1, trial=1, presentation=1, at=bench.clock.now(), source="virtual")
    )
    bench.clock.advance(100 * MS)
    assert [record.topic for record in bench.batches()[-1].records] == [PROMPT, SHOWN]
    bench.publisher.publish((PROMPT, ON_ITS_WAY))
    bench.clock.advance(600 * MS)
    assert [record.topic for record in bench.batches()[-1].records] == [PROMPT], "never shown"


def test_samples_are_joined_by_seat(bench: Bench) -> None:
    bench.receive(PeerJoined(ANNA))
    bench.clock.advance(SECOND)
    for samples in (b"one", b"two"):
        bench.bus.publish(IMU, m.ImuBlock(samples=samples))
    bench.bus.publish(IMU, m.ImuBlock(seat="B", samples=b"three"))
    bench.clock.advance(100 * MS)
    assert bench.channel.sent[-2:] == [
        OutgoingSamples("A", b"onetwo"),
        OutgoingSamples("B", b"three"),
    ]


def test_full_channel_is_followed_by_snapshots_for_all(bench: Bench) -> None:
    bench.receive(PeerJoined(ANNA), PeerJoined(OLAF))
    bench.clock.advance(SECOND)
    bench.channel.is_full = True
    bench.publisher.publish((LEVEL, raised_to(4)))
    bench.clock.advance(5 * SECOND)
    bench.channel.is_full = False
    bench.clock.advance(2 * SECOND)
    assert {snapshot.name for snapshot in bench.snapshots()} == {ANNA, OLAF}
    for snapshot in bench.snapshots():
        assert raised_to(4) in [record.message for record in snapshot.records]


def test_broker_is_checked_while_the_node_is_attached(bench: Bench) -> None:
    bench.clock.advance(10 * SECOND)
    checks = bench.channel.checks
    assert checks >= 10
    bench.node.detach()
    bench.receive(PeerJoined(ANNA))
    bench.clock.advance(10 * SECOND)
    assert bench.channel.checks == checks
    assert bench.presence() == []


# --- the welcome


def welcome_of(name: str, **parameters: object) -> Welcome:
    """Return the welcome of a session of a task."""
    kind = Catalogue().task(name)
    people = {"A": "P01", "B": "P02"} if name == "pairs" else {"A": "P01"}
    return session_welcome(kind(build(kind.Parameters, parameters)), "s1", "l1", people)


def test_welcome_has_format_length_and_parameters_and_the_spoken_names_of_two() -> None:
    welcome = welcome_of("keyboard", attempts=5, practice_attempts=2, prompts_per_attempt=7)
    assert (welcome.unit, welcome.decimals, welcome.spoken_names) == ("ms", 0, {})
    assert (welcome.attempts, welcome.trials) == (7, 7)
    assert welcome.parameters["prompts_per_attempt"] == 7
    assert welcome_of("pairs").spoken_names == {"A": "Left", "B": "Right"}
    assert welcome_of("pairs", address="code").spoken_names == {"A": "P01", "B": "P02"}
