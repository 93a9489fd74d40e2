"""Operator statistics that a Wizard-of-Oz paper must report (Riek 2012), as far as they are
recorded. Pure.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any, get_args

import msgspec

from sar_tui.loop.topics import (
    COMMAND,
    DECISION,
    MODE,
    NOTE_ADDED,
    PROTOCOL,
    PROTOCOL_TICKED,
    REASON,
    REMARK,
)
from sar_tui.model import messages as m
from sar_tui.reports.agreement import Agreement, agreement
from sar_tui.reports.deviations import Deviation, Pause, deviations, pauses
from sar_tui.reports.distribution import Distribution, distribution
from sar_tui.reports.logged_messages import LoggedMessage, peers, spans
from sar_tui.reports.presence import KINDS, MODES, Absence, mode_times, presence, seconds
from sar_tui.reports.proposals import Fate, ProposalRecord, proposal_records
from sar_tui.reports.protocol import Adherence, adherence
from sar_tui.rules.parameters import TaskParameters


class Note(msgspec.Struct, frozen=True):
    """Note, or event mark with its ``label``. ``at_s``: of the key, from the start of its run."""

    run: int
    at_s: float
    actor: str
    text: str
    label: str


def notes(messages: Sequence[LoggedMessage]) -> list[Note]:
    """Return all notes and event marks of a session, in order, without those that were taken
    back.
    """
    known = spans(messages)
    taken_back = {
        (run, message.actor, message.done)
        for run, _, message in messages
        if isinstance(message, m.TakenBack) and message.what == "note"
    }
    return [
        Note(
            run,
            seconds((message.at or at) - known[run].began),
            message.actor,
            message.text,
            message.label,
        )
        for run, at, message in messages
        if isinstance(message, m.NoteAdded)
        and run in known
        and (run, message.actor, message.at or at) not in taken_back
    ]


_PLANNED = (
    *(f"operator_{kind}" for kind in KINDS),
    "feedback_delay_ms",
    "filler",
    "operator_time_ms",
    "operator_ms_per_word",
    "operator_timeout",
    "operator_lost",
    "operator_lost_ms",
)
"""Settings of modes and times of decision."""
_ACTS = {
    topic.name
    for topic in (COMMAND, DECISION, REMARK, MODE, NOTE_ADDED, PROTOCOL, PROTOCOL_TICKED, REASON)
}
"""Names of the topics of acts that are answered."""


class ProposalSummary(msgspec.Struct, frozen=True):
    """Proposals of one kind in one mode.

    Attributes:
        time_s: for which the mode was set; ``time_share``: of the session.
        unattended_s: of that, without an operator.
        n: number of proposals; ``share``: of those of the kind.
        fates: counts by outcome (see `proposals.Fate`), which add up to ``n``.
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
    """Report on the operators of a session. Times in s, latencies in ms.

    Attributes:
        plan: operator settings at the start of the session.
        operated: True if there was an operator at any time.
        initiated: counts of acts on the operators' own initiative, by kind.
        answers: counts of the operators' acts by the session's answer: ``done``, ``refused`` (by
            the link, too), ``late``. Earlier versions answered none.
        therapist: counts of what a therapist did at the participant's terminal: commands, settings
            by name, notes.
        decision_ms: from the appearance of a proposal on the operator's screen to the deciding key.
        undecided_seen: number of proposals that appeared without being decided by a key.
        waiting_ms: time pending until a proposal was decided by anyone.
        link_ms: from the time stamp of an operator's key to its arrival in the session.
        counts: of the deviations by type.
        pauses: the participant's own.
        notes, event_marks: numbers of them.
        written: the notes and event marks.
        protocol: adherence to the operators' protocol; None if they had none.
    """

    session: str
    plan: dict[str, Any]
    operated: bool
    operators: list[str]
    observers: list[str]
    duration_s: float
    operated_s: float
    proposals: list[ProposalSummary]
    initiated: dict[str, int]
    answers: dict[str, int]
    therapist: dict[str, int]
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
    written: list[Note]
    protocol: Adherence | None = None


class Latencies(msgspec.Struct, frozen=True):
    """Single latencies (ms), for histograms."""

    decision: list[float]
    waiting: list[float]
    link: list[float]


def report(
    session: str, parameters: Mapping[str, Any], messages: Sequence[LoggedMessage]
) -> tuple[WizardReport, Latencies]:
    """Report on a session.

    Args:
        session: its id.
        parameters: of its task, as stored; older versions may lack some.
        messages: as recorded.
    """
    settings = operator_settings(parameters)
    operators = peers(messages, "operator")
    records = proposal_records(messages, settings)
    there = presence(messages)
    found = deviations(messages, operators)
    latencies = Latencies(
        decision=[each.decision_ms for each in records if each.decision_ms is not None],
        waiting=[each.waiting_ms for each in records if each.waiting_ms is not None],
        link=list(_link_ms(messages, operators)),
    )
    written = notes(messages)
    counts = Counter[str]()
    for deviation in found:
        counts[deviation.what] += deviation.count
    whole = WizardReport(
        session=session,
        plan={name: getattr(settings, name) for name in _PLANNED},
        operated=bool(operators),
        operators=operators,
        observers=peers(messages, "observer"),
        duration_s=there.duration_s,
        operated_s=there.operated_s,
        proposals=_proposals(records, messages, settings, there.duration_s),
        initiated=dict(Counter(_initiated(messages, operators))),
        answers=_answers(messages, operators),
        therapist=dict(Counter(_by_therapist(messages))),
        decision_ms=distribution(latencies.decision),
        undecided_seen=sum(bool(each.seen) and each.key_at is None for each in records),
        waiting_ms=distribution(latencies.waiting),
        link_ms=distribution(latencies.link),
        agreement=agreement(records),
        agreement_by_kind=agreement_by_kind(records),
        counts=dict(counts),
        absences=list(there.absences),
        deviations=found,
        pauses=pauses(messages, operators),
        notes=sum(not note.label for note in written),
        event_marks=sum(bool(note.label) for note in written),
        written=written,
        protocol=adherence(messages, records, operators),
    )
    return whole, latencies


def operator_settings(parameters: Mapping[str, Any]) -> TaskParameters:
    """Return the settings of a session from its stored parameters."""
    # earlier versions gave each proposal the same time
    given = {
        "operator_ms_per_word": 0,
        **parameters,
    }
    return msgspec.convert(given, TaskParameters)


def _proposals(
    records: Sequence[ProposalRecord],
    messages: Sequence[LoggedMessage],
    settings: TaskParameters,
    duration_s: float,
) -> list[ProposalSummary]:
    """Return a row for each kind and mode that was ever set or has a proposal."""
    times = {(time.kind, time.mode): time for time in mode_times(messages, settings)}
    of_kind = Counter(record.kind for record in records)
    rows = []
    for kind in (*KINDS, "filler"):
        for mode in MODES:
            here = [record for record in records if (record.kind, record.mode) == (kind, mode)]
            time = times.get((kind, mode))  # type: ignore[arg-type]
            if not here and time is None:
                continue
            fates = Counter(record.fate for record in here)
            rows.append(
                ProposalSummary(
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


def agreement_by_kind(records: Sequence[ProposalRecord]) -> dict[str, Agreement]:
    """Return the agreement for each kind on which an operator decided."""
    decided: dict[str, list[ProposalRecord]] = {}
    for record in records:
        if record.verdict:
            decided.setdefault(record.kind, []).append(record)
    return {kind: agreement(decided[kind]) for kind in KINDS if kind in decided}


def _share(part: float, whole: float) -> float | None:
    return round(part / whole, 4) if whole else None


def _initiated(messages: Iterable[LoggedMessage], operators: Collection[str]) -> Iterator[str]:
    """Yield the acts on the operators' own initiative: remarks by source, commands, changes of
    mode.
    """
    for _, _, message in messages:
        match message:
            case m.Remark():
                yield message.source
            case m.SessionCommand() if message.actor in operators:
                yield message.command
            case m.ModeChanged():
                yield "mode"


def _answers(messages: Iterable[LoggedMessage], operators: Collection[str]) -> dict[str, int]:
    """Count the answers to operators' acts. What the link refused, it reports together."""
    counts = Counter[str]()
    for _, _, message in messages:
        match message:
            case m.ActAnswered() if message.actor in operators:
                counts[message.outcome] += 1
            case m.PeerRequestRefused() if message.actor in operators and message.what in _ACTS:
                counts["refused"] += message.count
    return dict(counts)


def _by_therapist(messages: Iterable[LoggedMessage]) -> Iterator[str]:
    """Yield the acts of a therapist in the participant's terminal: commands, names of settings,
    "note".
    """
    for _, _, message in messages:
        match message:
            case m.SessionCommand(actor="therapist"):
                yield message.command
            case m.SettingChanged(actor="therapist"):
                yield message.name
            case m.NoteAdded(actor="therapist"):
                yield "note"


def _link_ms(messages: Iterable[LoggedMessage], operators: Collection[str]) -> Iterator[float]:
    """Yield the time from the time stamp of each act to its arrival."""
    acts = m.SessionCommand | m.Decision | m.Remark | m.ModeChanged | m.ProposalSeen | m.NoteAdded
    for _, at, message in messages:
        if isinstance(message, acts) and message.at and message.actor in operators:
            yield (at - message.at) / 1e6
