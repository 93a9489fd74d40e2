"""The tree of commands. A command's module is imported when the command is called, or for the help that lists it."""

import gc
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from typing import Annotated, Any

import typer
import typer.main

from sar_tui import __version__
from sar_tui.cli.common import Data, Home, Tasks, need_screen
from sar_tui.cli.errors import Commands

COMMANDS = {
    "run": "live:run",
    "resume": "live:resume",
    "wizard": "wizard:wizard",
    "simulate": "simulate:simulate",
    "sessions": "sessions:sessions",
    "show": "sessions:show",
    "wellbeing": "wellbeing:wellbeing",
    "adverse": "adverse:app",
    "detect": "detect:detect",
    "reanalyse": "reanalyse:reanalyse",
    "progress": "progress:progress",
    "validate": "validate:validate",
    "graph": "graph:graph",
    "serve": "serve:serve",
    "rescue": "rescue:rescue",
    "passphrase": "passphrase:passphrase",
    "doctor": "doctor.command:doctor",
    "timing": "measure_timing:measure_timing",
    "agent": "agent_view:follow_agent",
    "link": "link:app",
    "instrument": "instrument:app",
    "report": "report:app",
    "programme": "programme:app",
    "tasks": "tasks:app",
    "themes": "themes:app",
}
"""Each command by its name: its module in this package, and there a function, or a Typer with further commands."""


@cache
def load(name: str) -> Any:
    """Import a command, and return it as typer makes it for the command line."""
    module, _, attribute = COMMANDS[name].partition(":")
    declared = getattr(import_module(f"{__package__}.{module}"), attribute)
    alone = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
    if isinstance(declared, typer.Typer):
        alone.add_typer(declared, name=name)
        group: Any = typer.main.get_command(alone)
        return group.commands[name]
    alone.command(name)(declared)
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


@app.callback(invoke_without_command=True)
def open_app(
    context: typer.Context,
    data: Data = None,
    tasks: Tasks = None,
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Motor-rehabilitation tasks in a terminal. Opens the app if there is no command."""
    home = Home.of(context, data, tasks)
    context.obj = home
    if context.invoked_subcommand is None:
        catalogue = home.catalogue()
        need_screen()
        gc.disable()  # nothing that is loaded is garbage; the app turns it on again once its first screen is filled
        try:
            from sar_tui.app.app import run_app

            ended = run_app(home.folder, catalogue)
        finally:
            gc.enable()
        raise typer.Exit(ended)
