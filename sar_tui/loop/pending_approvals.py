"""Proposals that wait for an operator's decision."""

from collections.abc import Callable

from sar_tui.model.messages import PendingApproval


class PendingApprovals:
    """The proposals that wait, in the order in which they were made."""

    def __init__(self) -> None:
        self._waiting: dict[str, PendingApproval] = {}

    @property
    def is_empty(self) -> bool:
        """True if no proposal waits."""
        return not self._waiting

    @property
    def waiting(self) -> tuple[PendingApproval, ...]:
        """The pending proposals, oldest first."""
        return tuple(self._waiting.values())

    @property
    def next_deadline(self) -> int | None:
        """The earliest deadline (ns), if there is one."""
        return min(
            (one.deadline for one in self._waiting.values() if one.deadline is not None),
            default=None,
        )

    def add(self, pending: PendingApproval) -> None:
        """Add a proposal; it replaces one with the same id."""
        self._waiting[pending.proposal.id] = pending

    def take(self, id: str) -> PendingApproval | None:
        """Remove and return a proposal by its id; None if it does not wait."""
        return self._waiting.pop(id, None)

    def take_due(self, now: int) -> tuple[PendingApproval, ...]:
        """Remove and return the proposals whose deadline has passed."""
        return self.remove(lambda pending: pending.deadline is not None and pending.deadline <= now)

    def remove(
        self, which: Callable[[PendingApproval], bool] = lambda _: True
    ) -> tuple[PendingApproval, ...]:
        """Remove and return the proposals for which ``which`` is true."""
        gone = tuple(filter(which, self._waiting.values()))
        for pending in gone:
            del self._waiting[pending.proposal.id]
        return gone
