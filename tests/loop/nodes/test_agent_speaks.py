"""Trials wait while the agent speaks."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop import topics as t
from sar_tui.loop.bus import Record, Topic
from sar_tui.loop.node import Node, on
from sar_tui.model.messages import Message, Proposal
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.node import OutputNode
from sar_tui.outputs.output import Output
from sar_tui.plugins import Catalogue
from tests.facts import each, facts
from tests.lifting_task import LiftDriver, lifting
from tests.loop_driver import LoopDriver
from tests.outputs.fake_outputs import Speaker

CATALOGUE = Catalogue()
KEYBOARD, CALM = CATALOGUE.task("keyboard"), CATALOGUE.theme("calm")
FIXED = {"foreperiod_min_ms": 900, "foreperiod_max_ms": 900, "quiet_ms": 500}
TWO = {"prompts_per_attempt": 2, "attempts": 2}
GREETED = 13 * SECOND
"""When the greeting is over: it takes three seconds, as every utterance."""


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


def session(
    at: str = "trial", output: Output | None = None, wait_ms: int = 0, **settings: Any
) -> LoopDriver:
    """Start a keyboard session with an agent that speaks, wait, and go on to its first trial."""
    speech = OutputNode(output or Speaker(3000), "speech", CALM)
    driver = LoopDriver(KEYBOARD, CALM, extra=[speech], **{**TWO, **FIXED, **settings})
    driver.wait(wait_ms)
    if at == "trial":
        driver.enter()
        driver.press("enter")
    return driver


def lift_session(**settings: Any) -> LiftDriver:
    """Start a session of the lifting task with the same agent."""
    speech = OutputNode(Speaker(3000), "speech", CALM)
    return lifting("instructions", extra=[speech, Prompter()], **{**FIXED, **settings})


def is_acting(driver: LoopDriver) -> bool:
    return bool(driver.all(t.ACTING)) and driver.last(t.ACTING).acting


def last_time(driver: LoopDriver, topic: Topic[Any]) -> int:
    return [record.at for record in driver.records if record.topic is topic][-1]


def when_still(driver: LoopDriver) -> int:
    """Return when the agent last became silent."""
    acting = [record for record in driver.records if record.topic is t.ACTING]
    return [record.at for record in acting if not record.message.acting][-1]


# --- with a foreperiod


def test_the_first_foreperiod_waits_for_the_end_of_the_greeting() -> None:
    driver = session("instructions")
    assert is_acting(driver)
    driver.enter()
    driver.press("enter")
    assert facts(driver.waiting, "what stage") == ("agent", "trial")
    driver.to_prompt()
    assert when_still(driver) == GREETED
    shown = last_time(driver, t.PROMPT)
    assert shown - GREETED == 900 * MS, "no key was pressed for long"
    waits = ["agent", "quiet", "foreperiod", "response"]
    assert each(driver.all(t.WAITING), "what")[-4:] == waits


def test_keys_while_the_agent_speaks_are_no_false_starts_but_delay_the_foreperiod() -> None:
    driver = session()
    driver.wait((GREETED - driver.clock.now()) / MS - 100)
    driver.press("f")
    pressed = driver.clock.now()
    assert driver.waiting.what == "agent"
    driver.to_prompt()
    assert last_time(driver, t.PROMPT) - pressed == (500 + 900) * MS
    driver.press("#")
    assert driver.last(t.TRIAL).timing.false_starts == 0


def test_feedback_and_encouragement_are_spoken_to_their_end_before_the_next_trial() -> None:
    driver = session(wait_ms=10_000)
    for _ in range(2):
        driver.answer(300)
    driver.wait(0)
    assert (driver.last(t.ACTION).kind, is_acting(driver)) == ("feedback", True)
    driver.wait(200)
    driver.press("enter")
    assert driver.last(t.ATTEMPT_STARTED).attempt == 2
    assert driver.waiting.what == "agent"
    driver.to_prompt()
    assert each(driver.all(t.ACTION), "kind")[-2:] == ["feedback", "encouragement"]
    assert when_still(driver) - last_time(driver, t.FEEDBACK) == 2 * 3 * SECOND
    assert last_time(driver, t.PROMPT) - when_still(driver) == 900 * MS


def test_the_stop_key_lets_the_trial_come_at_once() -> None:
    driver = session(output=Speaker(60_000))
    driver.wait(2000)
    assert driver.waiting.what == "agent"
    driver.operate("stop")
    stopped_at = driver.clock.now()
    driver.to_prompt()
    assert last_time(driver, t.PROMPT) - stopped_at == 900 * MS
    stopped = [("speech", stopped_at, stopped_at, "")]
    assert each(driver.all(t.STOPPED), "output asked at detail") == stopped


def test_a_pause_silences_the_agent_at_once() -> None:
    driver = session(output=Speaker(5000))
    driver.operate("pause")
    driver.wait(0)
    assert driver.last(t.HALT).reason == "left"
    assert not is_acting(driver)
    driver.wait(1000)
    driver.operate("resume")
    driver.to_prompt()


# --- with a key that starts each trial


def test_no_trial_can_be_started_while_the_agent_speaks() -> None:
    driver = lift_session()
    driver.enter()
    driver.press("enter")
    assert facts(driver.waiting, "what stage") == ("agent", "trial")
    driver.press("space")
    driver.wait((GREETED - driver.clock.now()) / MS - 100)
    assert driver.waiting.what == "agent"
    assert driver.all(t.PROMPT) == [], "a key pressed meanwhile starts nothing"
    driver.wait(100)
    assert driver.waiting.what == "start"
    driver.lift()
    assert driver.last(t.TRIAL).correct


@pytest.mark.parametrize("signal", [False, True])
def test_an_utterance_begun_before_the_start_key_ends_before_the_trial_continues(
    signal: bool,
) -> None:
    """A greeting may wait behind a long utterance, and come then."""
    driver = lift_session(signal=signal)
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
    assert last_time(driver, t.PROMPT) - when_still(driver) == (900 * MS if signal else 0)


# --- arbitrary input

KEYS = "enter enter space right tab f k u d".split()
PRESSES = st.lists(st.tuples(st.integers(0, 2500), st.sampled_from(KEYS)), max_size=60)
TASKS: dict[str, dict[str, Any]] = {
    "keyboard": {"prompts_per_attempt": 2},
    "lift": {},
    "lift on a signal": {"signal": True},
    "lifts by themselves": {"by_itself": True},
}


@given(
    PRESSES,
    st.integers(1, 6000),
    st.sampled_from([0, 800, 2500]),
    st.sampled_from(["every", "request", "summary"]),
    st.sampled_from(["keyboard", "lift", "lift on a signal", "lifts by themselves"]),
)
def test_prompts_and_speech_never_overlap(
    presses: list[tuple[int, str]], takes_ms: int, delay_ms: int, schedule: str, which: str
) -> None:
    feedback = {"feedback_delay_ms": delay_ms, "feedback_schedule": schedule, "feedback_every": 2}
    settings = {"attempts": 3, "rest_every": 1, "foreperiod_max_ms": 700, **feedback}
    extra = [OutputNode(Speaker(takes_ms), "speech", CALM)]
    if which == "keyboard":
        driver = LoopDriver(KEYBOARD, CALM, extra=extra, **settings, **TASKS[which])
    else:
        driver = lifting("instructions", extra=extra, **settings, **TASKS[which])
    for after_ms, key in presses:
        driver.wait(after_ms)
        is_shown = driver.screen.onset is not None and driver.screen.prompt
        driver.press(driver.last(t.PROMPT).expected if key == "right" and is_shown else key)
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
        awaits = record.message.what in ("foreperiod", "storage", "response")
        return speaking, record.message.stage == "trial" and awaits
    return speaking, up
