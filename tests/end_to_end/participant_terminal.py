"""Drives the real program in a pseudo-terminal, and reads its screen and its database."""

import json
import sqlite3
import subprocess
import sys
from collections.abc import Sequence
from contextlib import closing
from itertools import pairwise
from pathlib import Path
from typing import Any

import pyte

from sar_tui.timing.pty import Terminal

QUICK = {"quiet_ms": 40, "foreperiod_min_ms": 60, "foreperiod_max_ms": 120, "min_rt_ms": 50}
"""Parameters that keep a test short."""


def command(*words: str) -> list[str]:
    """Return a command of the program; ``run`` is told that a participant is new if they are."""
    return [sys.executable, "-m", "sar_tui", *words, *_new(words)]


def _new(words: Sequence[str]) -> list[str]:
    if words[0] != "run":
        return []
    values = {name: value for name, value in pairwise(words) if name in ("-p", "--data")}
    database = Path(values["--data"]) / "sar-tui.db"
    known = database.exists() and rows(
        database.parent, "SELECT 1 FROM participants WHERE code=?", values["-p"]
    )
    return [] if known else ["--new"]


def run_command(data: Path, participant: str = "P01", **parameters: object) -> list[str]:
    settings = [f"--set={name}={value}" for name, value in (QUICK | parameters).items()]
    return command(
        "run", "keyboard", "-p", participant, "--data", str(data), "--seed", "7", *settings
    )


def see_the_summary(terminal: Terminal) -> None:
    """Continue from the last response to the summary."""
    terminal.wait_for("Press Enter to see how it went.")
    terminal.settle()
    terminal.confirm()
    terminal.wait_for("Press Enter to finish.")
    terminal.settle()


class ScreenReader:
    """Reads the text on a terminal's screen."""

    def __init__(self, terminal: Terminal, columns: int = 80, rows: int = 24) -> None:
        self._terminal = terminal
        self._screen = pyte.Screen(columns, rows)
        self._stream = pyte.ByteStream(self._screen)
        self._seen = 0

    def text(self) -> str:
        """Return the text on the screen."""
        self._stream.feed(bytes(self._terminal.output[self._seen :]))
        self._seen = len(self._terminal.output)
        return "\n".join(line.rstrip() for line in self._screen.display)

    def reversed(self) -> list[str]:
        """Return the reversed parts of each row that has some, with one space between them."""
        self.text()
        rows = (self._screen.buffer[row] for row in range(self._screen.lines))
        found = (
            "".join(row[x].data if row[x].reverse else " " for x in range(self._screen.columns))
            for row in rows
        )
        return [" ".join(text.split()) for text in found if text.strip()]

    def resize(self, columns: int, rows: int) -> None:
        """Change the size of the terminal and of what is read."""
        self.text()
        self._screen.resize(rows, columns)
        self._terminal.resize(columns, rows)


def rows(data: Path, query: str, *values: object) -> list[tuple[Any, ...]]:
    with closing(sqlite3.connect(data / "sar-tui.db")) as database:
        return database.execute(query, values).fetchall()


def only_session(data: Path) -> str:
    ((session,),) = rows(data, "SELECT id FROM sessions")
    return str(session)


def replays_identically(data: Path, *options: str) -> bool:
    """Return True if the only session comes out as recorded when it is replayed, and has
    messages.
    """
    words = command("replay", only_session(data), "--data", str(data), "--json", *options)
    called = subprocess.run(words, capture_output=True, text=True, check=False)
    result = json.loads(called.stdout or "{}")
    assert called.returncode == 0, called.stderr or result["first_difference"]
    return bool(result["identical"] and result["events"])
