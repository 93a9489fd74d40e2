"""``sar-tui graph``: draw the loop from the nodes' own declarations."""

from typing import TYPE_CHECKING

import typer

from sar_tui.cli.common import AsJson, Data, Home, TaskName, Tasks, console, print_json, watch_plugins

if TYPE_CHECKING:
    from sar_tui.framework.graph import Graph
    from sar_tui.framework.task import Task
    from sar_tui.framework.theme import Theme


def graph(
    context: typer.Context,
    task: TaskName,
    as_json: AsJson = False,
    data: Data = None,
    tasks: Tasks = None,
) -> None:
    """Draw the nodes and topics of a task's loop."""
    watch_plugins(context)
    catalogue = Home.of(context, data, tasks).catalogue()
    kind = catalogue.task(task)
    whole = _loop(kind, catalogue.theme("calm"))
    if as_json:
        print_json({"task": task, "nodes": whole.nodes, "edges": whole.edges})
        return

    from sar_tui.cli.graph_drawing import draw

    out = console()
    out.print(draw(whole, out.width), markup=False, end="")


def _loop(kind: "type[Task]", theme: "Theme") -> "Graph":
    """Return the loop as the app runs it: inputs, the framework's nodes, the task's view, screen and recorder."""
    from sar_tui.app.screen_output import ScreenOutput
    from sar_tui.framework.graph import graph
    from sar_tui.framework.parameters import build
    from sar_tui.framework.session import core_nodes
    from sar_tui.inputs.keyboard import Keyboard
    from sar_tui.inputs.sensor import Imu
    from sar_tui.runs.plan import set_up
    from sar_tui.store.recorder import Recorder
    from sar_tui.widgets.task_view import view_of

    task = set_up(kind, build(kind.Parameters, {}))
    core = core_nodes(task, theme, seed=0)
    sensors = [Imu] if kind.sensor_seats(task.parameters) else []
    views = [view for view in [view_of(kind)] if view.receives()]
    return graph([Keyboard, *sensors, *(type(node) for node in core), *views, ScreenOutput], [Recorder])
