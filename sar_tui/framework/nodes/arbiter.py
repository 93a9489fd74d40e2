"""The Arbiter: stands between what the agent proposes and what the participant gets."""

from sar_tui.framework.messages import Action, Proposal, Waiting
from sar_tui.framework.node import Node, on
from sar_tui.framework.topics import ACTION, PROPOSED, WAITING


class Arbiter(Node):
    """Passes every proposal on, but nothing in a trial: what comes late waits until the trial is over."""

    name = "arbiter"
    emits = (ACTION,)

    def __init__(self) -> None:
        super().__init__()
        self._held: list[Proposal] = []
        self._in_trial = False

    @on(WAITING)
    def waiting(self, waiting: Waiting) -> None:
        self._in_trial = waiting.what in ("foreperiod", "storage", "response")
        if not self._in_trial:
            held, self._held = self._held, []
            for proposal in held:
                self._pass(proposal)

    @on(PROPOSED)
    def proposed(self, proposal: Proposal) -> None:
        if self._in_trial:
            self._held.append(proposal)
        else:
            self._pass(proposal)

    def _pass(self, proposal: Proposal) -> None:
        self.emit(
            ACTION,
            Action(
                seat=proposal.seat,
                id=proposal.id,
                kind=proposal.kind,
                text=proposal.text,
                face=proposal.face,
                valence=proposal.valence,
                attempt=proposal.attempt,
                decision="accepted",
                actor="agent",
            ),
        )
