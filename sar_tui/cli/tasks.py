"""``sar-tui tasks``: lists, shows, creates and checks tasks."""

from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import (
    AsJson,
    Data,
    Home,
    Tasks,
    console,
    named_path,
    print_json,
    watch_plugins,
)
from sar_tui.cli.errors import Refused
from sar_tui.cli.scaffold import installed, replaced_lines
from sar_tui.tui.exit_codes import FAILED

if TYPE_CHECKING:
    from sar_tui.model.trial_types import Metric

app = typer.Typer(rich_markup_mode=None)


@app.callback(invoke_without_command=True)
def list_tasks(
    context: typer.Context, as_json: AsJson = False, data: Data = None, tasks: Tasks = None
) -> None:
    """List the tasks; show, create or check one."""
    watch_plugins(context)
    context.obj = home = Home.of(context, data, tasks)
    if context.invoked_subcommand is not None:
        return
    catalogue = home.catalogue()
    rows, broken = installed(
        catalogue.task_names(),
        catalogue.task,
        lambda task: {
            "title": task.title,
            "summary": task.summary,
            "trains": task.trains,
            "metric": None if task.metric.is_none else task.metric,
        },
    )
    replaced = catalogue.replaced_tasks()
    marked = [
        {**row, "replaces": "built-in"} if row["name"] in replaced else row
        for row in [*rows, *broken]
    ]
    from sar_tui.cli.tables import Column, Listing, print_listing

    print_listing(
        Listing(
            "tasks",
            empty="There are no tasks.",
            columns=(
                Column("name", itemgetter("name")),
                Column("title", itemgetter("title")),
                Column("trains", itemgetter("trains")),
                Column("summary", itemgetter("summary")),
                Column("metric", lambda row: _metric_in_words(row["metric"])),
            ),
            folds=True,
        ),
        marked if as_json else rows,
        as_json,
    )
    if as_json:
        return
    out = console()
    for text in replaced_lines(replaced):
        out.print(f"! {text}", markup=False, soft_wrap=True)
    for problem in broken:
        out.print(f"✗ {problem['name']}: {problem['error']}", markup=False, soft_wrap=True)


def _metric_in_words(metric: "Metric | None") -> str:
    if metric is None:
        return ""
    unit = f"{metric.unit}, " if metric.unit else ""
    return f"{metric.name.replace('_', ' ')} ({unit}{metric.better} is better)"


@app.command("show")
def show_task(
    context: typer.Context,
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="The task's name.", show_default=False)
    ],
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Show the parameters of a task, the details of its trials, and its measures of attempts."""
    import msgspec

    from sar_tui.export.json_columns import declared_keys
    from sar_tui.rules.declaration import show
    from sar_tui.rules.parameters import fields, grouped

    task = Home.of(context, data, tasks).catalogue().task(name)
    details = [
        {
            "name": detail,
            "type": " or ".join(sorted(declared.types)),
            "description": declared.meaning,
        }
        for detail, declared in declared_keys(task.Details).items()
    ]
    if as_json:
        facts = {
            "name": name,
            "title": task.title,
            "summary": task.summary,
            "metric": None if task.metric.is_none else task.metric,
        }
        parameters = [msgspec.structs.asdict(field) for field in fields(task.Parameters)]
        print_json(
            {"task": facts, "parameters": parameters, "details": details, "measures": task.measured}
        )
        return

    from sar_tui.cli.tables import add, head, table

    out = console()
    out.print(f"{task.title}. {task.summary}\n", markup=False)
    made = table("name", "default", "allowed", "what it is", whole=("name", "default"))
    for heading, declared in grouped(task.Parameters).items():
        if heading:
            head(made, heading)
        for field in declared:
            words = f"{field.title}. {field.help}" if field.help else field.title
            add(
                made, field.name, show(field.default), f"{field.bounds} {field.unit}".strip(), words
            )
    out.print(made)
    measures = [
        {"name": each.name, "unit": each.unit, "what it is": each.title} for each in task.measured
    ]
    kept = [
        {"name": each["name"], "type": each["type"], "what it is": each["description"]}
        for each in details
    ]
    for heading, rows in (("Details of a trial", kept), ("Measures of an attempt", measures)):
        if rows:
            out.print(f"\n{heading}", markup=False)
            made = table(*rows[0], whole=("name",))
            for row in rows:
                add(made, *row.values())
            out.print(made)


@app.command("new")
def new_task(
    context: typer.Context,
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME", help="Its name in small letters, such as tapping.", show_default=False
        ),
    ],
    to: Annotated[
        Path, typer.Option("--to", metavar="DIR", help="Folder to create it in.")
    ] = Path(),
    model: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="TASK",
            help="The task to copy. Default: a choice reaction, in one short file.",
            show_default=False,
        ),
    ] = None,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Create a task that works, to be edited."""
    from sar_tui.cli.scaffold import new_task as create

    folder = create(name, to, model, Home.of(context, data, tasks).catalogue())
    console().print(
        f"Created {folder}, {f'a copy of {model}' if model else 'a working example'}. "
        "Edit task.py, then try\n"
        f"  sar-tui tasks check {folder}\n"
        f"  sar-tui simulate {name} --user average --tasks {folder.parent}",
        markup=False,
        soft_wrap=True,
    )


@app.command("check")
def check_task(
    path: Annotated[
        Path,
        typer.Argument(
            parser=named_path, metavar="PATH", help="The task's folder.", show_default=False
        ),
    ],
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Test a task folder against the contract of tasks."""
    from sar_tui.checks.task import check

    folder = path.resolve()
    if not folder.is_dir():
        raise Refused(f"There is no folder {path} to check.")
    out = console()
    made = []
    for done in check(folder):
        made.append(done)
        if not as_json:
            out.print(done.line, markup=False, soft_wrap=True)
    passed = all(done.ok for done in made)
    if as_json:
        rows = [
            {
                "check": done.check,
                "ok": done.ok,
                "problem": " ".join(done.problems),
                "warning": done.warning,
            }
            for done in made
        ]
        print_json({"task": folder.name, "passed": passed, "checks": rows})
    elif passed:
        out.print(f"{folder.name} passes all checks.", markup=False)
    if not passed:
        raise typer.Exit(FAILED)
