"""An edit changes only what the operator changed; deadlines are taken in order."""

from typing import Any

import pytest

from sar_tui.loop.action_queue import accepted, edited
from sar_tui.loop.approvals import PendingApprovals
from sar_tui.model.messages import Action, Decision, PendingApproval, Proposal
from sar_tui.model.theme import Theme
from sar_tui.model.units import SECOND
from tests.facts import facts

LOOKS: Any = {"face": "happy", "gesture": "nod", "tone": "success", "degree": "strong"}
SAID: Any = {"text": "Well done.", "spoken": "Well done.", "valence": "positive"}
PRAISE = Proposal(id="a1", kind="feedback", **SAID, **LOOKS)


def edit(theme: Theme, proposal: Proposal = PRAISE, **changes: Any) -> Action:
    decision = Decision(action="a1", verdict="edit", actor="operator.ana", **changes)
    return edited(accepted(proposal), decision, theme, at=7)


def pending(name: str, deadline: int | None) -> PendingApproval:
    return PendingApproval(
        proposal=Proposal(id=name, kind="feedback", text=name), mode="veto", deadline=deadline
    )


def test_an_edited_valence_replaces_face_gesture_tone_and_degree(calm: Theme) -> None:
    action = edit(calm, valence="negative")
    assert facts(action, "face gesture tone degree") == ("encouraging", "lean_in", "", "clear")
    expected = ("Well done.", "edited", "operator.ana", 7)
    assert facts(action, "text decision actor decided") == expected


def test_an_edited_valence_adds_no_gesture_to_a_proposal_without_one(calm: Theme) -> None:
    still = Proposal(id="a1", kind="feedback", text="Well done.", valence="positive")
    assert edit(calm, still, valence="negative").gesture == ""


def test_edited_text_is_spoken_as_the_theme_does(calm: Theme) -> None:
    action = edit(calm, text="412 ms.")
    assert (action.text, action.spoken) == ("412 ms.", "412 milliseconds.")
    assert (action.face, action.degree) == ("happy", "strong")


def test_an_edited_gesture_overrides_that_of_the_valence(calm: Theme) -> None:
    assert edit(calm, valence="negative", gesture="wave").gesture == "wave"
    assert edit(calm, gesture="").gesture == ""


@pytest.mark.parametrize(
    "same", [{"text": "Well done."}, {"valence": "positive"}, {"gesture": "nod"}]
)
def test_an_edit_with_the_same_values_is_an_acceptance(calm: Theme, same: dict[str, str]) -> None:
    action = edit(calm, **same)
    assert (action.decision, action.degree, action.actor) == ("accepted", "strong", "operator.ana")


def test_proposals_are_due_by_deadline_and_those_without_one_stay() -> None:
    approvals = PendingApprovals()
    for name, deadline in (("late", 3 * SECOND), ("soon", SECOND), ("never", None)):
        approvals.add(pending(name, deadline))
    assert approvals.next_deadline == SECOND
    assert [due.proposal.id for due in approvals.take_due(SECOND)] == ["soon"]
    assert [due.proposal.id for due in approvals.take_due(10 * SECOND)] == ["late"]
    assert approvals.next_deadline is None
    assert [waiting.proposal.id for waiting in approvals.waiting] == ["never"]
