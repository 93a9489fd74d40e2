"""The bus delivers messages so that causes come before effects."""

import threading

import pytest

from sar_tui.loop.bus import FAULT, Bus, Record, Service, Topic
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node, TimedNode, on, serves
from sar_tui.model.messages import Fault, Message
from tests.facts import each, facts


class Said(Message, frozen=True, kw_only=True):
    word: str


class Asked(Message, frozen=True, kw_only=True):
    number: int


IN = Topic("test/in", Said, origin="input")
OTHER_IN = Topic("test/other-in", Said, origin="input")
OUT = Topic("test/out", Said)
KEPT = Topic("test/kept", Said, keep=True)
STREAM = Topic("test/stream", Said, origin="input", stream=True)
DOUBLE = Service("test/double", Asked, Asked)


def said(word: str) -> Said:
    return Said(word=word)


@pytest.fixture
def clock() -> VirtualClock:
    return VirtualClock()


@pytest.fixture
def bus(clock: VirtualClock) -> Bus:
    return Bus(clock)


@pytest.fixture
def cascades(bus: Bus) -> list[list[Record]]:
    seen: list[list[Record]] = []
    bus.tap(seen.append)
    return seen


def words(cascade: list[Record]) -> list[str]:
    return [record.message.word for record in cascade if isinstance(record.message, Said)]


def test_a_topic_refuses_another_type_and_a_subclass_of_its_own(bus: Bus) -> None:
    class Shouted(Said, frozen=True, kw_only=True):
        pass

    with pytest.raises(TypeError, match="test/in carries Said, not Asked"):
        bus.publish(IN, Asked(number=1))  # type: ignore[misc]
    with pytest.raises(TypeError):
        bus.publish(IN, Shouted(word="hey"))


def test_a_publish_inside_a_handler_waits_until_the_handler_and_its_peers_are_done(
    bus: Bus,
) -> None:
    order: list[str] = []

    def causes(_: Said) -> None:
        order.append("cause begins")
        bus.publish(OUT, said("effect"))
        order.append("cause ends")

    bus.subscribe(IN, causes)
    bus.subscribe(IN, lambda _: order.append("peer"))
    bus.subscribe(OUT, lambda _: order.append("effect"))
    bus.publish(IN, said("go"))
    assert order == ["cause begins", "cause ends", "peer", "effect"]


def test_an_input_published_inside_a_cascade_begins_its_own_when_that_is_over(
    bus: Bus, cascades: list[list[Record]]
) -> None:
    def react(_: Said) -> None:
        bus.publish(OTHER_IN, said("next input"))
        bus.publish(OUT, said("effect"))

    bus.subscribe(IN, react)
    bus.publish(IN, said("input"))
    assert [words(cascade) for cascade in cascades] == [["input", "effect"], ["next input"]]


def test_a_cascade_has_one_time_and_its_messages_count_up(
    bus: Bus, clock: VirtualClock, cascades: list[list[Record]]
) -> None:
    def slow(_: Said) -> None:
        bus.publish(OUT, said("effect"))
        clock.set(clock.now() + 5)

    bus.subscribe(IN, slow)
    clock.set(100)
    bus.publish(IN, said("one"))
    clock.set(200)
    bus.publish(IN, said("two"))
    expected = [(1, 100), (2, 100), (3, 200), (4, 200)]
    assert [(record.seq, record.at) for cascade in cascades for record in cascade] == expected


def test_a_derived_message_without_a_cause_is_neither_published_nor_posted(
    bus: Bus, cascades: list[list[Record]]
) -> None:
    with pytest.raises(RuntimeError, match="test/out is derived"):
        bus.publish(OUT, said("from nowhere"))
    with pytest.raises(TypeError):
        bus.post(OUT, said("derived"))
    with pytest.raises(TypeError):
        bus.post(IN, Asked(number=1))  # type: ignore[misc]
    assert cascades == []


def test_another_thread_may_not_publish(bus: Bus, cascades: list[list[Record]]) -> None:
    refused: list[Exception] = []

    def intrude() -> None:
        try:
            bus.publish(IN, said("intruder"))
        except RuntimeError as error:
            refused.append(error)

    thread = threading.Thread(target=intrude)
    thread.start()
    thread.join()
    assert "use post()" in str(refused[0])
    assert cascades == []


def test_another_thread_may_post_and_the_owner_delivers(
    bus: Bus, clock: VirtualClock, cascades: list[list[Record]]
) -> None:
    served_on: list[int] = []
    bus.subscribe(IN, lambda _: served_on.append(threading.get_ident()))
    thread = threading.Thread(target=lambda: bus.post(IN, said("by post")))
    thread.start()
    thread.join()
    assert cascades == []
    clock.advance(0)
    assert [words(cascade) for cascade in cascades] == [["by post"]]
    assert served_on == [threading.get_ident()]


def test_a_handler_that_raises_publishes_a_fault_and_the_others_still_run(
    bus: Bus, cascades: list[list[Record]]
) -> None:
    served: list[str] = []

    def breaks(_: Said) -> None:
        raise ZeroDivisionError("no luck")

    bus.subscribe(IN, breaks, "clumsy")
    bus.subscribe(IN, lambda message: served.append(message.word), "steady")
    bus.publish(IN, said("one"))
    bus.publish(IN, said("two"))
    assert served == ["one", "two"]
    (fault, *rest) = [
        r.message for cascade in cascades for r in cascade if isinstance(r.message, Fault)
    ]
    assert facts(fault, "node topic error") == ("clumsy", "test/in", "ZeroDivisionError: no luck")
    assert "breaks" in fault.trace
    assert len(rest) == 1


def test_a_fault_handler_that_raises_ends_there(bus: Bus, cascades: list[list[Record]]) -> None:
    def breaks(_: Message) -> None:
        raise RuntimeError("again")

    bus.subscribe(IN, breaks)
    bus.subscribe(FAULT, breaks)
    bus.publish(IN, said("one"))
    assert [record.topic.name for record in cascades[0]] == ["test/in", "framework/fault"]


def test_a_service_answers_at_once_and_its_exception_is_the_callers(bus: Bus) -> None:
    def double(asked: Asked) -> Asked:
        if asked.number < 0:
            raise ValueError("negative")
        return Asked(number=2 * asked.number)

    bus.serve(DOUBLE, double)
    assert bus.call(DOUBLE, Asked(number=21)).number == 42
    with pytest.raises(ValueError, match="negative"):
        bus.call(DOUBLE, Asked(number=-1))
    with pytest.raises(TypeError, match="test/double takes Asked"):
        bus.call(DOUBLE, said("two"))  # type: ignore[misc]
    with pytest.raises(ValueError, match="served already"):
        bus.serve(DOUBLE, double)


def test_a_late_subscriber_gets_the_last_value_of_a_kept_topic_only(bus: Bus) -> None:
    def keep(message: Said) -> None:
        bus.publish(KEPT, message)
        bus.publish(OUT, message)

    bus.subscribe(IN, keep)
    bus.publish(IN, said("old"))
    bus.publish(IN, said("new"))
    late: list[str] = []
    bus.subscribe(KEPT, lambda message: late.append(message.word))
    bus.subscribe(OUT, lambda message: late.append("never"))
    assert late == ["new"]


def test_messages_of_a_stream_are_not_numbered(bus: Bus, cascades: list[list[Record]]) -> None:
    during: list[int] = []

    def react(message: Said) -> None:
        during.append(len(cascades))
        if message.word == "sample":
            bus.publish(OUT, said("found in the stream"))

    bus.subscribe(STREAM, react)
    bus.subscribe(OUT, react)
    bus.publish(STREAM, said("sample"))
    bus.publish(STREAM, said("another"))
    expected = [["sample", "found in the stream"], ["another"]]
    assert [words(cascade) for cascade in cascades] == expected
    assert [record.seq for cascade in cascades for record in cascade] == [1, 1, 2]
    assert during == [0, 0, 1]


def test_a_node_may_only_use_what_it_declares(bus: Bus) -> None:
    class Shy(Node):
        name = "shy"
        emits = (OUT,)

        @on(IN)
        def received(self, message: Said) -> None:
            self.emit(OUT, message)
            self.ask(DOUBLE, Asked(number=1))

        @serves(DOUBLE)
        def double(self, asked: Asked) -> Asked:
            return asked

    node = Shy()
    node.attach(bus)
    faults: list[Fault] = []
    bus.subscribe(FAULT, faults.append)
    bus.publish(IN, said("go"))
    assert (Shy.receives(), Shy.answers()) == ((IN,), (DOUBLE,))
    assert each(faults, "error") == ["ValueError: shy does not declare that it asks test/double"]
    with pytest.raises(ValueError, match="does not declare that it emits test/kept"):
        node.emit(KEPT, said("secret"))


class Alarm(TimedNode):
    name = "alarm"

    def __init__(self) -> None:
        super().__init__()
        self.fired: list[tuple[str, int]] = []

    def timer(self, name: str, late: int) -> None:
        self.fired.append((name, self.now))


def test_a_timer_fires_when_due_unless_cancelled_or_set_again(
    bus: Bus, clock: VirtualClock
) -> None:
    alarm = Alarm()
    alarm.attach(bus)
    alarm.set_timer("tea", 100)
    alarm.set_timer("bread", 50)
    alarm.set_timer("tea", 200)
    alarm.cancel_timer("bread")
    clock.advance(300)
    assert alarm.fired == [("tea", 200)]
