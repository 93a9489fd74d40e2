"""Adherence of operators to their protocol: what was due, and what they did. Pure."""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from statistics import median
from typing import Literal, NamedTuple

import msgspec

from sar_tui.model import messages as m
from sar_tui.model.protocol import BY_PROTOCOL, WizardProtocol
from sar_tui.reports.logged_messages import LoggedMessage, spans
from sar_tui.reports.presence import seconds
from sar_tui.reports.proposals import ProposalRecord
from sar_tui.rules.protocol_file import deed_of

DueOutcome = Literal["done", "late", "not done", "failed", "omitted"]
"""``done`` in time; ``late``: done after ``late_after_s``; ``not done``: the operator said so;
``failed``: the session refused the act; ``omitted``: not ticked.
"""
NO_REASON = "no reason given"
_COUNTED = ("level", "skip", "repeat")
"""Commands that a protocol may govern; a stop, a pause or a mark never counts as outside of it."""
_KINDS = {"key": "say", "phrase": "say", "level by": "level", "approve": "accept"}
"""Kinds of act by the verbs of a protocol, where they differ."""


class UsedProtocol(msgspec.Struct, frozen=True):
    """A protocol. ``hash``: of its file (SHA-256)."""

    name: str
    version: int
    hash: str


class DueItem(msgspec.Struct, frozen=True):
    """Something that was due, and its outcome.

    Attributes:
        at_s: when it was due, from the start of its run.
        what, number: step or rule of the protocol, from 1.
        latency_s: from then to the key that ticked it as done.
    """

    run: int
    at_s: float
    what: Literal["step", "rule"]
    number: int
    attempt: int
    do: str
    outcome: DueOutcome
    latency_s: float | None = None
    actor: str = ""


class TickTimes(msgspec.Struct, frozen=True):
    """Times from due to done (s)."""

    n: int
    median: float
    least: float
    most: float


class Adherence(msgspec.Struct, frozen=True):
    """Adherence to a protocol, of a session or of several.

    Attributes:
        operators: number of those who had control or watched as operators.
        practised: recorded sessions on which each had practised, as their panels reported.
        due: sum of ``done``, ``late`` and ``omitted``. Omitted is also what the operator said was
            ``not_done``, and what the session ``failed`` to do.
        latency_s: of what was done, also late.
        outside: acts that no step and no rule asked for, by kind.
        reasons: of vetoes and of edits, by text.
        items: of one session.
    """

    protocols: list[UsedProtocol]
    operators: int
    practised: dict[str, int]
    due: int
    done: int
    late: int
    omitted: int
    not_done: int
    failed: int
    latency_s: TickTimes | None
    outside: dict[str, int]
    reasons: dict[str, dict[str, int]]
    items: list[DueItem] = []


class _Act(NamedTuple):
    """An act that a protocol may ask for, at its key (ns).

    ``kind``: ``say``, ``gesture``, a command, ``mode``, or the verdict of a decision. ``action``:
    what it decides on.
    """

    run: int
    at: int
    kind: str
    id: str = ""
    action: str = ""


class _Due(NamedTuple):
    """Something due, its protocol, and its tick with the time of its key (ns)."""

    run: int
    due: m.ProtocolDue
    protocol: WizardProtocol
    tick: m.ProtocolTicked | None = None
    ticked_at: int = 0

    @property
    def kind(self) -> str:
        """The kind of act that it asks for."""
        verb = deed_of(self.due.do, self.protocol).verb
        return _KINDS.get(verb, verb)


def adherence(
    messages: Sequence[LoggedMessage],
    records: Iterable[ProposalRecord],
    operators: Collection[str],
) -> Adherence | None:
    """Return how far the operators of a session kept to their protocol; None if they had none.

    Args:
        messages: of the session, in order.
        records: of its proposals.
        operators: their names.
    """
    chosen = [one.message for one in messages if isinstance(one.message, m.ProtocolChosen)]
    if not chosen:
        return None
    answers = {
        message.id: message.outcome
        for *_, message in messages
        if isinstance(message, m.ActAnswered)
    }
    reasons = {
        message.action: message.text
        for *_, message in messages
        if isinstance(message, m.ReasonGiven)
    }
    began = {run: span.began for run, span in spans(messages).items()}
    dues, acts = _dues(messages), list(_acts(messages, operators))
    asked_for = _asked_for(dues, acts)
    by_protocol = {act.action for act in asked_for if act.action} | {
        action for action, text in reasons.items() if text == BY_PROTOCOL
    }
    outside = [act.kind for act in acts if act not in asked_for and act.action not in by_protocol]
    return _summary(
        protocols=[_used(each.protocol) for each in chosen],
        operators=len(operators),
        practised={each.actor: each.practised for each in chosen},
        items=[_item(each, answers, began.get(each.run, 0)) for each in dues],
        outside=Counter(kind for kind in outside if kind != "accept"),
        reasons=_reasons(records, reasons, by_protocol),
    )


def pooled(found: Sequence[Adherence], operators: int) -> Adherence | None:
    """Return the adherence of several sessions together; None if none had a protocol.

    Args:
        found: of each session that had one.
        operators: number of different operators in all of them.
    """
    if not found:
        return None
    outside = Counter[str]()
    reasons: dict[str, Counter[str]] = {}
    practised: dict[str, int] = {}
    for each in found:
        outside.update(each.outside)
        for verdict, counts in each.reasons.items():
            reasons.setdefault(verdict, Counter()).update(counts)
        for operator, times in each.practised.items():
            practised[operator] = max(times, practised.get(operator, 0))
    whole = _summary(
        protocols=[used for each in found for used in each.protocols],
        operators=operators,
        practised=practised,
        items=[item for each in found for item in each.items],
        outside=outside,
        reasons={verdict: dict(counts) for verdict, counts in reasons.items()},
    )
    return msgspec.structs.replace(whole, items=[])


def _summary(
    protocols: Iterable[UsedProtocol],
    operators: int,
    practised: dict[str, int],
    items: list[DueItem],
    outside: Counter[str],
    reasons: dict[str, dict[str, int]],
) -> Adherence:
    outcomes = Counter(item.outcome for item in items)
    times = [item.latency_s for item in items if item.latency_s is not None]
    latency = (
        TickTimes(len(times), round(median(times), 3), min(times), max(times)) if times else None
    )
    return Adherence(
        protocols=list(dict.fromkeys(protocols)),
        operators=operators,
        practised=practised,
        due=len(items),
        done=outcomes["done"],
        late=outcomes["late"],
        omitted=len(items) - outcomes["done"] - outcomes["late"],
        not_done=outcomes["not done"],
        failed=outcomes["failed"],
        latency_s=latency,
        outside=dict(outside),
        reasons=reasons,
        items=items,
    )


def _used(protocol: WizardProtocol) -> UsedProtocol:
    return UsedProtocol(protocol.name, protocol.version, protocol.hash)


def _dues(messages: Iterable[LoggedMessage]) -> list[_Due]:
    """Return all that was due, in order, with the first tick of each."""
    protocol: WizardProtocol | None = None
    found: dict[str, _Due] = {}
    for run, at, message in messages:
        match message:
            case m.ProtocolChosen():
                protocol = message.protocol
            case m.ProtocolDue() if protocol:
                found[message.id] = _Due(run, message, protocol)
            case m.ProtocolTicked() if message.due in found:
                if found[message.due].tick is None:
                    ticked = found[message.due]._replace(tick=message, ticked_at=message.at or at)
                    found[message.due] = ticked
    return list(found.values())


def _item(each: _Due, answers: dict[str, m.ActOutcome], began: int) -> DueItem:
    due, tick = each.due, each.tick
    outcome: DueOutcome = "omitted"
    latency = None
    if tick:
        latency = seconds(max(0, each.ticked_at - due.at))
        if tick.outcome == "not done":
            outcome = "not done"
        elif tick.act and answers.get(tick.act, "done") != "done":
            outcome = "failed"
        else:
            outcome = "late" if latency > each.protocol.late_after_s else "done"
    return DueItem(
        run=each.run,
        at_s=seconds(due.at - began),
        what=due.what,
        number=due.number,
        attempt=due.attempt,
        do=due.do,
        outcome=outcome,
        latency_s=latency if outcome in ("done", "late") else None,
        actor=tick.actor if tick else "",
    )


def _acts(messages: Iterable[LoggedMessage], operators: Collection[str]) -> Iterator[_Act]:
    """Yield the operators' acts that a protocol may ask for, from when they had one."""
    has_protocol = False
    for run, at, message in messages:
        has_protocol |= isinstance(message, m.ProtocolChosen)
        if not has_protocol or not isinstance(message, m.OperatorAct):
            continue
        act = _Act(run, message.at or at, "", message.id)
        match message:
            case m.Remark():
                yield act._replace(kind="say" if message.text else "gesture")
            case m.Decision():
                yield act._replace(kind=message.verdict, action=message.action)
            case m.ModeChanged():
                yield act._replace(kind="mode")
            case m.SessionCommand() if message.actor in operators and message.command in _COUNTED:
                yield act._replace(kind=message.command)


def _asked_for(dues: Iterable[_Due], acts: Sequence[_Act]) -> set[_Act]:
    """Return the acts by which the operators did what was due: those of ticks; and for a tick
    without one, the first of its kind since it was due, which the operator did by its own key.
    """
    found: set[_Act] = set()
    for each in dues:
        if each.tick is None or each.tick.outcome == "not done":
            continue
        for act in acts:
            if each.tick.act:
                is_it = act.id == each.tick.act
            else:
                is_between = act.run == each.run and each.due.at <= act.at <= each.ticked_at
                is_it = is_between and act.kind == each.kind and act not in found
            if is_it:
                found.add(act)
                break
    return found


def _reasons(
    records: Iterable[ProposalRecord], given: dict[str, str], by_protocol: Collection[str]
) -> dict[str, dict[str, int]]:
    """Count the reasons of the operators' vetoes and edits; what a tick did needs none."""
    found: dict[str, Counter[str]] = {}
    for record in records:
        if record.verdict in ("vetoed", "edited"):
            usual = BY_PROTOCOL if record.id in by_protocol else NO_REASON
            text = given.get(record.id, usual)
            found.setdefault(record.verdict, Counter())[text] += 1
    return {verdict: dict(counts) for verdict, counts in found.items()}
