"""``sar-tui report``: statistics of sessions for a paper."""

from collections.abc import Iterable, Sequence
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import (
    AsJson,
    Everything,
    Home,
    Mixed,
    Sessions,
    SessionsOf,
    Simulated,
    console,
    named_path,
    print_json,
    write_new,
)
from sar_tui.cli.errors import Refused
from sar_tui.cli.progress_line import progress_line
from sar_tui.cli.study_plan import Key, key_of
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    import sqlite3

    from rich.console import Console

    from sar_tui.reports.sections import Section
    from sar_tui.reports.wizard_study import OperatedSession, WizardStudy
    from sar_tui.store.selection import Request, Selection

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True)

_WIDTH = 76
"""Largest width of a histogram."""

AsPage = Annotated[
    Path | None,
    typer.Option(
        "--html",
        parser=named_path,
        metavar="FILE",
        show_default=False,
        help="Write a page to read and to print.",
    ),
]
_Study = Annotated[
    str, typer.Argument(metavar="[STUDY]", show_default=False, help="If there are several.")
]
_SameStudy = Annotated[
    str,
    typer.Option("--study", metavar="NAME", show_default=False, help="The same as STUDY."),
]


@app.callback()
def report() -> None:
    """Report on sessions for a paper."""


@app.command("wizard")
def wizard(
    home: Home,
    sessions: Sessions = None,
    participant: SessionsOf = None,
    everything: Everything = False,
    simulated: Simulated = False,
    mixed: Mixed = False,
    exclude: Annotated[
        list[str] | None,
        typer.Option(
            "--exclude",
            metavar="SESSION=WHY",
            show_default=False,
            help="Leave out a session, and say why in the report. May be repeated.",
        ),
    ] = None,
    html: AsPage = None,
    as_json: AsJson = False,
) -> None:
    """Report what the operators of sessions did, how fast, and how far they agreed with the agent.

    One session is reported in full. Several are pooled: agreement, latencies by operator and
    condition, exclusions, and drift.
    """
    names = list(sessions or ())
    if len(names) == 1 and not (participant or everything or exclude):
        _one_session(home, names[0], html, as_json)
        return
    request = _request(names, participant, everything, simulated, mixed)
    with home.database() as database:
        found, selection = _study(home, database, request, exclude or [])
    from sar_tui.reports.wizard_study_words import sections as sections_of_study

    put_out(
        found,
        sections_of_study(found),
        "Report on the operators of several sessions",
        html,
        as_json,
    )
    _tell_left_out(selection)


@app.command("intervention")
def intervention(
    home: Home,
    sessions: Sessions = None,
    participant: SessionsOf = None,
    everything: Everything = False,
    simulated: Simulated = False,
    mixed: Mixed = False,
    html: AsPage = None,
    as_json: AsJson = False,
) -> None:
    """Report the training that was given: dose, challenge and how it progressed, deviations, harms.

    By the items of TIDieR and TIDieR-Rehab that the record knows.
    """
    from sar_tui.reports.intervention import intervention as make_report
    from sar_tui.reports.intervention import read
    from sar_tui.reports.intervention_words import sections
    from sar_tui.store.selection import select

    request = _request(list(sessions or ()), participant, everything, simulated, mixed)
    with home.database() as database, progress_line("Reading") as show:
        selection = select(database, home.folder, request, only_counted=True)
        done, of = count(1), len(selection.sessions)
        found = make_report(
            read(database, home.folder, selection, lambda: show("Reading", next(done), of))
        )
    put_out(found, sections(found), "Report on the intervention", html, as_json)
    _tell_left_out(selection)


@app.command("study")
def study(
    home: Home,
    name: _Study = "",
    same: _SameStudy = "",
    key: Key = None,
    html: AsPage = None,
    as_json: AsJson = False,
) -> None:
    """Report on a study: flow of participants, dose, deviations, what is missing."""
    from datetime import UTC, datetime

    from sar_tui.study import ledger
    from sar_tui.study.report import make_report, sections

    with home.database() as database:
        frozen = ledger.find(database, name or same)
        found = make_report(database, frozen, key_of(frozen.plan, key), datetime.now(UTC))
    put_out(found, sections(found), f"Report on the study {frozen.plan.name}", html, as_json)


@app.command("methods")
def methods(
    home: Home,
    name: _Study = "",
    same: _SameStudy = "",
    to: Annotated[
        Path | None,
        typer.Option(
            "--to", parser=named_path, metavar="FILE", show_default=False, help="A new file."
        ),
    ] = None,
) -> None:
    """Write the methods of a study for a paper; every number is from the log."""
    from sar_tui.study import ledger
    from sar_tui.study.plan_words import methods as text_of

    with home.database() as database:
        text = text_of(database, home.folder, ledger.find(database, name or same))
    if to is None:
        print(text, end="")
    else:
        write_new(to, text)
        print(f"{to} is written.")


def _one_session(home: Home, name: str, html: Path | None, as_json: bool) -> None:
    from sar_tui.reports import logged_messages, wizard_words
    from sar_tui.reports.wizard import report as make_report

    with home.session(name) as (database, row):
        messages = logged_messages.read(database, row["id"])
    found, latencies = make_report(row["id"], row["parameters"], messages)
    out = console()
    mode = "" if row["mode"] == "live" else f", {row['mode']}"
    who = " and ".join(filter(None, (row["participant"], row.get("partner"))))
    title = f"Session {row['id']}: {row['task']}, {who}{mode}."
    sections = wizard_words.sections(found, latencies, min(out.width, _WIDTH))
    if as_json or html:
        put_out(found, sections, title, html, as_json)
        return
    if found.operated:
        out.print(title, markup=False, soft_wrap=True)
    print_sections(out, sections, titled=False)


def _study(
    home: Home, database: "sqlite3.Connection", request: "Request", exclude: Sequence[str]
) -> "tuple[WizardStudy, Selection]":
    """Return the report on the sessions that are asked for, and which those are."""
    from sar_tui.reports import logged_messages
    from sar_tui.reports.wizard_study import Exclusion, read_session, study
    from sar_tui.store.database import StoreError
    from sar_tui.store.selection import select

    selection = select(database, home.folder, request, only_counted=True)
    by_hand = _excluded(selection.ids, exclude)
    excluded = [Exclusion(session, why) for session, why in by_hand.items()]
    read: list[OperatedSession] = []
    with progress_line("Reading") as show:
        for number, row in enumerate(selection.sessions):
            show("Reading", number, len(selection.sessions))
            if row["id"] not in by_hand:
                try:
                    read.append(read_session(row, logged_messages.read(database, row["id"])))
                except StoreError as error:
                    excluded.append(Exclusion(row["id"], str(error)))
    return study(read, excluded), selection


def _excluded(known: Sequence[str], exclude: Sequence[str]) -> dict[str, str]:
    """Return the reasons of sessions that are excluded, by id. Raises Refused."""
    found = {}
    for text in exclude:
        name, _, why = text.partition("=")
        meant = [session for session in known if name.strip() and session.startswith(name.strip())]
        if len(meant) != 1:
            many = "More than one" if meant else "None"
            raise Refused(
                f"{many} of these sessions begins with {name.strip()!r}. Write --exclude "
                "SESSION=WHY."
            )
        if not why.strip():
            raise Refused(f"Say why {meant[0]} is excluded: --exclude {meant[0]}=WHY.")
        found[meant[0]] = why.strip()
    return found


def _request(
    names: Sequence[str], participant: str | None, everything: bool, simulated: bool, mixed: bool
) -> "Request":
    """Return the request. Sessions that are named may be of any kind."""
    from sar_tui.store.selection import Request

    return Request(
        names=tuple(names),
        participant=participant or "",
        everything=everything,
        simulated=simulated,
        mixed=mixed or bool(names and not simulated),
    )


def put_out(
    found: object, sections: "Sequence[Section]", title: str, html: Path | None, as_json: bool
) -> None:
    """Print a report, as JSON if asked, or write it as a page. Raises Refused if the file
    exists.
    """

    if html is not None:
        from sar_tui.reports.sections import page

        write_new(html, page(title, sections))
    if as_json:
        print_json(found)
    elif html is not None:
        print(f"{html} is written. Open it in a browser, which can also print it.")
    else:
        print_sections(console(), sections)


def print_sections(out: "Console", sections: Iterable["Section"], *, titled: bool = True) -> None:
    """Print sections with an empty line between their parts. ``titled``: with their titles."""
    from rich.text import Text

    from sar_tui.cli.tables import add, table
    from sar_tui.model.visible_text import visible
    from sar_tui.reports.sections import Drawing, Table

    is_first = True
    for section in sections:
        for index, part in enumerate(section.parts):
            if not is_first:
                out.print()
            is_first = False
            if titled and not index:
                out.print(Text(section.title, style="bold"), soft_wrap=True)
            match part:
                case Table():
                    shown = table(*part.heads, right=part.right, whole=part.whole)
                    for row in part.rows:
                        add(shown, *row)
                    out.print(shown)
                    if part.more:
                        out.print(part.more, markup=False, soft_wrap=True)
                case Drawing():
                    out.print("\n".join([part.caption, *part.lines]), markup=False, soft_wrap=True)
                case _:
                    out.print(visible(part, "\n"), markup=False, soft_wrap=True)


def _tell_left_out(selection: "Selection") -> None:
    """Name the sessions that do not count, and those that are running. Raises Exit if one is
    running.
    """
    for sentence in (*selection.set_aside, *selection.refused):
        console(error=True).print(f"! {sentence}", soft_wrap=True)
    if selection.refused:
        raise typer.Exit(FAILED)
