"""Proposals that wait for an operator's decision."""

from collections.abc import Callable

from sar_tui.framework.messages import PendingApproval
from sar_tui.framework.policies.arbitration import is_awaited


class PendingApprovals:
    """The proposals that wait, in the order in which they were made."""

    def __init__(self) -> None:
        self._waiting: dict[str, PendingApproval] = {}

    @property
    def waiting(self) -> tuple[PendingApproval, ...]:
        """All of them, the oldest first."""
        return tuple(self._waiting.values())

    @property
    def is_awaited(self) -> bool:
        """Whether the session waits for one of them."""
        return any(map(is_awaited, self._waiting.values()))

    @property
    def next_deadline(self) -> int | None:
        """When the next of them is decided without an operator (ns)."""
        return min((one.deadline for one in self._waiting.values() if one.deadline is not None), default=None)

    def add(self, pending: PendingApproval) -> None:
        """Let a proposal wait; one of the same id takes its place."""
        self._waiting[pending.proposal.id] = pending

    def take(self, id: str) -> PendingApproval | None:
        """It waits no longer; None where it does not."""
        return self._waiting.pop(id, None)

    def take_due(self, now: int) -> tuple[PendingApproval, ...]:
        """Those whose time is over."""
        return self.remove(lambda pending: pending.deadline is not None and pending.deadline <= now)

    def remove(self, which: Callable[[PendingApproval], bool] = lambda _: True) -> tuple[PendingApproval, ...]:
        """Some of them wait no longer; returns those."""
        gone = tuple(filter(which, self._waiting.values()))
        for pending in gone:
            del self._waiting[pending.proposal.id]
        return gone
