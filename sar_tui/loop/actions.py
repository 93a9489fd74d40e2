"""Builds actions from proposals, operators' edits and operators' remarks. Pure."""

from msgspec.structs import replace

from sar_tui.model.messages import Action, Decision, Ground, PendingApproval, Proposal, Remark
from sar_tui.model.theme import Theme

OPERATOR_PRIORITY = 50
"""Priority of an operator's own words: higher than that of anything the agent proposes."""


def accepted(
    proposal: Proposal,
    actor: str = "agent",
    ground: Ground = "mode",
    pending: PendingApproval | None = None,
    at: int = 0,
) -> Action:
    """Return a proposal as an action, unchanged, decided by ``actor`` at ``at`` (ns)."""
    fields = {name: getattr(proposal, name) for name in proposal.__struct_fields__}
    mode = pending.mode if pending else "autonomous"
    return Action(**fields, decision="accepted", actor=actor, mode=mode, ground=ground, decided=at)


def edited(action: Action, decision: Decision, theme: Theme, at: int) -> Action:
    """Return an action as an operator edited it at ``at`` (ns); an edit without a change keeps its
    ``decision``.
    """
    changes: dict[str, object] = {}
    if decision.valence is not None and decision.valence != action.valence:
        manner = theme.manner(decision.valence)
        changes |= {
            "valence": decision.valence,
            "face": manner.face,
            "tone": manner.tone,
            "degree": "clear",
        }
        if action.gesture:
            changes["gesture"] = manner.gesture
    if decision.text is not None and decision.text != action.text:
        changes |= {"text": decision.text, "spoken": theme.spoken(decision.text)}
    if decision.gesture is not None and decision.gesture != action.gesture:
        changes["gesture"] = decision.gesture
    how = "edited" if changes else action.decision
    return replace(
        action, **changes, decision=how, actor=decision.actor, ground="operator", decided=at
    )


def initiated(remark: Remark, id: str, theme: Theme, at: int) -> Action:
    """Return an operator's own words or gesture as an action, in the manner of the theme."""
    manner = theme.manner(remark.valence or "remark")
    return Action(
        seat=remark.seat,
        id=id,
        kind="remark" if remark.text else "gesture",
        text=remark.text,
        spoken=theme.spoken(remark.text),
        face=remark.face or (manner.face if remark.text else ""),
        gesture=remark.gesture or (manner.gesture if remark.valence else ""),
        gaze=remark.gaze or ("ahead" if remark.text else ""),
        tone=manner.tone if remark.valence else "",
        valence=remark.valence,
        priority=OPERATOR_PRIORITY,
        decision="initiated",
        actor=remark.actor,
        mode="manual",
        ground="operator",
        decided=at,
    )


def gesture_of(proposal: Proposal) -> Proposal:
    """Return a proposal's gesture as a proposal of its own."""
    return replace(
        proposal,
        id=f"{proposal.id}.gesture",
        kind="gesture",
        text="",
        spoken="",
        face="",
        gaze="",
        tone="",
        policy="drop",
        joins=True,
    )
