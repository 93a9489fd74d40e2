"""Presets: named sets of a task's settings, shipped with the task or saved by a therapist."""

from pathlib import Path

from sar_tui.framework.task import Task
from sar_tui.plugins import task_folder
from sar_tui.runs.programme_file import ProgrammeFile, read
from sar_tui.store.database import StoreError

FOLDER = "presets"
"""Folder of presets, in a task's folder and in the data folder; there it has a folder for each task."""
_ORDER = ("mild", "moderate", "severe")


def own_folder(data: Path, task: type[Task]) -> Path:
    """Return the folder of a therapist's own presets for a task."""
    return data / FOLDER / task.name


def files(data: Path, task: type[Task]) -> dict[str, Path]:
    """Return the files of a task's presets by name: those of the task first, in order of severity, then one's own.

    One's own replaces one of the task with the same name.
    """
    shipped = {path.stem: path for path in (task_folder(task) / FOLDER).glob("*.toml")}
    own = {path.stem: path for path in own_folder(data, task).glob("*.toml")}
    ranks = {name: rank for rank, name in enumerate(_ORDER)}
    names = sorted(shipped | own, key=lambda name: (name not in shipped, ranks.get(name, len(ranks)), name))
    return {name: own.get(name) or shipped[name] for name in names}


def find(data: Path, task: type[Task], name: str) -> ProgrammeFile:
    """Read a preset.

    Raises:
        StoreError: there is none of that name, its file cannot be read, or it is for another task.
    """
    known = files(data, task)
    if name not in known:
        has = f"It has: {', '.join(known)}." if known else "It has none."
        raise StoreError(f"The task {task.name} has no preset {name}. {has}", bad_input=True)
    preset = read(known[name])
    if preset.task != task.name:
        raise StoreError(f"{known[name]} is for the task {preset.task}, not {task.name}.", bad_input=True)
    return preset
