"""``sar-tui progress``: a participant over sessions."""

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import (
    AsJson,
    Code,
    Home,
    console,
    named_path,
    print_json,
    watch_plugins,
    write_new,
)
from sar_tui.cli.errors import Refused
from sar_tui.cli.progress_line import progress_line

if TYPE_CHECKING:
    from rich.console import Console

    from sar_tui.loop.task import Task
    from sar_tui.model.language import Language
    from sar_tui.reports.progress import LineProgress, Progress

    Find = Callable[[str], type[Task] | None]

_LISTED = 20
"""Sessions of a line that are printed; JSON has all."""
_MONTHS = 3
_CHART = 90, 16
"""Columns and rows of a chart."""
_ID = 6
"""Characters of a session's id that are printed."""


def progress(
    context: typer.Context,
    home: Home,
    participant: Code,
    task: Annotated[
        str | None,
        typer.Option("--task", metavar="TASK", show_default=False, help="Only this task."),
    ] = None,
    compare: Annotated[
        str | None,
        typer.Option(
            "--compare",
            metavar="SESSION,SESSION",
            show_default=False,
            help="Compare two sessions, by id or beginning.",
        ),
    ] = None,
    html: Annotated[
        Path | None,
        typer.Option(
            "--html",
            parser=named_path,
            metavar="FILE",
            show_default=False,
            help="Write a page with charts, to print. It needs the extra `report`.",
        ),
    ] = None,
    note: Annotated[
        bool, typer.Option("--note", help="Print a paragraph to paste into a record.")
    ] = False,
    language: Annotated[
        str,
        typer.Option("--language", metavar="CODE", help="Language of the sentences: en, de, es."),
    ] = "en",
    as_json: AsJson = False,
) -> None:
    """Show a participant's progress over sessions: the level at goal, noise, practice and dose."""
    from sar_tui.model.language import BUNDLED
    from sar_tui.reports.progress import progress as make_progress
    from sar_tui.store import records, wellbeing
    from sar_tui.store.participants import check_known
    from sar_tui.store.people_events import check_included
    from sar_tui.store.results import sessions_of

    if language not in BUNDLED:
        named = language or "an empty language"
        raise Refused(f"There are no sentences in {named}. Choose one of: {', '.join(BUNDLED)}.")
    watch_plugins(context)
    find = _finder(home)
    with home.database() as database, progress_line("Computing"):
        code = check_known(database, participant)
        check_included(database, code)
        found = make_progress(
            code,
            sessions_of(database, code, task, folder=home.folder),
            find,
            records.listing(database, participant=code),
            ratings=wellbeing.history(database, code),
        )
    if not (found.lines or found.instruments or found.events) and not as_json and html is None:
        of_task = "" if task is None else f" of the task {task}"
        raise Refused(
            f"{code} has no finished attempts{of_task} yet. `sar-tui sessions` lists all sessions."
        )
    if html is not None:
        _write_page(found, html, find, language)
    elif compare is not None:
        _compare(found, compare, find, language, as_json)
    elif as_json:
        print_json(found)
    elif note:
        from sar_tui.reports import progress_words

        for line in found.lines:
            tr = progress_words.words(language, find(line.task))
            console().print(progress_words.note(code, line, tr), soft_wrap=True, end="\n\n")
        for text in progress_words.after_notes(found, progress_words.words(language, None)):
            console().print(text, soft_wrap=True, end="\n\n")
    else:
        _print(console(), found, find, language)


def _write_page(found: "Progress", path: Path, find: "Find", language: str) -> None:
    """Write the page. Raises Refused if the file exists, or charts cannot be drawn."""
    from sar_tui.reports.charts import ChartsMissing
    from sar_tui.reports.progress_page import page

    try:
        with progress_line("Drawing"):
            text = page(found, find, language)
    except ChartsMissing as error:
        raise Refused(str(error)) from error
    write_new(path, text)
    print(f"{path} is written. Open it in a browser, which can also print it.")


def _finder(home: Home) -> "Find":
    """Return a function that finds an installed task by name; it returns None for any other."""
    from sar_tui.plugins import PluginError

    catalogue = home.catalogue()

    @cache
    def find(name: str) -> "type[Task] | None":
        try:
            return catalogue.task(name)
        except PluginError:
            return None

    return find


def _print(out: "Console", found: "Progress", find: "Find", language: str) -> None:
    from sar_tui.reports import progress_words
    from sar_tui.reports.progress_headline import headline

    warnings = progress_words.warnings(found, progress_words.words(language, None))
    for line in reversed(found.lines):
        tr = progress_words.words(language, find(line.task))
        out.print(f"{found.participant} · {progress_words.heading(line, tr)}", soft_wrap=True)
        out.print(headline(found, line, tr).text, soft_wrap=True, end="\n\n")
        _print_warnings(out, warnings)
        warnings = []
        _print_chart(out, line, tr)
        _print_sessions(out, line, tr)
        for sentence in progress_words.sentences(line, tr):
            out.print(sentence, soft_wrap=True)
        out.print()
    _print_warnings(out, warnings)
    _print_instruments(out, found, language)
    _print_dose(out, found, progress_words.words(language, None))


def _print_warnings(out: "Console", warnings: Sequence[str]) -> None:
    for text in warnings:
        out.print(f"! {text}", soft_wrap=True, end="\n\n")


def _print_chart(out: "Console", line: "LineProgress", tr: "Language") -> None:
    """Print the level at goal over sessions, or their results where no level is known; nothing of a
    single session.
    """
    from rich.text import Text

    from sar_tui.reports.progress_timeline import charted, timeline

    if len(line.sessions) < 2 or not charted(line):
        return
    for row in timeline(line, min(out.width, _CHART[0]), _CHART[1], tr):
        out.print(Text(row.text), soft_wrap=True)
    out.print()


def _print_sessions(out: "Console", line: "LineProgress", tr: "Language") -> None:
    from sar_tui.cli.tables import print_table
    from sar_tui.reports import progress_words

    heads = [
        tr(head)
        for head in ("session", "date", "levels", "mean ± SD", "correct", "goals", "level at goal")
    ]
    heads.append(f"{tr(line.axis.unit or line.axis.name)}, 95 %")
    measured = [
        measure
        for measure in line.measured
        if any(measure.name in each.qualities for each in line.sessions)
    ]
    heads += [measure.label(tr) for measure in measured]
    has_felt = any(each.pain is not None or each.tiredness is not None for each in line.sessions)
    if has_felt:
        heads += [tr("pain"), tr("tired")]
    rows = [
        (
            each.session[:_ID],
            progress_words.day(each.began),
            f"{each.first_level}→{each.last_level}",
            tr.figures(progress_words.mean(line, each)),
            f"{each.right / each.trials:.0%}" if each.trials else "",
            "" if each.reached is None else f"{each.reached}/{each.attempts}",
            tr.figures(f"{each.at_goal.level:.1f}") if each.at_goal and each.at_goal.level else "",
            progress_words.band(line, each, tr) or tr(progress_words.SIDES[each.side]),
            *(progress_words.measured(each, measure, tr) for measure in measured),
            *(
                "–" if given is None else str(given)
                for given in (each.pain, each.tiredness)
                if has_felt
            ),
        )
        for each in line.sessions[-_LISTED:]
    ]
    print_table(out, heads, rows, right=heads[2:])
    if len(line.sessions) > _LISTED:
        out.print(f"{len(line.sessions) - _LISTED} earlier sessions are in --json.")
    if line.between_sd is not None:
        shown = progress_words.between_sd(line, tr)
        between = tr("SD between the means of the sessions: {sd}.", sd=shown)
        out.print(
            f"{between} {tr('SD in the table: between the attempts of a session.')}", soft_wrap=True
        )
    out.print()


def _print_instruments(out: "Console", found: "Progress", language: str) -> None:
    from sar_tui.reports import progress_words

    for each in found.instruments:
        tr = progress_words.words(language, None)
        out.print(progress_words.instrument_change(each, tr), soft_wrap=True, end="\n\n")


def _print_dose(out: "Console", found: "Progress", tr: "Language") -> None:
    from sar_tui.reports import dose_words

    if not found.days:
        return
    out.print(tr("Dose"))
    out.print("\n".join(dose_words.calendar_lines(found, _MONTHS, tr)), soft_wrap=True, end="\n\n")
    out.print(dose_words.recent_text(found.recent, tr), soft_wrap=True)
    last = found.days[-1]
    out.print(
        tr(
            "{date}: {done} of {planned} attempts, {repetitions} repetitions, {minutes} min on "
            "task without rests.",
            date=last.date,
            done=str(last.done),
            planned=str(last.planned),
            repetitions=str(last.repetitions),
            minutes=f"{last.time_on_task_s / 60:.1f}",
        ),
        soft_wrap=True,
    )


def _compare(found: "Progress", named: str, find: "Find", language: str, as_json: bool) -> None:
    from sar_tui.reports import progress_words
    from sar_tui.reports.progress import compare as make_comparison

    names = [name.strip() for name in named.split(",")]
    if len(names) != 2 or not all(names):
        raise Refused("--compare takes two sessions, such as --compare 3f2a,last.")
    one, other = (_session(found, name) for name in names)
    comparison = make_comparison(found, one, other)
    assert comparison is not None
    if as_json:
        print_json(comparison)
        return
    line = next(line for line in found.lines if any(each.session == one for each in line.sessions))
    tr = progress_words.words(language, find(line.task))
    console().print(progress_words.compared(line, comparison, tr), soft_wrap=True)


def _session(found: "Progress", name: str) -> str:
    """Return the id of a session of the participant, given its id, its beginning, or ``last``.
    Raises Refused.
    """
    known = [each.session for line in found.lines for each in line.sessions]
    meant = (
        known[-1:] if name == "last" else [session for session in known if session.startswith(name)]
    )
    if len(meant) != 1:
        many = "More than one session" if meant else "No session with a finished attempt"
        raise Refused(f"{many} of {found.participant} begins with {name}.")
    return meant[0]
