"""The operator's protocol: when a step or a rule is due, from the session's messages. Pure."""

import operator
from collections.abc import Callable
from typing import Literal

import msgspec
from msgspec.structs import replace

from sar_tui.model import messages as m
from sar_tui.model.protocol import ANSWERS, Condition, Moment, WizardProtocol
from sar_tui.rules.arbitration import CONTROLLED
from sar_tui.rules.protocol_file import deed_of

_COMPARE: dict[str, Callable[[float, float], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    "=": operator.eq,
    ">=": operator.ge,
    ">": operator.gt,
}
_OF_TIME = {"ms": 1.0, "s": 1000.0}
"""Units of time, which a condition and a task may choose differently, in ms."""


class ProtocolProgress(msgspec.Struct, frozen=True):
    """Progress of a session in the operator's protocol.

    Attributes:
        protocol: None until an operator has one.
        attempt: begun last; ``scored``: last one that was scored, by seat.
        past: steps that were due, or whose moment was over when the protocol came, by index.
        counts: how often a rule has held, by seat and index.
        timeouts: prompts of this attempt without a response, by seat.
        is_paused: the session is paused.
        dues: number of all that was due.
    """

    protocol: WizardProtocol | None = None
    attempt: int = 0
    scored: dict[str, int] = {}
    past: frozenset[int] = frozenset()
    counts: dict[tuple[str, int], int] = {}
    timeouts: dict[str, int] = {}
    is_paused: bool = False
    dues: int = 0


Stepped = tuple[ProtocolProgress, tuple[m.ProtocolDue, ...]]


def step(progress: ProtocolProgress, message: m.Message, at: int) -> Stepped:  # noqa: PLR0911
    """Return the progress after a message of the session, and what is due because of it.

    Rules on answers to questions are looked at when the answer is given, all others when an attempt
    is scored. An attempt that is scored again does not count again; practice does not count.

    Args:
        progress: before it.
        message: of any kind. Others than those handled here change nothing.
        at: its time (ns).
    """
    match message:
        case m.ProtocolChosen():
            return _chosen(progress, message.protocol, at)
        case m.AttemptStarted():
            begun = replace(progress, attempt=message.attempt, timeouts={})
            return _steps_due(begun, "attempt", message.attempt, at)
        case m.TrialEnded(response=None):
            timeouts = progress.timeouts.get(message.seat, 0) + 1
            return replace(progress, timeouts={**progress.timeouts, message.seat: timeouts}), ()
        case m.AttemptEnded():
            return _attempt_ended(progress, message, at)
        case m.StepEnded() if message.name in ANSWERS and progress.protocol:
            return _rules_due(progress, message, message.seat, at)
        case m.Waiting(stage="review"):
            return _steps_due(progress, "end", 0, at)
        case m.Waiting():
            is_paused = message.stage == "paused"
            if is_paused == progress.is_paused:
                return progress, ()
            progress = replace(progress, is_paused=is_paused)
            return _steps_due(progress, "pause", 0, at) if is_paused else (progress, ())
        case m.SessionEnded():
            return _steps_due(progress, "end", 0, at)
    return progress, ()


def _chosen(progress: ProtocolProgress, protocol: WizardProtocol, at: int) -> Stepped:
    """Begin with a protocol. Steps whose moment is over are past."""
    over = {
        "start": min(1, progress.attempt),
        "attempt": progress.attempt,
        "after attempt": max(progress.scored.values(), default=0),
    }
    past = frozenset(
        index
        for index, each in enumerate(protocol.steps)
        if max(1, each.attempt) <= over.get(each.at, 0)
    )
    chosen = replace(progress, protocol=protocol, past=past, counts={})
    return _steps_due(chosen, "start", 0, at)


def _attempt_ended(progress: ProtocolProgress, ended: m.AttemptEnded, at: int) -> Stepped:
    if ended.attempt <= progress.scored.get(ended.seat, 0):
        return progress, ()
    progress = replace(progress, scored={**progress.scored, ended.seat: ended.attempt})
    progress, due = _steps_due(progress, "after attempt", ended.attempt, at)
    if ended.practice or progress.protocol is None:
        return progress, due
    progress, by_rules = _rules_due(progress, ended, ended.seat, at)
    return progress, (*due, *by_rules)


def _steps_due(progress: ProtocolProgress, moment: Moment, attempt: int, at: int) -> Stepped:
    """Return the steps of a moment that are due; those of a pause are due in every pause."""
    due = []
    for index, each in enumerate(progress.protocol.steps if progress.protocol else ()):
        if each.at == moment and each.attempt <= attempt and index not in progress.past:
            past = progress.past if moment == "pause" else progress.past | {index}
            progress = replace(progress, past=past, dues=progress.dues + 1)
            due.append(
                m.ProtocolDue(
                    id=f"d{progress.dues}",
                    what="step",
                    number=index + 1,
                    attempt=progress.attempt,
                    do=each.do,
                    at=at,
                )
            )
    return progress, tuple(due)


def _rules_due(
    progress: ProtocolProgress, result: m.AttemptEnded | m.StepEnded, seat: str, at: int
) -> Stepped:
    """Return the rules whose condition holds often enough. Each then counts from zero again."""
    assert progress.protocol
    due = []
    for index, rule in enumerate(progress.protocol.rules):
        condition, key = rule.when, (seat, index)
        if (value := _value(condition, result, progress.timeouts.get(seat, 0))) is None:
            continue
        count = progress.counts.get(key, 0)
        if _COMPARE[condition.comparison](value, condition.value):
            count += 1
        elif condition.in_a_row:
            count = 0
        is_due = count >= condition.times
        progress = replace(progress, counts={**progress.counts, key: 0 if is_due else count})
        if is_due:
            progress = replace(progress, dues=progress.dues + 1)
            due.append(
                m.ProtocolDue(
                    seat=seat,
                    id=f"d{progress.dues}",
                    what="rule",
                    number=index + 1,
                    attempt=progress.attempt,
                    do=rule.do,
                    at=at,
                )
            )
    return progress, tuple(due)


def _value(
    condition: Condition, result: m.AttemptEnded | m.StepEnded, timeouts: int
) -> float | None:
    """Return what a condition compares; None if this result does not tell."""
    if isinstance(result, m.StepEnded):
        answer = result.answer
        is_number = isinstance(answer, int | float) and result.name == condition.measure
        return float(answer) if is_number else None  # type: ignore[arg-type]
    values: dict[str, float | None] = {
        "accuracy": None if result.accuracy is None else round(100 * result.accuracy, 6),
        "success": {"success": 1.0, "failure": 0.0}.get(result.outcome),
        "timeouts": timeouts,
        "level": result.level,
    }
    factor = unit_factor(result.metric_unit, condition.unit)
    if factor is not None and result.metric is not None:
        values["metric"] = result.metric * factor
    return values.get(condition.measure)


def verdict_on(
    proposal: m.Proposal, due: m.ProtocolDue, protocol: WizardProtocol
) -> Literal["accept", "veto", ""]:
    """Return how something due decides on a proposal; empty if it is about something else.

    A rule decides on no feedback but that of the participant whose result it is.
    """
    deed = deed_of(due.do, protocol)
    if deed.kind is None or deed.kind != CONTROLLED.get(proposal.kind):
        return ""
    if due.what == "rule" and proposal.kind == "feedback" and proposal.seat != due.seat:
        return ""
    return "veto" if deed.verb == "veto" else "accept"


def unit_factor(given: str, wanted: str) -> float | None:
    """Return what a value in one unit is multiplied by for another; None if they differ in kind.

    ``wanted`` may be empty: then it is the given one.
    """
    if wanted in ("", given):
        return 1.0
    if given in _OF_TIME and wanted in _OF_TIME:
        return _OF_TIME[given] / _OF_TIME[wanted]
    return None
