"""Arbitration: decides if a proposal is acted on, waits for an operator, or is dropped. Pure.

Each kind of action has a mode, which determines whether an operator has to decide. Without an
operator the modes do not apply; the setting ``operator_lost`` determines whether actions that would
have waited are done or dropped.
"""

from collections.abc import Collection
from typing import Literal

import msgspec

from sar_tui.model.messages import ControlledKind, Ground, Kind, Mode, PendingApproval, Proposal
from sar_tui.model.units import MS, SECOND
from sar_tui.rules.parameters import TaskParameters

CONTROLLED: dict[Kind, ControlledKind] = {
    "greeting": "instruction",
    "instruction": "instruction",
    "goodbye": "instruction",
    "encouragement": "encouragement",
    "rest": "encouragement",
    "feedback": "feedback",
    "gesture": "gesture",
    "difficulty": "difficulty",
}
"""The kind whose mode applies to each kind of action. Others always act: an operator's own remarks,
and fillers.
"""


CHOOSING = 2 * SECOND
"""Time to notice a proposal and, once it is read, to choose and press a key."""
_FIRST: tuple[Kind, ...] = ("feedback", "difficulty")
"""Kinds that come before anything else between two attempts."""


class Arbitration(msgspec.Struct, frozen=True):
    """The modes that are set. They apply while there is an operator (``operated``)."""

    modes: dict[ControlledKind, Mode]
    operated: bool = False

    def mode(self, kind: Kind) -> Mode:
        """Return the mode of a kind of action, with or without an operator."""
        return self.modes[CONTROLLED[kind]] if kind in CONTROLLED else "autonomous"


class Verdict(msgspec.Struct, frozen=True):
    """The decision on a proposal and its ground. ``pending`` is the approval to wait for."""

    outcome: Literal["act", "drop", "wait"]
    ground: Ground = "mode"
    pending: PendingApproval | None = None


def start(parameters: TaskParameters) -> Arbitration:
    """Return the modes at the start of a session, without an operator."""
    return Arbitration(
        {
            "feedback": parameters.operator_feedback,
            "encouragement": parameters.operator_encouragement,
            "instruction": parameters.operator_instruction,
            "gesture": parameters.operator_gesture,
            "difficulty": parameters.operator_difficulty,
        }
    )


def set_mode(state: Arbitration, kind: ControlledKind, mode: Mode) -> Arbitration:
    """Return the modes after a change of one."""
    return msgspec.structs.replace(state, modes={**state.modes, kind: mode})


def decide(
    state: Arbitration,
    parameters: TaskParameters,
    proposal: Proposal,
    now: int,
    level: int | None = None,
    pending: Collection[PendingApproval] = (),
) -> Verdict:
    """Decide on a proposal made at ``now`` (ns), while others are ``pending``.

    The operator has the time that `time_to_decide` returns. For feedback with a fixed delay it is
    that delay instead, so that its timing does not show who decided.
    """
    mode = state.mode(proposal.kind)
    if mode == "autonomous":
        return Verdict("act")
    if not state.operated:
        return Verdict("act" if parameters.operator_lost == "autonomous" else "drop", "no operator")
    approval = PendingApproval(seat=proposal.seat, proposal=proposal, mode=mode, level=level)
    if mode != "manual":
        undecided = [one.proposal for one in pending if one.deadline]
        waits = time_to_decide(parameters, [*undecided, proposal])
        deadline = proposal.due if proposal.due > now else now + waits
        otherwise = "act" if mode == "veto" else parameters.operator_timeout
        approval = msgspec.structs.replace(approval, deadline=deadline, otherwise=otherwise)
    return Verdict("wait", pending=approval)


def time_to_decide(parameters: TaskParameters, proposals: Collection[Proposal]) -> int:
    """Return the time (ns) to read proposals one after the other and decide on each; at least
    ``operator_time_ms``.
    """
    least = parameters.operator_time_ms * MS
    if not parameters.operator_ms_per_word:
        return least
    words = sum(len((one.text or one.spoken).split()) for one in proposals)
    return max(least, words * parameters.operator_ms_per_word * MS + len(proposals) * CHOOSING)


def is_gesture_separate(state: Arbitration, parameters: TaskParameters, proposal: Proposal) -> bool:
    """Return True if a proposal's gesture is decided separately from its text: its mode is not
    autonomous.
    """
    if not proposal.gesture or proposal.kind not in CONTROLLED:
        return False
    return state.mode("gesture") != "autonomous" and (
        state.operated or parameters.operator_lost == "silent"
    )


def is_awaited(pending: PendingApproval) -> bool:
    """Return True if no attempt begins before a decision: it has a deadline, so that nothing that
    is due is lost.
    """
    return pending.deadline is not None


def comes_first(pending: PendingApproval) -> bool:
    """Return True if encouragement and rest wait for a decision: on feedback or a change of level,
    with a deadline.
    """
    return pending.deadline is not None and pending.proposal.kind in _FIRST
