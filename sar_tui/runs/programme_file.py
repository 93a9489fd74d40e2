"""Programmes and presets as TOML files."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import msgspec

from sar_tui.loop.task import Task
from sar_tui.model.toml_lines import TomlError, TomlLines, decode
from sar_tui.plugins import task_folder
from sar_tui.rules.declaration import Field
from sar_tui.rules.parameters import fields, grouped
from sar_tui.store.database import StoreError
from sar_tui.store.programmes import Programme

_KEYS = ("task", "participant", "version", "saved", "author", "reason", "theme", "summary")
_WIDTH = 118


class ProgrammeFile(msgspec.Struct, frozen=True):
    """The content of a file. Only ``task`` and ``parameters`` are always there.

    Attributes:
        task: name of the task.
        parameters: values by name, not checked.
        participant, version: the programme that it was exported from.
        theme: name of the theme.
        summary: of a preset, for people.
    """

    task: str
    parameters: dict[str, Any] = {}
    participant: str = ""
    version: int = 0
    saved: str = ""
    author: str = ""
    reason: str = ""
    theme: str = ""
    summary: str = ""


def read(path: Path) -> ProgrammeFile:
    """Read a file.

    Raises:
        StoreError: it cannot be read, or it holds something else.
    """
    try:
        text = path.read_bytes().decode()
    except OSError as error:
        raise StoreError(f"{path} cannot be read: {error.strerror}.", bad_input=True) from error
    except UnicodeDecodeError:
        raise StoreError(f"{path} is not a text in UTF-8.", bad_input=True) from None
    return parse(text, str(path))


def parse(text: str, name: str) -> ProgrammeFile:
    """Return the content of a TOML text; ``name`` is that of its file, for messages.

    Raises:
        StoreError: it is no TOML, or it holds something else.
    """
    try:
        content = decode(text)
    except TomlError as error:
        raise StoreError(f"{name}, {error}", bad_input=True) from error
    unknown = content.keys() - {*_KEYS, "parameters"}
    if unknown:
        where = "Settings belong under [parameters]."
        raise StoreError(
            f"{name} has unknown entries: {', '.join(sorted(unknown))}. {where}", bad_input=True
        )
    try:
        return msgspec.convert(content, ProgrammeFile)
    except msgspec.ValidationError as error:
        said = TomlLines(text, name).invalid(str(error))
        raise StoreError(f"This is not a programme. {said}", bad_input=True) from error


def write(task: type[Task], participant: str, programme: Programme) -> str:
    """Return a programme as TOML: what differs from the defaults as values, all else as
    comments.
    """
    head = {
        "task": task.name,
        "participant": participant,
        "version": programme.version,
        "saved": programme.created_at,
        "author": programme.author,
        "reason": programme.reason,
        "theme": programme.theme,
    }
    lines = [f"# Programme of {participant}: {task.title}", *_assignments(head), "", "[parameters]"]
    gone = programme.parameters.keys() - {field.name for field in fields(task.Parameters)}
    for heading, declared in grouped(task.Parameters).items():
        lines += ["", f"# --- {heading or task.title} ---"]
        for field in declared:
            lines += ["", *_comments(_about(field)), _setting(field, programme.parameters)]
    for name in sorted(gone):
        lines += ["", f"# {_comment(name)} does not exist any more.", f"# {_comment(name)}"]
    return "\n".join(lines) + "\n"


def write_preset(task: type[Task], programme: Programme) -> str:
    """Return the settings of a programme that a preset states (see `runs.presets`) as TOML, each
    with its value.
    """
    lines = [f"# Preset for {task.title}", *_assignments({"task": task.name}), "", "[parameters]"]
    for heading, declared in grouped(task.Parameters).items():
        stated = [field for field in declared if not field.personal]
        lines += ["", f"# --- {heading or task.title} ---"] if stated else []
        for field in stated:
            value = programme.parameters.get(field.name, msgspec.to_builtins(field.default))
            lines += ["", *_comments(_about(field)), f"{field.name} = {_value(value)}"]
    return "\n".join(lines) + "\n"


def _assignments(values: Mapping[str, Any]) -> Iterator[str]:
    return (f"{name} = {_value(value)}" for name, value in values.items() if value not in ("", 0))


def _setting(field: Field, values: Mapping[str, Any]) -> str:
    if field.name in values:
        return f"{field.name} = {_value(values[field.name])}"
    return f"# {field.name} = {_value(msgspec.to_builtins(field.default))}"


def _about(field: Field) -> str:
    """Return a field's title, unit, meaning, bounds and default."""
    title = f"{field.title} ({field.unit})." if field.unit else f"{field.title}."
    bounds = f"{field.bounds}." if field.bounds else ""
    default = json.dumps(msgspec.to_builtins(field.default), ensure_ascii=False)
    return " ".join(
        filter(
            None,
            (title, field.help, f"Allowed: {bounds}" if bounds else "", f"Default: {default}."),
        )
    )


def _comments(text: str) -> list[str]:
    import textwrap

    return [f"# {line}" for line in textwrap.wrap(_comment(text), _WIDTH)]


def _comment(text: str) -> str:
    """Return a text without the characters that a comment must not have."""
    return "".join(character if character.isprintable() else " " for character in text)


def _value(value: Any) -> str:
    """Return a number, text, bool or list of them in TOML, which writes these as JSON does."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


# --- presets


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
