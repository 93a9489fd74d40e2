"""What the agent is about to say and do: one thing at a time, the most important first."""

from collections.abc import Callable, Collection, Iterable

from sar_tui.framework.messages import Action, ActionPart, Kind

LASTING: tuple[ActionPart, ...] = ("say", "gesture", "gaze", "tone")
"""Deeds that take a while. Words on the screen stand until others take their place: nobody waits for them."""


class ActionQueue:
    """What waits for its turn, and what is under way.

    ``queue`` waits; ``interrupt`` breaks off what is under way unless that is more important; ``drop`` waits only as
    long as the session stands still.
    """

    def __init__(self) -> None:
        self._waiting: list[Action] = []
        self.current: Action | None = None
        self._open: set[tuple[str, ActionPart]] = set()

    @property
    def is_acting(self) -> bool:
        """Whether something is under way."""
        return self.current is not None

    @property
    def waiting(self) -> tuple[Action, ...]:
        """What waits, in the order of its turn: the more important first, then the earlier."""
        return tuple(sorted(self._waiting, key=lambda action: -action.priority))

    def add(self, action: Action) -> None:
        """Let something wait for its turn."""
        self._waiting.append(action)

    def take(self, id: str) -> Action | None:
        """It waits no longer; None where it does not."""
        return next(iter(self.remove(lambda action: action.id == id)), None)

    def next(self, now: int, held: Collection[Kind] = ()) -> Action | None:
        """Whose turn it is now; None where nothing may begin yet. Kinds that are ``held`` go on waiting."""
        ready = next((action for action in self.waiting if action.due <= now and action.kind not in held), None)
        return ready if ready and (self.current is None or self.interrupts(ready)) else None

    def interrupts(self, action: Action) -> bool:
        """Whether an action takes the place of what is under way; nobody's answer is cut off by another's."""
        if self.current is None or action.policy != "interrupt" or action.priority < self.current.priority:
            return False
        return not (action.kind == self.current.kind == "feedback" and action.seat != self.current.seat)

    def next_due(self, now: int) -> int | None:
        """When the next of what is not due yet falls due (ns), if anything is."""
        return min((action.due for action in self._waiting if action.due > now), default=None)

    def begin(self, action: Action, open_parts: Iterable[tuple[str, ActionPart]]) -> None:
        """Its turn has come. ``open_parts``: which outputs do what for it; without any it is over at once."""
        self._waiting.remove(action)
        self._open = set(open_parts)
        self.current = action if self._open else None

    def finish_part(self, action: str, output: str, part: ActionPart) -> bool:
        """An output is done with its part; True if with that the action is over."""
        if self.current is None or self.current.id != action:
            return False
        self._open.discard((output, part))
        if self._open:
            return False
        self.current = None
        return True

    def abandon(self) -> None:
        """What is under way is over, whatever the outputs say."""
        self._open.clear()
        self.current = None

    def remove(self, which: Callable[[Action], bool] = lambda _: True) -> tuple[Action, ...]:
        """Give up what waits, or some of it; returns that."""
        gone = tuple(filter(which, self._waiting))
        self._waiting = [action for action in self._waiting if action not in gone]
        return gone
