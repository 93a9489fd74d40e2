"""``sar-tui themes``: how the agent can look and speak."""

import typer

from sar_tui.cli.common import AsJson, Data, Home, Tasks, console, print_json


def themes(context: typer.Context, as_json: AsJson = False, data: Data = None, tasks: Tasks = None) -> None:
    """List how the agent can look and speak."""
    from sar_tui.plugins import PluginError

    catalogue = Home.of(context, data, tasks).catalogue()
    rows, broken = [], []
    for name in catalogue.theme_names():
        try:
            theme = catalogue.theme(name)
        except PluginError as error:
            broken.append({"name": name, "error": str(error)})
        else:
            rows.append({"name": name, "title": theme.title, "summary": theme.summary})
    if as_json:
        print_json({"themes": [*rows, *broken]})
        return

    from sar_tui.cli.tables import add, table

    made = table("name", "title", "summary")
    for row in rows:
        add(made, *row.values())
    console().print(made)
    for row in broken:
        console().print(f"✗ {row['error']}", markup=False)
