"""``sar-tui record``: adverse events, scores, pain, answers, and what a clinic declares."""

import sys
from collections.abc import Sequence
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import (
    AsJson,
    Code,
    Data,
    Home,
    Language,
    New,
    Plain,
    Tasks,
    are_new,
    console,
    is_plain,
    named_path,
    need_terminal,
    print_json,
)
from sar_tui.cli.errors import Refused
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from sar_tui.records.kind import Kind
    from sar_tui.records.redcap import FoundForm
    from sar_tui.store.records import Record

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True)

_Values = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="FIELD=VALUE", help="Such as severity=mild or score=34.", show_default=False
    ),
]
_Id = Annotated[str, typer.Argument(metavar="RECORD", help="Its id.", show_default=False)]
_On = Annotated[
    str,
    typer.Option(
        "--on",
        metavar="DATE",
        show_default=False,
        help="The day it is of, 2026-03-01; of some kinds with a time, 2026-03-01T14:30. "
        "Default: now.",
    ),
]


@app.callback()
def record() -> None:
    """Enter, correct and list records: adverse events, scores of other tests, pain, answers."""


@app.command("kinds")
def list_kinds(as_json: AsJson = False, data: Data = None, tasks: Tasks = None) -> None:
    """List the kinds of record with their fields; a clinic can add its own (docs/records.md)."""
    from sar_tui.cli.tables import Column, Listing, print_listing
    from sar_tui.records.kind import kinds, unusable_files
    from sar_tui.reports.progress_words import published

    print_listing(
        Listing(
            "kinds",
            empty="There are no kinds of record.",
            columns=(
                Column("kind", attrgetter("name")),
                Column("title", attrgetter("title")),
                Column("fields", _fields_in_words),
                Column(
                    "published changes",
                    lambda kind: "\n".join(published(each, kind) for each in kind.published),
                ),
            ),
            folds=True,
            whole=("kind",),
        ),
        list(kinds().values()),
        as_json,
    )
    for problem in unusable_files():
        print(f"! {problem}", file=sys.stderr)


@app.command("add")
def add_record(
    context: typer.Context,
    kind: Annotated[
        str,
        typer.Argument(
            metavar="KIND", help="`sar-tui record kinds` lists them.", show_default=False
        ),
    ],
    participant: Code,
    values: _Values = None,
    on: _On = "",
    session: Annotated[
        str | None,
        typer.Option(
            "--session",
            metavar="SESSION|last",
            show_default=False,
            help="The session that it belongs to.",
        ),
    ] = None,
    new: New = False,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Enter a record. Of a score, a second one of the same day replaces the first, which is kept."""
    from sar_tui.drivers.login_name import login_name
    from sar_tui.store import participants, records
    from sar_tui.store.database import StoreError
    from sar_tui.store.sessions import find

    home = Home.of(context, data, tasks)
    declared = records.kind_of(kind)
    if declared.entered_by == "program":
        raise Refused(f"Records of the kind {declared.name} follow from sessions.")
    if declared.why_not_allowed:
        raise Refused(declared.why_not_allowed)
    code = participants.check_code(participant)
    with home.writable_database() as database:
        found = find(database, home.folder, session) if session is not None else None
        if found and code not in (found["participant"], found["partner"]):
            raise StoreError(f"The session {found['id']} is not one of {code}.", bad_input=True)
        is_new = are_new(database, [participant], said=new)
        entered = records.add(
            database,
            declared,
            code,
            on,
            _read_values(values),
            session=found["id"] if found else None,
            author=login_name(),
            is_new=is_new,
        )
    _print_saved(entered, declared, as_json=as_json)


@app.command("fill")
def fill_form(
    context: typer.Context,
    form: Annotated[
        str,
        typer.Argument(
            metavar="FORM", help="`sar-tui record kinds` lists them.", show_default=False
        ),
    ],
    participant: Code,
    language: Language = None,
    plain: Plain = False,
    new: New = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Let a participant fill in a form, alone on the screen; its scores are printed afterwards.

    A form that was left, or whose terminal was closed, goes on where it was, on the same day.
    """
    from sar_tui.model.language import BUNDLED
    from sar_tui.store import forms, participants
    from sar_tui.store.forms import Occasion
    from sar_tui.store.training_days import utc

    home = Home.of(context, data, tasks)
    kind, code = forms.form(form), participants.check_code(participant)
    if language is not None and language not in BUNDLED:
        raise Refused(
            f"There is no language {language!r:.20}. Choose one of: {', '.join(BUNDLED)}."
        )
    as_lines = is_plain(plain)
    need_terminal(plain=as_lines)
    with home.writable_database() as database:
        if are_new(database, [participant], said=new):
            participants.add(database, code)
    if language and language not in kind.languages:
        print(f"! {kind.name} has no words in {BUNDLED[language]}.", file=sys.stderr)
    of, began = Occasion(code), utc()
    if as_lines:
        from sar_tui.app.plain import run_plain_form as run
    else:
        from sar_tui.app.app import run_form as run
    ended = run(home.folder, home.catalogue(), kind, of, language or "")
    with home.database() as database:
        found = forms.newest(database, kind, of)
    if found and found.recorded_at >= began:
        said = forms.summary(found, kind)
        console().print(f"{kind.title} of {code}: {said}.", soft_wrap=True)
    raise typer.Exit(ended)


@app.command("redcap")
def write_redcap(
    forms: Annotated[
        list[str],
        typer.Argument(
            metavar="FORM…", help="`sar-tui record kinds` lists them.", show_default=False
        ),
    ],
    to: Annotated[
        Path,
        typer.Option(
            "--to",
            parser=named_path,
            metavar="FILE.zip|DIR",
            show_default=False,
            help="A new file; of several forms, a folder for a file each.",
        ),
    ],
    language: Language = None,
    as_json: AsJson = False,
) -> None:
    """Write forms as REDCap's instruments, which its Online Designer adds to a project.

    A data dictionary would replace all forms of the project; an instrument's zip adds one.
    """
    from sar_tui.drivers.files import write_private
    from sar_tui.records.redcap import RedcapError, instrument_zip
    from sar_tui.store.forms import form

    kinds = [form(name) for name in dict.fromkeys(forms)]
    if language and (without := [kind.name for kind in kinds if language not in kind.languages]):
        raise Refused(f"{without[0]} has no words in {language!r:.20}.")
    written = []
    for kind in kinds:
        path = to if len(kinds) == 1 else to / f"{kind.name.lower()}.zip"
        try:
            content = instrument_zip(kind, language or "en")
            path.parent.mkdir(parents=True, exist_ok=True)
            write_private(path, content)
        except RedcapError as error:
            raise Refused(str(error)) from error
        except OSError as error:
            raise Refused(f"{path} cannot be written: {error.strerror or error}.") from error
        written.append(str(path))
    if as_json:
        print_json({"files": written})
        return
    for path_of_file in written:
        console().print(f"Written: {path_of_file}", soft_wrap=True)


@app.command("from-redcap")
def read_redcap(
    file: Annotated[
        Path,
        typer.Argument(
            parser=named_path,
            metavar="FILE",
            help="A data dictionary (CSV), or an instrument (zip).",
            show_default=False,
        ),
    ],
    to: Annotated[
        Path | None,
        typer.Option(
            "--to",
            parser=named_path,
            metavar="DIR",
            show_default=False,
            help="Folder for the files. Default: where your own kinds of record are.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Read forms from REDCap. A form that cannot be the same here is refused, with its rows."""
    from sar_tui.records.kind import kinds, own_folder
    from sar_tui.records.redcap import RedcapError, read

    try:
        found = read(file)
    except RedcapError as error:
        raise Refused(str(error)) from error
    folder = to or own_folder()
    known = {name.casefold() for name in kinds()} if to is None else set()
    told = []
    for each in found:
        path = folder / f"{each.name}.toml"
        refused = each.refused or _write_declaration(each, path, known)
        told.append(
            {
                "form": each.name,
                "file": "" if refused else str(path),
                "refused": refused,
                "left_out": each.left_out,
            }
        )
        if as_json:
            continue
        for text in (*each.left_out, *refused):
            console().print(f"! {text}", soft_wrap=True)
        done = "is refused" if refused else f"is read: {path}"
        console().print(f"The form {each.name} {done}.", soft_wrap=True)
    if as_json:
        print_json({"forms": told})
    if not found or any(each["refused"] for each in told):
        raise typer.Exit(FAILED)


def _write_declaration(form: "FoundForm", path: Path, known: set[str]) -> list[str]:
    """Write the file of a form, whose kind is known from now on. Return why it cannot be, else
    nothing.
    """
    from sar_tui.drivers.files import write_private

    name = form.kind.casefold()
    if name in known:
        return [f"There is a kind of record {form.kind} already."]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_private(path, form.declaration)
    except OSError as error:
        return [f"{path} cannot be written: {error.strerror or error}."]
    known.add(name)
    return []


@app.command("correct")
def correct_record(
    context: typer.Context,
    id: _Id,
    values: _Values = None,
    on: Annotated[
        str | None,
        typer.Option("--on", metavar="DATE", show_default=False, help="Another date."),
    ] = None,
    remove: Annotated[
        bool, typer.Option("--remove", help="It was entered by mistake, and counts no longer.")
    ] = False,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Correct a record, or add what is known now. What was recorded before is kept."""
    from sar_tui.drivers.login_name import login_name
    from sar_tui.store import records

    with Home.of(context, data, tasks).writable_database() as database:
        changed = records.correct(
            database, id, _read_values(values), at=on, removed=remove, author=login_name()
        )
    _print_saved(changed, records.kind_of(changed.kind), as_json=as_json)


@app.command("list")
def list_records(
    context: typer.Context,
    kind: Annotated[
        str | None,
        typer.Argument(metavar="[KIND]", help="Only of this kind.", show_default=False),
    ] = None,
    participant: Annotated[
        str | None,
        typer.Option(
            "-p",
            "--participant",
            metavar="CODE",
            show_default=False,
            help="Records of this participant.",
        ),
    ] = None,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """List records as they are known now, by date, and what the therapist should know of pain."""
    from sar_tui.rules.wellbeing import tell_therapist
    from sar_tui.store import participants, records, wellbeing

    code = participants.check_code(participant) if participant is not None else None
    names = [records.kind_of(kind).name] if kind else []
    with Home.of(context, data, tasks).database() as database:
        found = records.listing(database, kinds=names, participant=code)
        if code and not found:
            participants.check_known(database, code)
        reasons = tell_therapist(wellbeing.history(database, code)) if code else ()
    from sar_tui.cli.tables import Column, Listing, print_listing
    from sar_tui.reports.wellbeing import advice

    for text in () if as_json else advice(reasons):
        console().print(f"! {text}", soft_wrap=True)
    of = "".join((f" of the kind {kind}" if kind else "", f" of {code}" if code else ""))
    print_listing(
        Listing(
            "records",
            empty=f"There are no records{of}.",
            columns=(
                Column("record", attrgetter("id")),
                Column("date", _date),
                Column("who", attrgetter("participant")),
                Column("kind", attrgetter("kind")),
                Column("contents", _in_short),
            ),
            folds=True,
            whole=("record", "date", "kind"),
        ),
        found,
        as_json,
        tell_therapist=reasons,
    )


@app.command("show")
def show_record(
    context: typer.Context,
    id: _Id,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Show all versions of a record: who recorded what, and when."""
    from sar_tui.store import records

    with Home.of(context, data, tasks).database() as database:
        found = records.versions(database, id)
    from sar_tui.cli.tables import Column, Listing, print_listing
    from sar_tui.store.sessions import local_time

    if not as_json:
        title = f"{found[0].kind} {id} of {found[0].participant}"
        console().print(title, soft_wrap=True, end="\n\n")
    print_listing(
        Listing(
            "versions",
            empty="There is no version of it.",
            columns=(
                Column("version", attrgetter("version"), is_number=True),
                Column("recorded", lambda one: local_time(one.recorded_at)),
                Column("by", attrgetter("recorded_by")),
                Column("date", _date),
                Column("contents", _in_words),
            ),
            folds=True,
        ),
        found,
        as_json,
    )


def _read_values(given: Sequence[str] | None) -> dict[str, str | int | float | bool | None]:
    """Return the values of FIELD=VALUE arguments; an empty one empties the field. Raises Refused."""
    found: dict[str, str | int | float | bool | None] = {}
    for pair in given or ():
        name, sign, value = pair.partition("=")
        if not sign or not name.strip():
            raise Refused(f"A value is given as FIELD=VALUE, such as severity=mild, not {pair!r}.")
        found[name.strip()] = value or None
    return found


def _fields_in_words(kind: "Kind") -> str:
    """Return the fields of a kind on a line each; of a form the number of its items, its scores, and
    why it cannot be used here.
    """
    if kind.form is None:
        return "\n".join(map(_field_in_words, kind.fields))
    scores = [f"{score.name}: {kind.field(score.name).range}" for score in kind.scores]
    items = f"form of {len(kind.items)} item{'s' * (len(kind.items) > 1)}"
    return "\n".join((items, *scores, *filter(None, [kind.why_unusable])))


def _field_in_words(field: object) -> str:
    from sar_tui.records.kind import Field

    assert isinstance(field, Field)
    options = " | ".join(field.labels) if field.type == "choice" else field.range or field.type
    return f"{field.name}: {options}{'' if field.required else ', or empty'}"


def _date(one: "Record") -> str:
    from sar_tui.store.sessions import local_time

    return local_time(one.at) if "+" in one.at else one.at


def _in_short(one: "Record") -> str:
    """Return the scores of a form, or the values of another record."""
    from sar_tui.records.kind import kinds
    from sar_tui.store.forms import summary

    kind = kinds().get(one.kind)
    if kind is None or kind.form is None:
        return _in_words(one)
    return "; ".join((summary(one, kind), *(["removed"] * one.removed)))


def _in_words(one: "Record") -> str:
    """Return the values of a record, with the moment of a session."""
    values = [f"{name}: {value}" for name, value in one.content.items()]
    moment = [{"pause": "in a pause"}.get(one.moment, f"{one.moment} the session")]
    return "; ".join((*(moment if one.moment else ()), *values, *(["removed"] * one.removed)))


def _print_saved(entered: "Record", kind: "Kind", *, as_json: bool) -> None:
    if as_json:
        print_json({"record": entered})
        return
    unknown = [field for field in kind.fields if field.later and field.name not in entered.content]
    missing = [f"{field.name}=…" for field in unknown]
    later = f" Add later: `sar-tui record correct {entered.id} {' '.join(missing)}`."
    done = "removed, and kept in the database" if entered.removed else "recorded"
    console().print(
        f"{kind.title} {entered.id} of {entered.participant} is {done}."
        f"{later if missing and not entered.removed else ''}",
        soft_wrap=True,
    )
