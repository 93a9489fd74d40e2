"""``sar-tui participant``: people's rights: withdrawal, the right code, de-identification, erasure,
a report.
"""

from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import (
    AsJson,
    Code,
    Home,
    RecordedSession,
    console,
    is_interactive,
    named_path,
    print_json,
    warn_of_git,
    watch_plugins,
)
from sar_tui.cli.errors import Refused
from sar_tui.cli.progress_line import progress_line
from sar_tui.cli.report import AsPage, put_out
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from sar_tui.reports.person import PersonReport
    from sar_tui.store.erasure import Done

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True)

_Again = Annotated[str | None, typer.Argument(metavar="[CODE]", help="Again.", show_default=False)]
_Yes = Annotated[bool, typer.Option("--yes", help="Ask nothing; the code is given twice.")]
_Reason = Annotated[
    str, typer.Option("--reason", metavar="TEXT", help="Why, without names.", show_default=False)
]


@app.callback()
def participant() -> None:
    """Use people's rights: withdraw, correct a code, de-identify, erase, report (docs/peoples-rights.md)."""


@app.command("withdraw")
def withdraw(
    home: Home,
    code: Code,
    reason: _Reason = "",
    keep: Annotated[
        bool, typer.Option("--keep", help="What was recorded is kept and used. The default.")
    ] = False,
    exclude: Annotated[
        bool,
        typer.Option(
            "--exclude",
            help="What was recorded is kept, and left out of exports, reports, progress.",
        ),
    ] = False,
    on: Annotated[
        str,
        typer.Option(
            "--on", metavar="DATE", help="The day of it. Default: today.", show_default=False
        ),
    ] = "",
    undo: Annotated[
        bool, typer.Option("--undo", help="Take the withdrawal back: the person goes on.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Record that a person stops. Nothing more is recorded of them."""
    from sar_tui.drivers.login_name import login_name
    from sar_tui.store import people_events
    from sar_tui.store.participants import check_known, check_own
    from sar_tui.store.people_events import Details, new_event

    if keep + exclude + undo > 1:
        raise Refused("Give one of --keep, --exclude and --undo.")
    if undo and not reason.strip():
        raise Refused("Say why the withdrawal is taken back: --reason TEXT.")
    code = check_own(code)
    day = people_events.check_day(on) if on else ""
    data: people_events.Data = "exclude" if exclude else "keep"
    with home.writable_database() as database:
        if people_events.erasure(database, code) is None:
            check_known(database, code)
        now = people_events.withdrawal(database, code)
        if undo and now is None:
            raise Refused(f"{code} has not withdrawn.")
        if not undo and now is not None and now.details.data == data:
            raise Refused(f"{code} has withdrawn on {now.day} already.")
        event = new_event(
            "resumed" if undo else "withdrawn",
            code,
            author=login_name(),
            reason=reason,
            details=Details(on=day) if undo else Details(data=data, on=day),
        )
        people_events.add(database, event)
    if as_json:
        print_json({"event": event})
    elif undo:
        print(f"The withdrawal of {code} is taken back.")
    elif exclude:
        print(
            f"{code} has withdrawn: nothing more is recorded of them, and what was is left out of "
            "exports, reports and progress."
        )
    else:
        print(f"{code} has withdrawn: nothing more is recorded of them. What was is kept.")


@app.command("withdrawals")
def withdrawals(home: Home, as_json: AsJson = False) -> None:
    """List withdrawals, de-identifications and erasures."""
    from sar_tui.cli.tables import Column, Listing, print_listing
    from sar_tui.store import people_events
    from sar_tui.store.sessions import local_time

    with home.database() as database:
        found = people_events.events(database)
    print_listing(
        Listing(
            "events",
            empty="Nobody has withdrawn, was de-identified or erased.",
            columns=(
                Column("when", lambda one: one.details.on or local_time(one.at)),
                Column("who", attrgetter("participant")),
                Column("what", attrgetter("event")),
                Column("data", attrgetter("details.data")),
                Column("reason", attrgetter("reason")),
                Column("by", attrgetter("recorded_by")),
            ),
        ),
        found,
        as_json,
    )


@app.command("move")
def move(
    home: Home,
    session: RecordedSession,
    code: Annotated[
        str, typer.Argument(metavar="CODE", help="Whose session it is.", show_default=False)
    ],
    reason: _Reason = "",
    seat: Annotated[
        str,
        typer.Option("--seat", metavar="A|B", help="The seat, in a session for two."),
    ] = "A",
    new: Annotated[bool, typer.Option("--new", help="The participant is new.")] = False,
    as_json: AsJson = False,
) -> None:
    """Give a session to the right participant, if it was recorded by a wrong code."""
    from sar_tui.drivers.login_name import login_name
    from sar_tui.store import participants, record_changes
    from sar_tui.store.people_events import LONGEST_REASON
    from sar_tui.store.sessions import find
    from sar_tui.store.texts import check_text

    reason = check_text("The reason", reason, LONGEST_REASON)
    if not reason:
        raise Refused("Say why the session is moved: --reason TEXT.")
    seat = seat.strip().upper()
    if seat not in ("A", "B"):
        raise Refused(f"A seat is A or B, not {seat!r}.")
    with home.writable_database() as database:
        found = find(database, home.folder, session)["id"]
        try:
            (code,) = participants.admit(database, [code], is_new=new)
        except participants.UnknownParticipant as unknown:
            raise Refused(unknown.advice) from None
        record_changes.check_movable(database, found, seat, code)
        participants.add(database, code)
        before = record_changes.move(
            database, home.folder, found, seat, code, actor=login_name(), reason=reason
        )
    if as_json:
        print_json({"session": found, "seat": seat, "before": before, "after": code})
    else:
        print(f"Session {found} is one of {code}. That it was recorded for {before} is in its log.")


@app.command("de-identify")
def de_identify(
    home: Home,
    code: Code,
    again: _Again = None,
    reason: _Reason = "",
    yes: _Yes = False,
    as_json: AsJson = False,
) -> None:
    """Erase what was typed, and replace the code by a random one. It cannot be undone."""
    from sar_tui.drivers.login_name import login_name
    from sar_tui.store import erasure

    code = _confirmed(
        home, code, again, "All texts go, and nobody can say any more who it was.", yes=yes
    )
    with progress_line("De-identifying"):
        done = erasure.de_identify(home.folder, code, author=login_name(), reason=reason)
    if as_json:
        print_json(done)
    else:
        print(
            f"{code} is {done.event.participant} now, without texts "
            f"({_count(done.sessions, 'session')}). No list has both codes."
        )
        _print_rest(done)
    if done.refused:
        raise typer.Exit(FAILED)


@app.command("erase")
def erase(
    home: Home,
    code: Code,
    again: _Again = None,
    reason: _Reason = "",
    yes: _Yes = False,
    as_json: AsJson = False,
) -> None:
    """Erase all of a person, also from rescue files and backups. It cannot be undone.

    Given again, it looks through all files again.
    """
    from sar_tui.drivers.login_name import login_name
    from sar_tui.store import erasure

    code = _confirmed(home, code, again, "All that was recorded of them is erased.", yes=yes)
    with progress_line("Erasing"):
        done = erasure.erase(home.folder, code, author=login_name(), reason=reason)
    if as_json:
        print_json(done)
    else:
        kept = (
            f" Of {_count(done.shared, 'session')} for two, the part of the partner stays."
            if done.shared
            else ""
        )
        print(f"{code} is erased ({_count(done.sessions, 'session')}).{kept}")
        _print_rest(done)
    if done.refused:
        raise typer.Exit(FAILED)


def _confirmed(home: Home, code: str, again: str | None, what: str, *, yes: bool) -> str:
    """Return a code that was given twice. Raises Refused, StoreError, or Exit if it was not."""
    from sar_tui.store import people_events
    from sar_tui.store.participants import check_code, check_known, check_own

    code = check_code(code)
    with home.database() as database:
        if people_events.erasure(database, code) is None:
            check_known(database, check_own(code))
    if yes and again is None:
        raise Refused(f"With --yes the code is given twice: {code} {code} --yes.")
    if again is None and not is_interactive():
        raise Refused(f"Nobody can be asked here. Give the code twice: {code} {code} --yes.")
    if again is None:
        again = typer.prompt(f"{what} Type the code again", default="", err=True)
    if again.strip().upper() != code:
        raise Refused("The codes are not the same. Nothing was done.")
    return code


def _print_rest(done: "Done") -> None:
    from sar_tui.store.sessions import local_time

    for file in done.rewritten:
        print(f"Rewritten without them: {file}")
    for file in done.deleted:
        print(f"Deleted, a page on their progress: {file}")
    for refusal in done.refused:
        print(
            f"! {refusal.file} may hold them, and was not rewritten. {refusal.why} Delete it, or "
            "give the command again."
        )
    for entry in done.exports:
        recipient = f" for {entry.recipient}" if entry.recipient else ""
        print(
            f"! An export of {local_time(entry.exported_at)}{recipient} ({entry.format}, by "
            f"{entry.exported_by}) has them: tell whoever has it."
        )
    for folder in done.folders:
        print(f"! This export has them, and is not changed: {folder}")
    for folder in done.speech:
        print(f"! What the agent said to them was recorded in {folder}: delete it there.")
    print(
        "Backups outside of the data folder, and databases of other sites, are not known here. "
        "A merge does not bring the person back."
    )


def _count(number: int, name: str) -> str:
    return f"{number} {name}{'' if number == 1 else 's'}"


@app.command("report")
def report(
    context: typer.Context,
    home: Home,
    code: Code,
    to: Annotated[
        Path | None,
        typer.Option(
            "--to",
            parser=named_path,
            metavar="DIR",
            show_default=False,
            help="Make a folder with all data as files, and the report.",
        ),
    ] = None,
    html: AsPage = None,
    as_json: AsJson = False,
) -> None:
    """Report all that is stored of one person, for that person."""
    from sar_tui.reports.person import read, sections
    from sar_tui.store.participants import check_code, check_known

    watch_plugins(context)
    code = check_code(code)
    with home.database() as database:
        if not (found := read(database, home.folder, code)).events:
            check_known(database, code)
    made = sections(found)
    if to is not None:
        _write_files(home, to, found)
    if to is None or html is not None or as_json:
        put_out(found, made, f"What is stored of {code}", html, as_json)
    else:
        number = _count(len(found.sessions), "session")
        console().print(f"{number} of {code} in {to}", soft_wrap=True)
    if found.shared and to is not None:
        console(error=True).print(
            f"! For two people: {', '.join(found.shared)}. Take out what is of the other one before "
            "you hand the files over.",
            soft_wrap=True,
        )


def _write_files(home: Home, to: Path, found: "PersonReport") -> None:
    """Write the report, what no export has, the person's rows in studies, and an export with texts
    and messages into a new folder. Sessions of a study that is blind still are in no export.
    """
    import msgspec

    from sar_tui.drivers.files import make_private, write_private
    from sar_tui.drivers.login_name import login_name
    from sar_tui.export.export import Options
    from sar_tui.export.export import export as write
    from sar_tui.export.registry import load
    from sar_tui.reports.person import sections
    from sar_tui.reports.sections import page
    from sar_tui.store.selection import Request

    if to.exists() and (not to.is_dir() or any(to.iterdir())):
        raise Refused(f"{to} exists already, and is not overwritten. Name another folder.")
    try:
        make_private(to)
        title = f"What is stored of {found.participant}"
        write_private(to / "report.html", page(title, sections(found)))
        rest = msgspec.json.format(msgspec.json.encode(found), indent=2).decode()
        write_private(to / "report.json", f"{rest}\n")
        if found.studies:
            _write_studies(to / "studies.csv", found)
    except OSError as error:
        raise Refused(f"{to} cannot be written: {error.strerror}.") from error
    warn_of_git(to)
    if found.blind:
        console(error=True).print(
            f"! {_count(len(found.blind), 'session')} of a study that is blind still: settings and "
            "files would tell the condition. Give the command again when the study has ended.",
            soft_wrap=True,
        )
    ended = [row["id"] for row in found.sessions[::-1] if row["status"] != "running"]
    names = tuple(id for id in ended if id not in found.blind)
    if not names:
        return
    request = Request(names=names, mixed=True, also_withdrawn=True)
    options = Options(
        with_notes=True, with_events=True, recipient="the participant", author=login_name()
    )
    with home.database() as database, progress_line("Exporting"):
        exported = write(
            database,
            home.folder,
            home.catalogue(),
            request,
            load("csv"),
            to / "data",
            lambda steps: lambda: None,
            options,
        )
    for sentence in (*exported.notices, *exported.problems):
        console(error=True).print(f"! {sentence}", soft_wrap=True)


def _write_studies(path: Path, found: "PersonReport") -> None:
    """Write the person's rows in studies as CSV. Raises OSError."""
    import io

    from sar_tui.drivers.files import write_private
    from sar_tui.export.csv_file import CsvWriter
    from sar_tui.reports.person import StudyRow

    text = io.StringIO(newline="")
    writer = CsvWriter(text)
    names = StudyRow.__struct_fields__
    writer.row(names)
    writer.rows([getattr(each, name) for name in names] for each in found.studies)
    write_private(path, text.getvalue())
