"""A session follows its operator's protocol: what is due, ticks, and the same again in a replay."""

from typing import Any

import pytest

from sar_tui.loop import topics as t
from sar_tui.model import messages as m
from sar_tui.model.protocol import ProtocolRule, ProtocolStep, WizardProtocol
from sar_tui.plugins import Catalogue
from sar_tui.rules.protocol_file import parse_condition
from tests.loop_driver import LoopDriver

CATALOGUE = Catalogue()
RULES = tuple(
    ProtocolRule(parse_condition(when), when, do)
    for when, do in (("accuracy >= 0 % twice", "say greeting"), ("timeouts >= 1", "Help them."))
)
STEPS = (
    ProtocolStep("start", "say greeting"),
    ProtocolStep("after attempt", "Offer water.", 1),
    ProtocolStep("pause", "Ask why."),
    ProtocolStep("end", "Thank them."),
)
PROTOCOL = WizardProtocol("kind", 1, "h", steps=STEPS, rules=RULES)
ANA = "operator.ana"
SETTINGS: dict[str, Any] = {"attempts": 2, "prompts_per_attempt": 2, "encouragement": False}


@pytest.fixture
def driver() -> LoopDriver:
    kind, theme = CATALOGUE.task("keyboard"), CATALOGUE.theme("calm")
    return LoopDriver(kind, theme, **SETTINGS)


def act(driver: LoopDriver, topic: Any, kind: Any, **fields: Any) -> None:
    fields |= {"actor": ANA, "at": driver.clock.now()}
    driver.session.bus.publish(topic, kind(**fields))


def due(driver: LoopDriver) -> list[str]:
    return [one.message.do for one in driver.records if one.topic is t.PROTOCOL_DUE]  # type: ignore[attr-defined]


def answers(driver: LoopDriver) -> list[tuple[str, str]]:
    given: list[Any] = [one.message for one in driver.records if one.topic is t.ANSWERED]
    return [(answer.id, answer.outcome) for answer in given]


def test_steps_and_rules_are_due_in_a_session_that_replays_identically(driver: LoopDriver) -> None:
    act(driver, t.PROTOCOL, m.ProtocolChosen, protocol=PROTOCOL, id="a1")
    assert (due(driver), answers(driver)) == (["say greeting"], [("a1", "done")])
    driver.enter()
    driver.attempt()
    assert due(driver)[1:] == ["Offer water."]
    for id in ("a2", "a3"):
        act(driver, t.PROTOCOL_TICKED, m.ProtocolTicked, due="d1", outcome="done", id=id)
    act(driver, t.REASON, m.ReasonGiven, action="p", verdict="veto", digit=1, text="x", id="a4")
    assert answers(driver)[1:] == [("a2", "done"), ("a3", "late"), ("a4", "done")]
    driver.operate("pause")
    driver.operate("resume")
    driver.operate("pause")
    driver.operate("resume")
    assert due(driver)[2:] == ["Ask why."] * 2
    driver.attempt()
    assert due(driver)[4:] == ["say greeting", "Thank them."]
    assert driver.difference() is None


def test_prompts_without_a_response_are_counted(driver: LoopDriver) -> None:
    act(driver, t.PROTOCOL, m.ProtocolChosen, protocol=PROTOCOL)
    driver.start()
    driver.until(lambda: "Offer water." in due(driver))
    assert "Help them." in due(driver)
    assert answers(driver) == [], "nobody awaits an answer to an act without an id"


def test_what_was_due_by_another_protocol_is_not_any_more(driver: LoopDriver) -> None:
    act(driver, t.PROTOCOL, m.ProtocolChosen, protocol=PROTOCOL)
    act(driver, t.PROTOCOL, m.ProtocolChosen, protocol=WizardProtocol("other", 1, "h2"))
    act(driver, t.PROTOCOL_TICKED, m.ProtocolTicked, due="d1", outcome="done", id="a1")
    assert answers(driver) == [("a1", "late")]


def test_a_pause_in_a_prompt_is_over_with_the_next_prompt(driver: LoopDriver) -> None:
    act(driver, t.PROTOCOL, m.ProtocolChosen, protocol=PROTOCOL)
    driver.start()
    for _ in range(2):
        driver.until(lambda: driver.waiting.stage == "trial")
        driver.operate("pause")
        driver.operate("resume")
    assert due(driver).count("Ask why.") == 2


def test_without_a_protocol_nothing_is_published(driver: LoopDriver) -> None:
    driver.enter()
    driver.attempt()
    assert due(driver) == []
    assert answers(driver) == []


def test_what_is_due_is_told_again_when_the_session_is_resumed(driver: LoopDriver) -> None:
    act(driver, t.PROTOCOL, m.ProtocolChosen, protocol=PROTOCOL)
    driver.enter()
    driver.attempt()
    act(driver, t.PROTOCOL_TICKED, m.ProtocolTicked, due="d1", outcome="done")
    before = driver.records
    again = LoopDriver(
        type(driver.session.task), CATALOGUE.theme("calm"), history=before, **SETTINGS
    )
    assert due(again) == ["Offer water.", "Ask why."], "it is paused when it is resumed"
    told: Any = next(one for one in again.records if one.topic is t.PROTOCOL_DUE)
    assert told.message.at == told.at, "by the clock of the new run"
    act(again, t.PROTOCOL_TICKED, m.ProtocolTicked, due="d2", outcome="done", id="a1")
    assert answers(again) == [("a1", "done")]
    again.records[:0] = before
    assert again.difference() is None
