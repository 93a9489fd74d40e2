"""The graph of a task's loop, as the app runs it."""

from sar_tui.app.screen_output import ScreenOutput
from sar_tui.inputs.keyboard import Keyboard
from sar_tui.inputs.sensor import Imu, TrunkImu
from sar_tui.loop.graph import Graph, graph
from sar_tui.loop.session import core_nodes
from sar_tui.loop.task import Task
from sar_tui.model.theme import Theme
from sar_tui.outputs.prompt_tones import PromptTones
from sar_tui.rules.parameters import build, fields
from sar_tui.runs.plan import set_up
from sar_tui.store.recorder import Recorder
from sar_tui.widgets.task_view import view_of


def loop_graph(kind: type[Task], theme: Theme) -> Graph:
    """Return the loop of a task: inputs, the framework's nodes, the task's view, screen, tones and
    recorder.
    """
    task = set_up(kind, build(kind.Parameters, {}))
    sensors = [Imu] if kind.sensor_seats(task.parameters) else []
    if any(field.name == "imu_trunk" for field in fields(kind.Parameters)):
        sensors.append(TrunkImu)
    views = [view for view in [view_of(kind)] if view.receives()]
    nodes = (type(node) for node in core_nodes(task, theme, seed=0))
    return graph([Keyboard, *sensors, *nodes, *views, ScreenOutput, PromptTones], [Recorder])
