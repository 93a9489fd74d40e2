"""The installation: versions, tasks, themes and outputs."""

import platform
from collections.abc import Callable

from sar_tui.cli.common import Home
from sar_tui.cli.doctor.finding import Finding
from sar_tui.cli.installed import replaced_lines


def python() -> Finding:
    """Report the versions."""
    import textual

    import sar_tui

    versions = f"sar-tui {sar_tui.__version__}, Textual {textual.__version__}, {platform.system()}"
    return Finding("Python", "ok", f"{platform.python_version()}, with {versions}")


def tasks(home: Home) -> Finding:
    """Load every task."""
    from sar_tui.plugins import PluginError

    try:
        catalogue = home.catalogue()
    except PluginError as error:
        return Finding("Tasks", "bad", str(error), "Name a folder that exists with --tasks.")
    found = _loaded(
        "Tasks", catalogue.task_names(), catalogue.task, "`sar-tui tasks check FOLDER` says more."
    )
    if found.state == "ok" and (lines := replaced_lines(catalogue.replaced_tasks())):
        return Finding(
            "Tasks", "care", " ".join(lines), "Give it a name of its own if this is not meant."
        )
    return found


def themes(home: Home) -> Finding:
    """Load every theme."""
    catalogue = home._replace(tasks=()).catalogue()
    return _loaded(
        "Themes", catalogue.theme_names(), catalogue.theme, "Fix its folder, or remove it."
    )


def outputs() -> Finding:
    """Load the plug-ins among the outputs. None is opened, because only a session knows its
    address.
    """
    from sar_tui.outputs.output import OutputError
    from sar_tui.outputs.outputs import INSTALLED, output_names

    problems = []
    for name in sorted(INSTALLED.names()):
        try:
            INSTALLED.load(name)
        except OutputError as error:
            problems.append(str(error))
    if problems:
        return Finding(
            "Outputs", "bad", " ".join(problems), "Install its package again, or remove it."
        )
    return Finding("Outputs", "ok", ", ".join(output_names()))


def policies() -> Finding:
    """Name the policies of difficulty and feedback, and those that cannot be used."""
    from sar_tui.rules.parameters import TaskParameters, fields
    from sar_tui.rules.policies import BY_CHOICE, FAILED

    choices = [field.choices for field in fields(TaskParameters) if field.name in BY_CHOICE]
    if FAILED:
        problems = " ".join(FAILED.values())
        return Finding("Policies", "bad", problems, "Fix its file or its package, or remove it.")
    return Finding("Policies", "ok", ", ".join(name for names in choices for name in names))


def _loaded(name: str, names: list[str], load: Callable[[str], object], advice: str) -> Finding:
    from sar_tui.plugins import PluginError

    problems = []
    for each in names:
        try:
            load(each)
        except PluginError as error:
            problems.append(str(error))
    if problems:
        return Finding(name, "bad", " ".join(problems), advice)
    if not names:
        return Finding(name, "bad", "There are none.", "Install sar-tui again.")
    return Finding(name, "ok", ", ".join(names))
