"""Outcome of each proposal: mode, decision, operator and times. Pure."""

from collections.abc import Iterable
from typing import Literal

import msgspec

from sar_tui.model import messages as m
from sar_tui.model.messages import ControlledKind, Mode, Valence
from sar_tui.reports.logged_messages import LoggedMessage
from sar_tui.rules import arbitration
from sar_tui.rules.parameters import TaskParameters

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
"""Outcome of a proposal.

``agent``: done, because its kind was autonomous. ``accepted``, ``edited``: an operator decided, and
it was done. ``vetoed``: stopped by an operator before it began; ``cut_off``: after.
``timed_out_…``: nobody decided in time. ``no_operator_…``: there was no operator.
``manual_dropped``: left to the operator, who did not do it. ``late``, ``stopped``, ``amended``: as
in `messages.Dropped`. ``mode_changed``: an operator set its kind to manual while it was pending,
and did not do it. ``open``: undecided when the record ends.
"""
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


class ProposalRecord(msgspec.Struct):
    """Proposal and its outcome. Times in ns.

    Attributes:
        kind: the kind whose mode applied, or ``filler``.
        mode: when it was proposed.
        pending_at: when it was put before an operator.
        seen: when it was on the screen, by operator.
        key_at, by: time stamp of the first key that decided on it, and the operator who pressed it.
        resolved_at: when it was decided, by an operator or not.
        verdict: the operator's last decision, even if something else happened afterwards.
        text, valence: as proposed.
        said, said_valence: as decided.
    """

    id: str
    run: int
    kind: ControlledKind | Literal["filler"]
    mode: Mode
    proposed_at: int
    text: str = ""
    valence: Valence | None = None
    pending_at: int | None = None
    seen: dict[str, int] = {}
    key_at: int | None = None
    by: str = ""
    resolved_at: int | None = None
    verdict: Verdict | None = None
    fate: Fate = "open"
    said: str | None = None
    said_valence: Valence | None = None

    @property
    def decision_ms(self) -> float | None:
        """Time from the deciding operator's screen to their key; None without a key, or if it was
        not seen.
        """
        shown = self.seen.get(self.by)
        return None if self.key_at is None or shown is None else (self.key_at - shown) / 1e6

    @property
    def waiting_ms(self) -> float | None:
        """Time pending until it was decided by anyone; None if it was never pending or is still
        open.
        """
        return (
            None
            if self.pending_at is None or self.resolved_at is None
            else (self.resolved_at - self.pending_at) / 1e6
        )


class ProposalLog:
    """Log of a session's proposals, built message by message.

    Attributes:
        records: by id, in order.
        state: modes, and whether there is an operator, as the arbiter had them.
    """

    def __init__(self, parameters: TaskParameters) -> None:
        self.records: dict[str, ProposalRecord] = {}
        self.state = arbitration.start(parameters)
        self._decisions: dict[str, tuple[int, m.Decision]] = {}
        self._level_decided_at = -1
        self._pending_mode: dict[str, Mode] = {}
        self._cause: tuple[int, Fate] = (-1, "open")

    def add(self, logged: LoggedMessage) -> None:
        """Add the next message."""
        run, at, message = logged
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
                record = self.records.get(message.proposal.id) or self._propose(
                    run, at, message.proposal
                )
                record.pending_at = at if record.pending_at is None else record.pending_at
                self._pending_mode[record.id] = message.mode
            case m.ProposalSeen() if known := self.records.get(message.action):
                known.seen.setdefault(message.actor, message.at or at)
            case m.Decision():
                self._decisions[message.action] = at, message
            case m.Action() if known := self.records.get(message.id):
                self._decide(known, at, message)
            case m.Dropped() if known := self.records.get(message.id):
                self._drop(known, at, message)
            case m.Halt(reason="vetoed") if known := self.records.get(message.action):
                known.fate, known.verdict = "cut_off", "vetoed"
                self._note_key(known, at)
            case m.LevelDecided():
                self._decide_level(run, at, message)
            case m.LevelChanged():
                self._level_changed(run, at, message)

    def _note_cause(self, at: int, message: m.Message) -> None:
        """Note a cause for the rejection of a pending level: its reason is not logged, but its
        cause precedes it.
        """
        match message:
            case m.AttemptStarted():
                self._cause = (-1, "open")
            case m.AttemptEnded():
                self._cause = (at, "amended")
            case m.SessionEnded():
                self._cause = (at, "late")
            case m.SessionCommand(command="stop"):
                self._cause = (at, "stopped")

    def _propose(self, run: int, at: int, proposal: m.Proposal) -> ProposalRecord:
        kind = arbitration.CONTROLLED.get(proposal.kind, "filler")
        record = self.records[proposal.id] = ProposalRecord(
            id=proposal.id,
            run=run,
            kind=kind,  # type: ignore[arg-type]
            mode=self.state.mode(proposal.kind),
            proposed_at=at,
            text=proposal.text,
            valence=None
            if proposal.kind == "gesture"
            else proposal.valence,  # counted with its words
        )
        return record

    def _decide(self, record: ProposalRecord, at: int, action: m.Action) -> None:
        """Note an action. It is logged twice if an operator decided: then, and when it is done."""
        record.said, record.said_valence = action.text, action.valence
        if record.resolved_at is None:
            record.resolved_at = at
        if action.ground == "operator":
            record.verdict = record.fate = "edited" if action.decision == "edited" else "accepted"
            self._note_key(record, at)
        else:
            record.fate = _done(action.ground)

    def _drop(self, record: ProposalRecord, at: int, dropped: m.Dropped) -> None:
        record.fate, record.said, record.said_valence = _DROPPED[dropped.reason], None, None
        if dropped.reason == "manual" and self._has_changed_its_mode(record):
            record.fate = "mode_changed"
        if record.resolved_at is None:
            record.resolved_at = at
        if dropped.reason == "vetoed":
            record.verdict = "vetoed"
            self._note_key(record, at)

    def _note_key(self, record: ProposalRecord, at: int) -> None:
        """Note the key that decided: a decision in the same cascade."""
        decided_at, decision = self._decisions.get(record.id, (-1, None))
        if record.key_at is None and decision and decided_at == at:
            record.key_at, record.by = decision.at or at, decision.actor

    # --- changes of level

    def _decide_level(self, run: int, at: int, decided: m.LevelDecided) -> None:
        if decided.decision != "rejected":
            self._level_decided_at = at
        record = self.records.get(decided.id) or self._propose(
            run, at, m.Proposal(id=decided.id, kind="difficulty", text="")
        )
        record.resolved_at = at
        if decided.ground == "operator":
            record.verdict = record.fate = (
                "vetoed" if decided.decision == "rejected" else decided.decision
            )
            self._note_key(record, at)
        elif decided.decision != "rejected":
            record.fate = _done(decided.ground)
        else:
            not_done: dict[str, Fate] = {
                "deadline": "timed_out_dropped",
                "no operator": "no_operator_dropped",
            }
            record.fate = not_done.get(decided.ground) or self._rejection_cause(record, at)

    def _rejection_cause(self, record: ProposalRecord, at: int) -> Fate:
        """Return why a pending level was rejected without a decision, from the cause in the same
        cascade.
        """
        cause_at, cause = self._cause
        if cause_at == at:
            return cause
        if record.mode == "manual":
            return "manual_dropped"
        return "mode_changed" if self._has_changed_its_mode(record) else "amended"

    def _has_changed_its_mode(self, record: ProposalRecord) -> bool:
        return self._pending_mode.get(record.id, record.mode) != record.mode

    def _level_changed(self, run: int, at: int, change: m.LevelChanged) -> None:
        """Note a change of level that was never pending, as after the last attempt."""
        if change.reason == "operator" or self._level_decided_at == at:
            return
        id = f"level {len(self.records) + 1}"
        record = self._propose(
            run, at, m.Proposal(seat=change.seat, id=id, kind="difficulty", text="")
        )
        record.resolved_at = at
        record.fate = (
            "agent" if record.mode == "autonomous" or self.state.operated else "no_operator_done"
        )


def proposal_records(
    messages: Iterable[LoggedMessage], parameters: TaskParameters
) -> list[ProposalRecord]:
    """Return all proposals of a session, in order, with their outcomes."""
    log = ProposalLog(parameters)
    for message in messages:
        log.add(message)
    return list(log.records.values())


def _done(ground: m.Ground) -> Fate:
    done: dict[str, Fate] = {"deadline": "timed_out_done", "no operator": "no_operator_done"}
    return done.get(ground, "agent")
