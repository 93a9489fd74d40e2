"""The report on the operators of a session in words."""

from collections.abc import Iterator, Mapping

from sar_tui.reports.agreement import Agreement
from sar_tui.reports.distribution import Distribution, histogram
from sar_tui.reports.presence import KINDS
from sar_tui.reports.protocol_words import section as protocol_section
from sar_tui.reports.sections import Drawing, Section, Table
from sar_tui.reports.wizard import Latencies, WizardReport

NOT_RECORDED = (
    "A paper must also report what is not recorded (Riek 2012): who the operators were, what they "
    "knew of the hypotheses, how they were trained and instructed, how their errors were judged, "
    "and what the participant was told."
)
LATENCY_COLUMNS = ("n", "median", "IQR", "5 %", "95 %", "worst")
_LISTED = 30
"""Deviations that are shown; JSON has all."""
_FATES = {
    "agent": "decided by the agent",
    "accepted": "accepted",
    "edited": "edited",
    "vetoed": "vetoed",
    "cut_off": "cut off",
    "timed_out_done": "timed out, then done",
    "timed_out_dropped": "timed out, then dropped",
    "no_operator_done": "done without an operator",
    "no_operator_dropped": "dropped without an operator",
    "manual_dropped": "left to the operator, not done",
    "late": "dropped: too late",
    "stopped": "dropped: stopped",
    "amended": "dropped: scored again",
    "mode_changed": "dropped: the mode was changed",
    "open": "undecided",
}
DEVIATIONS = {"baton": "control"}
"""Shown names of stored spellings."""
_INITIATED = {
    "phrase": "phrases",
    "free text": "free texts",
    "gesture": "gestures",
    "mode": "changes of mode",
}


def sections(found: WizardReport, latencies: Latencies, width: int) -> list[Section]:
    """Return the report in words. ``width``: of its drawings, in characters."""
    if not found.operated:
        proposed = sum(row.n for row in found.proposals)
        alone = (
            f"No operator took part in session {found.session}: the agent decided on all its "
            f"proposals ({proposed})."
        )
        parts = [alone, *_therapist(found)]
        return [Section("Operators", parts), *([_deviations(found)] if found.deviations else [])]
    share = f" ({found.operated_s / found.duration_s:.0%})" if found.duration_s else ""
    who = f"Operators: {', '.join(found.operators)}. "
    if found.observers:
        who += f"Observers: {', '.join(found.observers)}. "
    who += f"There was an operator for {found.operated_s:.1f} of {found.duration_s:.1f} s{share}."
    initiated = f"On the operators' own initiative: {_initiated(found.initiated)}."
    return [
        Section("Operators", [who, f"Plan: {_plan(found.plan)}."]),
        Section("Proposals", [_proposals(found), initiated, *_answers(found), *_therapist(found)]),
        Section("Latencies", list(_latencies(found, latencies, width))),
        Section("Agreement", ["\n".join(agreement_sentences(found.agreement))]),
        *([protocol_section(found.protocol)] if found.protocol else []),
        _deviations(found),
        *_pauses(found),
        _notes(found),
        Section("To add", [NOT_RECORDED]),
    ]


def percent(share: float | None) -> str:
    """Return a share in percent; empty if there is none."""
    return "" if share is None else f"{share:.0%}"


def count(n: int, what: str) -> str:
    """Return a number of things: "1 proposal", "2 proposals"."""
    return f"{n} {what}{'' if n == 1 else 's'}"


def figures(found: Distribution | None) -> tuple[str, ...]:
    """Return the cells of a distribution (ms), for `LATENCY_COLUMNS`."""
    if found is None:
        return ("0", *[""] * 5)
    values = (found.median, found.iqr, found.p5, found.p95, found.worst)
    return (str(found.n), *(f"{value:.1f}" for value in values))


def agreement_sentences(found: Agreement) -> Iterator[str]:
    """Yield sentences on how far operators agreed with the agent."""
    if not found.decided:
        yield "No operator decided on a proposal."
        return
    yield (
        f"Operators decided on {count(found.decided, 'proposal')}: {found.accepted} as proposed "
        f"({percent(found.accepted_share)}), {found.edited} edited, {found.vetoed} vetoed."
    )
    if found.words_changed_median is not None and found.words_changed_most is not None:
        yield (
            f"{count(found.edits_of_words, 'edit')} changed words: "
            f"{found.words_changed_median:.0%} of them in the "
            f"median, {found.words_changed_most:.0%} at most."
        )
    if found.valences:
        kappa = (
            "not defined, because there was only one valence"
            if found.valence_kappa is None
            else found.valence_kappa
        )
        yield (
            f"The valence was overridden in {found.valences_overridden} of {found.valences} "
            "decided proposals that had "
            f"one and were said; Cohen's kappa of proposed and said: {kappa}."
        )


def deviation_counts(counts: Mapping[str, int]) -> str:
    """Return the numbers of deviations by type."""
    return ", ".join(f"{DEVIATIONS.get(what, what)} {n}" for what, n in sorted(counts.items()))


def _answers(found: WizardReport) -> list[str]:
    if not (acts := sum(found.answers.values())):
        return []
    shares = ", ".join(
        f"{name} {n} ({percent(n / acts)})"
        for outcome, name in (("done", "done"), ("refused", "not done"), ("late", "too late"))
        if (n := found.answers.get(outcome, 0))
    )
    return [f"The session answered {count(acts, 'act')} of operators: {shares}."]


def _therapist(found: WizardReport) -> list[str]:
    if not found.therapist:
        return []
    return [f"A therapist, at the participant's terminal: {_initiated(found.therapist)}."]


def _plan(plan: Mapping[str, object]) -> str:
    """Return the settings by name, without kinds that were autonomous from the start."""
    kinds = {f"operator_{kind}" for kind in KINDS}
    said = (
        f"{name} {value}"
        for name, value in plan.items()
        if name not in kinds or value != "autonomous"
    )
    return ", ".join(said)


def _proposals(found: WizardReport) -> Table:
    rows = []
    for row in found.proposals:
        fates = ", ".join(f"{n} {_FATES[fate]}" for fate, n in row.fates.items())
        # a filler has no mode
        mode = (row.mode, percent(row.time_share)) if row.kind in KINDS else ("", "")
        rows.append((row.kind, *mode, str(row.n), percent(row.share), fates))
    numbers = ("time", "n", "of kind")
    return Table(("proposals", "mode", *numbers, "outcomes"), rows, numbers, ("proposals", "mode"))


def _initiated(counts: Mapping[str, int]) -> str:
    return (
        ", ".join(f"{_INITIATED.get(what, what)} {n}" for what, n in sorted(counts.items()))
        or "nothing"
    )


def _latencies(
    found: WizardReport, latencies: Latencies, width: int
) -> Iterator[str | Table | Drawing]:
    rows = [
        (name, *figures(times))
        for name, times in (
            ("on screen → operator's key", found.decision_ms),
            ("pending → decided by anyone", found.waiting_ms),
            ("operator's key → session", found.link_ms),
        )
    ]
    yield Table(("latency, ms", *LATENCY_COLUMNS), rows, LATENCY_COLUMNS)
    if drawing := histogram(latencies.decision, width):
        yield Drawing("From a proposal on the operator's screen to the key:", drawing)
    if found.undecided_seen:
        yield (
            f"{count(found.undecided_seen, 'proposal')} appeared on the operator's screen and "
            "got no key."
        )


def _deviations(found: WizardReport) -> Section:
    lines = []
    for absence in found.absences:
        back = "until one was back" if absence.came_back else "until the run ended"
        lines.append(
            f"No operator from {absence.at_s:.1f} s of run {absence.run} on, for "
            f"{absence.duration_s:.1f} s, {back} ({absence.actor} {absence.state})."
        )
    if not found.deviations:
        return Section(
            "Deviations", ["\n".join([*lines, "There was no deviation from the session's plan."])]
        )
    said = f"Deviations from the session's plan: {deviation_counts(found.counts)}."
    rows = []
    for each in found.deviations[:_LISTED]:
        notes = (each.detail, f"{each.duration_s:.1f} s" if each.duration_s is not None else "")
        what = DEVIATIONS.get(each.what, each.what)
        rows.append(
            (str(each.run), f"{each.at_s:.1f}", what, each.actor, ", ".join(filter(None, notes)))
        )
    left = len(found.deviations) - _LISTED
    more = f"… and {left} more: --json has them all." if left > 0 else ""
    heads = ("run", "at, s", "what", "who", "detail")
    return Section(
        "Deviations", ["\n".join([*lines, said]), Table(heads, rows, heads[:2], ("what",), more)]
    )


def _pauses(found: WizardReport) -> list[Section]:
    lines = []
    for pause in found.pauses:
        reason = f" ({pause.reason})" if pause.reason else ""
        ended = f"{pause.ended_by} resumed" if pause.ended_by else "until the run ended"
        lines.append(
            f"The participant paused at {pause.at_s:.1f} s of run {pause.run}{reason}, for "
            f"{pause.duration_s:.1f} s; {ended}."
        )
    return [Section("Pauses", ["\n".join(lines)])] if lines else []


def _notes(found: WizardReport) -> Section:
    said = f"{count(found.notes, 'note')}, {count(found.event_marks, 'event mark')}."
    if not found.written:
        return Section("Notes", [said])
    rows = [
        (
            str(each.run),
            f"{each.at_s:.1f}",
            each.actor,
            ": ".join(filter(None, (each.label, each.text))),
        )
        for each in found.written
    ]
    heads = ("run", "at, s", "who", "note or mark")
    return Section("Notes", [said, Table(heads, rows, heads[:2])])
