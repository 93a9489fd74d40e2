"""The participant sees the operator's decisions and nothing else of the panel."""

from typing import Literal

import pytest

from sar_tui.loop.topics import (
    ACTION,
    ARBITER_STATE,
    COMMAND,
    DECISION,
    PENDING_APPROVAL,
    PRESENCE,
)
from sar_tui.model import messages as m
from sar_tui.plugins import Catalogue
from tests.app.app_driver import AppDriver, OpenSession
from tests.app.fake_voice import Voice

APPROVE = {"operator_feedback": "approve", "operator_time_ms": 20_000, "encouragement": False}
ANA = "operator.ana"
EDITED = "You held on [b]well[/b]."


async def to_proposal(driver: AppDriver) -> m.PendingApproval:
    """Continue to the end of the first attempt, and leave the proposal undecided for 1.5 s."""
    states: list[m.ArbiterState] = []
    driver.session.bus.subscribe(ARBITER_STATE, states.append)
    driver.session.bus.post(PRESENCE, m.OperatorChanged(actor=ANA, state="joined", operated=True))
    await driver.do_attempt(await driver.to_first_prompt())
    await driver.wait(1500)
    return states[-1].pending[0]


@pytest.mark.parametrize(("verdict", "text"), [("accept", ""), ("veto", ""), ("edit", EDITED)])
async def test_a_filler_disappears_after_the_wait_and_only_the_decision_is_shown(
    open_session: OpenSession,
    catalogue: Catalogue,
    verdict: Literal["accept", "veto", "edit"],
    text: str,
) -> None:
    async with open_session(**APPROVE) as driver:
        pending = await to_proposal(driver)
        assert driver.said in catalogue.theme("calm").phrases["filler"]
        assert "Press Enter" not in driver.text
        decision = m.Decision(action=pending.proposal.id, verdict=verdict, actor=ANA, text=text)
        driver.session.bus.post(DECISION, decision)
        await driver.settle()
        shown = {"accept": pending.proposal.text, "veto": "", "edit": EDITED}
        assert driver.said == shown[verdict], "the words that were decided on, whole"
        assert "Press Enter for attempt 2 of 2." in driver.text
        for word in ("operator", "ana", "approve"):
            assert word not in driver.text.lower().split()


VETO_GOODBYE = {
    "attempts": 1, "operator_instruction": "veto", "operator_time_ms": 4000, "encouragement": False,
}  # fmt: skip


@pytest.mark.parametrize("is_vetoed", [False, True])
async def test_the_goodbye_precedes_the_end_unless_it_is_vetoed(
    open_session: OpenSession, is_vetoed: bool
) -> None:
    async with open_session(**VETO_GOODBYE) as driver:
        said: list[str] = []
        asked: list[m.PendingApproval] = []
        bus = driver.session.bus
        bus.subscribe(ACTION, lambda action: said.append(action.kind))
        bus.subscribe(PENDING_APPROVAL, asked.append)
        bus.post(PRESENCE, m.OperatorChanged(actor=ANA, state="joined", operated=True))
        await driver.do_attempt(await driver.to_first_prompt())
        await driver.wait(10_000)
        await driver.see_the_summary()
        proposal = asked[-1].proposal
        assert proposal.kind == "goodbye"
        assert "One moment…" in driver.text
        await driver.press("enter")
        assert driver.screen_name == "SessionScreen"
        if is_vetoed:
            bus.post(DECISION, m.Decision(action=proposal.id, verdict="veto", actor=ANA))
            await driver.wait(300)
            assert "goodbye" not in said
        else:
            await driver.wait(10_000)
            assert said[-1] == "goodbye"
            assert driver.said == proposal.text
        assert "Press Enter to finish." in driver.text
        await driver.press("enter")
        assert driver.app.live is not None
        assert driver.app.live.is_closed


async def test_a_goodbye_that_was_waited_for_is_heard_to_its_end(
    open_session: OpenSession, catalogue: Catalogue, voice: Voice
) -> None:
    async with open_session(outputs=["screen", "voice"], **VETO_GOODBYE) as driver:
        driver.session.bus.post(
            PRESENCE, m.OperatorChanged(actor=ANA, state="joined", operated=True)
        )
        driver.session.bus.post(COMMAND, m.SessionCommand(command="end", actor=ANA))
        await driver.wait(10_000)
        await voice.end(driver)  # the greeting
        assert voice.asked[-1][1] in catalogue.theme("calm").phrases["goodbye_early"]
        assert "One moment…" in driver.text
        await driver.press("enter")
        assert driver.screen_name == "SessionScreen"
        await voice.begin(driver)
        await voice.end(driver)
        assert "Press Enter to finish." in driver.text
        await driver.wait(300)
        await driver.press("enter")
        assert driver.app.live is not None
        assert driver.app.live.is_closed
