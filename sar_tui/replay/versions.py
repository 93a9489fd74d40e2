"""Software that a session was recorded with, and the software that is present: what can make them
differ.
"""

import sqlite3
from collections.abc import Mapping
from typing import Any

import msgspec

from sar_tui.plugins import Catalogue, PluginError, task_code, task_source
from sar_tui.rules.version import RULES
from sar_tui.store import sessions
from sar_tui.store.provenance import software


class Versions(msgspec.Struct, frozen=True, kw_only=True):
    """Versions of all that a session follows from beside its inputs. None: it was not recorded, or
    is not there.

    The rules are those of the loop (`rules.version`): a session keeps the ones that it began with.
    """

    sar_tui: str | None
    task: str
    task_version: str | None
    task_hash: str | None
    theme: str
    theme_hash: str | None
    rules: int | None


class RecordedVersions(Versions, frozen=True, kw_only=True):
    """Versions of one run of a session: another program may have resumed it."""

    run: int


def recorded(
    database: sqlite3.Connection,
    row: sessions.Row,
    rules: Mapping[int, int],
    themes: Mapping[int, str],
) -> tuple[RecordedVersions, ...]:
    """Return the versions of each run of a stored session.

    Args:
        database: that holds the session.
        row: of the session.
        rules: by run, as far as they are in the record.
        themes: names of the themes, by run.
    """
    return tuple(
        RecordedVersions(
            run=run["run"],
            rules=rules.get(run["run"]),
            **_named(row["task"], themes.get(run["run"], row["theme"]), run["software"] or {}),
        )
        for run in sessions.rows(database, "runs", row["id"])
    )


def present(row: sessions.Row, catalogue: Catalogue) -> Versions:
    """Return the versions of what is installed now. Raises PluginError if the task is not there any
    more.
    """
    kind = catalogue.task(row["task"])
    code = task_code(kind)
    try:
        theme_folder = catalogue.theme_folder(row["theme"])
    except PluginError:
        found = software(kind, task_source(kind), code, code) | {"theme": {}}
    else:
        found = software(kind, task_source(kind), code, theme_folder)
    return Versions(rules=RULES, **_named(row["task"], row["theme"], found))


def _named(task: str, theme: str, found: dict[str, Any]) -> dict[str, Any]:
    of_task, of_theme = found.get("task") or {}, found.get("theme") or {}
    version = of_task.get("version")
    return {
        "sar_tui": found.get("sar_tui"),
        "task": task,
        "task_version": None if version is None else str(version),
        "task_hash": of_task.get("hash"),
        "theme": theme,
        "theme_hash": of_theme.get("hash"),
    }


def changes(then: Versions, now: Versions) -> list[str]:
    """Return a sentence for each part that is another one now than in a run."""
    found = []
    if then.sar_tui != now.sar_tui:
        found.append(
            f"sar-tui was {then.sar_tui or 'of an unknown version'}, and is {now.sar_tui}."
        )
    if then.task_version != now.task_version:
        found.append(
            f"The task {now.task} was version {then.task_version}, and is version "
            f"{now.task_version}."
        )
    elif then.task_hash != now.task_hash:
        found.append(f"The files of the task {now.task} have changed.")
    if now.theme_hash is None:
        found.append(f"The theme {now.theme} is not installed.")
    elif then.theme != now.theme:
        found.append(f"The theme was {then.theme}, and not {now.theme}.")
    elif then.theme_hash != now.theme_hash:
        found.append(f"The files of the theme {now.theme} have changed.")
    if then.rules is not None and then.rules != now.rules:
        found.append(
            f"The session keeps rules {then.rules} of the loop; new sessions have rules "
            f"{now.rules}."
        )
    return found
