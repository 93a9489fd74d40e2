"""The language of the app's screens for participants.

Such a screen holds it as ``tr``, where its widgets and the help find it
(`widgets.language.language_of`).
"""

import dataclasses
from collections.abc import Mapping

from textual.binding import ActiveBinding

from sar_tui.loop.task import Task
from sar_tui.model.language import Language, language
from sar_tui.plugins import Catalogue, task_folder
from sar_tui.runs.plan import Plan
from sar_tui.widgets.language import app_texts


def app_language(code: str, texts: Mapping[str, str] = {}) -> Language:
    """Return the app's texts in a language; ``texts``, such as a theme's, take precedence."""
    return app_texts(code).including(texts)


def session_language(task: Task) -> Language:
    """Return the texts of a session's screen: the app's, the framework's, the task's and the
    theme's.
    """
    return app_language(task.tr.code, task.tr.texts)


def planned_language(plan: Plan, catalogue: Catalogue) -> Language:
    """Return the texts of the screen before a session begins. Raises PluginError if there is no
    such theme.
    """
    code = plan.parameters.language
    own = language(code, task_folder(plan.task)).texts
    return app_language(code, {**own, **catalogue.theme(plan.theme, code).texts})


def translated(bindings: dict[str, ActiveBinding], tr: Language) -> dict[str, ActiveBinding]:
    """Translate a screen's ``active_bindings`` for its footer and help."""
    return {
        key: active._replace(
            binding=dataclasses.replace(active.binding, description=tr(active.binding.description)),
            tooltip=tr(active.tooltip),
        )
        for key, active in bindings.items()
    }
