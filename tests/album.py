"""Snapshots of screens as plain text.

``SAR_TUI_UPDATE_SNAPSHOTS=1`` draws them again; then read the diff.
"""

import os
from pathlib import Path
from typing import Protocol


class Drawn(Protocol):
    """A driver of an app whose screen can be read."""

    @property
    def rows(self) -> list[str]: ...


class Album:
    """Compares screens with their snapshots, and reports all that have changed.

    Args:
        folder: of the snapshots.
        kind: the part of their files' names that distinguishes themes and sizes.
        size: columns and rows that a screen must not exceed.
    """

    def __init__(self, folder: Path, kind: str, size: tuple[int, int]) -> None:
        self._folder, self._kind, self._size = folder, kind, size
        self.taken: list[str] = []
        self.changed: dict[str, str] = {}

    def take(self, name: str, driver: Drawn) -> None:
        rows, (columns, lines) = driver.rows, self._size
        assert len(rows) <= lines
        assert max(map(len, rows)) <= columns
        self.taken.append(name)
        path = self._folder / f"{name}.{self._kind}.txt"
        seen = "\n".join(rows).rstrip("\n") + "\n"
        if os.environ.get("SAR_TUI_UPDATE_SNAPSHOTS"):
            path.parent.mkdir(exist_ok=True)
            path.write_text(seen, encoding="utf-8")
        elif not path.exists() or path.read_text(encoding="utf-8") != seen:
            self.changed[name] = seen

    def check(self) -> None:
        for name, seen in self.changed.items():
            print(f"--- {name} is now:\n{seen}")
        assert not self.changed, (
            f"{', '.join(self.changed)}: SAR_TUI_UPDATE_SNAPSHOTS=1 stores them as they are now"
        )
