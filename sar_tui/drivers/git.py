"""Questions to git on files: which it tracks, and which ``git add .`` would take."""

import os
import subprocess
from pathlib import Path

_TIMEOUT_S = 20.0


def tracked(folder: Path) -> list[Path]:
    """Return the files of a folder that git tracks, staged ones too; none if the folder is in no
    work tree.
    """
    return _listed(folder, "--cached")


def would_add(folder: Path) -> list[Path]:
    """Return the files of a folder that ``git add .`` would take, as it neither tracks nor ignores
    them.
    """
    return _listed(folder, "--others", "--exclude-standard")


def is_safe_from(path: Path) -> bool:
    """Return True if git ignores a file or folder that exists, or it is in no work tree."""
    ignored = 0, 128
    return _git(path.absolute().parent, "check-ignore", "--quiet", "--", path.name)[0] in ignored


def _listed(folder: Path, *which: str) -> list[Path]:
    code, out = _git(folder, "ls-files", "-z", *which, "--", ".")
    return [folder / os.fsdecode(name) for name in out.split(b"\0") if name] if code == 0 else []


def _git(folder: Path, *words: str) -> tuple[int, bytes]:
    """Return the exit code and the output of git; 128, with which it fails, if it is not
    installed.
    """
    kept = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    # A stranger's repository may name a program that git starts to see what has changed.
    command = ["git", "-c", "core.fsmonitor=false", "-C", str(folder), *words]
    try:
        done = subprocess.run(
            command, capture_output=True, env=kept, timeout=_TIMEOUT_S, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return 128, b""
    return done.returncode, done.stdout
