"""The language of what a participant reads on the app's screens.

A screen of theirs keeps it as ``tr``; its widgets, and the help that stands over it, find it there
(`widgets.language.language_of`).
"""

import dataclasses
from collections.abc import Mapping
from pathlib import Path

from textual.binding import ActiveBinding

from sar_tui.framework.language import Language, language
from sar_tui.framework.task import Task
from sar_tui.plugins import Catalogue, task_folder
from sar_tui.runs.plan import Plan

_APP = Path(__file__).parents[1] / "app"
"""The folder of the app's translations."""


def app_language(code: str, texts: Mapping[str, str] = {}) -> Language:
    """The app's words in a language; ``texts``, such as a theme's own, go before them."""
    return language(code, _APP).including(texts)


def session_language(task: Task) -> Language:
    """All the words of a session's screen: the app's, then the framework's, the task's, and the theme's."""
    return app_language(task.tr.code, task.tr.texts)


def planned_language(plan: Plan, catalogue: Catalogue) -> Language:
    """The same for a session that has not begun. Raises PluginError: there is no such theme."""
    code = plan.parameters.language
    own = language(code, task_folder(plan.task)).texts
    return app_language(code, {**own, **catalogue.theme(plan.theme, code).texts})


def translated(bindings: dict[str, ActiveBinding], tr: Language) -> dict[str, ActiveBinding]:
    """A screen's ``active_bindings`` as its footer and its help should call them."""
    return {
        key: active._replace(
            binding=dataclasses.replace(active.binding, description=tr(active.binding.description)),
            tooltip=tr(active.tooltip),
        )
        for key, active in bindings.items()
    }
