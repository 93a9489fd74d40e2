"""Keys that are held or doubled, on every screen that a participant sees, in a real
pseudo-terminal.

A walk leads from screen to screen. The key that leaves a screen is pressed as an unsteady hand does
it: it is held, so that the keyboard repeats it at 30 Hz, or pressed twice within 80 ms. The next
screen must then still be there.
"""

import itertools
import os
import re
import time
from pathlib import Path
from typing import Literal

import pytest

from sar_tui.model.units import MS
from sar_tui.store import participants, programmes
from sar_tui.store.database import connect
from sar_tui.store.passphrase import Passphrase
from sar_tui.timing.pty import Terminal, encode
from tests.end_to_end.participant_terminal import QUICK, ScreenReader, command, only_session

pytestmark = pytest.mark.skipif(os.name != "posix", reason="there are no pseudo-terminals")

Hand = Literal["held", "doubled"]
Step = tuple[str, str]
"""A key, and words of the screen that it leads to."""
ANSWER, THROUGH = "answer", "through"
"""Stand for the key that the prompt asks for, and for an Enter that is down while another screen
appears by itself.
"""
ONCE = "="
"""Before a key that is pressed once: it only moves in a menu, or types."""

DELAY_MS, PERIOD_MS, HELD_MS, DOUBLED_MS = 400, 33, 1500, 80
"""Time before a held key is repeated, between two repeats, and in all; and between two presses of
one.
"""
HIDDEN = str.maketrans("│╭╮╰╯─▌┃█", "         ")
F12 = b"\x1b[24~"


class Walk:
    """Walks from screen to screen with an unsteady hand.

    Attributes:
        tried: the screens that were reached.
        skipped: the one that was not there any more, with what stood there.
    """

    def __init__(self, terminal: Terminal, hand: Hand) -> None:
        self._terminal, self._hand = terminal, hand
        self._reader = ScreenReader(terminal)
        self.tried: list[str] = []
        self.skipped: list[str] = []

    def take(self, *steps: Step) -> None:
        """Take steps, until a screen is skipped: then what follows is not as planned."""
        for key, words in steps:
            if self.skipped:
                return
            if key == THROUGH:
                self._hold_until(words)
                self._arrive(words)
                continue
            self._read(900)
            if key.startswith(ONCE):
                self._terminal.write(_bytes(key.removeprefix(ONCE)))
            else:
                self._press(self._asked() if key == ANSWER else key)
            self._arrive(words)

    def _arrive(self, words: str) -> None:
        """Note if a screen with these words stands there, and stays."""
        deadline = time.monotonic() + 30
        while not self._sees(words) and time.monotonic() < deadline:
            self._read(50)
        self._read(300)
        self.tried.append(words)
        if not self._sees(words):
            self.skipped.append(f"{words}: {' '.join(self._text().split())[:300]}")

    def _press(self, key: str) -> None:
        for wait_ms in self._waits():
            self._terminal.write(_bytes(key))
            self._read(wait_ms)

    def _waits(self) -> list[int]:
        if self._hand == "doubled":
            return [DOUBLED_MS, 0]
        return [DELAY_MS, *itertools.repeat(PERIOD_MS, (HELD_MS - DELAY_MS) // PERIOD_MS)]

    def _hold_until(self, words: str) -> None:
        """Hold Enter until a screen has been there for a second; or double it as soon as the screen
        appears.
        """
        deadline = time.monotonic() + 30
        while not self._sees(words) and time.monotonic() < deadline:
            if self._hand == "held":
                self._terminal.press("enter")
            self._read(PERIOD_MS)
        self._press("enter")

    def _read(self, ms: float) -> None:
        until = time.monotonic_ns() + round(ms * MS)
        while self._terminal.read(until):
            pass

    def _text(self) -> str:
        return self._reader.text().translate(HIDDEN)

    def _sees(self, words: str) -> bool:
        return words in " ".join(self._text().split())

    def _asked(self) -> str:
        found = re.search(r"Press: (\S)", self._text())
        assert found, self._text()
        return found[1]


def _bytes(key: str) -> bytes:
    return F12 if key == "f12" else encode(key)


def exercise(data: Path, task: str = "keyboard", **settings: object) -> None:
    """Store an exercise of participant P01, who trains alone."""
    Passphrase(data).set("quiet river")
    database = connect(data)
    participants.add(database, "P01")
    programmes.save(database, "P01", task, programmes.Programme(settings), after=0)
    database.close()


def patient(data: Path) -> Terminal:
    return Terminal(command("--patient", "p01", "--data", str(data)))


HANDS = pytest.mark.parametrize("hand", ["held", "doubled"])
SETTINGS = QUICK | {"attempts": 2, "prompts_per_attempt": 1, "quiet_ms": 500, "ask_wellbeing": True}
READY, SECOND = "Press Enter to begin attempt 1 of 2.", "Press Enter for attempt 2 of 2."
FIRST: tuple[Step, ...] = (
    (THROUGH, "Press Enter to start."),
    ("enter", "How much pain do you have now?"),
    ("0", "How much pain do you have now?"),
    ("enter", "How tired are you now?"),
    ("3", "How tired are you now?"),
    ("enter", "A key appears in the middle of the screen."),
    ("enter", READY),
)


@pytest.mark.slow
def test_the_first_screens_are_not_skipped_by_a_held_key(data: Path) -> None:
    exercise(data, **SETTINGS)
    with patient(data) as terminal:
        walk = Walk(terminal, "held")
        walk.take(*FIRST[:5])
    assert walk.skipped == []
    assert len(walk.tried) == 5


@pytest.mark.slow
@HANDS
def test_no_screen_of_a_participant_who_trains_alone_is_skipped(data: Path, hand: Hand) -> None:
    """The start, questions before, between and after, the goal, a rest, every menu of a pause, help
    and passphrase.
    """
    effort = "How hard was that for you?"
    rest = {"rest_after_attempts": 1, "rest_seconds": 8}
    exercise(data, questions=("exertion",), questions_every=1, **rest, **SETTINGS)
    steps: tuple[Step, ...] = (
        *FIRST,
        ("enter", "Press: "),
        (ANSWER, effort),
        (ONCE + "5", effort),
        ("enter", "A short rest"),
        (THROUGH, SECOND),
        ("escape", "Take your time."),
        (ONCE + "down", "I am tired"),
        ("enter", "Take all the rest you need."),
        ("enter", SECOND),
        ("escape", "Take your time."),
        *[(ONCE + "down", "I am finished")] * 4,
        ("enter", "End the session now?"),
        ("enter", SECOND),
        ("escape", "Take your time."),
        *[(ONCE + "down", "I am in pain")] * 2,
        ("enter", "How much pain do you have now?"),
        ("1", "How much pain do you have now?"),
        ("enter", "Where does it hurt?"),
        ("2", "Where does it hurt?"),
        ("enter", "Tell your therapist or the experimenter about the pain before you go on."),
        ("enter", SECOND),
        ("f1", "Press Enter to close this."),
        ("enter", SECOND),
        ("f12", "Please enter the passphrase."),
        ("enter", SECOND),
        ("enter", "Press: "),
        (ANSWER, effort),
        (ONCE + "5", effort),
        ("enter", "Press Enter to see how it went."),
        ("enter", "Press Enter to finish."),
        ("enter", "How much pain do you have now?"),
        ("0", "How much pain do you have now?"),
        ("enter", "How tired are you now?"),
        ("3", "How tired are you now?"),
        ("enter", "T H A T W A S E V E R Y T H I N G"),
        ("enter", "About 1 minute"),
    )
    with patient(data) as terminal:
        walk = Walk(terminal, hand)
        walk.take(*steps)
    assert walk.skipped == []
    assert len(walk.tried) == len(steps)


@pytest.mark.slow
@HANDS
def test_no_other_screen_of_a_session_is_skipped(data: Path, hand: Hand) -> None:
    """The flash for a camera, the question before leaving, a window that was too small, and a
    session gone on with.
    """
    settings = [
        f"--set={name}={value}" for name, value in (SETTINGS | {"ask_wellbeing": "no"}).items()
    ]
    where = ("--data", str(data))
    with Terminal(
        command("run", "keyboard", "-p", "P01", "--sync-flash", *where, *settings)
    ) as terminal:
        first = Walk(terminal, hand)
        first.take(
            (THROUGH, "Press Enter when the camera is recording."),
            ("escape", "Press Enter to go on."),
            ("ctrl+q", "Leave now?"),
            ("enter", "Press Enter to go on."),
            ("enter", READY),
        )
        terminal.resize(60, 20)
        first.take((ONCE + "x", "Please make it larger."))
        terminal.resize(80, 24)
        first.take((THROUGH, READY), ("enter", "Press: "), (ANSWER, SECOND))
    with Terminal(command("resume", only_session(data), *where)) as terminal:
        second = Walk(terminal, hand)
        second.take((THROUGH, "Welcome back"), ("enter", SECOND), ("enter", "Press: "))
    assert first.skipped + second.skipped == []


@pytest.mark.slow
@HANDS
def test_no_screen_around_reaches_is_skipped(data: Path, hand: Hand) -> None:
    """The check of the sensor, and the start of a reach; and what advises a person in pain not to
    train.
    """
    exercise(data, "reaching", imu="simulated", attempts=2, ask_wellbeing=True)
    with patient(data) as terminal:
        walk = Walk(terminal, hand)
        walk.take(
            *FIRST[:2],
            ("9", "How much pain do you have now?"),
            ("enter", "Where does it hurt?"),
            ("3", "Where does it hurt?"),
            ("enter", "How tired are you now?"),
            ("4", "How tired are you now?"),
            ("enter", "Please do not train now"),
            ("enter", "You can rest now."),
            ("enter", "Press Enter to start."),
            *FIRST[1:5],
            ("enter", "Check the sensor"),
            ("enter", "Press Enter to go on."),
            ("enter", READY),
            ("enter", "Press Space to start."),
        )
    assert walk.skipped == []
