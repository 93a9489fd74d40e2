"""Messages of a session, written by hand."""

from typing import Any

from sar_tui.model import messages as m
from sar_tui.reports.logged_messages import LoggedMessage

ANNA = "operator.anna"


class Script(list[LoggedMessage]):
    """Messages of a session with times in ms. Run 1 begins at 0."""

    def __init__(self) -> None:
        super().__init__()
        self.run = 0
        self.begin(1, 0)

    def begin(self, run: int, ms: float) -> "Script":
        self.run = run
        return self.log(ms, m.SessionStarted(run=run, task="keyboard", theme="calm", seed=1))

    def log(self, ms: float, *messages: m.Message) -> "Script":
        """Add the messages of one cascade."""
        self.extend(LoggedMessage(self.run, round(ms * 1e6), message) for message in messages)
        return self

    def join(
        self, ms: float, who: str = ANNA, state: Any = "joined", *, operated: bool = True
    ) -> "Script":
        return self.log(ms, m.OperatorChanged(actor=who, state=state, operated=operated))

    def gone(self, ms: float, state: Any = "lost") -> "Script":
        """The only operator goes."""
        return self.join(ms, state=state, operated=False)


def has(found: object, **fields: object) -> None:
    """Assert that something has these attributes."""
    assert {name: getattr(found, name) for name in fields} == fields


def proposal(id: str, kind: Any = "feedback", text: str = "Well done.", **parts: Any) -> m.Proposal:
    return m.Proposal(id=id, kind=kind, text=text, **parts)


def pending(
    proposed: m.Proposal, mode: Any = "approve", level: int | None = None
) -> m.PendingApproval:
    return m.PendingApproval(proposal=proposed, mode=mode, level=level)


def action(
    proposed: m.Proposal, decision: Any = "accepted", ground: Any = "operator", **changes: Any
) -> m.Action:
    """Return the action of a proposal."""
    said = {name: getattr(proposed, name) for name in proposed.__struct_fields__} | changes
    return m.Action(
        **said, decision=decision, actor=ANNA if ground == "operator" else "agent", ground=ground
    )


def decision(id: str, verdict: Any = "accept", ms: float = 0, **parts: Any) -> m.Decision:
    return m.Decision(action=id, verdict=verdict, actor=ANNA, at=round(ms * 1e6), **parts)


def seen(id: str, ms: float, who: str = ANNA) -> m.ProposalSeen:
    return m.ProposalSeen(action=id, actor=who, at=round(ms * 1e6))


def level_decided(id: str, level: int, decision: Any, ground: Any) -> m.LevelDecided:
    return m.LevelDecided(
        id=id, level=level, decision=decision, actor="somebody", ground=ground, at=0
    )
