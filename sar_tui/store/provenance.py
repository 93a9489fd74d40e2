"""Where data comes from: the versions and hashes of what made it, and the machine it was made on."""

import hashlib
import os
import platform
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import msgspec

import sar_tui
from sar_tui.framework.task import Task
from sar_tui.framework.trial_types import Metric

_MULTIPLEXERS = {"tmux": "TMUX", "screen": "STY", "zellij": "ZELLIJ"}
_PACKAGES = ("textual", "rich", "msgspec", "sqlite-utils")


def software(task: type[Task], task_folder: Path, theme_folder: Path) -> dict[str, Any]:
    """Versions of the program and its libraries; what the task declared; hashes of the task's and theme's folders."""
    return {
        "sar_tui": sar_tui.__version__,
        "python": platform.python_version(),
        "packages": {name: _version(name) for name in _PACKAGES},
        "task": {
            "title": task.title,
            "version": task.version,
            "metric": msgspec.to_builtins(task.metric),
            "hash": folder_hash(task_folder),
        },
        "theme": {"hash": folder_hash(theme_folder)},
    }


def metric(recorded: dict[str, Any]) -> Metric:
    """The metric of a session, as its task declared it then; from what ``software`` gave."""
    return msgspec.convert(recorded["task"]["metric"], Metric)


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def folder_hash(folder: Path) -> str:
    """SHA-256 over the names and contents of a folder's source and data files."""
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts:
            digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


TIMING_FILE = "timing.json"
"""Where `sar-tui timing` leaves its figures, in the data folder."""


def measured_timing(folder: Path) -> dict[str, Any] | None:
    """What `sar-tui timing` measured on this machine, if it did."""
    try:
        timing: dict[str, Any] = msgspec.json.decode((folder / TIMING_FILE).read_bytes(), type=dict)
    except (OSError, msgspec.MsgspecError):
        return None
    return timing


def machine() -> dict[str, Any]:
    """The machine and the terminal, with what is known to blur timing in ``flags``."""
    multiplexer = next((name for name, sign in _MULTIPLEXERS.items() if sign in os.environ), None)
    ssh = any(name in os.environ for name in ("SSH_CONNECTION", "SSH_TTY", "SSH_CLIENT"))
    flags = [*(["ssh"] if ssh else []), *([multiplexer] if multiplexer else [])]
    return {
        "system": platform.system(),
        "release": platform.release(),
        "processor": platform.machine(),
        "cores": os.cpu_count(),
        "clock": "perf_counter" if sys.platform == "win32" else "monotonic",
        "terminal": os.environ.get("TERM_PROGRAM") or os.environ.get("TERM", ""),
        "ssh": ssh,
        "multiplexer": multiplexer,
        "flags": flags,
    }
