"""``sar-tui tasks``: what is installed, and help for those who write one."""

from pathlib import Path
from typing import Annotated, Any

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks, console, print_json
from sar_tui.cli.errors import FAILED

app = typer.Typer(rich_markup_mode=None)


@app.callback(invoke_without_command=True)
def list_tasks(context: typer.Context, as_json: AsJson = False, data: Data = None, tasks: Tasks = None) -> None:
    """List the tasks; show one, begin a new one, check one."""
    context.obj = home = Home.of(context, data, tasks)
    if context.invoked_subcommand is not None:
        return
    from sar_tui.plugins import PluginError

    catalogue = home.catalogue()
    rows: list[dict[str, Any]] = []
    broken: list[dict[str, str]] = []
    for name in catalogue.task_names():
        try:
            task = catalogue.task(name)
        except PluginError as error:
            broken.append({"name": name, "error": str(error)})
        else:
            rows.append({"name": name, "title": task.title, "summary": task.summary, "metric": task.metric})
    if as_json:
        print_json({"tasks": [*rows, *broken]})
        return

    from sar_tui.cli.tables import add, table

    made = table("name", "title", "summary", "metric")
    for row in rows:
        metric = row["metric"]
        unit = f"{metric.unit}, " if metric.unit else ""
        words = f"{metric.name.replace('_', ' ')} ({unit}{metric.better} is better)"
        add(made, row["name"], row["title"], row["summary"], words)
    out = console()
    out.print(made)
    for problem in broken:
        out.print(f"✗ {problem['name']}: {problem['error']}", markup=False)


@app.command("show")
def show_task(
    context: typer.Context,
    name: Annotated[str, typer.Argument(help="The task's name.", show_default=False)],
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Show what can be set for a task, for --set NAME=VALUE."""
    from sar_tui.framework.parameters import fields, show

    task = Home.of(context, data, tasks).catalogue().task(name)
    declared = fields(task.Parameters)
    if as_json:
        facts = {"name": name, "title": task.title, "summary": task.summary, "metric": task.metric}
        print_json({"task": facts, "parameters": declared})
        return

    from sar_tui.cli.tables import add, table

    out = console()
    out.print(f"{task.title}. {task.summary}\n", markup=False)
    made = table("name", "default", "allowed", "unit", "what it is")
    for field in declared:
        words = f"{field.title}. {field.help}" if field.help else field.title
        add(made, field.name, show(field.default), field.bounds, field.unit, words)
    out.print(made)


@app.command("new")
def new_task(
    name: Annotated[str, typer.Argument(help="Its name: a small word, such as tapping.", show_default=False)],
    to: Annotated[Path, typer.Option("--to", metavar="DIR", help="Where its folder is made.")] = Path(),
) -> None:
    """Begin a new task: a folder with a working example, to be changed."""
    from sar_tui.cli.scaffold import make

    folder = make(name, to)
    console().print(
        f"Made {folder}: a working task to make your own. Change task.py, then try\n"
        f"  sar-tui tasks check {folder}\n"
        f"  sar-tui simulate {name} --user average --tasks {folder.parent}",
        markup=False,
        soft_wrap=True,
    )


@app.command("check")
def check_task(
    path: Annotated[Path, typer.Argument(help="The task's folder.", show_default=False)],
    as_json: AsJson = False,
) -> None:
    """Test a task folder against the contract of tasks."""
    from sar_tui.cli.task_check import check

    folder = path.resolve()
    out = console()
    found = []
    for check_made in check(folder):
        found.append(check_made)
        if not as_json:
            out.print(
                f"✓ {check_made.check}" if check_made.ok else f"✗ {check_made.check}. {check_made.problem}",
                markup=False,
            )
    passed = all(check_made.ok for check_made in found)
    if as_json:
        print_json(
            {
                "task": folder.name,
                "passed": passed,
                "checks": [{"check": c.check, "ok": c.ok, "problem": c.problem} for c in found],
            }
        )
    elif passed:
        out.print(f"{folder.name} keeps the contract.", markup=False)
    if not passed:
        raise typer.Exit(FAILED)
