"""``sar-tui report``: what a paper has to report about a session."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks, console, print_json

if TYPE_CHECKING:
    from rich.console import Console

    from sar_tui.reports.agreement import Agreement
    from sar_tui.reports.distribution import Distribution
    from sar_tui.reports.wizard import Times, WizardReport

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True)

_WIDTH = 76
"""Of a histogram, at most."""
_LISTED = 30
"""So many deviations are printed; JSON has all."""
_FATES = {
    "agent": "the agent's own",
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
    "amended": "dropped: scored anew",
    "mode_changed": "dropped: the mode was changed",
    "open": "undecided",
}
_INITIATED = {"phrase": "phrases", "free text": "free texts", "gesture": "gestures", "mode": "changes of mode"}


@app.callback()
def report() -> None:
    """Report on a session, as a paper has to."""


@app.command("wizard")
def wizard(
    context: typer.Context,
    session: Annotated[
        str, typer.Argument(metavar="SESSION|last", help="Its id, or the beginning of it.", show_default=False)
    ],
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Report what the operator of a session did, how fast, and how far they agreed with the agent."""
    from sar_tui.reports import record
    from sar_tui.reports.wizard import report as make
    from sar_tui.store import sessions as store

    home = Home.of(context, data, tasks)
    with home.database() as database:
        found = store.find(database, home.folder, session)
        told = record.read(database, found["id"])
    made, times = make(found["id"], found["parameters"], told)
    if as_json:
        print_json(made)
        return
    out = console()
    if not made.operated:
        out.print(_without(made), markup=False, soft_wrap=True)
        if made.deviations:
            _print_deviations(out, made)
        return
    mode = "" if found["mode"] == "live" else f", {found['mode']}"
    who = " and ".join(filter(None, (found["participant"], found.get("partner"))))
    _say(out, f"Session {found['id']}: {found['task']}, {who}{mode}.", end="\n")
    _print(out, made, times)


def _without(made: "WizardReport") -> str:
    proposed = sum(row.n for row in made.proposals)
    return (
        f"No operator took part in session {made.session}: all it proposed ({proposed}) was the agent's own to decide."
    )


def _print(out: "Console", made: "WizardReport", times: "Times") -> None:
    share = f" ({made.operated_s / made.duration_s:.0%})" if made.duration_s else ""
    who = f"Operators: {', '.join(made.operators)}. "
    if made.observers:
        who += f"Observers: {', '.join(made.observers)}. "
    _say(out, f"{who}There was an operator for {made.operated_s:.1f} of {made.duration_s:.1f} s{share}.")
    _say(out, f"Plan: {_plan(made.plan)}.")
    _print_proposals(out, made)
    _say(out, f"Of the operators' own accord: {_initiated(made.initiated)}.")
    _print_latencies(out, made, times)
    for line in _agreement(made.agreement):
        _say(out, line, end="\n")
    out.print()
    _print_deviations(out, made)
    _print_pauses(out, made)
    _print_written(out, made)
    _say(
        out,
        "What no record tells has to be reported beside (Riek 2012): who the operators were, what they knew of the "
        "hypotheses, how they were trained and instructed, how their errors were judged, and what the participant was "
        "told.",
        end="\n",
    )


def _say(out: "Console", words: str, end: str = "\n\n") -> None:
    out.print(words, markup=False, soft_wrap=True, end=end)


def _print_proposals(out: "Console", made: "WizardReport") -> None:
    from sar_tui.cli.tables import add, table
    from sar_tui.reports.presence import KINDS

    numbers = ("time", "n", "of kind")
    head = table("proposals", "mode", *numbers, "what became of them", right=numbers, whole=("proposals", "mode"))
    for row in made.proposals:
        fates = ", ".join(f"{n} {_FATES[fate]}" for fate, n in row.fates.items())
        ruled = (row.mode, _percent(row.time_share)) if row.kind in KINDS else ("", "")  # nobody rules over a filler
        add(head, row.kind, *ruled, row.n, _percent(row.share), fates)
    out.print(head)
    out.print()


def _plan(plan: dict[str, object]) -> str:
    """By the names under which they are set; a kind that was the agent's own from the beginning is not named."""
    from sar_tui.reports.presence import KINDS

    kinds = {f"operator_{kind}" for kind in KINDS}
    said = (f"{name} {value}" for name, value in plan.items() if name not in kinds or value != "autonomous")
    return ", ".join(said)


def _percent(share: float | None) -> str:
    return "" if share is None else f"{share:.0%}"


def _initiated(counts: dict[str, int]) -> str:
    return ", ".join(f"{_INITIATED.get(what, what)} {n}" for what, n in sorted(counts.items())) or "nothing"


def _print_latencies(out: "Console", made: "WizardReport", times: "Times") -> None:
    from sar_tui.cli.tables import add, table
    from sar_tui.reports.distribution import histogram

    numbers = ("n", "median", "IQR", "5 %", "95 %", "worst")
    head = table("latency, ms", *numbers, right=numbers)
    for name, found in (
        ("on screen → operator's key", made.decision_ms),
        ("offered → decided, by whomever", made.waiting_ms),
        ("operator's key → session", made.link_ms),
    ):
        add(head, name, *_figures(found))
    out.print(head)
    out.print()
    drawing = histogram(times.decision, min(out.width, _WIDTH))
    if drawing:
        _say(out, "From a proposal on the operator's screen to the key:", end="\n")
        _say(out, "\n".join(drawing))
    if made.undecided_seen:
        _say(out, f"{_count(made.undecided_seen, 'proposal')} stood on the operator's screen without a key.")


def _figures(found: "Distribution | None") -> Sequence[object]:
    if found is None:
        return (0, *[None] * 5)
    return (found.n, *(f"{value:.1f}" for value in (found.median, found.iqr, found.p5, found.p95, found.worst)))


def _agreement(found: "Agreement") -> Iterator[str]:
    if not found.decided:
        yield "On no proposal did an operator decide."
        return
    yield (
        f"On {_count(found.decided, 'proposal')} an operator decided: {found.accepted} as proposed "
        f"({_percent(found.accepted_share)}), {found.edited} edited, {found.vetoed} vetoed."
    )
    if found.words_changed_median is not None and found.words_changed_most is not None:
        yield (
            f"{_count(found.edits_of_words, 'edit')} changed words: {found.words_changed_median:.0%} of them in the "
            f"median, {found.words_changed_most:.0%} at most."
        )
    if found.valences:
        kappa = "not defined, for there was one valence only" if found.valence_kappa is None else found.valence_kappa
        yield (
            f"The valence was overridden in {found.valences_overridden} of {found.valences} that had one and were "
            f"to be said; Cohen's kappa of proposed and said: {kappa}."
        )


def _print_deviations(out: "Console", made: "WizardReport") -> None:
    from sar_tui.cli.tables import add, table

    for absence in made.absences:
        back = "then there was one again" if absence.came_back else "until the run ended"
        _say(
            out,
            f"No operator from {absence.at_s:.1f} s of run {absence.run} on, for {absence.duration_s:.1f} s, {back} "
            f"({absence.actor} {absence.state}).",
            end="\n",
        )
    if not made.deviations:
        _say(out, "There was no deviation from the session's plan.")
        return
    counts = ", ".join(f"{what} {n}" for what, n in sorted(made.counts.items()))
    _say(out, f"Deviations from the session's plan: {counts}.")
    head = table("run", "at, s", "what", "who", "detail", right=("run", "at, s"), whole=("what",))
    for each in made.deviations[:_LISTED]:
        notes = (each.detail, f"{each.duration_s:.1f} s" if each.duration_s is not None else "")
        add(head, each.run, f"{each.at_s:.1f}", each.what, each.actor, ", ".join(filter(None, notes)))
    out.print(head)
    if len(made.deviations) > _LISTED:
        _say(out, f"… and {len(made.deviations) - _LISTED} more: --json has them all.", end="\n")
    out.print()


def _print_pauses(out: "Console", made: "WizardReport") -> None:
    for pause in made.pauses:
        reason = f" ({pause.reason})" if pause.reason else ""
        ended = f"{pause.ended_by} went on" if pause.ended_by else "until the run ended"
        _say(
            out,
            f"The participant paused at {pause.at_s:.1f} s of run {pause.run}{reason}, for {pause.duration_s:.1f} s; "
            f"{ended}.",
            end="\n",
        )
    if made.pauses:
        out.print()


def _print_written(out: "Console", made: "WizardReport") -> None:
    from sar_tui.cli.tables import add, table

    _say(out, f"{_count(made.notes, 'note')}, {_count(made.event_marks, 'event mark')}.")
    if not made.written:
        return
    head = table("run", "at, s", "who", "note or mark", right=("run", "at, s"))
    for each in made.written:
        add(head, each.run, f"{each.at_s:.1f}", each.actor, ": ".join(filter(None, (each.label, each.text))))
    out.print(head)
    out.print()


def _count(n: int, what: str) -> str:
    return f"{n} {what}{'' if n == 1 else 's'}"
