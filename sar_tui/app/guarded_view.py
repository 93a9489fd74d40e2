"""Guard around a task's view: if it raises, a fault is recorded, and the participant sees the plain
screen.
"""

from collections.abc import Callable, Sequence
from typing import TypeVar

from rich.text import Text

from sar_tui.loop.bus import Bus
from sar_tui.loop.node import Node
from sar_tui.loop.task import Task
from sar_tui.model.messages import AttemptEnded, Prompt
from sar_tui.plugin_calls import PLUGIN_ERRORS, calling
from sar_tui.tui.language import session_language
from sar_tui.widgets.prompt_lines import Line, plain_lines
from sar_tui.widgets.task_view import Colors, Drawing, TaskView, measured, sentences, view_of

R = TypeVar("R")


class GuardedView(Node):
    """Calls a task's view. A function of it that has raised once is not called again in this
    session.

    Args:
        task: the session's task.
    """

    name = TaskView.name

    def __init__(self, task: Task) -> None:
        super().__init__()
        self._faults: list[tuple[str, BaseException]] = []
        self._failed: set[str] = set()
        self._view = self._try("load", lambda: view_of(type(task))(task), TaskView(task))
        self._view.name = self.name

    def attach(self, bus: Bus) -> None:
        """Attach the view to a bus, and report what has failed so far."""
        super().attach(bus)
        self._view.tr = session_language(self._view.task)
        self._try("attach", lambda: self._view.attach(bus), None)
        for place, error in self._faults:
            bus.report(self.name, place, error)

    def call_to_redraw(self, redraw: Callable[[], None]) -> None:
        """Have a function called whenever the view says that it looks different now."""
        self._view.on_redraw = redraw

    def prompt_lines(self, prompt: Prompt | None, width: int, height: int) -> Sequence[Line]:
        """Draw a prompt as the view does, or plainly."""

        def draw() -> Sequence[Line]:
            lines = [
                (str(text), bool(bold))
                for text, bold in self._view.prompt_lines(prompt, width, height)
            ]
            if prompt and not any(prompt.text in text for text, _ in lines):
                raise ValueError(f"no line of the prompt holds its text, {prompt.text!r}")
            return lines

        return self._try("prompt_lines", draw, None) or plain_lines(prompt, width, height)

    def between_attempts(self) -> Drawing | None:
        """Return what to draw between attempts; a drawing that fails is empty."""
        drawing = self._try("between_attempts", self._view.between_attempts, None)
        if drawing is None:
            return None

        def draw(width: int, height: int, colors: Colors) -> Text:
            return self._try("drawing", lambda: _text(drawing(width, height, colors)), Text(""))

        return draw

    def facts(self, attempts: Sequence[AttemptEnded]) -> list[str]:
        """Return the sentences that the task's measures and its view add to a seat's summary."""
        task, tr = self._view.task, self._view.tr
        none: list[str] = []
        facts = self._try(
            "facts", lambda: sentences(self._view.facts(attempts, task.metric, tr)), none
        )
        return measured(type(task), attempts, tr) + facts

    def _try(self, place: str, call: Callable[[], R], fallback: R) -> R:
        if place in self._failed:
            return fallback
        try:
            with calling("node", type(self._view) if hasattr(self, "_view") else self.name):
                return call()
        except PLUGIN_ERRORS as error:
            self._failed.add(place)
            if hasattr(self, "bus"):
                self.bus.report(self.name, place, error)
            else:
                self._faults.append((place, error))
            return fallback


def _text(value: object) -> Text:
    if not isinstance(value, Text):
        raise TypeError(f"a drawing is a rich.text.Text, not {type(value).__name__}")
    return value
