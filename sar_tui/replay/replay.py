"""A stored session run again from its inputs, on the virtual clock, without screen, outputs and
devices.
"""

import sqlite3
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import msgspec

from sar_tui.loop.bus import Record
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.replay_comparison import Difference
from sar_tui.loop.session import Session
from sar_tui.model.messages import SessionStarted
from sar_tui.plugins import DEFAULT_THEME, Catalogue, PluginError, task_code, task_source
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import without_outputs
from sar_tui.runs.run import Progress, check_rules, told_history
from sar_tui.store import sessions
from sar_tui.store.database import StoreError
from sar_tui.store.provenance import software
from sar_tui.store.record_changes import check_not_erased
from sar_tui.store.rescue import rescue_files


class FirstDifference(msgspec.Struct, frozen=True):
    """The first message that differs. ``recorded`` or ``derived`` is None if there is no such
    message.

    Its number ``seq`` is that of the view ``events``. ``topic`` is that of the recorded message, or
    of the derived one if nothing was recorded. ``derived_topic`` differs from it if another kind of
    message was derived in its place.
    """

    seq: int
    topic: str
    recorded: dict[str, Any] | None
    derived: dict[str, Any] | None
    derived_topic: str | None


class Versions(msgspec.Struct, frozen=True, kw_only=True):
    """Versions of all that a session follows from beside its inputs. None: it was not recorded, or
    is not there. ``run``: of the session, in which they were present; another program may have
    resumed it.
    """

    run: int | msgspec.UnsetType = msgspec.UNSET
    sar_tui: str | None
    task: str
    task_version: str | None
    task_hash: str | None
    theme: str
    theme_hash: str | None


class Replayed(msgspec.Struct, frozen=True):
    """Result of a replay. ``events``: number of messages that came out as recorded, up to the first
    difference.
    """

    session: str
    identical: bool
    events: int
    first_difference: FirstDifference | None
    recorded_with: tuple[Versions, ...]
    replayed_with: Versions


def replay(
    database: sqlite3.Connection,
    folder: Path,
    catalogue: Catalogue,
    row: sessions.Row,
    progress: Progress = lambda done, of: None,
) -> Replayed:
    """Feed the recorded inputs of a session through the nodes, and compare what follows with the
    record.

    What a session knew of its participants at its beginning (best results, what was done that day)
    is in its record, as are its theme's words and looks: later sessions and an edited theme change
    nothing.

    Args:
        database: only read.
        folder: the data folder.
        catalogue: where the task is found.
        row: of the session, from `store.sessions.find`.
        progress: called with the number of messages that are done, and of all.

    Raises:
        StoreError: the session is running, part of it is in a rescue file, or its record cannot be
            read.
        PluginError: its task is not installed any more.
        ParameterError: its parameters are not those of the present task.
        Failed: its task cannot be set up.
    """
    check_whole(database, folder, row)
    versions = _present(row, catalogue)
    session = new_session(row, catalogue, {})
    themes: dict[int, str] = {}
    compared = session.compare(_noting_themes(told_history(database, row["id"], progress), themes))
    return Replayed(
        session=row["id"],
        identical=compared.difference is None,
        events=compared.same,
        first_difference=_described(compared.difference) if compared.difference else None,
        recorded_with=_recorded(database, row, themes),
        replayed_with=versions,
    )


def new_session(row: sessions.Row, catalogue: Catalogue, changed: Mapping[str, object]) -> Session:
    """Return a session like a stored one before its beginning, with some other parameters.

    Raises PluginError, ParameterError and Failed as `replay`.
    """
    kind = catalogue.task(row["task"])
    values = {**row["parameters"], **changed}
    task = without_outputs(kind, build(kind.Parameters, values))
    # until the record names its own
    theme = catalogue.theme(DEFAULT_THEME, task.parameters.language)
    return Session(task, theme, VirtualClock(), row["seed"])


def check_whole(database: sqlite3.Connection, folder: Path, row: sessions.Row) -> None:
    """Raise StoreError if the record of a session is not whole, still grows, or is of other rules."""
    if row["status"] == "running":
        raise StoreError(
            f"The session {row['id']} is running. Replay it when it has ended.", bad_input=True
        )
    if files := rescue_files(folder, row["id"]):
        raise StoreError(
            f"The last messages of session {row['id']} are in {files[0]}. Run `sar-tui rescue` "
            "first.",
            bad_input=True,
        )
    check_not_erased(database, row["id"])
    check_rules(database, row["id"])


def _noting_themes(history: Iterator[Record], themes: dict[int, str]) -> Iterator[Record]:
    """Yield the messages of a record, and note the theme of each run."""
    for record in history:
        if isinstance(record.message, SessionStarted):
            themes[record.message.run] = record.message.theme
        yield record


def _described(difference: Difference) -> FirstDifference:
    was, now = difference.recorded, difference.derived
    return FirstDifference(
        seq=difference.seq,
        topic=difference.topic,
        recorded=msgspec.to_builtins(was.message) if was else None,
        derived=msgspec.to_builtins(now.message) if now else None,
        derived_topic=now.topic.name if now else None,
    )


# --- versions


def _recorded(
    database: sqlite3.Connection, row: sessions.Row, themes: Mapping[int, str]
) -> tuple[Versions, ...]:
    """Return the versions of each run of a stored session. ``themes``: their names, by run."""
    return tuple(
        _versions(
            row["task"], themes.get(run["run"], row["theme"]), run["software"] or {}, run["run"]
        )
        for run in sessions.rows(database, "runs", row["id"])
    )


def _present(row: sessions.Row, catalogue: Catalogue) -> Versions:
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
    return _versions(row["task"], row["theme"], found)


def _versions(
    task: str, theme: str, found: dict[str, Any], run: int | msgspec.UnsetType = msgspec.UNSET
) -> Versions:
    of_task, of_theme = found.get("task") or {}, found.get("theme") or {}
    version = of_task.get("version")
    return Versions(
        run=run,
        sar_tui=found.get("sar_tui"),
        task=task,
        task_version=None if version is None else str(version),
        task_hash=of_task.get("hash"),
        theme=theme,
        theme_hash=of_theme.get("hash"),
    )
