"""The commands. Each is a few lines that call other packages, which are imported when the command runs."""

import sys
from typing import Annotated

import typer

from sar_tui import __version__
from sar_tui.cli.agent_view import follow_agent
from sar_tui.cli.common import AsJson, Data, Home, Tasks, need_screen
from sar_tui.cli.detect import detect
from sar_tui.cli.doctor.command import doctor as doctor_command
from sar_tui.cli.errors import Commands
from sar_tui.cli.graph import graph
from sar_tui.cli.link import app as link_app
from sar_tui.cli.live import resume, run
from sar_tui.cli.reanalyse import reanalyse
from sar_tui.cli.report import app as report_app
from sar_tui.cli.serve import serve
from sar_tui.cli.sessions import sessions, show
from sar_tui.cli.simulate import simulate
from sar_tui.cli.tasks import app as tasks_app
from sar_tui.cli.themes import app as themes_app
from sar_tui.cli.validate import validate
from sar_tui.cli.wizard import wizard

app = typer.Typer(
    name="sar-tui",
    cls=Commands,
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
        from sar_tui.app.app import run_app

        raise typer.Exit(run_app(home.folder, catalogue))


def measure_timing(
    context: typer.Context,
    trials: Annotated[int, typer.Option(min=10, max=10_000, help="Number of responses to measure.")] = 100,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Measure the timing of this machine.

    Reports whether it is fit for an experiment, and why. The figures are stored with later sessions.
    """
    from sar_tui.cli import timing

    raise typer.Exit(timing.run(Home.of(context, data, tasks).folder, trials, as_json))


for command in (
    run,
    resume,
    wizard,
    simulate,
    sessions,
    show,
    detect,
    reanalyse,
    validate,
    graph,
    serve,
    doctor_command,
):
    app.command()(command)
app.command("timing")(measure_timing)
app.command("agent")(follow_agent)
app.add_typer(link_app, name="link")
app.add_typer(report_app, name="report")
app.add_typer(tasks_app, name="tasks")
app.add_typer(themes_app, name="themes")


def main() -> None:
    """Run the program, and exit with 0: done, 1: failed, 2: bad usage or input, 130: stopped by Ctrl-C."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    app(prog_name="sar-tui")
