"""A session that is cut off anywhere can be replayed and resumed without loss."""

import functools
from collections.abc import Callable, Iterable
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop import topics as t
from sar_tui.loop.bus import Record, Topic
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.loop.replay_comparison import is_same
from sar_tui.loop.session import ReplayError, Session
from sar_tui.loop.task import Task
from sar_tui.model.messages import Fault, Prompt, Stored, TrialEnded
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE
from tests.facts import each
from tests.loop_driver import LoopDriver

CATALOGUE = Catalogue()
KEYBOARD, CALM = CATALOGUE.task("keyboard"), CATALOGUE.theme("calm")
SHORT = {"attempts": 4, "practice_attempts": 1, "prompts_per_attempt": 3}
SET_UP = {**SHORT, "start_level": 4, "min_accuracy": 0.6}


def new_task(**changed: Any) -> Task:
    return KEYBOARD(build(KEYBOARD.Parameters, {**SET_UP, **changed}))


class Disk(Node):
    """Acknowledges every trial at once."""

    name = "disk"
    emits = (t.STORED,)

    @on(t.TRIAL)
    def ended(self, trial: TrialEnded) -> None:
        self.emit(t.STORED, Stored(attempt=trial.attempt, trial=trial.trial))


class Simulated:
    """A session with a simulated participant, either new or resumed from a record."""

    def __init__(self, history: list[Record] | None = None) -> None:
        task = new_task()
        self.clock = VirtualClock(7 * SECOND if history is None else 14 * SECOND)
        extra = [SimulatedParticipant(PEOPLE["average"], task, 3), Disk()]
        self.session = Session(task, CALM, self.clock, 3, extra)
        self.cascades: list[list[Record]] = []
        if history is not None:
            self.session.replay(history)
        self.session.bus.tap(self.cascades.append)
        self.session.begin(1 if history is None else 2)

    def finish(self) -> "Simulated":
        while not self.session.ended and self.clock.step():
            pass
        return self

    @property
    def records(self) -> list[Record]:
        return joined(self.cascades)


@functools.cache
def whole() -> Simulated:
    return Simulated().finish()


def joined(cascades: list[list[Record]]) -> list[Record]:
    return [record for cascade in cascades for record in cascade]


def cut(at: int) -> list[Record]:
    return joined(whole().cascades[:at])


def said(records: Iterable[Record], topic: Topic[Any]) -> list[Any]:
    return [record.message for record in records if record.topic is topic]


def shape(records: list[Record], topic: Topic[Any]) -> list[Any]:
    """Return the messages without time stamps, which differ between runs."""
    messages = said(records, topic)
    if topic is t.TRIAL:
        times = [one.reaction_time_ms and round(one.reaction_time_ms, 6) for one in messages]
        names = "attempt trial stimulus response correct timing.foreperiod_ms"
        return [*zip(each(messages, names), times, strict=True)]
    stamps = {"started", "ended", "metric", "due"}
    plain = [msgspec.to_builtins(message) for message in messages]
    return [{name: one[name] for name in one.keys() - stamps} for one in plain]


def test_replaying_a_whole_session_derives_it_again() -> None:
    session = whole()
    assert {*each(said(session.records, t.TRIAL), "correct")} == {True, False}
    assert len({*each(said(session.records, t.ATTEMPT_ENDED), "level")}) > 1
    again = Session(session.session.task, session.session.theme, VirtualClock(), 3)
    derived: list[list[Record]] = []
    again.bus.tap(derived.append)
    again.replay(session.records)
    assert joined(derived) == session.records
    assert again.ended


@given(st.data())
def test_a_session_cut_off_anywhere_continues_as_if_it_had_not_been(data: st.DataObject) -> None:
    session = whole()
    before = cut(data.draw(st.integers(0, len(session.cascades) - 1), label="cascades before it"))
    rest = Simulated(before).finish()
    assert rest.session.faults == []
    all_of_it = before + rest.records
    for topic in (t.TRIAL, t.ATTEMPT_ENDED, t.FEEDBACK, t.SESSION_ENDED):
        assert shape(all_of_it, topic) == shape(session.records, topic)
    assert [record.seq for record in all_of_it] == list(range(1, len(all_of_it) + 1))


def moments() -> dict[str, int]:
    """Return the numbers of cascades after which the session waits for each kind of event."""
    found: dict[str, int] = {}
    for number, cascade in enumerate(whole().cascades, 1):
        for waiting in said(cascade, t.WAITING):
            found.setdefault(f"{waiting.stage}: {waiting.what}", number)
    return found


@pytest.mark.parametrize(
    "moment", ["trial: quiet", "trial: foreperiod", "trial: response", "attempt: enter"]
)
def test_a_resumed_session_waits_for_enter_and_says_it_was_interrupted(moment: str) -> None:
    waiting = said(Simulated(cut(moments()[moment])).records, t.WAITING)
    assert each(waiting, "what stage reason") == [("enter", "paused", "interrupted")]


@pytest.mark.parametrize("at", [0, 1])
def test_a_session_cut_off_in_its_instructions_shows_them_again(at: int) -> None:
    waiting = said(Simulated(cut(at)).records, t.WAITING)
    assert each(waiting, "what stage") == [("enter", "instructions")]


def test_an_unanswered_prompt_is_shown_again_under_its_number() -> None:
    before = cut(moments()["trial: response"])
    unanswered = said(before, t.PROMPT)[-1]
    again = said(Simulated(before).finish().records, t.PROMPT)[0]
    presentation = unanswered.presentation + 1
    assert again == msgspec.structs.replace(unanswered, presentation=presentation)


# --- a record that was changed


def replay(records: Iterable[Record], **changed: Any) -> None:
    Session(new_task(**changed), CALM, VirtualClock(), 3).replay(records)


def with_change(place: int, **changes: Any) -> list[Record]:
    """Return the record with another message at a place."""
    records = list(whole().records)
    message = msgspec.structs.replace(records[place].message, **changes)
    records[place] = records[place]._replace(message=message)
    return records


def places(of: Callable[[Record], bool]) -> list[int]:
    return [place for place, record in enumerate(whole().records) if of(record)]


DERIVED = st.deferred(lambda: st.sampled_from(places(lambda one: one.topic.origin == "derived")))


@given(DERIVED)
def test_a_derived_message_that_was_changed_removed_or_duplicated_is_noticed(place: int) -> None:
    records = whole().records
    record = records[place]
    with pytest.raises(ReplayError, match=rf"Message {record.seq} \({record.topic.name}\)"):
        replay(with_change(place, seat="B"))
    with pytest.raises(ReplayError):
        replay([*records[:place], *records[place + 1 :]])
    with pytest.raises(ReplayError):
        replay([*records[:place], record, *records[place:]])


def test_a_replay_reads_a_record_as_it_goes_and_no_further_than_a_difference() -> None:
    place = places(lambda record: record.topic is t.TRIAL)[0]
    records = with_change(place, seat="B")
    read: list[int] = []
    history = (read.append(record.seq) or record for record in records)  # type: ignore[func-returns-value]
    with pytest.raises(ReplayError):
        replay(history)
    assert read[-1] == records[place].seq


def test_a_corrected_sentence_does_not_stop_a_replay() -> None:
    records = list(whole().records)
    for place, record in enumerate(records):
        changed = {"text", "notice", "attempt_name"} & set(record.message.__struct_fields__)
        if record.topic.origin == "derived" and changed:
            reworded = dict.fromkeys(changed, "As an earlier version said it.")
            message = msgspec.structs.replace(record.message, **reworded)
            records[place] = record._replace(message=message)
    assert records != whole().records
    replay(records)


def test_numbers_that_another_processor_rounds_differently_do_not_stop_a_replay() -> None:
    trial = said(whole().records, t.TRIAL)[0]

    def measured(smoothness: float, speeds: list[float], **changed: Any) -> TrialEnded:
        details = {"ldlj_out": smoothness, "speeds": speeds}
        return msgspec.structs.replace(trial, details=details, **changed)

    recorded = measured(-5.256055605931666, [0.0, 1.5])
    assert is_same(recorded, measured(-5.256055605931665, [1e-17, 1.5000000000000002]))
    assert not is_same(recorded, measured(-5.2560557, [0.0, 1.5]))
    assert not is_same(recorded, measured(-5.256055605931666, [0.0]))
    assert not is_same(recorded, measured(-5.256055605931665, [0.0, 1.5], trial=trial.trial + 1))


def test_a_failure_is_the_same_wherever_the_code_that_failed_stands() -> None:
    def failed(error: str, line: int) -> Fault:
        where = {"place": f"line {line} of task.py", "trace": f"line {line}"}
        return Fault(node="task", topic="input/key", error=error, **where)

    assert is_same(failed("KeyError: 3", 12), failed("KeyError: 3", 14))
    assert not is_same(failed("KeyError: 3", 12), failed("KeyError: 4", 12))


def test_a_record_that_ends_in_the_middle_of_a_cascade_is_noticed() -> None:
    for at in (10, 50, len(whole().cascades) - 1):
        *whole_cascades, last = whole().cascades[: at + 1]
        while len(last) == 1:
            *whole_cascades, last = whole_cascades
        with pytest.raises(ReplayError, match="incomplete"):
            replay(joined([*whole_cascades, last[:-1]]))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("prompts_per_attempt", 4),
        ("threshold", 500),
        ("choice_set", "left hand"),
        ("foreperiod_min_ms", 700),
    ],
)
def test_a_task_that_was_changed_since_is_noticed(name: str, value: Any) -> None:
    with pytest.raises(ReplayError, match="has changed since"):
        replay(whole().records, **{name: value})


# --- resuming


def test_after_a_replay_the_clock_is_the_sessions_own_and_no_old_timer_fires() -> None:
    driver = LoopDriver(KEYBOARD, CALM)
    driver.enter()
    driver.press("enter")
    resumed = LoopDriver(KEYBOARD, CALM, history=driver.records)
    assert resumed.session.bus.clock is resumed.clock
    resumed.wait(600_000)
    assert resumed.all(t.TIMER) == []
    assert resumed.waiting.reason == "interrupted"


class Clumsy(Node):
    """A screen that raises."""

    name = "clumsy"

    @on(t.PROMPT)
    def prompted(self, _: Prompt) -> None:
        raise RuntimeError("no such widget")


def test_a_session_in_which_an_output_raised_can_be_resumed() -> None:
    driver = LoopDriver(KEYBOARD, CALM, extra=[Clumsy()], prompts_per_attempt=2)
    driver.start()
    driver.answer()
    driver.to_prompt()
    assert {fault.node for fault in driver.session.faults} == {"clumsy"}
    assert driver.session.broken is None
    resumed = LoopDriver(KEYBOARD, CALM, history=driver.records, prompts_per_attempt=2)
    assert resumed.records[0].seq == driver.records[-1].seq + 1
    assert resumed.waiting.reason == "interrupted"
    resumed.press("enter")
    assert resumed.answer().trial == 2


def test_no_message_identifies_the_session_or_the_participant() -> None:
    for topic in t.ALL.values():
        assert not {"session", "participant", "person", "code"} & set(topic.type.__struct_fields__)
