"""The acts that can still be taken back: of each person the last one, for ten seconds."""

from collections.abc import Callable
from typing import NamedTuple

from sar_tui.model.messages import TakenBackKind
from sar_tui.model.units import SECOND

UNDO_FOR = 10 * SECOND
"""Time after an act in which it can be taken back."""


class Done(NamedTuple):
    """An act that can be taken back.

    Attributes:
        actor: who did it.
        what: its kind.
        at: when it was done (ns).
        take_back: takes it back; None if the session's script goes back instead.
        number: of the step or the attempt.
        seat: the participant whose answer it is.
        act: id of the command.
        is_possible: returns False while it cannot be taken back.
    """

    actor: str
    what: TakenBackKind
    at: int
    take_back: Callable[[], object] | None = None
    number: int = 0
    seat: str = "A"
    act: str = ""
    is_possible: Callable[[], bool] = lambda: True

    @property
    def until(self) -> int:
        """When it is too late (ns)."""
        return self.at + UNDO_FOR


class Undo:
    """The last act of each person. Nobody takes back an act of somebody else."""

    def __init__(self) -> None:
        self._last: dict[str, Done] = {}

    def note(self, done: Done) -> None:
        """Note an act, which its actor can take back instead of the one before.

        Another person's of its kind stands from here on, unless it is a note: two people may write
        one each.
        """
        if done.what != "note":
            self.forget(done.what)
        self._last[done.actor] = done

    def drop(self, done: Done) -> None:
        """Forget an act that was taken back."""
        del self._last[done.actor]

    def forget(self, *kinds: TakenBackKind) -> None:
        """Let acts of these kinds stand."""
        self._last = {who: done for who, done in self._last.items() if done.what not in kinds}

    def clear(self) -> None:
        """Let all acts stand."""
        self._last = {}

    def of(self, actor: str, now: int) -> Done | None:
        """Return the act that a person can take back now (ns); None if there is none."""
        done = self._last.get(actor)
        return done if done and now <= done.until and done.is_possible() else None
