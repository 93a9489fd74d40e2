"""Statistics on operators over several sessions: agreement, latencies by condition, exclusions,
drift. Pure.
"""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from statistics import median
from typing import Any, NamedTuple

import msgspec

from sar_tui.reports.agreement import Agreement, agreement
from sar_tui.reports.distribution import Distribution, distribution
from sar_tui.reports.logged_messages import LoggedMessage
from sar_tui.reports.proposals import ProposalRecord, proposal_records
from sar_tui.reports.protocol import Adherence, pooled
from sar_tui.reports.wizard import (
    Latencies,
    WizardReport,
    agreement_by_kind,
    operator_settings,
    report,
)

FEWEST = 5
"""Fewest values of a trend: with four, the interval would hold every slope."""
_Z = 1.959964


class Trend(msgspec.Struct, frozen=True):
    """Median slope of ``n`` values per step, with its 95 % interval. The values rise or fall if it
    leaves out zero.
    """

    n: int
    slope: float
    low: float
    high: float


def trend(values: Sequence[float]) -> Trend | None:
    """Return the trend of values in their order, a step apart; None with too few.

    The slope is the median of those of all pairs (Theil 1950), and its interval follows from the
    distribution of Kendall's score by the normal approximation, corrected for ties (Sen 1968).
    """
    n = len(values)
    if n < FEWEST:
        return None
    slopes = sorted(
        (later - earlier) / (j - i)
        for (i, earlier), (j, later) in combinations(enumerate(values), 2)
    )
    tied = sum(count * (count - 1) * (2 * count + 5) for count in Counter(values).values())
    spread = _Z * math.sqrt(max(0.0, (n * (n - 1) * (2 * n + 5) - tied) / 18))
    last = len(slopes) - 1
    low = max(0, round((len(slopes) - spread) / 2) - 1)
    high = min(last, round((len(slopes) + spread) / 2))
    return Trend(n, median(slopes), slopes[low], slopes[high])


ALIKE = "all alike"
"""Condition of sessions whose plans are the same."""


class StudySession(msgspec.Struct, frozen=True):
    """A session of the study.

    Attributes:
        condition: the planned operator settings that are not the same in all sessions, and the task
            if it differs.
        accepted_share: of the proposals that an operator decided on.
        decision_ms: median time from an operator's screen to the key.
        remarks: what a reader should know of it: that it ended early, that an operator was lost.
    """

    session: str
    participant: str
    mode: str
    operators: list[str]
    condition: str
    duration_s: float
    operated_s: float
    decided: int
    accepted_share: float | None
    decision_ms: float | None
    remarks: list[str]


class Exclusion(msgspec.Struct, frozen=True):
    """A session that does not count, and why."""

    session: str
    why: str


class OperatorGroup(msgspec.Struct, frozen=True):
    """Decisions of one operator in the sessions of one condition."""

    operator: str
    condition: str
    sessions: int
    decided: int
    accepted_share: float | None
    valence_kappa: float | None
    decision_ms: Distribution | None


class Drift(msgspec.Struct, frozen=True):
    """Change of an operator's decisions from session to session, and within sessions.

    Attributes:
        sessions: in which they decided, in order.
        decision_ms: trend of the sessions' medians, in ms per session.
        accepted_share: trend of the sessions' shares, per session.
        first_half_ms, second_half_ms: medians of the first and of the second half of each session's
            decisions.
    """

    operator: str
    sessions: int
    decision_ms: Trend | None
    accepted_share: Trend | None
    first_half_ms: float | None
    second_half_ms: float | None


class WizardStudy(msgspec.Struct, frozen=True):
    """Report on the operators of several sessions.

    Attributes:
        agreement: over the decisions of all sessions together; ``agreement_by_kind`` for each kind
            of proposal.
        accepted_shares: the smallest, the median and the greatest share of the sessions.
        decision_ms, waiting_ms, link_ms: as in `WizardReport`, of all sessions together.
        counts: deviations of all sessions by type.
        protocol: adherence to the operators' protocol in the sessions that had one, together.
    """

    sessions: list[StudySession]
    excluded: list[Exclusion]
    operators: list[str]
    duration_s: float
    operated_s: float
    agreement: Agreement
    agreement_by_kind: dict[str, Agreement]
    accepted_shares: tuple[float, float, float] | None
    decision_ms: Distribution | None
    waiting_ms: Distribution | None
    link_ms: Distribution | None
    groups: list[OperatorGroup]
    drift: list[Drift]
    counts: dict[str, int]
    protocol: Adherence | None = None


class OperatedSession(NamedTuple):
    """A session as a study needs it. ``row``: as `store.sessions.listing` returns it."""

    row: Mapping[str, Any]
    report: WizardReport
    latencies: Latencies
    records: list[ProposalRecord]


def read_session(row: Mapping[str, Any], messages: Sequence[LoggedMessage]) -> OperatedSession:
    """Return what a study needs of a session's messages."""
    made, latencies = report(row["id"], row["parameters"], messages)
    return OperatedSession(
        row, made, latencies, proposal_records(messages, operator_settings(row["parameters"]))
    )


def study(read: Iterable[OperatedSession], excluded: Sequence[Exclusion] = ()) -> WizardStudy:
    """Report on sessions in the order in which they were played.

    Args:
        read: sessions that are not excluded by hand. Those without an operator are excluded here.
        excluded: others, each with the reason.
    """
    left_out, kept = list(excluded), []
    for each in read:
        if each.report.operated:
            kept.append(each)
        else:
            left_out.append(Exclusion(each.row["id"], "No operator took part."))
    conditions = _conditions(kept)
    records = [record for each in kept for record in each.records]
    shares = sorted(s for each in kept if (s := each.report.agreement.accepted_share) is not None)
    counts = Counter[str]()
    for each in kept:
        counts.update(each.report.counts)
    by_protocol = [each.report for each in kept if each.report.protocol]
    adherences = [found.protocol for found in by_protocol if found.protocol]
    followed = pooled(adherences, len({name for found in by_protocol for name in found.operators}))
    return WizardStudy(
        sessions=[
            _session(each, condition) for each, condition in zip(kept, conditions, strict=True)
        ],
        excluded=left_out,
        operators=list(dict.fromkeys(name for each in kept for name in each.report.operators)),
        duration_s=round(sum(each.report.duration_s for each in kept), 3),
        operated_s=round(sum(each.report.operated_s for each in kept), 3),
        agreement=agreement(records),
        agreement_by_kind=agreement_by_kind(records),
        accepted_shares=(shares[0], round(median(shares), 4), shares[-1]) if shares else None,
        decision_ms=distribution([ms for each in kept for ms in each.latencies.decision]),
        waiting_ms=distribution([ms for each in kept for ms in each.latencies.waiting]),
        link_ms=distribution([ms for each in kept for ms in each.latencies.link]),
        groups=_groups(kept, conditions),
        drift=[_drift(operator, kept) for operator in _deciding(kept)],
        counts=dict(counts),
        protocol=followed,
    )


def _conditions(kept: Sequence[OperatedSession]) -> list[str]:
    """Return the condition of each session: the parts of the plans that are not the same in all."""
    plans = [{**each.report.plan, "task": each.row["task"]} for each in kept]
    differing = [
        name
        for name in (plans[0] if plans else ())
        if len({repr(plan[name]) for plan in plans}) > 1
    ]
    return [", ".join(f"{name} {plan[name]}" for name in differing) or ALIKE for plan in plans]


def _session(each: OperatedSession, condition: str) -> StudySession:
    row, found = each.row, each.report
    return StudySession(
        session=row["id"],
        participant=" and ".join(filter(None, (row["participant"], row.get("partner")))),
        mode=row["mode"],
        operators=found.operators,
        condition=condition,
        duration_s=found.duration_s,
        operated_s=found.operated_s,
        decided=found.agreement.decided,
        accepted_share=found.agreement.accepted_share,
        decision_ms=found.decision_ms.median if found.decision_ms else None,
        remarks=list(_remarks(each)),
    )


def _remarks(each: OperatedSession) -> Iterable[str]:
    if each.row["status"] != "completed":
        yield {"aborted": "stopped early"}.get(each.row["status"], str(each.row["status"]))
    for what, said in (("lost", "operator lost"), ("unproven", "operator not proven to be there")):
        if times := each.report.counts.get(what):
            yield f"{said} {times} ×" if times > 1 else said
    if each.report.undecided_seen:
        yield f"{each.report.undecided_seen} shown without a decision"


def _deciding(kept: Sequence[OperatedSession]) -> list[str]:
    """Return the operators who decided on a proposal, in the order of their first decisions."""
    return list(
        dict.fromkeys(record.by for each in kept for record in each.records if _is_theirs(record))
    )


def _is_theirs(record: ProposalRecord) -> bool:
    return bool(record.verdict and record.by)


def _groups(kept: Sequence[OperatedSession], conditions: Sequence[str]) -> list[OperatorGroup]:
    found: dict[tuple[str, str], list[list[ProposalRecord]]] = {}
    for each, condition in zip(kept, conditions, strict=True):
        of_session: dict[str, list[ProposalRecord]] = {}
        for record in filter(_is_theirs, each.records):
            of_session.setdefault(record.by, []).append(record)
        for operator, records in of_session.items():
            found.setdefault((operator, condition), []).append(records)
    return [
        _group(operator, condition, sessions) for (operator, condition), sessions in found.items()
    ]


def _group(
    operator: str, condition: str, sessions: Sequence[Sequence[ProposalRecord]]
) -> OperatorGroup:
    records = [record for session in sessions for record in session]
    agreed = agreement(records)
    return OperatorGroup(
        operator=operator,
        condition=condition,
        sessions=len(sessions),
        decided=agreed.decided,
        accepted_share=agreed.accepted_share,
        valence_kappa=agreed.valence_kappa,
        decision_ms=distribution(
            [record.decision_ms for record in records if record.decision_ms is not None]
        ),
    )


def _drift(operator: str, kept: Sequence[OperatedSession]) -> Drift:
    medians, shares, first, second = [], [], [], []
    sessions = 0
    for each in kept:
        decided = [
            record for record in each.records if _is_theirs(record) and record.by == operator
        ]
        if not decided:
            continue
        sessions += 1
        shares.append(sum(record.verdict == "accepted" for record in decided) / len(decided))
        times = [record.decision_ms for record in decided if record.decision_ms is not None]
        if times:
            medians.append(median(times))
        half = len(times) // 2
        first += times[:half]
        second += times[len(times) - half :]
    return Drift(
        operator=operator,
        sessions=sessions,
        decision_ms=trend(medians),
        accepted_share=trend(shares),
        first_half_ms=round(median(first), 3) if first else None,
        second_half_ms=round(median(second), 3) if second else None,
    )
