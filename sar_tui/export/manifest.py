"""The manifest of an export: what it holds, how it was made, and the SHA-256 of each file."""

import hashlib
from pathlib import Path
from typing import Any

import msgspec

from sar_tui import __version__
from sar_tui.export.target import LOCK, MANIFEST

_BLOCK = 1 << 20


def write_manifest(folder: Path, about: Path = Path(), **facts: Any) -> str:
    """Write the manifest of a folder whose files are complete; return its SHA-256.

    Args:
        about: the place of the manifest in the folder.
        facts: the format, the sessions, and other facts about the export.
    """
    files = [
        {
            "path": path.relative_to(folder).as_posix(),
            "bytes": path.stat().st_size,
            "sha256": sha256(path),
        }
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != LOCK
    ]
    manifest = (
        msgspec.json.format(msgspec.json.encode({"sar_tui": __version__, **facts, "files": files}))
        + b"\n"
    )
    (folder / about / MANIFEST).write_bytes(manifest)
    return hashlib.sha256(manifest).hexdigest()


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
