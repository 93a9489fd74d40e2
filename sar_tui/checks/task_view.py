"""Checks a task's view: draws it wherever a session's screen would, in a replay of simulated
sessions.
"""

import contextlib
from collections.abc import Sequence

from sar_tui.app.guarded_view import GuardedView
from sar_tui.loop.author_lines import at
from sar_tui.loop.bus import Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.loop.session import ReplayError, Session
from sar_tui.loop.task import Task
from sar_tui.loop.topics import PROMPT, RECALL, SESSION_ENDED, WAITING
from sar_tui.model.messages import AttemptEnded, Fault, Prompt, Recall, SessionEnded, Waiting
from sar_tui.model.theme import Theme
from sar_tui.plugin_calls import PLUGIN_ERRORS
from sar_tui.plugins import PluginError, task_folder
from sar_tui.tui.base_app import textual_theme
from sar_tui.widgets.prompt_lines import Line
from sar_tui.widgets.task_view import Colors, sentences, view_of

SIZES = ((80, 12), (120, 30))
"""Columns and rows to draw in: about the middle of a terminal of 80 by 24, and of a large one."""
_FAILURES = {
    "load": "It cannot be set up",
    "attach": "It cannot be attached to a session",
    "drawing": "The drawing of its between_attempts failed",
}


def has_view(kind: type[Task]) -> bool:
    """Return True if there is a ``view.py`` beside the task."""
    return (task_folder(kind) / "view.py").is_file()


def contract_problem(kind: type[Task]) -> str:
    """Return a sentence that says why a view cannot be loaded or is not one; empty if it is
    sound.
    """
    try:
        view = view_of(kind)
    except PluginError as error:
        return str(error)
    services = [service.name for service in (*view.asks, *view.answers())]
    declared = [*(topic.name for topic in view.emits), *services]
    return f"The view may only listen, but it declares {', '.join(declared)}." if declared else ""


def drawing_problem(task: Task, theme: Theme, seed: int, history: Sequence[Record]) -> str:
    """Return sentences that say what of a task's view failed in the replay of a session; empty if
    nothing did.

    Args:
        task: built with the parameters of that session.
        theme: of that session, as is its ``seed``.
        history: the messages of that session.
    """
    session = Session(task, theme, VirtualClock(), seed)
    view = GuardedView(task)
    view.attach(session.bus)
    screen = _Screen(view, task, textual_theme(theme).to_color_system().generate())
    screen.attach(session.bus)
    with contextlib.suppress(ReplayError):  # the faults of the view are not in the record
        session.replay(history)
    faults = {fault.topic: _sentence(fault) for fault in session.faults if fault.node == view.name}
    return " ".join((*faults.values(), *screen.problems.values()))


def _sentence(fault: Fault) -> str:
    failed = _FAILURES.get(fault.topic)
    if failed is None:
        failed = (
            f"Its handler of {fault.topic} failed"
            if "/" in fault.topic
            else f"Its {fault.topic} failed"
        )
    number, _, file = fault.place.removeprefix("line ").partition(" of ")
    is_own = not file.endswith(("guarded_view.py", "task_view.py"))
    return at(f"{file}:{number}" if is_own else "", f"{failed} ({fault.error}).")


class _Screen(Node):
    """Asks a view for what a session's screen shows: prompts, drawings between attempts, and
    sentences at the end.
    """

    name = "screen"

    def __init__(self, view: GuardedView, task: Task, colors: Colors) -> None:
        super().__init__()
        self.problems: dict[str, str] = {}
        self._view, self._task, self._colors = view, task, colors

    @on(PROMPT)
    def prompted(self, prompt: Prompt) -> None:
        for frame in range(max(1, len(prompt.frames))):
            self._draw(prompt.shown(frame))

    @on(WAITING)
    def waiting(self, waiting: Waiting) -> None:
        if waiting.stage == "trial":
            self._draw(None)
        elif waiting.stage in ("attempt", "review") and (drawing := self._view.between_attempts()):
            for width, height in SIZES:
                drawing(width, height, self._colors)

    @on(SESSION_ENDED)
    def ended(self, _: SessionEnded) -> None:
        for attempts in (
            [],
            *(self.bus.call(RECALL, Recall(seat=seat)).attempts for seat in self._task.seats),
        ):
            self._view.facts(attempts)
            self._check_findings(attempts)

    def _draw(self, prompt: Prompt | None) -> None:
        for width, height in SIZES:
            self._check_size(self._view.prompt_lines(prompt, width, height), width, height)

    def _check_size(self, lines: Sequence[Line], width: int, height: int) -> None:
        longest = max((len(text.rstrip()) for text, _ in lines), default=0)
        if len(lines) > height or longest > width:
            self.problems["prompt_lines"] = (
                f"Its prompt_lines returned {len(lines)} lines of up to {longest} characters, "
                f"where there is room for {height} of {width}."
            )

    def _check_findings(self, attempts: Sequence[AttemptEnded]) -> None:
        try:
            sentences(view_of(type(self._task)).findings(attempts, self._task.metric))
        except PLUGIN_ERRORS as error:
            self.problems["findings"] = f"Its findings failed ({type(error).__name__}: {error})."
