"""Queue of actions that wait for their turn: one at a time, by priority."""

from collections.abc import Callable, Collection, Iterable

from sar_tui.model.messages import Action, ActionPart, Kind

LASTING: tuple[ActionPart, ...] = ("say", "gesture", "gaze", "tone")
"""Parts that take time. Text on the screen stays until other text replaces it, so nothing waits for
it.
"""


class ActionQueue:
    """The actions that wait, and the one under way.

    The policy of an action: ``queue`` waits; ``interrupt`` replaces the current action unless that
    has a higher priority; ``drop`` is left out if the session continues before its turn.
    """

    def __init__(self) -> None:
        self._waiting: list[Action] = []
        self.current: Action | None = None
        self._open: set[tuple[str, ActionPart]] = set()

    @property
    def is_acting(self) -> bool:
        """True if an action is under way."""
        return self.current is not None

    @property
    def is_idle(self) -> bool:
        """True if no action waits or is under way."""
        return self.current is None and not self._waiting

    @property
    def waiting(self) -> tuple[Action, ...]:
        """The actions that wait, by priority, then by age."""
        return tuple(sorted(self._waiting, key=lambda action: -action.priority))

    @property
    def open_parts(self) -> frozenset[tuple[str, ActionPart]]:
        """The parts of the current action that are not over, by output."""
        return frozenset(self._open)

    def add(self, action: Action) -> None:
        """Add an action."""
        self._waiting.append(action)

    def take(self, id: str) -> Action | None:
        """Remove and return an action by its id; None if it does not wait."""
        return next(iter(self.remove(lambda action: action.id == id)), None)

    def next(self, now: int, held: Collection[Kind] = ()) -> Action | None:
        """Return the action whose turn it is, if it may begin. Actions of the kinds ``held`` are
        passed over.
        """
        ready = next(
            (action for action in self.waiting if action.due <= now and action.kind not in held),
            None,
        )
        return ready if ready and (self.current is None or self.interrupts(ready)) else None

    def interrupts(self, action: Action) -> bool:
        """Return True if an action replaces the current one. Feedback never interrupts feedback for
        another seat.
        """
        if (
            self.current is None
            or action.policy != "interrupt"
            or action.priority < self.current.priority
        ):
            return False
        return not (
            action.kind == self.current.kind == "feedback" and action.seat != self.current.seat
        )

    def next_due(self, now: int) -> int | None:
        """Return when the next action that is not due yet becomes due (ns), if there is one."""
        return min((action.due for action in self._waiting if action.due > now), default=None)

    def begin(self, action: Action, open_parts: Iterable[tuple[str, ActionPart]]) -> None:
        """Begin an action. ``open_parts``: the parts to wait for, by output; without any it is over
        at once.
        """
        self._waiting.remove(action)
        self._open = set(open_parts)
        self.current = action if self._open else None

    def finish_part(self, action: str, output: str, part: ActionPart) -> bool:
        """Record that an output has finished a part; True if this ends the current action."""
        if self.current is None or self.current.id != action:
            return False
        self._open.discard((output, part))
        if self._open:
            return False
        self.current = None
        return True

    def abandon(self) -> None:
        """Stop waiting for the current action."""
        self._open.clear()
        self.current = None

    def remove(self, which: Callable[[Action], bool] = lambda _: True) -> tuple[Action, ...]:
        """Remove and return the waiting actions for which ``which`` is true."""
        gone = tuple(filter(which, self._waiting))
        self._waiting = [action for action in self._waiting if action not in gone]
        return gone
