"""What a paper has to report about its wizard (Riek 2012), as far as a session's record can tell. Pure."""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any, get_args

import msgspec

from sar_tui.framework import messages as m
from sar_tui.framework.parameters import TaskParameters, current_values
from sar_tui.reports.agreement import Agreement, agreement
from sar_tui.reports.deviations import Deviation, deviations
from sar_tui.reports.distribution import Distribution, distribution
from sar_tui.reports.notes import Written, written
from sar_tui.reports.pauses import Pause, pauses
from sar_tui.reports.presence import KINDS, MODES, Absence, mode_times, presence
from sar_tui.reports.proposals import Case, Fate, cases
from sar_tui.reports.record import Told, people

_PLANNED = (
    *(f"operator_{kind}" for kind in KINDS),
    "feedback_delay_ms",
    "filler",
    "operator_time_ms",
    "operator_timeout",
    "operator_lost",
    "operator_lost_ms",
)
"""The settings that say who decides, and how long that may take."""


class Proposals(msgspec.Struct, frozen=True):
    """A kind of proposal in one mode: for how long that was set, how many there were, and what became of them.

    ``time_s``, and its share of the session; ``unattended_s``: of that, without an operator. ``n``, and its share of
    the proposals of the kind. ``fates``: how many came to what (see `cases.Fate`); they add up to ``n``.
    """

    kind: str
    mode: str
    time_s: float
    time_share: float | None
    unattended_s: float
    n: int
    share: float | None
    fates: dict[str, int]


class WizardReport(msgspec.Struct, frozen=True):
    """Everything; times in s, latencies in ms.

    ``plan``: the settings that rule over operators, as they were when the session began. ``operated``: whether an
    operator was ever there. ``initiated``: what operators did of their own accord, by what it was. ``decision_ms``:
    from a proposal's standing on the operator's screen to the key; ``undecided_seen``: so many stood there without
    one; ``waiting_ms``: from an offer until it was decided, by whomever; ``link_ms``: from the stamp of an operator's
    key to its arrival in the session. ``counts``: of the deviations, by what they are. ``pauses``: the participant's
    own. ``written``: the notes and event marks themselves.
    """

    session: str
    plan: dict[str, Any]
    operated: bool
    operators: list[str]
    observers: list[str]
    duration_s: float
    operated_s: float
    proposals: list[Proposals]
    initiated: dict[str, int]
    decision_ms: Distribution | None
    undecided_seen: int
    waiting_ms: Distribution | None
    link_ms: Distribution | None
    agreement: Agreement
    agreement_by_kind: dict[str, Agreement]
    counts: dict[str, int]
    absences: list[Absence]
    deviations: list[Deviation]
    pauses: list[Pause]
    notes: int
    event_marks: int
    written: list[Written]


class Times(msgspec.Struct, frozen=True):
    """The latencies themselves, to be drawn, ms."""

    decision: list[float]
    waiting: list[float]
    link: list[float]


def report(session: str, parameters: Mapping[str, Any], told: Sequence[Told]) -> tuple[WizardReport, Times]:
    """Report on a session.

    Args:
        session: its id.
        parameters: of its task, as stored; those of versions that had no operator may be missing.
        told: its messages.
    """
    settings = msgspec.convert(current_values(TaskParameters, parameters), TaskParameters)
    operators = people(told, "operator")
    proposed = cases(told, settings)
    there = presence(told)
    found = deviations(told, operators)
    times = Times(
        decision=[case.decision_ms for case in proposed if case.decision_ms is not None],
        waiting=[case.waiting_ms for case in proposed if case.waiting_ms is not None],
        link=list(_link_ms(told, operators)),
    )
    noted = written(told)
    counts = Counter[str]()
    for deviation in found:
        counts[deviation.what] += deviation.count
    made = WizardReport(
        session=session,
        plan={name: getattr(settings, name) for name in _PLANNED},
        operated=bool(operators),
        operators=operators,
        observers=people(told, "observer"),
        duration_s=there.duration_s,
        operated_s=there.operated_s,
        proposals=_proposals(proposed, told, settings, there.duration_s),
        initiated=dict(Counter(_initiated(told, operators))),
        decision_ms=distribution(times.decision),
        undecided_seen=sum(bool(case.seen) and case.keyed is None for case in proposed),
        waiting_ms=distribution(times.waiting),
        link_ms=distribution(times.link),
        agreement=agreement(proposed),
        agreement_by_kind=_agreement_by_kind(proposed),
        counts=dict(counts),
        absences=list(there.absences),
        deviations=found,
        pauses=pauses(told, operators),
        notes=sum(not note.label for note in noted),
        event_marks=sum(bool(note.label) for note in noted),
        written=noted,
    )
    return made, times


def _proposals(
    proposed: Sequence[Case], told: Sequence[Told], settings: TaskParameters, duration_s: float
) -> list[Proposals]:
    """A row for each kind and mode that was set at some time, or in which there was a proposal."""
    times = {(time.kind, time.mode): time for time in mode_times(told, settings)}
    of_kind = Counter(case.kind for case in proposed)
    rows = []
    for kind in (*KINDS, "filler"):
        for mode in MODES:
            here = [case for case in proposed if (case.kind, case.mode) == (kind, mode)]
            time = times.get((kind, mode))  # type: ignore[arg-type]
            if not here and time is None:
                continue
            fates = Counter(case.fate for case in here)
            rows.append(
                Proposals(
                    kind=kind,
                    mode=mode,
                    time_s=time.time_s if time else 0.0,
                    time_share=_share(time.time_s if time else 0.0, duration_s),
                    unattended_s=time.unattended_s if time else 0.0,
                    n=len(here),
                    share=_share(len(here), of_kind[kind]),  # type: ignore[index]
                    fates={fate: fates[fate] for fate in get_args(Fate) if fates[fate]},
                )
            )
    return rows


def _agreement_by_kind(proposed: Sequence[Case]) -> dict[str, Agreement]:
    """Only of the kinds on which an operator decided."""
    decided: dict[str, list[Case]] = {}
    for case in proposed:
        if case.verdict:
            decided.setdefault(case.kind, []).append(case)
    return {kind: agreement(decided[kind]) for kind in KINDS if kind in decided}


def _share(part: float, whole: float) -> float | None:
    return round(part / whole, 4) if whole else None


def _initiated(told: Iterable[Told], operators: Collection[str]) -> Iterator[str]:
    """What operators did without being asked: by kind of remark, by command, modes."""
    for _, _, message in told:
        match message:
            case m.Remark():
                yield message.source
            case m.Operator() if message.actor in operators:
                yield message.command
            case m.ModeChanged():
                yield "mode"


def _link_ms(told: Iterable[Told], operators: Collection[str]) -> Iterator[float]:
    """From the stamp of each act to its arrival."""
    acts = m.Operator | m.Decision | m.Remark | m.ModeChanged | m.ProposalSeen | m.NoteAdded
    for _, at, message in told:
        if isinstance(message, acts) and message.at and message.actor in operators:
            yield (at - message.at) / 1e6
