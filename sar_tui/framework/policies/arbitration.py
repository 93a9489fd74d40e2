"""Arbitration: whether a proposal is acted on, waits for an operator, or is left out. Pure (see the operator's modes).

Who waits for what: a mode for each kind of action says whether an operator has to decide; without an operator the
modes do not hold, and what they would have held back is done, or left out, as the session is set.
"""

from typing import Literal

import msgspec

from sar_tui.framework.clock import MS
from sar_tui.framework.messages import ControlledKind, Ground, Kind, Mode, PendingApproval, Proposal
from sar_tui.framework.settings.operator import OperatorSettings

RULED: dict[Kind, ControlledKind] = {
    "greeting": "instruction",
    "instruction": "instruction",
    "goodbye": "instruction",
    "encouragement": "encouragement",
    "rest": "encouragement",
    "feedback": "feedback",
    "gesture": "gesture",
    "difficulty": "difficulty",
}
"""Whose mode a kind goes by. What is not here is nobody's to rule over: an operator's own, and what covers a wait."""


class Arbitration(msgspec.Struct, frozen=True):
    """The modes that are set, and whether there is an operator, so that they hold."""

    modes: dict[ControlledKind, Mode]
    operated: bool = False

    def mode(self, kind: Kind) -> Mode:
        """The mode that is set for a kind of action, whether or not anybody is there."""
        return self.modes[RULED[kind]] if kind in RULED else "autonomous"


class Verdict(msgspec.Struct, frozen=True):
    """What becomes of a proposal at once, and on what ground; an ``offer`` waits for an operator."""

    what: Literal["act", "drop", "offer"]
    ground: Ground = "mode"
    offer: PendingApproval | None = None


def start(parameters: OperatorSettings) -> Arbitration:
    """The modes a session begins with; nobody is there yet."""
    return Arbitration(
        {
            "feedback": parameters.operator_feedback,
            "encouragement": parameters.operator_encouragement,
            "instruction": parameters.operator_instruction,
            "gesture": parameters.operator_gesture,
            "difficulty": parameters.operator_difficulty,
        }
    )


def choose(state: Arbitration, kind: ControlledKind, mode: Mode) -> Arbitration:
    """The modes after one is set."""
    return msgspec.structs.replace(state, modes={**state.modes, kind: mode})


def rule(
    state: Arbitration, parameters: OperatorSettings, proposal: Proposal, now: int, level: int | None = None
) -> Verdict:
    """What becomes of a proposal made at ``now`` (ns).

    An offer falls due after the operator's time; of feedback that is given after a fixed delay, with that, so that its
    moment does not tell who decided.
    """
    mode = state.mode(proposal.kind)
    if mode == "autonomous":
        return Verdict("act")
    if not state.operated:
        return Verdict("act" if parameters.operator_lost == "autonomous" else "drop", "no operator")
    deadline = proposal.due if proposal.due > now else now + parameters.operator_time_ms * MS
    offer = PendingApproval(seat=proposal.seat, proposal=proposal, mode=mode, level=level)
    if mode != "manual":
        otherwise = "act" if mode == "veto" else parameters.operator_timeout
        offer = msgspec.structs.replace(offer, deadline=deadline, otherwise=otherwise)
    return Verdict("offer", offer=offer)


def is_apart(state: Arbitration, parameters: OperatorSettings, proposal: Proposal) -> bool:
    """Whether a proposal's gesture is ruled on apart from its words, because its mode is not the agent's own."""
    if not proposal.gesture or proposal.kind not in RULED:
        return False
    return state.mode("gesture") != "autonomous" and (state.operated or parameters.operator_lost == "silent")


def is_owed(offer: PendingApproval) -> bool:
    """Whether the session waits for an offer: it is an answer or a change of level, and decided by a set time."""
    return offer.deadline is not None and offer.proposal.kind in ("feedback", "difficulty")
