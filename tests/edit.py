"""Edits a file of a test."""

from pathlib import Path


def edit(path: Path, old: str, new: str) -> None:
    """Replace a text, which must be in the file, once."""
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
