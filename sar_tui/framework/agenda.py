"""What the agent is about to say and do: one thing at a time, the most important first."""

from collections.abc import Callable, Iterable

from sar_tui.framework.messages import Deed, Proposal

LASTING: tuple[Deed, ...] = ("say", "gesture", "gaze", "tone")
"""Deeds that take a while. Words on the screen stand until others take their place: nobody waits for them."""


class Agenda:
    """What waits for its turn, and what is under way.

    ``queue`` waits; ``interrupt`` breaks off what is under way unless that is more important; ``drop`` waits only as
    long as the session stands still.
    """

    def __init__(self) -> None:
        self._waiting: list[Proposal] = []
        self.current: Proposal | None = None
        self._open: set[tuple[str, Deed]] = set()

    @property
    def is_acting(self) -> bool:
        """Whether something is under way."""
        return self.current is not None

    @property
    def waiting(self) -> tuple[Proposal, ...]:
        """What waits, in the order of its turn: the more important first, then the earlier."""
        return tuple(sorted(self._waiting, key=lambda proposal: -proposal.priority))

    def add(self, proposal: Proposal) -> None:
        """Let something wait for its turn."""
        self._waiting.append(proposal)

    def next(self, now: int) -> Proposal | None:
        """Whose turn it is now; None where nothing may begin yet."""
        ready = next((proposal for proposal in self.waiting if proposal.due <= now), None)
        return ready if ready and (self.current is None or self.breaks_off(ready)) else None

    def breaks_off(self, proposal: Proposal) -> bool:
        """Whether a proposal takes the place of what is under way."""
        return (
            self.current is not None and proposal.policy == "interrupt" and proposal.priority >= self.current.priority
        )

    def next_due(self, now: int) -> int | None:
        """When the next of what is not due yet falls due (ns), if anything is."""
        return min((proposal.due for proposal in self._waiting if proposal.due > now), default=None)

    def begin(self, proposal: Proposal, open_deeds: Iterable[tuple[str, Deed]]) -> None:
        """Its turn has come. ``open_deeds``: which outputs do what for it; without any it is over at once."""
        self._waiting.remove(proposal)
        self._open = set(open_deeds)
        self.current = proposal if self._open else None

    def close(self, action: str, output: str, deed: Deed) -> bool:
        """An output is done with its part; True if with that the action is over."""
        if self.current is None or self.current.id != action:
            return False
        self._open.discard((output, deed))
        if self._open:
            return False
        self.current = None
        return True

    def abandon(self) -> None:
        """What is under way is over, whatever the outputs say."""
        self._open.clear()
        self.current = None

    def clear(self, gives_up: Callable[[Proposal], bool] = lambda _: True) -> tuple[Proposal, ...]:
        """Give up what waits, or some of it; returns that."""
        gone = tuple(filter(gives_up, self._waiting))
        self._waiting = [proposal for proposal in self._waiting if proposal not in gone]
        return gone
