"""Presets: named exercises, shipped with a task or saved by a therapist.

The scope of a preset is every setting of its task, common ones included, but those that belong to
the person or the place (``personal`` in `declaration.meta`). It states all of them: what its file
does not name is at its default.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sar_tui.loop.task import Task
from sar_tui.plugins import task_folder
from sar_tui.rules.declaration import Field
from sar_tui.rules.parameters import fields
from sar_tui.runs.programme_file import ProgrammeFile, read
from sar_tui.store.database import StoreError

FOLDER = "presets"
"""Folder of presets, in a task's folder and in the data folder; there it has a folder for each
task.
"""
_ORDER = ("mild", "moderate", "severe")


def applied(task: type[Task], preset: ProgrammeFile, current: Mapping[str, Any]) -> dict[str, Any]:
    """Return the value of every setting after a preset: nothing of an earlier preset is left.

    Personal settings keep their ``current`` values. Names in the preset that are no settings stay,
    for `build` to refuse.
    """
    personal = {field.name for field in fields(task.Parameters) if field.personal}
    named = preset.parameters
    return {
        **{field.name: field.default for field in fields(task.Parameters)},
        **{name: value for name, value in named.items() if name not in personal},
        **{name: value for name, value in current.items() if name in personal},
    }


def not_applied(task: type[Task], preset: ProgrammeFile) -> list[Field]:
    """Return the personal settings that a preset's file names, although no preset changes them."""
    return [
        field
        for field in fields(task.Parameters)
        if field.personal and field.name in preset.parameters
    ]


def own_folder(data: Path, task: type[Task]) -> Path:
    """Return the folder of a therapist's own presets for a task."""
    return data / FOLDER / task.name


def files(data: Path, task: type[Task]) -> dict[str, Path]:
    """Return the files of a task's presets by name: those of the task first, in order of severity,
    then one's own.

    One's own replaces one of the task with the same name.
    """
    shipped = {path.stem: path for path in (task_folder(task) / FOLDER).glob("*.toml")}
    own = {path.stem: path for path in own_folder(data, task).glob("*.toml")}
    ranks = {name: rank for rank, name in enumerate(_ORDER)}
    names = sorted(
        shipped | own, key=lambda name: (name not in shipped, ranks.get(name, len(ranks)), name)
    )
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
        raise StoreError(
            f"{known[name]} is for the task {preset.task}, not {task.name}.", bad_input=True
        )
    return preset
