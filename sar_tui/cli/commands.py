"""The tree of commands. A command's module is imported when the command is called, or for the help
that lists it.
"""

import gc
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Annotated, Any

import typer
import typer.main

from sar_tui import __version__
from sar_tui.cli.common import (
    Data,
    Home,
    Markers,
    Plain,
    Protocol,
    SyncFlash,
    Tasks,
    at_home,
    checked_markers,
    is_plain,
    need_screen,
    need_terminal,
)
from sar_tui.cli.errors import Commands, Refused

if TYPE_CHECKING:
    from sar_tui.plugins import Catalogue

COMMANDS = {
    "demo": "demo:demo",
    "run": "live:run",
    "resume": "live:resume",
    "wizard": "wizard:wizard",
    "simulate": "simulate:simulate",
    "sessions": "sessions:sessions",
    "show": "sessions:show",
    "record": "record:app",
    "participant": "participant:app",
    "export": "export:export",
    "detect": "detect:detect",
    "replay": "replay:replay",
    "reanalyse": "reanalyse:reanalyse",
    "progress": "progress:progress",
    "validate": "validate:validate",
    "graph": "graph:graph",
    "serve": "serve:serve",
    "backup": "maintenance:backup",
    "check": "maintenance:check",
    "site": "merge:site",
    "merge": "merge:merge",
    "rescue": "maintenance:rescue",
    "passphrase": "passphrase:passphrase",
    "doctor": "doctor.command:doctor",
    "timing": "timing:timing",
    "sensors": "sensors:sensors",
    "robots": "robots:robots",
    "markers": "markers:markers",
    "agent": "wizard:agent",
    "link": "link:app",
    "letterbox": "letterbox:app",
    "study": "study:app",
    "report": "report:app",
    "programme": "programme:app",
    "tasks": "tasks:app",
    "themes": "themes:app",
}
"""Each command by its name: its module in this package, and there a function, or a Typer with
further commands.
"""


@cache
def load(name: str) -> Any:
    """Import a command, and return it as typer makes it for the command line."""
    module, _, attribute = COMMANDS[name].partition(":")
    declared = getattr(import_module(f"{__package__}.{module}"), attribute)
    alone = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
    if isinstance(declared, typer.Typer):
        declarations: list[Any] = [declared.registered_callback, *declared.registered_commands]
        for each in filter(None, declarations):
            each.callback = at_home(each.callback)
        alone.add_typer(declared, name=name)
        group: Any = typer.main.get_command(alone)
        return group.commands[name]
    alone.command(name)(at_home(declared))
    return typer.main.get_command(alone)


class LazyCommands(Mapping[str, Any]):
    """The commands by name, each loaded when it is looked up."""

    def __getitem__(self, name: str) -> Any:
        if name not in COMMANDS:
            raise KeyError(name)
        return load(name)

    def __iter__(self) -> Iterator[str]:
        return iter(COMMANDS)

    def __len__(self) -> int:
        return len(COMMANDS)


class AllCommands(Commands):
    """The group of all commands."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.commands: Any = LazyCommands()


app = typer.Typer(
    name="sar-tui",
    cls=AllCommands,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"sar-tui {__version__}")
        raise typer.Exit


def _trains_at_home(home: Home) -> str | None:
    """Return the code of the person who trains at home with this data folder, if one does."""
    from sar_tui.letterbox import FILE

    if not (home.folder / FILE).exists():
        return None
    from sar_tui.letterbox.identity import read

    me = read(home.folder)
    return me.participant if me is not None and me.is_home else None


def _checked_patient(
    home: Home, catalogue: "Catalogue", code: str, *, plain: bool, sync_flash: bool
) -> str:
    """Return the code of a participant who can train alone; from here on the terminal's keys send
    no signals.

    Raises:
        Refused: there is no passphrase, or no terminal.
        StoreError: the code is not valid, or of another site, or has no exercise.
    """
    from sar_tui.app.patient_mode import ignore_keys_that_signal
    from sar_tui.runs.patient_plan import exercises
    from sar_tui.store.participants import check_known, check_own
    from sar_tui.store.passphrase import Passphrase

    code = check_own(code)
    if not Passphrase(home.folder).is_set:
        raise Refused("Patient mode ends with a passphrase. Set one first: sar-tui passphrase.")
    with home.database() as database:
        check_known(database, code)
        exercises(database, home.folder, catalogue, code)
    need_terminal(plain=plain, sync_flash=sync_flash)
    ignore_keys_that_signal()
    return code


@app.callback(invoke_without_command=True)
def open_app(
    context: typer.Context,
    data: Data = None,
    tasks: Tasks = None,
    patient: Annotated[
        str | None,
        typer.Option(
            "--patient",
            metavar="CODE",
            show_default=False,
            help="Let this participant train alone: only their exercises, until F12 and the "
            "passphrase.",
        ),
    ] = None,
    markers: Markers = None,
    sync_flash: SyncFlash = False,
    protocol: Protocol = None,
    plain: Plain = False,
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    """Motor-rehabilitation tasks in a terminal. Opens the app if there is no command."""
    home = Home.of(context, data, tasks)
    context.obj = home
    if context.invoked_subcommand is not None:
        misplaced = (
            (plain, "--plain goes after the command: sar-tui run TASK -p CODE --plain"),
            (patient is not None, "--patient goes without a command: sar-tui --patient CODE"),
            (markers, "--markers goes after the command: sar-tui run TASK -p CODE --markers WHERE"),
            (
                sync_flash,
                "--sync-flash goes after the command: sar-tui run TASK -p CODE --sync-flash",
            ),
            (protocol, "--protocol goes after the command: sar-tui wizard --protocol FILE"),
        )
        for is_given, why in misplaced:
            if is_given:
                raise Refused(why)
    else:
        catalogue = home.catalogue()
        patient = patient if patient is not None else _trains_at_home(home)
        as_lines = is_plain(plain) and patient is not None
        if protocol is not None and patient is not None:
            raise Refused("A participant alone has no operator's panel: leave out --protocol.")
        followed = None
        if protocol is not None:
            from sar_tui.cli.wizard import read_protocol

            followed = read_protocol(protocol)
        if patient is not None:
            patient = _checked_patient(
                home, catalogue, patient, plain=as_lines, sync_flash=sync_flash
            )
        elif plain:
            raise Refused("--plain is for a session: add --patient CODE, or use sar-tui run.")
        else:
            need_screen()
        addresses = checked_markers(markers)
        if as_lines:
            from sar_tui.app.plain import run_plain

            raise typer.Exit(
                run_plain(home.folder, catalogue, patient=patient or "", markers=addresses)
            )
        # nothing that is loaded is garbage; the app turns it on again once its first screen is
        # filled
        gc.disable()
        try:
            from sar_tui.app.app import run_app

            ended = run_app(
                home.folder,
                catalogue,
                patient=patient or "",
                markers=addresses,
                sync_flash=sync_flash,
                protocol=followed,
            )
        finally:
            gc.enable()
        raise typer.Exit(ended)
