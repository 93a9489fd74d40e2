"""Trials wait while the agent speaks."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop import topics as t
from sar_tui.loop.bus import Record, Topic
from sar_tui.loop.node import Node, on
from sar_tui.loop.task import Task
from sar_tui.model.messages import Message, Proposal
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.node import TIMEOUT, OutputNode
from sar_tui.outputs.output import Output
from sar_tui.plugins import Catalogue
from tests.facts import facts
from tests.lifting_task import Lift, LiftDriver
from tests.loop_driver import LoopDriver
from tests.outputs.fake_outputs import FakeOutput, Speaker

NewSession = Callable[..., Any]
FIXED = {"foreperiod_min_ms": 900, "foreperiod_max_ms": 900, "quiet_ms": 500}


class Speak(Message, frozen=True, kw_only=True):
    """Request that makes the agent speak now."""


SPEAK = Topic("test/speak", Speak, origin="input")


class Prompter(Node):
    """Makes the agent speak on request of a test."""

    name = "prompter"
    emits = (t.PROPOSED,)

    @on(SPEAK)
    def speak(self, _: Speak) -> None:
        self.emit(t.PROPOSED, Proposal(id="now", kind="greeting", text="Hello.", spoken="Hello."))


@pytest.fixture
def new_session(keyboard: type[Task], calm: Theme) -> NewSession:
    """Start a keyboard session with an agent whose every utterance takes three seconds."""

    def start(output: Output | None = None, **settings: Any) -> LoopDriver:
        speech = OutputNode(output or Speaker(3000), "speech", calm)
        return LoopDriver(
            keyboard,
            calm,
            extra=[speech],
            **{"prompts_per_attempt": 2, "attempts": 2, **FIXED, **settings},
        )

    return start


@pytest.fixture
def new_lift_session(calm: Theme) -> NewSession:
    """Start a session of the lifting task with the same agent."""

    def start(output: Output | None = None, **settings: Any) -> LiftDriver:
        speech = OutputNode(output or Speaker(3000), "speech", calm)
        return LiftDriver(
            Lift, calm, extra=[speech, Prompter()], **{"attempts": 2, **FIXED, **settings}
        )

    return start


def is_acting(driver: LoopDriver) -> bool:
    return bool(driver.all(t.ACTING)) and driver.last(t.ACTING).acting


def when_still(driver: LoopDriver) -> int:
    """Return when the agent last became silent."""
    return [
        record.at
        for record in driver.records
        if record.topic is t.ACTING and not record.message.acting
    ][-1]


def shown_at(driver: LoopDriver) -> int:
    return [record.at for record in driver.records if record.topic is t.PROMPT][-1]


# --- with a foreperiod


def test_the_first_foreperiod_waits_for_the_end_of_the_greeting(new_session: NewSession) -> None:
    driver = new_session()
    assert is_acting(driver)
    driver.enter()
    driver.press("enter")
    assert (driver.waiting.what, driver.waiting.stage) == ("agent", "trial")
    driver.to_prompt()
    assert when_still(driver) == 13 * SECOND
    assert shown_at(driver) - when_still(driver) == 900 * MS, "no key was pressed for long"
    assert [record.message.what for record in driver.records if record.topic is t.WAITING][-4:] == [
        "agent",
        "quiet",
        "foreperiod",
        "response",
    ]


def test_spoken_instructions_stop_when_the_participant_continues(new_session: NewSession) -> None:
    driver = new_session()
    driver.wait(4000)
    assert driver.last(t.ACTION).kind == "instruction"
    driver.enter()
    assert driver.last(t.HALT).reason == "left"
    assert not is_acting(driver)
    hurried = new_session()
    hurried.enter()
    hurried.press("enter")
    hurried.to_prompt()
    assert [dropped.reason for dropped in hurried.all(t.DROPPED)] == ["late"]


def test_keys_pressed_while_the_agent_speaks_are_no_false_starts_but_delay_the_foreperiod(
    new_session: NewSession,
) -> None:
    driver = new_session()
    driver.enter()
    driver.press("enter")
    driver.wait((13 * SECOND - driver.clock.now()) / MS - 100)
    driver.press("f")
    pressed = driver.clock.now()
    assert driver.waiting.what == "agent"
    driver.to_prompt()
    assert shown_at(driver) - pressed == (500 + 900) * MS
    driver.press("#")
    assert driver.last(t.TRIAL).timing.false_starts == 0


def test_encouragement_that_waits_for_feedback_is_spoken_before_the_next_trial(
    new_session: NewSession,
) -> None:
    driver = new_session()
    driver.wait(10_000)
    driver.enter()
    driver.begin_attempt()
    driver.answer(300)
    driver.answer(300)
    driver.wait(200)
    driver.press("enter")
    assert driver.waiting.what == "agent"
    began = [record.at for record in driver.records if record.topic is t.FEEDBACK][-1]
    driver.to_prompt()
    assert [action.kind for action in driver.all(t.ACTION)][-2:] == ["feedback", "encouragement"]
    assert when_still(driver) - began == 6 * SECOND


def test_feedback_is_spoken_to_its_end_before_the_next_trial(new_session: NewSession) -> None:
    driver = new_session(encouragement=False)
    driver.wait(10_000)
    driver.enter()
    driver.press("enter")
    for _ in range(2):
        driver.answer(300)
    driver.wait(0)
    assert (driver.last(t.ACTION).kind, is_acting(driver)) == ("feedback", True)
    driver.wait(200)
    driver.press("enter")
    assert driver.all(t.ATTEMPT_STARTED)[-1].attempt == 2
    assert driver.waiting.what == "agent"
    began = [record.at for record in driver.records if record.topic is t.FEEDBACK][-1]
    driver.to_prompt()
    assert when_still(driver) - began == 3 * SECOND
    assert shown_at(driver) - when_still(driver) == 900 * MS


def test_feedback_interrupts_a_greeting(new_session: NewSession) -> None:
    """The trials held the greeting back; it is spoken between them."""
    driver = new_session(Speaker(60_000), prompts_per_attempt=1, attempts=1)
    driver.operate("stop")
    driver.enter()
    driver.attempt()
    assert driver.last(t.ACTION).kind == "feedback"
    driver.press("enter")
    driver.wait(0)
    assert driver.last(t.ACTION).kind == "feedback", "the goodbye waits until it has been heard"
    driver.wait(60_000)
    assert driver.last(t.ACTION).kind == "goodbye"


def test_the_stop_key_lets_the_trial_come_at_once(new_session: NewSession) -> None:
    driver = new_session(Speaker(60_000))
    driver.enter()
    driver.press("enter")
    driver.wait(2000)
    assert driver.waiting.what == "agent"
    driver.operate("stop")
    stopped_at = driver.clock.now()
    driver.to_prompt()
    assert shown_at(driver) - stopped_at == 900 * MS
    (stopped,) = driver.all(t.STOPPED)
    assert facts(stopped, "output asked at detail") == ("speech", stopped_at, stopped_at, "")


def test_a_stop_in_a_trial_changes_nothing_in_it(new_session: NewSession) -> None:
    driver = new_session()
    driver.wait(10_000)
    driver.start()
    driver.wait(200)
    driver.operate("stop")
    driver.wait(100)
    driver.press(driver.screen.prompt.expected)
    assert driver.last(t.TRIAL).reaction_time_ms == 300.0


def test_a_hanging_output_delays_the_session_for_a_limited_time(new_session: NewSession) -> None:
    driver = new_session(FakeOutput("speech", frozenset({"say"})))
    driver.enter()
    driver.press("enter")
    driver.to_prompt()
    assert driver.clock.now() <= 10 * SECOND + 3 * TIMEOUT
    assert {report.state for report in driver.all(t.REPORT)} == {"queued", "failed"}


def test_a_pause_silences_the_agent_at_once(new_session: NewSession) -> None:
    driver = new_session(Speaker(5000))
    driver.enter()
    driver.press("enter")
    driver.operate("pause")
    driver.wait(0)
    assert driver.last(t.HALT).reason == "left"
    assert not is_acting(driver)
    driver.wait(1000)
    driver.operate("resume")
    driver.to_prompt()


def test_a_session_cut_off_while_the_agent_speaks_can_be_resumed(
    new_session: NewSession, keyboard: type[Task], calm: Theme
) -> None:
    driver = new_session()
    driver.enter()
    driver.press("enter")
    assert driver.waiting.what == "agent"
    settings = {"prompts_per_attempt": 2, "attempts": 2, **FIXED}
    resumed = LoopDriver(keyboard, calm, history=driver.records, **settings)
    resumed.press("enter")
    assert resumed.to_prompt().trial == 1
    assert not is_acting(resumed)


# --- with a key that starts each trial


def test_no_trial_can_be_started_while_the_agent_speaks(new_lift_session: NewSession) -> None:
    driver = new_lift_session()
    driver.enter()
    driver.press("enter")
    assert (driver.waiting.what, driver.waiting.stage) == ("agent", "trial")
    driver.press("space")
    driver.wait((13 * SECOND - driver.clock.now()) / MS - 100)
    assert driver.waiting.what == "agent"
    assert driver.all(t.PROMPT) == [], "a key pressed meanwhile starts nothing"
    driver.wait(100)
    assert driver.waiting.what == "start"
    driver.lift()
    assert driver.last(t.TRIAL).correct


@pytest.mark.parametrize("signal", [False, True])
def test_an_utterance_begun_before_the_start_key_ends_before_the_trial_continues(
    new_lift_session: NewSession, signal: bool
) -> None:
    """A greeting may wait behind a long utterance, and come then."""
    driver = new_lift_session(signal=signal)
    driver.wait(10_000)
    driver.begin_lifts()
    assert driver.waiting.what == "start"
    driver.session.bus.publish(SPEAK, Speak())
    assert is_acting(driver)
    driver.press("space")
    pressed = driver.clock.now()
    if not signal:
        assert driver.waiting.what == "agent"
    assert driver.to_prompt().started == pressed
    assert shown_at(driver) - when_still(driver) == (900 * MS if signal else 0)


# --- arbitrary input

CATALOGUE = Catalogue()
CALM = CATALOGUE.theme("calm")
KEYS = st.lists(
    st.tuples(
        st.integers(0, 2500),
        st.sampled_from(["enter", "enter", "space", "right", "tab", "f", "k", "u", "d"]),
    ),
    max_size=60,
)


@given(
    KEYS,
    st.integers(1, 6000),
    st.sampled_from([0, 800, 2500]),
    st.sampled_from(["every", "request", "summary"]),
    st.sampled_from(["keyboard", "lift", "lift on a signal", "lifts by themselves"]),
)
def test_prompts_and_speech_never_overlap(
    keys: list[tuple[int, str]], takes_ms: int, delay_ms: int, schedule: str, which: str
) -> None:
    kind = CATALOGUE.task("keyboard") if which == "keyboard" else Lift
    own: dict[str, Any] = {
        "keyboard": {"prompts_per_attempt": 2},
        "lift": {},
        "lift on a signal": {"signal": True},
        "lifts by themselves": {"by_itself": True},
    }[which]
    settings = {
        "attempts": 3,
        "feedback_delay_ms": delay_ms,
        "feedback_schedule": schedule,
        "rest_every": 1,
    }
    extra = [OutputNode(Speaker(takes_ms), "speech", CALM)]
    driver = LoopDriver(
        kind, CALM, extra=extra, feedback_every=2, foreperiod_max_ms=700, **settings, **own
    )
    for after_ms, key in keys:
        driver.wait(after_ms)
        expected = (
            driver.screen.prompt.expected
            if driver.screen.onset is not None and driver.screen.prompt
            else key
        )
        driver.press(expected if key == "right" else key)
    driver.wait(20_000)
    assert driver.session.faults == []
    speaking, up = False, False
    for record in driver.records:
        speaking, up = _after(record, speaking, up)
        assert not (speaking and up), f"message {record.seq}: {record.topic.name}"
    if not driver.all(t.SESSION_ENDED):
        assert driver.waiting.what not in ("agent", "answer"), "nothing hangs"


def _after(record: Record, speaking: bool, up: bool) -> tuple[bool, bool]:
    """Return if the agent speaks, and if a prompt is shown or about to come, after a message."""
    if record.topic is t.ACTING:
        return record.message.acting, up
    if record.topic is t.WAITING:
        in_trial = record.message.stage == "trial" and record.message.what in (
            "foreperiod",
            "storage",
            "response",
        )
        return speaking, in_trial
    return speaking, up
