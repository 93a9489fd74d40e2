"""``sar-tui programme``: shows, exports, imports participants' programmes, and lists their versions
and presets.
"""

import sys
from collections.abc import Mapping, Sequence
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sar_tui.cli.common import (
    AsJson,
    Code,
    Home,
    New,
    TaskName,
    are_new,
    console,
    named_path,
    print_json,
    write_new,
)
from sar_tui.cli.errors import Refused

if TYPE_CHECKING:
    from sar_tui.loop.task import Task
    from sar_tui.rules.parameters import Change
    from sar_tui.store.programmes import Programme

app = typer.Typer(rich_markup_mode=None)

AnyTask = Annotated[
    str | None,
    typer.Argument(
        metavar="[TASK]", help="The task. Default: each that has one.", show_default=False
    ),
]
Version = Annotated[
    int | None,
    typer.Option(
        "--version",
        metavar="N",
        min=1,
        show_default=False,
        help="An earlier version. Default: the newest.",
    ),
]


@app.callback()
def programme(home: Home) -> None:
    """Show, export, import a participant's programme: its settings, as versions."""


@app.command()
def show(
    home: Home,
    participant: Code,
    task: AnyTask = None,
    version: Version = None,
    as_json: AsJson = False,
) -> None:
    """Show the programme that the next session runs: what differs from the defaults."""
    from sar_tui.rules.parameters import changes, usable
    from sar_tui.store import programmes

    found = []
    with home.database() as database:
        code, names = _tasks(database, participant, task)
        for name in names:
            saved = programmes.find(database, code, name, version) if version else None
            found.append(
                (home.catalogue().task(name), saved or programmes.newest(database, code, name))
            )
    usables = [usable(kind.Parameters, saved.parameters) for kind, saved in found]
    if as_json:
        rows = [
            {**_facts(kind, code, saved), "parameters": saved.parameters, "left_out": left_out}
            for (kind, saved), (_, left_out) in zip(found, usables, strict=True)
        ]
        print_json({"programmes": rows})
        return
    if not found:
        _print_none(code)
    for (kind, saved), (kept, left_out) in zip(found, usables, strict=True):
        _print(kind, code, saved, changes(kind.Parameters, {}, kept), tuple(left_out.values()))


def _print(
    kind: "type[Task]",
    code: str,
    saved: "Programme",
    differing: "Sequence[Change]",
    left_out: Sequence[str],
) -> None:
    from sar_tui.cli.tables import add, table
    from sar_tui.rules.declaration import show as shown

    out = console()
    if not saved.version:
        out.print(
            f"{code} has no programme for {kind.title}: its defaults are used.", soft_wrap=True
        )
        return
    out.print(f"{code}, {kind.title}: version {saved.version}", soft_wrap=True)
    out.print(f"Saved {_when_and_who(_facts(kind, code, saved))}", soft_wrap=True)
    if saved.reason:
        out.print(f"Why   {saved.reason}", soft_wrap=True)
    out.print(f"Theme {saved.theme}", end="\n\n")
    if differing:
        made = table("setting", "value", "default", "name", whole=("name",))
        for change in differing:
            value = f"{shown(change.after) or 'none'} {change.unit}".rstrip()
            add(made, change.title, value, shown(change.before) or "none", change.name)
        out.print(made, end="\n\n")
    for reason in left_out:
        out.print(f"! Not used: {reason}", soft_wrap=True)
    rest = "Everything else is" if differing else "Everything is"
    out.print(
        f"{rest} at its default; `sar-tui tasks show {kind.name}` lists it.",
        end="\n\n",
        soft_wrap=True,
    )


@app.command()
def history(
    home: Home,
    participant: Code,
    task: AnyTask = None,
    as_json: AsJson = False,
) -> None:
    """List the versions of a programme: who changed what, when, why."""
    from sar_tui.rules.parameters import changes
    from sar_tui.store import programmes

    with home.database() as database:
        code, names = _tasks(database, participant, task)
        found = {name: programmes.versions(database, code, name) for name in names}
    rows: list[dict[str, Any]] = []
    for name, versions in found.items():
        kind = home.catalogue().task(name)
        for before, saved in zip([programmes.Programme(), *versions], versions, strict=False):
            made = changes(kind.Parameters, before.parameters, saved.parameters)
            facts = _facts(kind, code, saved)
            rows.append({**facts, "theme_before": before.theme, "changes": made})
    if not rows and not as_json:
        _print_none(code)
        return
    from sar_tui.cli.tables import Column, Listing, print_listing

    print_listing(
        Listing(
            "versions",
            empty="",
            columns=(
                Column("version", itemgetter("version"), is_number=True),
                *((Column("task", itemgetter("task")),) if len(found) > 1 else ()),
                Column("saved", _when_and_who),
                Column("what changed", _changes_in_words),
                Column("why", itemgetter("reason")),
            ),
            folds=True,
            whole=("saved",),
        ),
        rows[::-1],
        as_json,
    )


@app.command("export")
def export_programme(
    home: Home,
    participant: Code,
    task: TaskName,
    version: Version = None,
    to: Annotated[
        Path | None,
        typer.Option(
            "--to",
            parser=named_path,
            metavar="FILE",
            show_default=False,
            help="Write it to this file, which must not exist.",
        ),
    ] = None,
    preset: Annotated[
        str | None,
        typer.Option(
            "--preset", metavar="NAME", show_default=False, help="Keep it as a preset of your own."
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Write a programme as TOML, with the meaning of every setting."""
    import msgspec

    from sar_tui.rules.parameters import build, usable
    from sar_tui.runs.programme_file import write, write_preset
    from sar_tui.store import programmes

    kind = home.catalogue().task(task)
    with home.database() as database:
        code, _ = _tasks(database, participant, task)
        saved = programmes.find(database, code, task, version) if version else None
        saved = saved or programmes.newest(database, code, task)
    if as_json:
        kept, left_out = usable(kind.Parameters, saved.parameters)
        values = msgspec.to_builtins(build(kind.Parameters, kept))
        print_json(
            {"programme": {**_facts(kind, code, saved), "parameters": values, "left_out": left_out}}
        )
        return
    text = write(kind, code, saved)
    if preset is not None:
        to = _preset_file(home, kind, preset)
        text = write_preset(kind, saved)
    if to is None:
        print(text, end="")
        return
    write_new(to, text)
    console().print(f"Wrote {to}.", soft_wrap=True)


@app.command("import")
def import_programme(
    home: Home,
    participant: Code,
    task: TaskName,
    file: Annotated[
        Path | None,
        typer.Argument(
            parser=named_path,
            metavar="[FILE]",
            help="A file that export wrote; - for stdin.",
            show_default=False,
        ),
    ] = None,
    preset: Annotated[
        str | None,
        typer.Option(
            "--preset",
            metavar="NAME",
            show_default=False,
            help="Instead of a file: mild, moderate, severe, or one of your own. Settings of the "
            "person and the place, "
            "such as hand, language and limits, stay as they are; all others are as the preset "
            "says, else at their "
            "default.",
        ),
    ] = None,
    reason: Annotated[
        str,
        typer.Option(
            "--reason", metavar="TEXT", show_default=False, help="Why the programme changes."
        ),
    ] = "",
    author: Annotated[
        str | None,
        typer.Option(
            "--author",
            metavar="NAME",
            show_default=False,
            help="Who changes it. Default: the login name.",
        ),
    ] = None,
    new: New = False,
    anyway: Annotated[
        bool,
        typer.Option(
            "--anyway", help="Also if the programme was changed since the file was exported."
        ),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Save a file or a preset as the next version of a programme."""
    import msgspec

    from sar_tui.cli.common import checked_settings
    from sar_tui.drivers.login_name import login_name
    from sar_tui.letterbox.identity import check_programme
    from sar_tui.rules.parameters import build, changed, usable
    from sar_tui.runs.plan import make_plan
    from sar_tui.runs.programme_file import applied, find, not_applied
    from sar_tui.store import participants, programmes

    if (file is None) == (preset is None):
        raise Refused(
            "Name either a file or a preset: --preset mild. `sar-tui programme presets TASK` "
            "lists them."
        )
    if not reason.strip():
        raise Refused('Say why the programme changes: --reason "Reached the goal four times".')
    check_programme(home.folder)
    catalogue = home.catalogue()
    kind = catalogue.task(task)
    code = participants.check_own(participant)
    given = find(home.folder, kind, preset) if preset is not None else _read(file)
    if given.task != task:
        raise Refused(f"This programme is for the task {given.task}, not {task}.")
    with home.writable_database() as database:
        are_new(database, [code], said=new)
        last = programmes.newest(database, code, task)
        after = last.version
        if file is not None and given.participant.upper() == code and given.version and not anyway:
            after = given.version
        values: Mapping[str, Any] = given.parameters
        if preset is not None:
            values = applied(kind, given, usable(kind.Parameters, last.parameters)[0])
            given = msgspec.structs.replace(given, theme="")
        with checked_settings(kind):
            parameters = build(kind.Parameters, values)
            wanted = programmes.Programme(changed(parameters), given.theme or last.theme)
            make_plan(catalogue, kind, [code], saved=wanted, mode="simulated")
        try:
            saved = programmes.save(
                database, code, task, wanted, after=after,
                author=login_name() if author is None else author, reason=reason.strip(),
            )  # fmt: skip
        except programmes.Superseded as error:
            raise Refused(
                f"{error} Export it again, or give --anyway to put this file on top of it."
            ) from error
        participants.add(database, code)
    if as_json:
        print_json({"programme": {**_facts(kind, code, saved), "parameters": saved.parameters}})
        return
    if preset is not None and (stay := not_applied(kind, given)):
        names = ", ".join(field.title for field in stay)
        print(
            f"! The preset also names what belongs to the person or the place, and stays: {names}.",
            file=sys.stderr,
        )
    is_new = saved.version != last.version
    done = (
        f"Saved version {saved.version}"
        if is_new
        else f"Nothing differs from version {saved.version}"
    )
    console().print(f"{done} of the programme of {code} for {kind.title}.", soft_wrap=True)


@app.command()
def presets(
    home: Home,
    task: TaskName,
    as_json: AsJson = False,
) -> None:
    """List the presets of a task."""
    from sar_tui.runs.programme_file import files, read
    from sar_tui.store.database import StoreError

    rows: list[dict[str, Any]] = []
    for name, path in files(home.folder, home.catalogue().task(task)).items():
        try:
            preset = read(path)
        except StoreError as error:
            rows.append({"name": name, "error": str(error)})
        else:
            rows.append({"name": name, "summary": preset.summary, "parameters": preset.parameters})
    from sar_tui.cli.tables import Column, Listing, print_listing

    print_listing(
        Listing(
            "presets",
            empty=f"The task {task} has no presets.",
            columns=(
                Column("preset", itemgetter("name")),
                Column(
                    "summary", lambda row: row.get("error") or row["summary"] or "one of your own"
                ),
            ),
            folds=True,
            whole=("preset",),
        ),
        rows,
        as_json,
    )


def _tasks(database: Any, participant: str, task: str | None) -> tuple[str, list[str]]:
    """Return the code as it is stored, and the task, or those for which there is a programme.

    Raises StoreError if there is no such participant.
    """
    from sar_tui.store import participants, programmes

    code = participants.check_known(database, participant)
    return code, [task] if task is not None else programmes.tasks(database, code)


def _facts(kind: "type[Task]", code: str, saved: "Programme") -> dict[str, Any]:
    return {
        "participant": code,
        "task": kind.name,
        "version": saved.version,
        "created_at": saved.created_at,
        "author": saved.author,
        "reason": saved.reason,
        "theme": saved.theme,
    }


def _when_and_who(version: Mapping[str, Any]) -> str:
    from sar_tui.store.sessions import local_time

    author = version["author"]
    return f"{local_time(version['created_at'])}{f' by {author}' if author else ''}"


def _changes_in_words(version: Mapping[str, Any]) -> str:
    before, theme = version["theme_before"], version["theme"]
    changed = [change.text for change in version["changes"]]
    if before != theme:
        changed.append(f"theme {before} → {theme}")
    return "; ".join(changed) or "nothing differs from the defaults"


def _print_none(code: str) -> None:
    console().print(
        f"{code} has no programme yet: the defaults of each task are used. F2 in the app, or "
        "`sar-tui programme import`, makes one.",
        soft_wrap=True,
    )


def _read(file: Path | None) -> Any:
    from sar_tui.runs.programme_file import parse, read

    assert file
    if str(file) != "-":
        return read(file)
    try:
        return parse(sys.stdin.read(), "Standard input")
    except UnicodeDecodeError:
        raise Refused("Standard input is not a text in UTF-8.") from None


def _preset_file(home: Home, kind: "type[Task]", name: str) -> Path:
    """Return the file of a preset of one's own; its folder exists."""
    from sar_tui.drivers.files import make_private
    from sar_tui.runs.programme_file import own_folder

    if not name.replace("-", "").replace("_", "").isalnum():
        raise Refused(
            f"{name!r} cannot name a preset. Use letters, digits, - and _, such as left-arm."
        )
    folder = own_folder(home.folder, kind)
    make_private(folder)
    return folder / f"{name}.toml"
