"""Provenance of data: the software that made it, with versions and hashes, and the machine it was
made on.
"""

import hashlib
import os
import platform
import sys
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import msgspec

import sar_tui
from sar_tui.loop.task import Task
from sar_tui.loop.task_pictures import pictures_in
from sar_tui.model.trial_types import NO_METRIC, Metric
from sar_tui.store.connection import is_ssh, multiplexer, timing_flags

_PACKAGES = ("textual", "rich", "msgspec", "sqlite-utils", "numpy")


def software(task: type[Task], source: str, task_code: Path, theme_folder: Path) -> dict[str, Any]:
    """Describe the software: versions, the task's declaration, and hashes of the task's code and
    the theme's folder.

    ``source``: where the task comes from, as its own one may have the name of a built-in one.
    ``pictures``: the hash of each picture in the task's folder, if it has some.
    """
    pictures = _picture_hashes(task_code)
    return {
        "sar_tui": sar_tui.__version__,
        "python": platform.python_version(),
        "packages": {name: _version(name) for name in _PACKAGES},
        "task": {
            "title": task.title,
            "version": task.version,
            "metric": None if task.metric.is_none else msgspec.to_builtins(task.metric),
            "source": source,
            "hash": folder_hash(task_code),
            **({"pictures": pictures} if pictures else {}),
        },
        "theme": {"hash": folder_hash(theme_folder)},
    }


def _picture_hashes(folder: Path) -> dict[str, str]:
    """Return the SHA-256 of each picture in a task's folder, by its name there."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in pictures_in(folder)
    }


def metric(recorded: dict[str, Any]) -> Metric:
    """Return the metric that a session's task declared, from the stored result of ``software``.

    A task that has none has `NO_METRIC`.
    """
    declared = recorded["task"]["metric"]
    return NO_METRIC if declared is None else msgspec.convert(declared, Metric)


@cache
def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def folder_hash(folder: Path) -> str:
    """Return the SHA-256 of the names and contents of a folder's files, or of a single file."""
    digest = hashlib.sha256()
    files, above = (
        (sorted(folder.rglob("*")), folder) if folder.is_dir() else ([folder], folder.parent)
    )
    for path in files:
        if path.is_file() and "__pycache__" not in path.parts:
            digest.update(
                path.relative_to(above).as_posix().encode() + b"\0" + path.read_bytes() + b"\0"
            )
    return digest.hexdigest()


TIMING_FILE = "timing.json"
"""Name of the file in the data folder in which `sar-tui timing` stores its figures."""


def measured_timing(folder: Path) -> dict[str, Any] | None:
    """Return the figures that `sar-tui timing` stored in the data folder; None if there are
    none.
    """
    try:
        timing: dict[str, Any] = msgspec.json.decode((folder / TIMING_FILE).read_bytes(), type=dict)
    except (OSError, msgspec.MsgspecError):
        return None
    return timing


def machine() -> dict[str, Any]:
    """Describe the machine and the terminal. ``flags``: conditions that are known to make timing
    less exact.
    """
    return {
        "system": platform.system(),
        "release": platform.release(),
        "processor": platform.machine(),
        "cores": os.cpu_count(),
        "clock": "perf_counter" if sys.platform == "win32" else "monotonic",
        "terminal": os.environ.get("TERM_PROGRAM") or os.environ.get("TERM", ""),
        "ssh": is_ssh(),
        "multiplexer": multiplexer(),
        "flags": timing_flags(),
    }
