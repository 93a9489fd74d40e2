"""The contract of a task's view: what a task draws by itself during a session, in
``tasks/NAME/view.py``.

A view is optional. It is loaded with the session's screen, before the session begins, and its
module defines one `TaskView`. Nothing of it is a widget: the app owns the widgets, calls these
functions and shows what they return, so that a view can neither change the layout during a trial
nor disturb the onset's time stamp.

A view that raises does not disturb the session. The app shows the plain prompt, or no drawing, and
a `Fault` is recorded.
"""

import inspect
from collections.abc import Callable, Mapping, Sequence

from rich.text import Text

from sar_tui.loop.author_lines import hook_problem
from sar_tui.loop.node import Node
from sar_tui.loop.task import Task
from sar_tui.model.language import Language
from sar_tui.model.measure import mean_texts
from sar_tui.model.messages import AttemptEnded, Prompt
from sar_tui.model.trial_types import Metric
from sar_tui.plugin_calls import PLUGIN_ERRORS
from sar_tui.plugins import PluginError, module_beside
from sar_tui.widgets.prompt_lines import Line, plain_lines

Colors = Mapping[str, str]
"""The theme's colours by Textual's names: ``accent``, ``foreground``, ``text-muted``, ``success``,
``warning`` …
"""
Drawing = Callable[[int, int, Colors], Text]
"""Draws something in a number of columns and rows."""


class TaskView(Node):
    """The plain view, and the base of a task's own.

    It is a node that only listens: a method marked with ``@on(TOPIC)`` receives the session's
    messages before the screen does, so that the view can keep what it wants to draw.

    Args:
        task: the session's task.

    Attributes:
        tr: the session's language: the words of the app, the task and the theme.
    """

    name = "view"

    def __init__(self, task: Task) -> None:
        super().__init__()
        self.task = task
        self.tr = task.tr
        self.on_redraw: Callable[[], None] = lambda: None
        """Set by the screen."""

    def redraw(self) -> None:
        """Draw what stands on the screen again, by `prompt_lines`: after a change of what the view
        keeps, such as the place of a slider. Nothing is painted if it looks the same.
        """
        self.on_redraw()

    def prompt_lines(self, prompt: Prompt | None, width: int, height: int) -> Sequence[Line]:
        """Draw a prompt, or the fixation point where it is None, as at most ``height`` lines of
        ``width`` cells.

        One of the lines has to hold ``prompt.text`` unbroken: the prompt's onset is the moment at
        which the terminal has received it.
        """
        return plain_lines(prompt, width, height)

    def between_attempts(self) -> Drawing | None:
        """Return what to draw below the text between two attempts and after the last one; None for
        nothing.
        """
        return None

    @classmethod
    def facts(cls, attempts: Sequence[AttemptEnded], metric: Metric, tr: Language) -> list[str]:
        """Return sentences that the summary adds for one seat, for the participant to read.

        Args:
            attempts: the scored attempts of that seat, of this session or of one in the database.
            metric: of the task.
            tr: the reader's language.
        """
        return []

    @classmethod
    def findings(cls, attempts: Sequence[AttemptEnded], metric: Metric) -> list[str]:
        """Return the same for the researcher at the command line, in English."""
        return cls.facts(attempts, metric, Language())


def view_of(task: type[Task]) -> type[TaskView]:
    """Return a task's own view, or the plain one. Raises PluginError if its view cannot be
    loaded.
    """
    module = module_beside(task, "view")
    if module is None:
        return TaskView
    own = [
        value
        for value in vars(module).values()
        if getattr(value, "__module__", None) == module.__name__
    ]
    views = [value for value in own if inspect.isclass(value) and issubclass(value, TaskView)]
    if len(views) != 1:
        raise PluginError(
            f"The view.py of the task {task.name} must define one TaskView; it defines "
            f"{len(views)}."
        )
    if problem := hook_problem(views[0], TaskView):
        raise PluginError(f"The view of the task {task.name} cannot be used: {problem}")
    return views[0]


def sentences(value: object) -> list[str]:
    """Return a view's facts or findings. Raises TypeError if they are not a list of texts."""
    if not isinstance(value, list) or not all(isinstance(each, str) for each in value):
        raise TypeError(f"facts and findings are a list of texts, not {value!r}")
    return value


def measured(task: type[Task], attempts: Sequence[AttemptEnded], tr: Language) -> list[str]:
    """Return a sentence for each measure that a task declares, with its mean over the attempts that
    have it.
    """
    return mean_texts(
        task.measured, [attempt.qualities for attempt in attempts if not attempt.practice], tr
    )


def stored_facts(
    task: type[Task], attempts: Sequence[AttemptEnded], metric: Metric, tr: Language
) -> list[str]:
    """Return the declared measures and a view's facts about a session in the database; none of
    these if it fails.
    """
    found = measured(task, attempts, tr)
    try:
        return found + sentences(view_of(task).facts(attempts, metric, tr))
    except PLUGIN_ERRORS:  # third-party code: the rest of the summary is still right
        return found


def stored_findings(
    task: type[Task], attempts: Sequence[AttemptEnded], metric: Metric
) -> list[str]:
    """Return the declared measures and a view's findings about a session in the database; none of
    these if it fails.
    """
    found = measured(task, attempts, Language())
    try:
        return found + sentences(view_of(task).findings(attempts, metric))
    except PLUGIN_ERRORS:
        return found
