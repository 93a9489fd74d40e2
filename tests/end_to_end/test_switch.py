"""A session in a real terminal with the space bar alone, by a person who sees the mark."""

import os
import time
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.store import participants, programmes
from sar_tui.store.database import connect
from sar_tui.store.passphrase import Passphrase
from sar_tui.timing.pty import Terminal
from tests.end_to_end.participant_terminal import (
    QUICK,
    ScreenReader,
    command,
    replays_identically,
    rows,
)

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(os.name != "posix", reason="there are no pseudo-terminals"),
]

_PATIENCE_S = 60.0
_LOOK_S = 0.02


class OneSwitch:
    """A person who reads the screen, and can press one key only."""

    def __init__(self, terminal: Terminal, key: bytes) -> None:
        self._terminal = terminal
        self._key = key
        self._screen = ScreenReader(terminal)

    def press(self) -> None:
        self._terminal.write(self._key)

    def wait(self, seconds: float) -> None:
        """Let time pass, and read what comes."""
        until = time.monotonic_ns() + round(seconds * 1e9)
        while self._terminal.read(until):
            pass

    @property
    def text(self) -> str:
        return self._screen.text().replace("\N{NO-BREAK SPACE}", " ")

    def sees(self, *any_of: str) -> str:
        """Wait until one of the texts is on the screen, and return it."""
        until = time.monotonic() + _PATIENCE_S
        while time.monotonic() < until:
            self.wait(_LOOK_S)
            text = self.text
            for words in any_of:
                if words in text:
                    return words
        raise AssertionError(f"none of {any_of} on the screen:\n{self.text}")

    def choose(self, about: str, marked: str) -> None:
        """Press when a choice is marked on the screen that is about this, once it was read."""
        self.sees(about)
        self.wait(0.8)
        self.sees(marked)
        self.wait(0.2)
        self.press()


def _answer(person: OneSwitch, about: str, marked: str) -> None:
    person.choose(about, marked)
    person.choose("You chose:", "▸ Yes")


def _tell(person: OneSwitch) -> None:
    _answer(person, "How much pain", "┃  1  ┃")
    _answer(person, "Where does it hurt?", "▶ 2  right hand")
    _answer(person, "How tired", "┃  0  ┃")


SETTINGS: dict[str, object] = QUICK | {
    "switch": "one",
    "scan_interval_ms": 1000,
    "attempts": 1,
}
TASKS: dict[str, dict[str, object]] = {
    "gonogo": {"prompts_per_attempt": 4},
    "tapping": {"seconds": 3, "threshold": 4},
    "reaching": {"imu": "simulated"},
}


def _respond_to_shapes(person: OneSwitch) -> None:
    for _ in range(4):
        shape = person.sees("A circle: press", "A square: wait")
        if shape == "A circle: press":
            person.wait(0.3)
            person.press()
        while shape in person.text:
            person.wait(_LOOK_S)


def _tap(person: OneSwitch) -> None:
    person.sees("Tap the space bar")
    for _ in range(6):
        person.wait(0.25)
        person.press()


def _reach(person: OneSwitch) -> None:
    person.choose("Ready?", "▸ Start")
    person.sees("Reach: 15 cm")
    person.wait(3.0)
    person.press()


_RESPOND = {"gonogo": _respond_to_shapes, "tapping": _tap, "reaching": _reach}


def _do_session(person: OneSwitch, task: str) -> None:
    """Continue from the questions to those after the session, with a pause."""
    _tell(person)
    if task == "reaching":
        person.choose("Test reach", "▸ Begin")
    person.choose("Press to choose:", "▸ Pause")
    person.choose("Take your time.", "Go on")
    person.choose("Press to choose:", "▸ Go on")
    person.choose("Your goal:", "▸ Go on")
    _RESPOND[task](person)
    person.choose("All done", "▸ Go on")
    person.choose("Press your switch:", "▸ Finish")
    _tell(person)


def _assert_whole(data: Path) -> None:
    assert rows(data, "SELECT status FROM sessions") == [("completed",)]
    assert set(rows(data, "SELECT correct FROM trials")) == {(1,)}
    assert replays_identically(data)


@pytest.mark.parametrize("task", TASKS)
def test_a_session_with_the_space_bar_alone(data: Path, task: str) -> None:
    settings = SETTINGS | {"ask_wellbeing": "yes"} | TASKS[task]
    options = [f"--set={name}={value}" for name, value in settings.items()]
    words = ("run", task, "-p", "P01", "--data", str(data), "--seed", "7", *options)
    with Terminal(command(*words)) as terminal:
        _do_session(OneSwitch(terminal, b" "), task)
        assert terminal.wait() == 0
    _assert_whole(data)


def test_patient_mode_with_a_foot_switch_that_sends_enter(data: Path) -> None:
    Passphrase(data).set("quiet river")
    settings = SETTINGS | {"ask_wellbeing": True} | TASKS["gonogo"]
    with closing(connect(data)) as database:
        participants.add(database, "P01")
        programmes.save(database, "P01", "gonogo", programmes.Programme(settings), after=0)
    with Terminal(command("--patient", "P01", "--data", str(data))) as terminal:
        person = OneSwitch(terminal, b"\r")
        person.choose("Press your switch:", "▸ Start")
        _do_session(person, "gonogo")
        person.choose("Press your switch:", "▸ Start again")
        person.choose("Start again?", "▸ No")
        terminal.hang_up()
        terminal.wait()
    _assert_whole(data)
