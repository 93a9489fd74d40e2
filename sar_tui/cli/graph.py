"""``sar-tui graph``: draw the loop from the nodes' own declarations."""

import typer

from sar_tui.cli.common import (
    AsJson,
    Data,
    Home,
    TaskName,
    Tasks,
    console,
    print_json,
    watch_plugins,
)


def graph(
    context: typer.Context,
    task: TaskName,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Draw the nodes and topics of a task's loop."""
    from sar_tui.app.loop_graph import loop_graph

    watch_plugins(context)
    catalogue = Home.of(context, data, tasks).catalogue()
    kind = catalogue.task(task)
    whole = loop_graph(kind, catalogue.theme("calm"))
    if as_json:
        print_json({"task": task, "nodes": whole.nodes, "edges": whole.edges})
        return

    from sar_tui.cli.graph_drawing import draw

    out = console()
    out.print(draw(whole, out.width), markup=False, end="")
