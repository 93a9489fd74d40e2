"""``sar-tui report``: statistics of a session for a paper."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import typer

from sar_tui.cli.common import AsJson, Data, Home, RecordedSession, Tasks, console, print_json

if TYPE_CHECKING:
    from rich.console import Console

    from sar_tui.reports.agreement import Agreement
    from sar_tui.reports.distribution import Distribution
    from sar_tui.reports.wizard import Latencies, WizardReport

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True)

_WIDTH = 76
"""Largest width of a histogram."""
_LISTED = 30
"""Deviations that are printed; JSON has all."""
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
_DEVIATIONS = {"baton": "control"}
"""Printed names of stored spellings."""
_INITIATED = {"phrase": "phrases", "free text": "free texts", "gesture": "gestures", "mode": "changes of mode"}


@app.callback()
def report() -> None:
    """Report on a session."""


@app.command("wizard")
def wizard(
    context: typer.Context,
    session: RecordedSession,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Report what the operators of a session did, how fast, and how far they agreed with the agent."""
    from sar_tui.reports import logged_messages
    from sar_tui.reports.wizard import report as make_report

    with Home.of(context, data, tasks).session(session) as (database, found):
        messages = logged_messages.read(database, found["id"])
    report, latencies = make_report(found["id"], found["parameters"], messages)
    if as_json:
        print_json(report)
        return
    out = console()
    if not report.operated:
        out.print(_without_operator(report), markup=False, soft_wrap=True)
        _print_therapist(out, report)
        if report.deviations:
            _print_deviations(out, report)
        return
    mode = "" if found["mode"] == "live" else f", {found['mode']}"
    who = " and ".join(filter(None, (found["participant"], found.get("partner"))))
    _say(out, f"Session {found['id']}: {found['task']}, {who}{mode}.", end="\n")
    _print(out, report, latencies)


def _without_operator(report: "WizardReport") -> str:
    proposed = sum(row.n for row in report.proposals)
    return f"No operator took part in session {report.session}: the agent decided on all its proposals ({proposed})."


def _print(out: "Console", report: "WizardReport", latencies: "Latencies") -> None:
    share = f" ({report.operated_s / report.duration_s:.0%})" if report.duration_s else ""
    who = f"Operators: {', '.join(report.operators)}. "
    if report.observers:
        who += f"Observers: {', '.join(report.observers)}. "
    _say(out, f"{who}There was an operator for {report.operated_s:.1f} of {report.duration_s:.1f} s{share}.")
    _say(out, f"Plan: {_plan(report.plan)}.")
    _print_proposals(out, report)
    _say(out, f"On the operators' own initiative: {_initiated(report.initiated)}.")
    _print_therapist(out, report)
    _print_latencies(out, report, latencies)
    for line in _agreement(report.agreement):
        _say(out, line, end="\n")
    out.print()
    _print_deviations(out, report)
    _print_pauses(out, report)
    _print_notes(out, report)
    _say(
        out,
        "A paper must also report what is not recorded (Riek 2012): who the operators were, what they knew of the "
        "hypotheses, how they were trained and instructed, how their errors were judged, and what the participant was "
        "told.",
        end="\n",
    )


def _print_therapist(out: "Console", report: "WizardReport") -> None:
    if report.therapist:
        _say(out, f"A therapist, at the participant's terminal: {_initiated(report.therapist)}.")


def _say(out: "Console", text: str, end: str = "\n\n") -> None:
    out.print(text, markup=False, soft_wrap=True, end=end)


def _print_proposals(out: "Console", report: "WizardReport") -> None:
    from sar_tui.cli.tables import add, table
    from sar_tui.reports.presence import KINDS

    numbers = ("time", "n", "of kind")
    head = table("proposals", "mode", *numbers, "outcomes", right=numbers, whole=("proposals", "mode"))
    for row in report.proposals:
        fates = ", ".join(f"{n} {_FATES[fate]}" for fate, n in row.fates.items())
        mode = (row.mode, _percent(row.time_share)) if row.kind in KINDS else ("", "")  # a filler has no mode
        add(head, row.kind, *mode, row.n, _percent(row.share), fates)
    out.print(head)
    out.print()


def _plan(plan: dict[str, object]) -> str:
    """Return the settings by name, without kinds that were autonomous from the start."""
    from sar_tui.reports.presence import KINDS

    kinds = {f"operator_{kind}" for kind in KINDS}
    said = (f"{name} {value}" for name, value in plan.items() if name not in kinds or value != "autonomous")
    return ", ".join(said)


def _percent(share: float | None) -> str:
    return "" if share is None else f"{share:.0%}"


def _initiated(counts: dict[str, int]) -> str:
    return ", ".join(f"{_INITIATED.get(what, what)} {n}" for what, n in sorted(counts.items())) or "nothing"


def _print_latencies(out: "Console", report: "WizardReport", latencies: "Latencies") -> None:
    from sar_tui.cli.tables import add, table
    from sar_tui.reports.distribution import histogram

    numbers = ("n", "median", "IQR", "5 %", "95 %", "worst")
    head = table("latency, ms", *numbers, right=numbers)
    for name, found in (
        ("on screen → operator's key", report.decision_ms),
        ("pending → decided by anyone", report.waiting_ms),
        ("operator's key → session", report.link_ms),
    ):
        add(head, name, *_figures(found))
    out.print(head)
    out.print()
    drawing = histogram(latencies.decision, min(out.width, _WIDTH))
    if drawing:
        _say(out, "From a proposal on the operator's screen to the key:", end="\n")
        _say(out, "\n".join(drawing))
    if report.undecided_seen:
        _say(out, f"{_count(report.undecided_seen, 'proposal')} appeared on the operator's screen and got no key.")


def _figures(found: "Distribution | None") -> Sequence[object]:
    if found is None:
        return (0, *[None] * 5)
    return (found.n, *(f"{value:.1f}" for value in (found.median, found.iqr, found.p5, found.p95, found.worst)))


def _agreement(found: "Agreement") -> Iterator[str]:
    if not found.decided:
        yield "No operator decided on a proposal."
        return
    yield (
        f"Operators decided on {_count(found.decided, 'proposal')}: {found.accepted} as proposed "
        f"({_percent(found.accepted_share)}), {found.edited} edited, {found.vetoed} vetoed."
    )
    if found.words_changed_median is not None and found.words_changed_most is not None:
        yield (
            f"{_count(found.edits_of_words, 'edit')} changed words: {found.words_changed_median:.0%} of them in the "
            f"median, {found.words_changed_most:.0%} at most."
        )
    if found.valences:
        kappa = (
            "not defined, because there was only one valence" if found.valence_kappa is None else found.valence_kappa
        )
        yield (
            f"The valence was overridden in {found.valences_overridden} of {found.valences} decided proposals that had "
            f"one and were said; Cohen's kappa of proposed and said: {kappa}."
        )


def _print_deviations(out: "Console", report: "WizardReport") -> None:
    from sar_tui.cli.tables import add, table

    for absence in report.absences:
        back = "until one was back" if absence.came_back else "until the run ended"
        _say(
            out,
            f"No operator from {absence.at_s:.1f} s of run {absence.run} on, for {absence.duration_s:.1f} s, {back} "
            f"({absence.actor} {absence.state}).",
            end="\n",
        )
    if not report.deviations:
        _say(out, "There was no deviation from the session's plan.")
        return
    counts = ", ".join(f"{_DEVIATIONS.get(what, what)} {n}" for what, n in sorted(report.counts.items()))
    _say(out, f"Deviations from the session's plan: {counts}.")
    head = table("run", "at, s", "what", "who", "detail", right=("run", "at, s"), whole=("what",))
    for each in report.deviations[:_LISTED]:
        notes = (each.detail, f"{each.duration_s:.1f} s" if each.duration_s is not None else "")
        add(
            head,
            each.run,
            f"{each.at_s:.1f}",
            _DEVIATIONS.get(each.what, each.what),
            each.actor,
            ", ".join(filter(None, notes)),
        )
    out.print(head)
    if len(report.deviations) > _LISTED:
        _say(out, f"… and {len(report.deviations) - _LISTED} more: --json has them all.", end="\n")
    out.print()


def _print_pauses(out: "Console", report: "WizardReport") -> None:
    for pause in report.pauses:
        reason = f" ({pause.reason})" if pause.reason else ""
        ended = f"{pause.ended_by} resumed" if pause.ended_by else "until the run ended"
        _say(
            out,
            f"The participant paused at {pause.at_s:.1f} s of run {pause.run}{reason}, for {pause.duration_s:.1f} s; "
            f"{ended}.",
            end="\n",
        )
    if report.pauses:
        out.print()


def _print_notes(out: "Console", report: "WizardReport") -> None:
    from sar_tui.cli.tables import add, table

    _say(out, f"{_count(report.notes, 'note')}, {_count(report.event_marks, 'event mark')}.")
    if not report.written:
        return
    head = table("run", "at, s", "who", "note or mark", right=("run", "at, s"))
    for each in report.written:
        add(head, each.run, f"{each.at_s:.1f}", each.actor, ": ".join(filter(None, (each.label, each.text))))
    out.print(head)
    out.print()


def _count(n: int, what: str) -> str:
    return f"{n} {what}{'' if n == 1 else 's'}"
