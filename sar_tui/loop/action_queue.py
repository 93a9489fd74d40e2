"""Actions: made of what was proposed or decided, and queued by priority, one at a time."""

from collections.abc import Callable, Collection, Iterable

from msgspec.structs import replace

from sar_tui.model.messages import (
    Action,
    ActionPart,
    Decision,
    Ground,
    Kind,
    PendingApproval,
    Proposal,
    Remark,
)
from sar_tui.model.theme import Theme

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

    def remove(self, which: Callable[[Action], bool]) -> tuple[Action, ...]:
        """Remove and return the waiting actions for which ``which`` is true."""
        gone = tuple(filter(which, self._waiting))
        self._waiting = [action for action in self._waiting if action not in gone]
        return gone


# --- actions made of what was proposed or decided


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
