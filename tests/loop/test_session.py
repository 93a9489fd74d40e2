"""A session that is cut off anywhere can be replayed and resumed without loss."""

import functools
from collections.abc import Iterable
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.bus import Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.loop.replay_comparison import is_same
from sar_tui.loop.session import ReplayError, Session
from sar_tui.loop.task import Task
from sar_tui.loop.topics import (
    ALL,
    ATTEMPT_ENDED,
    FEEDBACK,
    KEY,
    PROMPT,
    SESSION,
    SESSION_ENDED,
    STORED,
    TIMER,
    TRIAL,
    WAITING,
)
from sar_tui.model.messages import Fault, Prompt, Stored, TrialEnded
from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE
from tests.loop_driver import LoopDriver

SET_UP = {
    "attempts": 4,
    "practice_attempts": 1,
    "prompts_per_attempt": 3,
    "start_level": 4,
    "min_accuracy": 0.6,
}


class Disk(Node):
    """Acknowledges every trial at once."""

    name = "disk"
    emits = (STORED,)

    @on(TRIAL)
    def ended(self, trial: TrialEnded) -> None:
        self.emit(STORED, Stored(attempt=trial.attempt, trial=trial.trial))


class Simulated:
    """A session with a simulated participant, either new or resumed from a record."""

    def __init__(
        self, history: list[Record] | None = None, seed: int = 3, run: int = 2, **changed: Any
    ) -> None:
        catalogue = Catalogue()
        kind = catalogue.task("keyboard")
        task = kind(build(kind.Parameters, {**SET_UP, **changed}))
        self.clock = VirtualClock(7_000_000_000 * (run if history is not None else 1))
        extra = [SimulatedParticipant(PEOPLE["average"], task, seed), Disk()]
        self.session = Session(task, catalogue.theme("calm"), self.clock, seed, extra)
        self.cascades: list[list[Record]] = []
        if history is not None:
            self.session.replay(history)
        self.session.bus.tap(self.cascades.append)
        self.session.begin(1 if history is None else run)

    def finish(self) -> "Simulated":
        while not self.session.ended and self.clock.step():
            pass
        return self

    @property
    def records(self) -> list[Record]:
        return [record for cascade in self.cascades for record in cascade]


@functools.cache
def whole() -> Simulated:
    return Simulated().finish()


def shape(records: list[Record], *topics: Any) -> list[Any]:
    """Return the messages without time stamps, which differ between runs."""
    chosen = []
    for record in records:
        message = record.message
        if record.topic not in topics:
            continue
        if isinstance(message, TrialEnded):
            timing = message.timing.foreperiod_ms
            chosen.append(
                (
                    message.attempt,
                    message.trial,
                    message.stimulus,
                    message.response,
                    message.correct,
                    timing,
                )
            )
        else:
            plain = msgspec.to_builtins(message)
            for stamp in ("started", "ended", "metric", "due"):
                plain.pop(stamp, None)
            chosen.append((record.topic.name, plain))
    return chosen


def reaction_times(records: list[Record]) -> list[float | None]:
    return [
        message.reaction_time_ms and round(message.reaction_time_ms, 6)
        for record in records
        if isinstance(message := record.message, TrialEnded)
    ]


def test_the_whole_session_has_enough_cascades_to_cut() -> None:
    session = whole()
    trials = [record.message for record in session.records if record.topic is TRIAL]
    assert len(trials) == 15
    assert session.session.ended
    assert {t.correct for t in trials} == {True, False}
    levels = [record.message.level for record in session.records if record.topic is ATTEMPT_ENDED]
    assert len(set(levels)) > 1


def test_replaying_a_whole_session_derives_it_again() -> None:
    records = whole().records
    again = Session(whole().session.task, whole().session.theme, VirtualClock(), 3)
    derived: list[list[Record]] = []
    again.bus.tap(derived.append)
    again.replay(records)
    assert [record for cascade in derived for record in cascade] == records
    assert again.ended


def cut(at: int) -> list[Record]:
    return [record for cascade in whole().cascades[:at] for record in cascade]


@given(st.data())
def test_a_session_cut_off_anywhere_continues_as_if_it_had_not_been(data: st.DataObject) -> None:
    session = whole()
    at = data.draw(st.integers(0, len(session.cascades) - 1), label="cascades before the cut")
    before = cut(at)
    rest = Simulated(before).finish()
    assert rest.session.faults == []
    joined = before + rest.records
    for topics in ([TRIAL], [ATTEMPT_ENDED], [FEEDBACK], [SESSION_ENDED]):
        assert shape(joined, *topics) == shape(session.records, *topics)
    assert reaction_times(joined) == reaction_times(session.records)


@given(st.data())
def test_a_session_cut_off_twice_continues_too(data: st.DataObject) -> None:
    session = whole()
    first = cut(
        data.draw(st.integers(0, len(session.cascades) - 1), label="cascades before the first cut")
    )
    second_run = Simulated(first).finish()
    length = data.draw(
        st.integers(1, len(second_run.cascades)), label="cascades before the second cut"
    )
    before = [*first, *(record for cascade in second_run.cascades[:length] for record in cascade)]
    if any(record.topic is SESSION_ENDED for record in before):
        return
    third_run = Simulated(before, run=3).finish()
    joined = before + third_run.records
    assert shape(joined, TRIAL) == shape(session.records, TRIAL)
    assert shape(joined, ATTEMPT_ENDED) == shape(session.records, ATTEMPT_ENDED)


@given(st.integers(0, 10_000))
def test_a_resumed_session_continues_the_message_numbers(at: int) -> None:
    before = cut(at % len(whole().cascades))
    joined = before + Simulated(before).records
    assert [record.seq for record in joined] == list(range(1, len(joined) + 1))


def moments() -> dict[str, int]:
    """Return the numbers of cascades after which the session waits for each kind of event."""
    found = {}
    for number, cascade in enumerate(whole().cascades, 1):
        for record in cascade:
            if record.topic is WAITING:
                found.setdefault(f"{record.message.stage}: {record.message.what}", number)
    return found


@pytest.mark.parametrize(
    "moment", ["trial: quiet", "trial: foreperiod", "trial: response", "attempt: enter"]
)
def test_a_resumed_session_waits_for_enter_and_says_it_was_interrupted(moment: str) -> None:
    waiting = [r.message for r in Simulated(cut(moments()[moment])).records if r.topic is WAITING]
    assert [(w.what, w.stage, w.reason) for w in waiting] == [("enter", "paused", "interrupted")]


def test_a_session_cut_off_in_its_instructions_shows_them_again() -> None:
    for at in (0, 1):
        waiting = [r.message for r in Simulated(cut(at)).records if r.topic is WAITING]
        assert [(w.what, w.stage) for w in waiting] == [("enter", "instructions")]


def test_an_unanswered_prompt_is_shown_again_under_its_number() -> None:
    before = cut(moments()["trial: response"])
    unanswered = [record.message for record in before if record.topic is PROMPT][-1]
    again = next(
        record.message for record in Simulated(before).finish().records if record.topic is PROMPT
    )
    assert isinstance(again, Prompt)
    assert again == msgspec.structs.replace(unanswered, presentation=unanswered.presentation + 1)


def test_a_session_cut_off_between_its_last_trial_and_the_acknowledgement_waits_for_enter_and_is_complete() -> (
    None
):
    last = max(
        number
        for number, cascade in enumerate(whole().cascades, 1)
        if any(r.topic is TRIAL for r in cascade)
    )
    resumed = Simulated(cut(last))
    assert [(r.message.what, r.message.stage) for r in resumed.records if r.topic is WAITING] == [
        ("enter", "review")
    ]
    records = resumed.finish().records
    assert [r.message.status for r in records if r.topic is SESSION_ENDED] == ["completed"]
    assert not any(r.topic is TRIAL for r in records)


def replay(records: Iterable[Record], **changed: Any) -> None:
    kind = Catalogue().task("keyboard")
    task = kind(build(kind.Parameters, {**SET_UP, **changed}))
    Session(task, Catalogue().theme("calm"), VirtualClock(), 3).replay(records)


def test_an_unchanged_record_can_be_replayed() -> None:
    replay(whole().records)


@given(st.data())
def test_a_derived_message_that_was_changed_is_noticed(data: st.DataObject) -> None:
    records = list(whole().records)
    places = [i for i, record in enumerate(records) if record.topic.origin == "derived"]
    place = data.draw(st.sampled_from(places))
    record = records[place]
    records[place] = record._replace(message=msgspec.structs.replace(record.message, seat="B"))
    with pytest.raises(ReplayError, match=rf"Message {record.seq} \({record.topic.name}\)"):
        replay(records)


def test_a_replay_reads_a_record_as_it_goes_and_no_further_than_a_difference() -> None:
    records = list(whole().records)
    place = next(i for i, record in enumerate(records) if record.topic is TRIAL)
    records[place] = records[place]._replace(
        message=msgspec.structs.replace(records[place].message, seat="B")
    )
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
            records[place] = record._replace(
                message=msgspec.structs.replace(record.message, **reworded)
            )
    assert records != whole().records
    replay(records)


def test_numbers_that_another_processor_rounds_differently_do_not_stop_a_replay() -> None:
    trial = next(
        record.message for record in whole().records if isinstance(record.message, TrialEnded)
    )

    def measured(smoothness: float, speeds: list[float], **changed: Any) -> TrialEnded:
        return msgspec.structs.replace(
            trial, details={"ldlj_out": smoothness, "speeds": speeds}, **changed
        )

    recorded = measured(-5.256055605931666, [0.0, 1.5])
    assert is_same(recorded, measured(-5.256055605931665, [1e-17, 1.5000000000000002]))
    assert not is_same(recorded, measured(-5.2560557, [0.0, 1.5]))
    assert not is_same(recorded, measured(-5.256055605931666, [0.0]))
    assert not is_same(recorded, measured(-5.256055605931665, [0.0, 1.5], trial=trial.trial + 1))


def test_a_failure_is_the_same_wherever_the_code_that_failed_stands() -> None:
    def failed(error: str, line: int) -> Fault:
        return Fault(
            node="task",
            topic="input/key",
            error=error,
            place=f"line {line} of task.py",
            trace=f"line {line}",
        )

    assert is_same(failed("KeyError: 3", 12), failed("KeyError: 3", 14))
    assert not is_same(failed("KeyError: 3", 12), failed("KeyError: 4", 12))


@given(st.data())
def test_a_removed_or_duplicated_message_is_noticed(data: st.DataObject) -> None:
    records = list(whole().records)
    places = [i for i, record in enumerate(records) if record.topic.origin == "derived"]
    place = data.draw(st.sampled_from(places))
    with pytest.raises(ReplayError):
        replay([*records[:place], *records[place + 1 :]])
    with pytest.raises(ReplayError):
        replay([*records[:place], records[place], *records[place:]])


def test_a_record_that_ends_in_the_middle_of_a_cascade_is_noticed() -> None:
    for at in (10, 50, len(whole().cascades) - 1):
        *whole_cascades, last = whole().cascades[: at + 1]
        while len(last) == 1:
            *whole_cascades, last = whole_cascades
        with pytest.raises(ReplayError, match="incomplete"):
            replay([record for cascade in (*whole_cascades, last[:-1]) for record in cascade])


def test_a_response_that_was_changed_is_noticed() -> None:
    records = list(whole().records)
    enters = 0
    for place, record in enumerate(records):
        if record.topic is KEY:
            enters += 1
            if enters == 3:
                records[place] = record._replace(
                    message=msgspec.structs.replace(record.message, key="#")
                )
    with pytest.raises(ReplayError):
        replay(records)


@pytest.mark.parametrize(
    "changed",
    [
        {"prompts_per_attempt": 4},
        {"threshold": 500},
        {"choice_set": "left hand"},
        {"foreperiod_min_ms": 700},
    ],
)
def test_a_task_that_was_changed_since_is_noticed(changed: dict[str, Any]) -> None:
    with pytest.raises(ReplayError, match="has changed since"):
        replay(whole().records, **changed)


def test_a_replay_uses_the_recorded_theme() -> None:
    edited = Catalogue().theme("high-contrast")
    again = Session(whole().session.task, edited, VirtualClock(), 3)
    again.replay(whole().records)
    assert again.ended


def test_after_a_replay_the_clock_is_the_sessions_own_and_no_old_timer_fires(
    keyboard: type[Task], calm: Theme
) -> None:
    driver = LoopDriver(keyboard, calm)
    driver.enter()
    driver.press("enter")
    resumed = LoopDriver(keyboard, calm, history=driver.records)
    assert resumed.session.bus.clock is resumed.clock
    resumed.wait(600_000)
    assert resumed.all(TIMER) == []
    assert resumed.waiting.reason == "interrupted"


class Clumsy(Node):
    """A screen that raises."""

    name = "clumsy"

    @on(PROMPT)
    def prompted(self, _: Prompt) -> None:
        raise RuntimeError("no such widget")


def test_a_session_in_which_an_output_raised_can_be_resumed(
    keyboard: type[Task], calm: Theme
) -> None:
    driver = LoopDriver(keyboard, calm, extra=[Clumsy()], prompts_per_attempt=2)
    driver.start()
    driver.answer()
    driver.to_prompt()
    assert {fault.node for fault in driver.session.faults} == {"clumsy"}
    assert driver.session.broken is None
    resumed = LoopDriver(keyboard, calm, history=driver.records, prompts_per_attempt=2)
    assert resumed.records[0].seq == driver.records[-1].seq + 1
    assert resumed.waiting.reason == "interrupted"
    resumed.press("enter")
    assert resumed.answer().trial == 2


def test_no_message_identifies_the_session_or_the_participant() -> None:
    for topic in ALL.values():
        assert not {"session", "participant", "person", "code"} & set(topic.type.__struct_fields__)


def test_every_message_can_be_encoded_and_decoded() -> None:
    for record in whole().records:
        text = msgspec.json.encode(record.message)
        assert msgspec.json.decode(text, type=record.topic.type) == record.message


def test_a_new_session_publishes_its_task_theme_and_seed(keyboard: type[Task], calm: Theme) -> None:
    driver = LoopDriver(keyboard, calm, seed=12)
    started = driver.last(SESSION)
    assert (started.run, started.task, started.theme, started.seed) == (1, "keyboard", "calm", 12)
