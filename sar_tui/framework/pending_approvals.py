"""What waits for an operator, and what becomes of it when they decide."""

from collections.abc import Callable

import msgspec

from sar_tui.framework.messages import Action, Decision, Ground, PendingApproval, Proposal
from sar_tui.framework.policies.arbitration import is_owed
from sar_tui.framework.theme import Theme


class PendingApprovals:
    """The proposals that wait, in the order in which they were made."""

    def __init__(self) -> None:
        self._waiting: dict[str, PendingApproval] = {}

    @property
    def waiting(self) -> tuple[PendingApproval, ...]:
        """All of them, the oldest first."""
        return tuple(self._waiting.values())

    @property
    def is_owing(self) -> bool:
        """Whether the session waits for one of them."""
        return any(map(is_owed, self._waiting.values()))

    @property
    def next_deadline(self) -> int | None:
        """When the next of them is decided without an operator (ns)."""
        return min((offer.deadline for offer in self._waiting.values() if offer.deadline is not None), default=None)

    def add(self, offer: PendingApproval) -> None:
        """Let a proposal wait; one of the same id takes its place."""
        self._waiting[offer.proposal.id] = offer

    def take(self, id: str) -> PendingApproval | None:
        """It waits no longer; None where it does not."""
        return self._waiting.pop(id, None)

    def take_due(self, now: int) -> tuple[PendingApproval, ...]:
        """Those whose time is over."""
        return self.clear(lambda offer: offer.deadline is not None and offer.deadline <= now)

    def clear(self, gives_up: Callable[[PendingApproval], bool] = lambda _: True) -> tuple[PendingApproval, ...]:
        """Some of them wait no longer; returns those."""
        gone = tuple(filter(gives_up, self._waiting.values()))
        for offer in gone:
            del self._waiting[offer.proposal.id]
        return gone


def accepted(
    proposal: Proposal, actor: str = "agent", ground: Ground = "mode", offer: PendingApproval | None = None, at: int = 0
) -> Action:
    """A proposal as it was made."""
    said = {name: getattr(proposal, name) for name in proposal.__struct_fields__}
    mode = offer.mode if offer else "autonomous"
    return Action(**said, decision="accepted", actor=actor, mode=mode, ground=ground, decided=at)


def edited(action: Action, decision: Decision, theme: Theme, at: int) -> Action:
    """What an operator made of something; if they changed nothing, it is accepted as it was."""
    changes: dict[str, object] = {}
    if decision.valence is not None and decision.valence != action.valence:
        manner = theme.manner(decision.valence)
        changes |= {"valence": decision.valence, "face": manner.face, "tone": manner.tone, "degree": "clear"}
        if action.gesture:
            changes["gesture"] = manner.gesture
    if decision.text is not None and decision.text != action.text:
        changes |= {"text": decision.text, "spoken": theme.spoken(decision.text)}
    if decision.gesture is not None and decision.gesture != action.gesture:
        changes["gesture"] = decision.gesture
    how = "edited" if changes else action.decision
    return msgspec.structs.replace(action, **changes, decision=how, actor=decision.actor, ground="operator", decided=at)
