"""Ctrl-C, Escape twice and windows of other sizes, on every screen, in a real pseudo-terminal:
nothing is lost, and nothing begins.
"""

import os
import re
import shutil
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Literal, NamedTuple

import pytest

from sar_tui.model.units import MS
from sar_tui.runs.demonstration import make_demonstration
from sar_tui.timing.pty import Terminal, encode
from tests.end_to_end.operator_terminal import SessionTerminals, plain
from tests.end_to_end.participant_terminal import ScreenReader, command, rows
from tests.end_to_end.test_held_keys import QUICK, READY, SECOND, exercise, patient

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(os.name != "posix", reason="there are no pseudo-terminals"),
]

What = Literal["a small window", "ctrl+c", "escape twice"]
FUNCTION_KEYS = {"f3": b"\x1bOR", "f4": b"\x1bOS", "f5": b"\x1b[15~", "f6": b"\x1b[17~"}
FUNCTION_KEYS |= {"f12": b"\x1b[24~"}
INTERRUPTED = 130
BUSY = "One moment"
LARGER = (100, 32), (160, 48)
TABLES = ("sessions", "attempts", "trials", "records", "programmes", "participants")


class Chair:
    """The person in front of a terminal, who reads before they press a key."""

    def __init__(self, terminal: Terminal, columns: int = 80, rows: int = 24) -> None:
        self.terminal = terminal
        self._size = columns, rows
        self._reader = ScreenReader(terminal, columns, rows)

    def text(self) -> str:
        """Return the words on the screen."""
        return plain(self._reader.text())

    def read(self, ms: float) -> None:
        """Read the output for a while."""
        until = time.monotonic_ns() + round(ms * MS)
        while self.terminal.read(until):
            pass

    def see(self, words: str) -> None:
        """Wait for words."""
        until = time.monotonic() + 30
        while plain(words) not in self.text():
            assert time.monotonic() < until, f"{words}: {self.text()}"
            self.read(50)

    def still(self) -> str:
        """Wait until the words no longer change and nothing is computed, and return them."""
        before = ""
        for _ in range(40):
            if before == (before := self.text()) and BUSY not in before:
                break
            self.read(600)
        return before

    def press(self, *keys: str) -> None:
        """Press keys one after the other, each after a while."""
        for key in keys:
            self.read(900)
            self.terminal.write(FUNCTION_KEYS.get(key) or encode(key))
        self.read(500)

    def shrink_and_grow(self) -> None:
        """Make the window too small, press keys that begin, leave or type, and make it large."""
        self._reader.resize(20, 5)
        self.read(400)
        for key in ("x", "enter", "space", "escape"):
            self.terminal.press(key)
            self.read(200)
        self._reader.resize(*self._size)
        self.read(900)

    def see_in_larger_windows(self, words: str) -> None:
        """Wait for words in larger windows, and then in one as large as before."""
        for size in (*LARGER, self._size):
            self._reader.resize(*size)
            self.read(900)
            self.see(words)

    def do(self, what: What) -> None:
        """Interrupt the screen."""
        if what == "a small window":
            self.shrink_and_grow()
        else:
            self.press(*["escape"] * 2 if what == "escape twice" else ["ctrl+c"])


def stored(data: Path) -> dict[str, int]:
    """Return the number of rows of each table."""
    return {name: rows(data, f"SELECT count(*) FROM {name}")[0][0] for name in TABLES}


# --- the therapist's screens


class Place(NamedTuple):
    """A screen of the therapist, the keys that lead to it, and words that stand there."""

    keys: Sequence[str]
    words: str
    stops: int = 1
    """Presses of Ctrl-C that end the program: the first tells what is unsaved."""


PLACES = {
    "home": Place((), "need a look"),
    "search": Place(("p", "0", "3"), "P03"),
    "new participant": Place(("+", "Q", "9"), "Q9"),
    "palette": Place(("ctrl+p", "h"), "Theme: Calm"),
    "help": Place(("f1",), "People who need a look come first"),
    "sessions": Place(("f6",), "Sessions of P01"),
    "past session": Place(("f6", "enter"), "goal reached in"),
    "progress": Place(("f4",), "Improving"),
    "explanation": Place(("f4", "enter"), "Improving"),
    "record": Place(("f4", "a", "tab", "tab", "4"), "Record of P01"),
    "settings": Place(("f2",), "When does it get harder or easier"),
    "a setting": Place(("f2", "tab", "tab", "down", "5"), "Misses before easier", stops=2),
    "find a setting": Place(("f2", "f3", "p", "a"), "Pain limit"),
    "versions": Place(("f2", "f5"), "Which version was better?"),
    "presets": Place(("f2", "f6"), "Which preset?"),
}


@pytest.fixture(scope="module")
def demonstration(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of invented people, to be copied."""
    folder = tmp_path_factory.mktemp("demonstration") / "data"
    make_demonstration(folder)
    return folder


@contextmanager
def therapist(data: Path, place: Place) -> Iterator[Chair]:
    """Go to a screen of the therapist."""
    with Terminal(command("--data", str(data))) as terminal:
        chair = Chair(terminal)
        chair.see("need a look")
        chair.press(*place.keys)
        chair.see(place.words)
        yield chair


@pytest.mark.parametrize("name", PLACES)
def test_a_therapist_loses_nothing_and_begins_nothing(
    name: str, demonstration: Path, tmp_path: Path
) -> None:
    data = shutil.copytree(demonstration, tmp_path / "data")
    before, place = stored(data), PLACES[name]
    with therapist(data, place) as chair:
        shown = chair.still()
        chair.do("a small window")
        assert chair.still() == shown
        chair.see_in_larger_windows(place.words)
        chair.press(*["ctrl+c"] * place.stops)
        assert chair.terminal.wait() == INTERRUPTED
    assert stored(data) == before
    with therapist(data, place) as chair:
        chair.do("escape twice")
        assert "need a look" in chair.still(), "Escape leads home, and not out of the program"
    assert stored(data) == before
    assert rows(data, "PRAGMA integrity_check") == [("ok",)]


# --- the participant's screens

SETTINGS = QUICK | {
    "attempts": 2,
    "prompts_per_attempt": 1,
    "quiet_ms": 2500,
    "foreperiod_min_ms": 2500,
    "foreperiod_max_ms": 3000,
    "ask_wellbeing": True,
    "questions": ("exertion",),
    "questions_every": 1,
    "rest_after_attempts": 1,
    "rest_seconds": 12,
}
START, PAIN, PLACE_OF_PAIN, TIRED = (
    "Press Enter to start.",
    "How much pain do you have now?",
    "Where does it hurt?",
    "How tired are you now?",
)
EFFORT, PASSPHRASE = "How hard was that for you?", "Please enter the passphrase."
MENU = "Take your time."
ANSWER = "answer"
"""Stands for the key that the prompt asks for."""


class Stop(NamedTuple):
    """A screen of the participant: the key that leads there, and its words.

    ``again``: keys that lead there after two Escapes, each of which goes one step back.
    """

    key: str
    words: str
    again: Sequence[str] = ()


BEFORE = (
    Stop("", START),
    Stop("f1", "Press Enter to close this.", ("f1",)),
    Stop("enter", START),
    Stop("f12", PASSPHRASE, ("f12",)),
    Stop("escape", START),
    Stop("enter", PAIN, ("enter",)),
    Stop("2", "Press Enter to go on.", ("enter", "2")),
    Stop("enter", PLACE_OF_PAIN, ("enter", "2", "enter")),
    Stop("3", PLACE_OF_PAIN, ("enter", "2", "enter", "3")),
    Stop("enter", TIRED, ("enter", "3", "enter")),
    Stop("3", TIRED, ("enter", "3", "enter", "3")),
    Stop("enter", "A key appears in the middle of the screen."),
)
"""From the start to the session."""
SESSION = (
    Stop("enter", READY),
    Stop("enter", "Keys 0 of 1"),
    Stop("", "Press: "),
    Stop(ANSWER, EFFORT),
    Stop("5", EFFORT),
    Stop("enter", "A short rest"),
    Stop("", SECOND),
    Stop("escape", MENU),
    Stop("enter", SECOND),
    Stop("enter", "Press: "),
    Stop(ANSWER, EFFORT),
    Stop("5", EFFORT),
    Stop("enter", "Press Enter to see how it went."),
    Stop("enter", "Press Enter to finish."),
    Stop("enter", PAIN),
    Stop("0", PAIN),
    Stop("enter", TIRED, ("enter",)),
)
"""From there to the last question."""


def go(chair: Chair, stops: Sequence[Stop]) -> Iterator[Stop]:
    """Go from screen to screen, and yield each when it is there."""
    for stop in stops:
        if stop.key == ANSWER:
            asked = re.search(r"Press: (\S)", chair.text())
            assert asked, chair.text()
            chair.press(asked[1])
        elif stop.key:
            chair.press(stop.key)
        chair.see(stop.words)
        yield stop


def interrupt(chair: Chair, stop: Stop, what: What, data: Path) -> None:
    """Interrupt a screen: it must stand there again, or below a pause, or one step ahead."""
    before = stored(data)
    chair.do(what)
    assert stored(data) == before, stop.words
    if what == "escape twice" and stop.again:
        chair.press(*stop.again)
    elif "Paused" in chair.text() and stop.words != MENU:
        chair.press("enter")
    chair.see(stop.words)


WHATS = pytest.mark.parametrize("what", ["a small window", "ctrl+c", "escape twice"])


@WHATS
def test_nothing_begins_before_a_session(data: Path, what: What) -> None:
    exercise(data, **SETTINGS)
    with patient(data) as terminal:
        for stop in go(chair := Chair(terminal), BEFORE):
            interrupt(chair, stop, what, data)
    assert rows(data, "SELECT count(*) FROM trials") == [(0,)]


@WHATS
@pytest.mark.timeout(400)
def test_nothing_is_lost_in_a_session_and_no_attempt_begins(data: Path, what: What) -> None:
    exercise(data, **SETTINGS)
    with patient(data) as terminal:
        chair = Chair(terminal)
        assert len(list(go(chair, BEFORE))) == len(BEFORE)
        for stop in go(chair, SESSION):
            interrupt(chair, stop, what, data)
    assert rows(data, "SELECT count(*) FROM trials") == [(2,)]


@WHATS
def test_the_check_of_a_sensor_begins_nothing(data: Path, what: What) -> None:
    exercise(data, "reaching", imu="simulated", attempts=2, ask_wellbeing=False)
    stops = (Stop("", START), Stop("enter", "Check the sensor", ("enter",)))
    with patient(data) as terminal:
        for stop in go(chair := Chair(terminal), stops):
            interrupt(chair, stop, what, data)
    assert rows(data, "SELECT 1 FROM sessions") == []


# --- the operator's panel


def test_a_panel_comes_back_and_changes_nothing_of_the_session(data: Path) -> None:
    with SessionTerminals(data) as terminals:
        participant, panel = terminals.both()
        chair = Chair(panel.terminal, 100, 30)
        before = stored(data)
        chair.do("a small window")
        chair.do("escape twice")
        chair.see_in_larger_windows("Nothing is pending")
        assert stored(data) == before
        assert terminals.reported("arbiter/state")[-1].get("pending", []) == []
        chair.press("ctrl+c")
        assert panel.terminal.wait() == INTERRUPTED
        assert participant.sees("Press Enter to go on.")
        assert stored(data) == before
