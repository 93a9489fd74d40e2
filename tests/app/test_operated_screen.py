"""Given an operator, when they decide, then the participant sees what was decided, and nothing of the rest."""

from pathlib import Path

import pytest

from sar_tui.framework import messages as m
from sar_tui.framework.task import Task
from sar_tui.framework.topics import DECISION, PRESENCE, STANDING
from sar_tui.plugins import Catalogue
from tests.app.chair import Chair, plan, sit_down

APPROVE = {"operator_feedback": "approve", "operator_time_ms": 20_000, "encouragement": False}
ANA = "operator.ana"


async def to_offer(chair: Chair) -> m.Offer:
    """To the end of the first attempt, with an operator who has not decided for a second and a half."""
    standing: list[m.Standing] = []
    chair.session.bus.subscribe(STANDING, standing.append)
    chair.session.bus.post(PRESENCE, m.OperatorChanged(actor=ANA, state="joined", operated=True))
    await chair.do_attempt(await chair.to_first_prompt())
    await chair.wait(1500)
    return standing[-1].offers[0]


async def decide(chair: Chair, offer: m.Offer, verdict: str, **how: object) -> None:
    told = m.Decision(action=offer.proposal.id, verdict=verdict, actor=ANA, **how)  # type: ignore[arg-type]
    chair.session.bus.post(DECISION, told)
    await chair.settle()


@pytest.mark.parametrize("verdict", ["accept", "veto"])
async def test_what_covered_the_wait_is_gone_with_it_and_only_what_was_decided_stands(
    data: Path, catalogue: Catalogue, keyboard: type[Task], verdict: str
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, **APPROVE)) as chair:
        offer = await to_offer(chair)
        assert chair.said in catalogue.theme("calm").phrases["filler"]
        assert "Press Enter" not in chair.text
        await decide(chair, offer, verdict)
        assert chair.said == (offer.proposal.text if verdict == "accept" else "")
        assert "Press Enter to begin attempt 2 of 2." in chair.text


async def test_what_is_edited_stands_there_in_the_operators_words_alone(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, **APPROVE)) as chair:
        offer = await to_offer(chair)
        await decide(chair, offer, "edit", text="You held on [b]well[/b].")
        assert chair.said == "You held on [b]well[/b]."
        for word in ("operator", "ana", "approve"):
            assert word not in chair.text.lower().split()
