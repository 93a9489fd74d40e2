"""A second seat: the operator's panel in a pseudo-terminal of its own, its keys by what they do, and the log."""

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

from sar_tui.framework.clock import MS, SECOND
from sar_tui.operator.commands import TOO_SOON
from sar_tui.operator.keymap import KEY_COMMANDS, key_name
from sar_tui.timing.pty import Terminal, read_together
from sar_tui.timing.scripted_participant import Answer, ScriptedParticipant, random_answers
from tests.end_to_end.participant_terminal import Eyes, command, rows, run_command

Row = dict[str, Any]
_SIZE = 100, 30
_COLUMNS = tuple(
    "id kind proposed final decision actor mode ground reason proposed_ns shown_ns decided_ns started_ns".split()
)


def key_of(id: str) -> str:
    """The key of something an operator can do, by its id in the panel's own table."""
    (first, *_) = next(each for each in KEY_COMMANDS if each.id == id).keys.split(",")
    called = key_name(first)
    return called if len(called) == 1 else first


class Room:
    """Two seats at one session, with a folder of their own for its socket; whoever looks at one terminal sees both.

    Use it as a context: what runs in it is ended with it.
    """

    def __init__(self, data: Path) -> None:
        self.data = data
        self._terminals: dict[Terminal, tuple[int, int]] = {}
        self._ends = ExitStack()
        # A socket's path has to be short, shorter than pytest's own folders.
        self.runtime = Path(tempfile.mkdtemp(prefix="sar-"))
        self._ends.callback(shutil.rmtree, self.runtime, ignore_errors=True)

    def __enter__(self) -> "Room":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ends.close()

    def participant(self, *flags: str, **parameters: object) -> "Participant":
        """Start a session, with these flags and parameters."""
        return Participant(self.sit_down([*run_command(self.data, **parameters), *flags]))

    def panel(self, *flags: str) -> "Panel":
        """Start a panel."""
        return Panel(self, self.sit_down(command("wizard", *flags, "--data", str(self.data)), *_SIZE))

    def both(self, **parameters: object) -> "tuple[Participant, Panel]":
        """Start a session and the panel of Ana, who steers it from here on."""
        participant = self.participant("--operator", **parameters)
        panel = self.panel("--name", "ana", "--wait")
        participant.terminal.wait_for("Press Enter to go on.")
        self.until(lambda: self.is_operated, "the operator steers")
        return participant, panel

    def sit_down(self, words: list[str], columns: int = 80, rows: int = 24) -> Terminal:
        """Start a program in a terminal."""
        environment = {"XDG_RUNTIME_DIR": str(self.runtime)}
        terminal = Terminal(words, columns=columns, rows=rows, environment=environment)
        self._ends.enter_context(terminal)
        self._terminals[terminal] = (columns, rows)
        read_together(*self._terminals)
        return terminal

    def look(self, seconds: float = 0.02) -> None:
        """Read whatever the terminals show meanwhile."""
        there = next((terminal for terminal in self._terminals if not terminal.ended), None)
        if there is None:
            time.sleep(seconds)  # nothing is left to be read
            return
        until = time.monotonic_ns() + round(seconds * SECOND)
        while there.read(until):
            pass

    def until(self, holds: Callable[[], object], what: str, seconds: float = 60) -> None:
        """Read the terminals until something holds."""
        deadline = time.monotonic() + seconds
        while not holds():
            assert time.monotonic() < deadline, "\n".join((f"waited in vain until {what}", *self.screens()))
            self.look()

    def screens(self) -> list[str]:
        """What stands on each terminal."""
        return [Eyes(terminal, *size).text() for terminal, size in self._terminals.items()]

    # --- what has been written down ------------------------------------------------------------------------------

    def reported(self, topic: str) -> list[Row]:
        """The messages of a topic, in order."""
        found = rows(self.data, "SELECT message FROM events WHERE topic=? ORDER BY session, seq", topic)
        return [json.loads(message) for (message,) in found]

    def actions(self, kind: str) -> list[Row]:
        """The rows of ``actions`` of a kind, in the order in which they were proposed or decided."""
        query = f"SELECT {', '.join(_COLUMNS)} FROM actions WHERE kind=? ORDER BY coalesce(proposed_ns, decided_ns)"
        found = [dict(zip(_COLUMNS, row, strict=True)) for row in rows(self.data, query, kind)]
        return [row | {name: row[name] and json.loads(row[name]) for name in ("proposed", "final")} for row in found]

    def presence(self) -> list[tuple[str, str]]:
        """Who came, went and was lost, in order."""
        return [(each["actor"], each["state"]) for each in self.reported("operator/presence")]

    @property
    def is_operated(self) -> bool:
        """Whether an operator has the baton."""
        changes = self.reported("operator/presence")
        return bool(changes and changes[-1]["operated"])

    def offered(self) -> Row | None:
        """The proposal that waits for an operator, as it was offered."""
        standing = self.reported("arbiter/standing")
        offers = standing[-1].get("offers", []) if standing else []
        return offers[0]["proposal"] if offers else None


class Participant:
    """The participant's seat."""

    def __init__(self, terminal: Terminal) -> None:
        self.terminal = terminal
        self.answers: Answer = random_answers(3, 120, 220)
        self.script = ScriptedParticipant(terminal, self._answer)
        self._eyes = Eyes(terminal)

    def _answer(self, number: int, expected: str) -> tuple[float, str]:
        return self.answers(number, expected)

    def answer(self, prompts: int) -> None:
        """Answer so many prompts more, and press Enter where that is asked for before one."""
        self.terminal.settle(silence_ms=50)
        if "Press Enter" in self._eyes.text():  # the request may have been read while another terminal was watched
            self.terminal.press("enter")
            self.script.forget_enter()
        self.script.run(len(self.script.presses) + prompts)

    def sees(self, text: str) -> bool:
        """Whether all words of a text stand on the screen, in their order: beside the agent they have several lines."""
        screen = iter(plain(self._eyes.text()).split())
        return all(word in screen for word in plain(text).split())

    def has_seen(self) -> set[str]:
        """Each line that ever stood on the screen."""
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
    """The operator's seat."""

    def __init__(self, room: Room, terminal: Terminal) -> None:
        self.terminal = terminal
        self._room = room
        self._eyes = Eyes(terminal, *_SIZE)

    def does(self, id: str) -> int:
        """Press the key of a command, given its id. Return the stamp taken just before."""
        return self.terminal.press(key_of(id))

    def writes(self, id: str, asked: str, text: str) -> None:
        """Press the key of a command that asks for text, replace the text with this one and press Enter."""
        self.does(id)
        self._room.until(lambda: asked in self.sees(), f"the panel asks {asked}")
        if asked not in self._lines():
            self.terminal.press("ctrl+u")
            self._room.until(lambda: asked in self._lines(), f"nothing stands after {asked}")
        for character in text:
            self.terminal.press(character)
        self.terminal.press("enter")

    def sees(self) -> str:
        """The screen's words, without its lines and blanks."""
        return plain(self._eyes.text())

    def _lines(self) -> list[str]:
        return [plain(line) for line in self._eyes.text().splitlines()]

    def wait_for_offer(self, after: str = "") -> Row:
        """Wait for a proposal other than that one, and until the panel takes a key for it; the proposal."""
        room = self._room
        room.until(lambda: (room.offered() or {"id": after})["id"] != after, "a proposal waits for the operator")
        offered = room.offered()
        assert offered
        id = offered["id"]
        room.until(lambda: _seen(room, id), f"the proposal {id} stands on the operator's screen")
        room.until(lambda: time.monotonic_ns() > _seen(room, id) + TOO_SOON + MS, "it can have been read")
        return offered

    def kill(self, number: int = signal.SIGKILL) -> None:
        """Send the program a signal."""
        os.kill(self.terminal.process.pid, number)


def _seen(room: Room, id: str) -> int:
    """When a proposal was on the operator's screen; 0 if it never was."""
    return next((int(each["at"]) for each in room.reported("operator/seen") if each["action"] == id), 0)


def plain(text: str) -> str:
    """Words alone, so that it does not matter where lines were broken and boxes drawn."""
    return " ".join("".join(each if each.isalnum() or each in "'.,:!?%-" else " " for each in text).split())


def runs(pid: int) -> bool:
    """Whether a process goes on; one that nobody has buried yet does not (Linux)."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


def children(pid: int) -> dict[int, str]:
    """The processes that a program has started, and those that they have, with their command lines (Linux)."""
    found: dict[int, str] = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            words = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace").strip()
        except (OSError, ValueError):  # it has ended meanwhile
            continue
        if parent == pid:
            found |= {int(entry.name): words, **children(int(entry.name))}
    return found
