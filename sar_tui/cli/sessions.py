"""``sar-tui sessions`` and ``sar-tui show``: list and show recorded sessions."""

from collections import Counter
from collections.abc import Sequence
from functools import partial
from statistics import median
from typing import TYPE_CHECKING, Any

import typer

from sar_tui.cli.common import (
    AsJson,
    Home,
    RecordedSession,
    SessionsOf,
    console,
    print_json,
    watch_plugins,
)
from sar_tui.cli.tables import Column, Listing, print_listing

if TYPE_CHECKING:
    import sqlite3

    from rich.console import Console

    from sar_tui.cli.tables import Findings
    from sar_tui.model.measure import Measure
    from sar_tui.model.trial_types import Metric
    from sar_tui.reports.output_summary import OutputSummary
    from sar_tui.store.records import Record

Row = dict[str, Any]
_PLOT_SIZE = (100, 14)
"""The plot's largest width, and its height."""


def sessions(
    home: Home,
    participant: SessionsOf = None,
    as_json: AsJson = False,
) -> None:
    """List the recorded sessions, the newest first."""
    from sar_tui.store import participants, sites, wellbeing
    from sar_tui.store.merge.people import other_code
    from sar_tui.store.sessions import listing, local_time, operators, participant_codes

    code = participants.check_code(participant) if participant is not None else None
    with home.database() as database:
        known = operators(database)
        listed = listing(database, home.folder, participant=code)
        felt = wellbeing.by_session(database, [row["id"] for row in listed])
        own = sites.own(database)
        stored = other_code(database, code) if code else ""
        if code and not listed and not stored:
            participants.check_known(database, code)
    rows = [
        {
            **row,
            "site": row["site"] or own,
            "operators": known.get(row["id"], []),
            "records": felt.get(row["id"], []),
        }
        for row in listed
    ]
    if not rows and stored and not as_json:
        console().print(f"{code} is {stored} here: sar-tui sessions -p {stored}", soft_wrap=True)
        return
    whose = f" of {code}" if code else ""
    print_listing(
        Listing(
            "sessions",
            empty=f"There are no sessions{whose} yet. `sar-tui simulate keyboard --user average` "
            "makes one.",
            columns=(
                Column("session", lambda row: row["id"]),
                Column("began", lambda row: local_time(row["started_at"], row["utc_offset_s"])),
                Column("who", participant_codes),
                Column("task", lambda row: row["task"]),
                Column("status", _status),
                Column("attempts", lambda row: row["attempts"], is_number=True),
            ),
        ),
        rows,
        as_json,
    )


def _status(row: Row) -> str:
    from sar_tui.reports.wellbeing import marks

    parts = [
        row["status"],
        "" if row["mode"] == "live" else row["mode"],
        "operator" if row["operators"] else "",
        marks(row["records"]),
    ]
    return ", ".join(filter(None, parts))


def show(
    context: typer.Context,
    home: Home,
    session: RecordedSession,
    as_json: AsJson = False,
) -> None:
    """Show a session: attempts, plot, timing."""
    from sar_tui.reports import session_facts
    from sar_tui.reports.output_summary import marker_summaries, output_summaries
    from sar_tui.store import records, sites
    from sar_tui.store import sessions as store

    watch_plugins(context)
    with home.session(session) as (database, found):
        programme = _programme(database, found)
        found["operators"] = store.operators(database, found["id"]).get(found["id"], [])
        attempts = store.rows(database, "attempts", found["id"])
        trials = store.rows(database, "trials", found["id"])
        outputs = output_summaries(database, found["id"])
        markers = marker_summaries(database, found["id"])
        recorded = records.listing(database, session=found["id"])
        moves = found["parameters"].get("difficulty_policy") in ("target", "percentile", "sequence")
        changes = (
            session_facts.level_changes(database, found["id"]) if moves and not as_json else []
        )
        must_rest = any(
            found["parameters"].get(f"rest_after_{what}") for what in ("attempts", "minutes")
        )
        changes += session_facts.rests(database, found["id"]) if must_rest and not as_json else []
        changes += session_facts.skipped_attempts(database, found["id"]) if not as_json else []
        changes += session_facts.taken_back(database, found["id"]) if not as_json else []
        changes += (
            session_facts.reported_changes(store.rows(database, "actions", found["id"]))
            if not as_json
            else []
        )
        found |= {
            "site": found["site"] or sites.own(database),
            "discarded": _discarded(database, found["id"]),
            "moved": _moved(database, found["id"]),
        }
    if as_json:
        known = {
            "session": found,
            "attempts": attempts,
            "trials": trials,
            "outputs": outputs,
            "markers": markers,
        }
        print_json({**known, "records": recorded})
        return

    from sar_tui.cli.tables import attempts_table, seats, summary
    from sar_tui.reports.session_facts import lines
    from sar_tui.store import provenance

    metric = provenance.metric(found["software"])
    out = console()
    measured, findings, missing = _declared(home, found["task"])
    _print_facts(out, found, programme)
    if attempts:
        out.print(attempts_table(attempts, metric, measured), end="\n\n")
        for seat in () if metric.is_none else seats(attempts):
            _print_plot(out, attempts, seat, metric)
    out.print(summary(attempts, metric, findings), soft_wrap=True, end="\n\n")
    if changes:
        out.print("\n".join(changes), markup=False, soft_wrap=True, end="\n\n")
    _print_marks(out, trials)
    _print_wellbeing(out, found, recorded)
    if said := lines(
        [each for each in recorded if each.kind == "answer"],
        sum(bool(each["practice"]) for each in attempts if each["seat"] == "A"),
    ):
        out.print("\n".join(said), markup=False, soft_wrap=True, end="\n\n")
    _print_timing(out, found["machine"], trials)
    for sent in markers:
        out.print(sent.line, markup=False, soft_wrap=True)
    if missing:
        out.print(
            f"! {missing} Without it, measures of its own are not shown.",
            markup=False,
            soft_wrap=True,
        )
    print_failed_outputs(out, outputs)


def _declared(home: Home, name: str) -> "tuple[Sequence[Measure], Findings, str]":
    """Return a task's measures, the function that adds its findings to a summary, and why there are
    none if so.
    """
    from sar_tui.plugins import PluginError
    from sar_tui.widgets.task_view import stored_findings

    try:
        task = home.catalogue().task(name)
    except PluginError as error:
        return (), lambda *_: (), str(error)
    return task.measured, partial(stored_findings, task), ""


def print_failed_outputs(out: "Console", outputs: "Sequence[OutputSummary]") -> None:
    """Print a line for each output that failed, so that the log is not the only place that reports
    it.
    """
    for summary in outputs:
        if summary.line:
            out.print(f"! {summary.line}", markup=False, soft_wrap=True)


def _programme(database: "sqlite3.Connection", row: Row) -> str:
    """Return the version of the programme that a session ran, who saved it, and why; empty if there
    was none.
    """
    from sar_tui.store import programmes
    from sar_tui.store.merge.people import code_at
    from sar_tui.store.record_changes import code_at_first

    version = row["programme"]
    if version is None:
        return ""
    first = code_at_first(database, row["id"], "A", row["participant"])
    code = code_at(database, first, row["site"])
    saved = programmes.versions(database, code, row["task"])
    known = next((each for each in saved if each.version == version), programmes.Programme())
    by = f" by {known.author}" if known.author else ""
    why = f": {known.reason}" if known.reason else ""
    return f"version {version}{by}{why}"


def _print_facts(out: "Console", row: Row, programme: str) -> None:
    from sar_tui.store.sessions import local_time, participant_codes

    ended = f", ended {local_time(row['ended_at'], row['utc_offset_s'])}" if row["ended_at"] else ""
    for name, value in (
        (
            "Session",
            f"{row['id']}  {row['status']}{'' if row['mode'] == 'live' else ', ' + row['mode']}",
        ),
        *([("", _discarded_words(row["discarded"]))] if row["discarded"] else []),
        ("Participant", participant_codes(row)),
        *(("", _moved_words(each)) for each in row["moved"]),
        *([("Site", row["site"])] if row["site"] else []),
        ("Task", f"{row['task']}, theme {row['theme']}, seed {row['seed']}"),
        *([("Programme", programme)] if programme else []),
        ("Began", f"{local_time(row['started_at'], row['utc_offset_s'])}{ended}"),
        ("Made by", f"sar-tui {row['software']['sar_tui']}, Python {row['software']['python']}"),
    ):
        out.print(f"{name:<12} {value}", markup=False)
    if row["operators"]:
        operators = (
            f"{', '.join(row['operators'])}; `sar-tui report wizard {row['id']}` shows "
            "what they did"
        )
        out.print(f"{'Operator':<12} {operators}", markup=False, soft_wrap=True)
    out.print()


def _discarded(database: "sqlite3.Connection", session: str) -> Row | None:
    """Return who discarded a session, when and why; None if it was not discarded."""
    from sar_tui.store.record_changes import why_discarded

    found = why_discarded(database, session)
    return {"actor": found.actor, "at": found.at, "reason": found.reason} if found else None


def _moved(database: "sqlite3.Connection", session: str) -> list[Row]:
    """Return who moved a session to another participant, when, from whom to whom, and why."""
    from sar_tui.store.record_changes import changes

    return [
        {"actor": one.actor, "at": one.at, "reason": one.reason, "seat": one.seat, **one.details}
        for one in changes(database, session)
        if one.change == "moved" and one.details
    ]


def _moved_words(moved: Row) -> str:
    from sar_tui.store.sessions import local_time

    who = f"{moved['actor']}, {local_time(moved['at'])}"
    return f"It was recorded for {moved['before']}, and moved to {moved['after']}: {moved['reason']} ({who})."


def _discarded_words(discarded: Row) -> str:
    from sar_tui.store.sessions import local_time

    who = f"{discarded['actor']}, {local_time(discarded['at'])}"
    return f"It does not count: {discarded['reason']} ({who}). In the app, F6 and Del restore it."


def _print_plot(out: "Console", attempts: Sequence[Row], seat: str, metric: "Metric") -> None:
    """Print the plot of a seat's attempts (thesis, Figure 4.4); two seats have the same axis."""
    from rich.text import Text

    from sar_tui.reports.charts import attempts_figure, result_name

    counted = [row for row in attempts if not row["practice"]]
    scored = [row for row in counted if row["seat"] == seat]
    if not scored:
        return
    plot = attempts_figure(
        [row["level"] for row in scored],
        [row["metric"] for row in scored],
        metric=metric.label,
        goals=[row["goal"] for row in scored],
        width=min(out.width, _PLOT_SIZE[0]),
        height=_PLOT_SIZE[1],
        color=out.is_terminal and not out.no_color,
        results=[result_name(row["outcome"], row["metric"], row["goal"], metric) for row in scored],
        beside=[row["metric"] for row in counted]
        + [row["goal"] for row in counted if row["goal"] is not None],
    )
    out.print(Text.from_ansi(plot), soft_wrap=True, end="\n\n")


def _print_marks(out: "Console", trials: Sequence[Row]) -> None:
    """Print the therapist's marks of single trials."""
    marks = [
        f"attempt {t['attempt']} {mark}"
        for t in trials
        if (mark := (t["details"] or {}).get("mark"))
    ]
    if marks:
        out.print(f"Marked by the therapist: {', '.join(marks)}.", soft_wrap=True, end="\n\n")


def _print_wellbeing(out: "Console", row: Row, recorded: "Sequence[Record]") -> None:
    """Print what the participants said of pain and tiredness, and adverse events that began in the
    session.
    """
    from sar_tui.records.kind import of_group
    from sar_tui.reports.wellbeing import session_lines
    from sar_tui.store.wellbeing import KINDS

    event_kinds = [kind.name for kind in of_group("event")]
    felt = [each for each in recorded if each.kind in KINDS]
    events = [each for each in recorded if each.kind in event_kinds]
    if lines := session_lines(row, felt, events):
        out.print("\n".join(lines), soft_wrap=True, end="\n\n")


def _print_timing(out: "Console", machine: Row, trials: Sequence[Row]) -> None:
    """Print the timing quality of a session."""
    if machine["flags"]:
        out.print(
            f"! Timing is less exact: the keys came through {' and '.join(machine['flags'])}."
        )
    timings = [trial["timing"] for trial in trials]
    if not timings:
        return
    flags = Counter(flag for timing in timings for flag in timing["flags"])
    flagged = sum(bool(timing["flags"]) for timing in timings)
    names = ", ".join(f"{name} {count}" for name, count in flags.most_common())
    out.print(
        f"Timing: {flagged} of {len(timings)} trials have a flag{f' ({names})' if names else ''}."
    )
    sources = Counter(timing["onset_source"] for timing in timings if timing["onset_source"])
    if sources:
        out.print(
            "Onsets stamped at: "
            f"{', '.join(f'{name} {count}' for name, count in sources.most_common())}."
        )
    delays = [
        timing["handler_delay_ms"] for timing in timings if timing["handler_delay_ms"] is not None
    ]
    if delays:
        out.print(f"From a key's stamp to its handling: median {median(delays):.2f} ms.")
