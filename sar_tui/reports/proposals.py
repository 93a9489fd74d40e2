"""What became of each thing that the agent proposed: in which mode, who decided, and when. Pure."""

from collections.abc import Iterable
from typing import Literal

import msgspec

from sar_tui.framework import messages as m
from sar_tui.framework.messages import ControlledKind, Mode, Valence
from sar_tui.framework.policies import arbitration
from sar_tui.framework.settings.operator import OperatorSettings
from sar_tui.reports.record import Told

Fate = Literal[
    "agent",
    "accepted",
    "edited",
    "vetoed",
    "cut_off",
    "timed_out_done",
    "timed_out_dropped",
    "no_operator_done",
    "no_operator_dropped",
    "manual_dropped",
    "late",
    "stopped",
    "amended",
    "mode_changed",
    "open",
]
"""``agent``: done, for its kind was the agent's own; ``accepted``, ``edited``: done, an operator decided; ``vetoed``:
one stopped it before it began; ``cut_off``: after; ``timed_out_…``: nobody decided in time; ``no_operator_…``: nobody
was there; ``manual_dropped``: only an operator would have done it, and did not; ``late``, ``stopped``, ``amended``: as
`messages.Dropped`; ``mode_changed``: an operator took its kind over while it waited, and did not do it; ``open``:
undecided when the record ends."""
Verdict = Literal["accepted", "edited", "vetoed"]
_DROPPED: dict[str, Fate] = {
    "vetoed": "vetoed",
    "expired": "timed_out_dropped",
    "no operator": "no_operator_dropped",
    "manual": "manual_dropped",
    "late": "late",
    "stopped": "stopped",
    "amended": "amended",
}


class Case(msgspec.Struct):
    """One proposal, and what became of it. Times in ns.

    ``kind``: whose mode it went by, or ``filler``. ``mode``: as it was set when it was proposed. ``offered``: when it
    was put before an operator; ``seen``: when it stood on whose screen; ``keyed``: the stamp of the first key that
    decided on it, and ``by`` whom. ``resolved``: when it was decided, by whomever. ``verdict``: the last of an
    operator's, whatever became of it then. ``text`` and ``valence`` as proposed; ``said`` and ``said_valence`` as
    decided.
    """

    id: str
    run: int
    kind: ControlledKind | Literal["filler"]
    mode: Mode
    proposed: int
    text: str = ""
    valence: Valence | None = None
    offered: int | None = None
    seen: dict[str, int] = {}
    keyed: int | None = None
    by: str = ""
    resolved: int | None = None
    verdict: Verdict | None = None
    fate: Fate = "open"
    said: str | None = None
    said_valence: Valence | None = None

    @property
    def decision_ms(self) -> float | None:
        """From its standing on the deciding operator's screen to their key; None if it was not decided by a key, or is
        not known to have been seen."""
        shown = self.seen.get(self.by)
        return None if self.keyed is None or shown is None else (self.keyed - shown) / 1e6

    @property
    def waiting_ms(self) -> float | None:
        """From its offer until it was decided, by whomever; None if it was never offered, or is open."""
        return None if self.offered is None or self.resolved is None else (self.resolved - self.offered) / 1e6


class ProposalLog:
    """Follows the messages of a session from proposal to outcome.

    Attributes:
        cases: by id, in the order in which they were proposed.
        state: the modes that are set, and whether there is an operator, as the arbiter had them.
    """

    def __init__(self, parameters: OperatorSettings) -> None:
        self.cases: dict[str, Case] = {}
        self.state = arbitration.start(parameters)
        self._decisions: dict[str, tuple[int, m.Decision]] = {}
        self._level_ruled = -1
        self._offered_as: dict[str, Mode] = {}
        self._cause: tuple[int, Fate] = (-1, "open")

    def hear(self, told: Told) -> None:
        """Take the next message."""
        run, at, message = told
        self._note_cause(at, message)
        match message:
            case m.SessionStarted():
                self.state = msgspec.structs.replace(self.state, operated=False)
            case m.OperatorChanged():
                self.state = msgspec.structs.replace(self.state, operated=message.operated)
            case m.ModeChanged():
                self.state = arbitration.set_mode(self.state, message.kind, message.mode)
            case m.Proposal():
                self._propose(run, at, message)
            case m.PendingApproval():
                case = self.cases.get(message.proposal.id) or self._propose(run, at, message.proposal)
                case.offered = at if case.offered is None else case.offered
                self._offered_as[case.id] = message.mode
            case m.ProposalSeen() if known := self.cases.get(message.action):
                known.seen.setdefault(message.actor, message.at or at)
            case m.Decision():
                self._decisions[message.action] = at, message
            case m.Action() if known := self.cases.get(message.id):
                self._decide(known, at, message)
            case m.Dropped() if known := self.cases.get(message.id):
                self._drop(known, at, message)
            case m.Halt(reason="vetoed") if known := self.cases.get(message.action):
                known.fate, known.verdict = "cut_off", "vetoed"
                self._key(known, at)
            case m.LevelDecided():
                self._rule_level(run, at, message)
            case m.LevelChanged():
                self._level_changed(run, at, message)

    def _note_cause(self, at: int, message: m.Message) -> None:
        """Of a level that falls away it is not told why; what comes before it in its cascade tells."""
        match message:
            case m.AttemptStarted():
                self._cause = (-1, "open")
            case m.AttemptEnded():
                self._cause = (at, "amended")
            case m.SessionEnded():
                self._cause = (at, "late")
            case m.Operator(command="stop"):
                self._cause = (at, "stopped")

    def _propose(self, run: int, at: int, proposal: m.Proposal) -> Case:
        kind = arbitration.CONTROLLED.get(proposal.kind, "filler")
        case = self.cases[proposal.id] = Case(
            id=proposal.id,
            run=run,
            kind=kind,  # type: ignore[arg-type]
            mode=self.state.mode(proposal.kind),
            proposed=at,
            text=proposal.text,
            valence=None if proposal.kind == "gesture" else proposal.valence,  # it is its words' already
        )
        return case

    def _decide(self, case: Case, at: int, action: m.Action) -> None:
        """It is told twice of what an operator decided: then, and when its turn comes."""
        case.said, case.said_valence = action.text, action.valence
        if case.resolved is None:
            case.resolved = at
        if action.ground == "operator":
            case.verdict = case.fate = "edited" if action.decision == "edited" else "accepted"
            self._key(case, at)
        else:
            case.fate = _done(action.ground)

    def _drop(self, case: Case, at: int, dropped: m.Dropped) -> None:
        case.fate, case.said, case.said_valence = _DROPPED[dropped.reason], None, None
        if dropped.reason == "manual" and self._has_changed_its_mode(case):
            case.fate = "mode_changed"
        if case.resolved is None:
            case.resolved = at
        if dropped.reason == "vetoed":
            case.verdict = "vetoed"
            self._key(case, at)

    def _key(self, case: Case, at: int) -> None:
        """Whose key it was: a decision in the same cascade."""
        decided_at, decision = self._decisions.get(case.id, (-1, None))
        if case.keyed is None and decision and decided_at == at:
            case.keyed, case.by = decision.at or at, decision.actor

    # --- changes of level ----------------------------------------------------------------------------------------

    def _rule_level(self, run: int, at: int, ruled: m.LevelDecided) -> None:
        if ruled.decision != "rejected":
            self._level_ruled = at
        case = self.cases.get(ruled.id) or self._propose(run, at, m.Proposal(id=ruled.id, kind="difficulty", text=""))
        case.resolved = at
        if ruled.ground == "operator":
            case.verdict = case.fate = "vetoed" if ruled.decision == "rejected" else ruled.decision
            self._key(case, at)
        elif ruled.decision != "rejected":
            case.fate = _done(ruled.ground)
        else:
            not_done: dict[str, Fate] = {"deadline": "timed_out_dropped", "no operator": "no_operator_dropped"}
            case.fate = not_done.get(ruled.ground) or self._fallen_away(case, at)

    def _fallen_away(self, case: Case, at: int) -> Fate:
        """Why a level that waited came to nothing without anybody's deciding: by what came in the same cascade."""
        cause_at, cause = self._cause
        if cause_at == at:
            return cause
        if case.mode == "manual":
            return "manual_dropped"
        return "mode_changed" if self._has_changed_its_mode(case) else "amended"

    def _has_changed_its_mode(self, case: Case) -> bool:
        return self._offered_as.get(case.id, case.mode) != case.mode

    def _level_changed(self, run: int, at: int, change: m.LevelChanged) -> None:
        """A change that nobody was asked about is told of by itself alone; after the last attempt nobody ever is."""
        if change.reason == "operator" or self._level_ruled == at:
            return
        id = f"level {len(self.cases) + 1}"
        case = self._propose(run, at, m.Proposal(seat=change.seat, id=id, kind="difficulty", text=""))
        case.resolved = at
        case.fate = "agent" if case.mode == "autonomous" or self.state.operated else "no_operator_done"


def cases(told: Iterable[Told], parameters: OperatorSettings) -> list[Case]:
    """All that was proposed in a session, in order, and what became of it."""
    docket = ProposalLog(parameters)
    for each in told:
        docket.hear(each)
    return list(docket.cases.values())


def _done(ground: m.Ground) -> Fate:
    done: dict[str, Fate] = {"deadline": "timed_out_done", "no operator": "no_operator_done"}
    return done.get(ground, "agent")
