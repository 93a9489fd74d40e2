"""Drives the operator's panel in a pseudo-terminal, and reads the session's log."""

import json
import os
import shutil
import signal
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any

import pyte

from sar_tui.model.units import MS, SECOND
from sar_tui.operator.commands import TOO_SOON
from sar_tui.operator.keymap import KEY_COMMANDS, key_name
from sar_tui.timing.pty import Terminal, read_together
from sar_tui.timing.scripted_participant import Answer, ScriptedParticipant, random_answers
from tests.end_to_end.participant_terminal import ScreenReader, command, rows, run_command

Row = dict[str, Any]
_SIZE = 100, 30
_COLUMNS = tuple(
    "id kind proposed final decision actor mode ground reason proposed_ns shown_ns decided_ns "
    "started_ns".split()
)


def key_of(id: str) -> str:
    """Return the key of an operator command, given its id."""
    (first, *_) = next(each for each in KEY_COMMANDS if each.id == id).keys.split(",")
    called = key_name(first)
    return called if len(called) == 1 else first


class SessionTerminals:
    """Terminals of a participant and an operator at one session, with a private folder for its
    socket.

    Use it as a context manager: its programs end with it. Reading one terminal reads all of them.
    """

    def __init__(self, data: Path) -> None:
        self.data = data
        self._terminals: dict[Terminal, tuple[int, int]] = {}
        self._ends = ExitStack()
        # A socket's path has to be short, shorter than pytest's own folders.
        self.runtime = Path(tempfile.mkdtemp(prefix="sar-"))
        self._ends.callback(shutil.rmtree, self.runtime, ignore_errors=True)

    def __enter__(self) -> "SessionTerminals":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ends.close()

    def participant(self, *flags: str, **parameters: object) -> "Participant":
        """Start a session, with these flags and parameters."""
        return Participant(self.start_program([*run_command(self.data, **parameters), *flags]))

    def panel(self, *flags: str) -> "Panel":
        """Start a panel."""
        return Panel(
            self, self.start_program(command("wizard", *flags, "--data", str(self.data)), *_SIZE)
        )

    def both(self, **parameters: object) -> "tuple[Participant, Panel]":
        """Start a session and the panel of Ana, who takes control."""
        participant = self.participant("--operator", **parameters)
        panel = self.panel("--name", "ana", "--wait")
        participant.terminal.wait_for("Press Enter to go on.")
        self.until(lambda: self.is_operated, "the operator steers")
        return participant, panel

    def start_program(self, words: list[str], columns: int = 80, rows: int = 24) -> Terminal:
        """Start a program in a terminal."""
        environment = {"XDG_RUNTIME_DIR": str(self.runtime)}
        terminal = Terminal(words, columns=columns, rows=rows, environment=environment)
        self._ends.enter_context(terminal)
        self._terminals[terminal] = (columns, rows)
        read_together(*self._terminals)
        return terminal

    def look(self, seconds: float = 0.02) -> None:
        """Read the output of the terminals for a while."""
        there = next((terminal for terminal in self._terminals if not terminal.ended), None)
        if there is None:
            time.sleep(seconds)  # nothing is left to be read
            return
        until = time.monotonic_ns() + round(seconds * SECOND)
        while there.read(until):
            pass

    def until(self, holds: Callable[[], object], what: str, seconds: float = 60) -> None:
        """Read the terminals until a condition holds."""
        deadline = time.monotonic() + seconds
        while not holds():
            assert time.monotonic() < deadline, "\n".join(
                (f"waited in vain until {what}", *self.screens())
            )
            self.look()

    def screens(self) -> list[str]:
        """Return the text on each terminal."""
        return [ScreenReader(terminal, *size).text() for terminal, size in self._terminals.items()]

    # --- the database

    def reported(self, topic: str) -> list[Row]:
        """Return the stored messages of a topic, in order."""
        found = rows(
            self.data, "SELECT message FROM events WHERE topic=? ORDER BY session, seq", topic
        )
        return [json.loads(message) for (message,) in found]

    def actions(self, kind: str) -> list[Row]:
        """Return the ``actions`` of a kind, in the order in which they were proposed or decided."""
        query = (
            f"SELECT {', '.join(_COLUMNS)} FROM actions WHERE kind=? ORDER BY "
            "coalesce(proposed_ns, decided_ns)"
        )
        found = [dict(zip(_COLUMNS, row, strict=True)) for row in rows(self.data, query, kind)]
        return [
            row | {name: row[name] and json.loads(row[name]) for name in ("proposed", "final")}
            for row in found
        ]

    def presence(self) -> list[tuple[str, str]]:
        """Return the operators who joined, left or were lost, in order. These terminals prove
        nobody's presence.
        """
        changes = self.reported("operator/presence")
        return [(each["actor"], each["state"]) for each in changes if each["state"] != "unproven"]

    @property
    def is_operated(self) -> bool:
        """True if an operator has control."""
        changes = self.reported("operator/presence")
        return bool(changes and changes[-1]["operated"])

    def pending_proposal(self) -> Row | None:
        """Return the proposal that waits for the operator's decision."""
        states = self.reported("arbiter/state")
        pending = states[-1].get("pending", []) if states else []
        return pending[0]["proposal"] if pending else None


class Participant:
    """The participant's terminal."""

    def __init__(self, terminal: Terminal) -> None:
        self.terminal = terminal
        self.answers: Answer = random_answers(3, 120, 220)
        self.script = ScriptedParticipant(terminal, self._answer)
        self._reader = ScreenReader(terminal)

    def _answer(self, number: int, expected: str) -> tuple[float, str]:
        return self.answers(number, expected)

    def answer(self, prompts: int) -> None:
        """Answer this many further prompts, and press Enter where a prompt requires it."""
        self.terminal.settle(silence_ms=50)
        # the request may have been read while another terminal was watched
        if "Press Enter" in self._reader.text():
            self.terminal.confirm()
            self.script.forget_enter()
        self.script.run(len(self.script.presses) + prompts)

    def sees(self, text: str) -> bool:
        """Return True if all words of a text are on the screen in order; beside the agent they span
        several lines.
        """
        screen = iter(plain(self._reader.text()).split())
        return all(word in screen for word in plain(text).split())

    def has_seen(self) -> set[str]:
        """Return every line that was ever on the screen."""
        screen = pyte.Screen(80, 24)
        stream = pyte.ByteStream(screen)
        lines: set[str] = set()
        output = bytes(self.terminal.output)
        for at in range(0, len(output), 100):
            stream.feed(output[at : at + 100])
            lines.update(plain(screen.display[row]) for row in screen.dirty)
            screen.dirty.clear()
        return lines


class Panel:
    """The operator's terminal."""

    def __init__(self, terminals: SessionTerminals, terminal: Terminal) -> None:
        self.terminal = terminal
        self._terminals = terminals
        self._reader = ScreenReader(terminal, *_SIZE)

    def does(self, id: str) -> int:
        """Press the key of a command, given its id. Return the stamp taken just before."""
        return self.terminal.press(key_of(id))

    def writes(self, id: str, asked: str, text: str) -> None:
        """Press the key of a command that asks for text, type this text instead and press Enter."""
        self.does(id)
        self._terminals.until(lambda: asked in self.sees(), f"the panel asks {asked}")
        if asked not in self._lines():
            self.terminal.press("ctrl+u")
            self._terminals.until(lambda: asked in self._lines(), f"nothing stands after {asked}")
        for character in text:
            self.terminal.press(character)
        self.terminal.press("enter")

    def sees(self) -> str:
        """Return the words on the screen, without lines and blanks."""
        return plain(self._reader.text())

    def _lines(self) -> list[str]:
        return [plain(line) for line in self._reader.text().splitlines()]

    def wait_for_proposal(self, after: str = "") -> Row:
        """Wait for a proposal other than ``after`` until the panel accepts a decision, and return
        it.
        """
        terminals = self._terminals
        terminals.until(
            lambda: (terminals.pending_proposal() or {"id": after})["id"] != after,
            "a proposal waits for the operator",
        )
        pending_proposal = terminals.pending_proposal()
        assert pending_proposal
        id = pending_proposal["id"]
        terminals.until(
            lambda: _shown_at(terminals, id), f"the proposal {id} stands on the operator's screen"
        )
        terminals.until(
            lambda: time.monotonic_ns() > _shown_at(terminals, id) + TOO_SOON + MS,
            "it can have been read",
        )
        return pending_proposal

    def kill(self, number: int = signal.SIGKILL) -> None:
        """Send the program a signal."""
        os.kill(self.terminal.process.pid, number)


def _shown_at(terminals: SessionTerminals, id: str) -> int:
    """Return the time when a proposal was on the operator's screen; 0 if it never was."""
    return next(
        (int(each["at"]) for each in terminals.reported("operator/seen") if each["action"] == id), 0
    )


def plain(text: str) -> str:
    """Return the words of a text without line breaks and box drawings."""
    return " ".join(
        "".join(each if each.isalnum() or each in "'.,:!?%-" else " " for each in text).split()
    )


def children(pid: int) -> dict[int, str]:
    """Return all descendants of a process with their command lines (Linux)."""
    found: dict[int, str] = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            words = (
                (entry / "cmdline")
                .read_bytes()
                .replace(b"\0", b" ")
                .decode(errors="replace")
                .strip()
            )
        except (OSError, ValueError):  # it has ended meanwhile
            continue
        if parent == pid:
            found |= {int(entry.name): words, **children(int(entry.name))}
    return found
