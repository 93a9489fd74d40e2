"""Paradigms of a laboratory, written from the docs: in a terminal, killed, resumed, simulated, and
replayed.
"""

import json
import re
import shutil
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import pytest

from sar_tui.model.units import MS
from sar_tui.timing.pty import Terminal
from tests.documented import write_documented
from tests.end_to_end.participant_terminal import (
    QUICK,
    command,
    only_session,
    replays_identically,
    rows,
    see_the_summary,
)

OWN = Path(__file__).parents[1] / "paradigms"
Keys = Sequence[tuple[int, str]]
"""Milliseconds after what was read, and a key."""


class Paradigm(NamedTuple):
    """A task, and how it is played.

    Attributes:
        answers: what is read from the screen, and the keys that follow; a group of the pattern
            replaces ``\\1``.
        killed_at: the program is killed when it has written this.
        stored: the fields of ``trials.timing`` that some trial must have.
    """

    task: str
    trials: int
    answers: Mapping[str, Keys]
    killed_at: str
    stored: tuple[str, ...]


PARADIGMS = [
    Paradigm(
        "span",
        2,
        {r"Digit: (\d)": (), r"Type the digits\.": ()},
        "Type the digits.",
        ("frame_onsets_ns",),
    ),
    Paradigm(
        "cueing",
        6,
        {r"Star: left": ((250, "left"),), r"Star: right": ((250, "right"),)},
        "Star",
        (),
    ),
    Paradigm(
        "oddball",
        6,
        {r"Listen now\.": ((180, "space"),)},
        "Listen now.",
        ("frame_onsets_ns", "tone_onsets_ns"),
    ),
    Paradigm(
        "beat",
        1,
        {r"Tap with the beeps\.": [(600 * beat, "space") for beat in range(8)]},
        "Tap",
        ("tone_onsets_ns",),
    ),
]


class Player:
    """Reads the terminal, and presses keys when they are due; Enter when it is asked for."""

    def __init__(self, terminal: Terminal, answers: Mapping[str, Keys]) -> None:
        self._terminal = terminal
        self._answers = [(re.compile(pattern.encode()), keys) for pattern, keys in answers.items()]
        self._read_to = len(terminal.output)
        self._due: list[tuple[int, str]] = []
        self._digits = ""

    def play(self, is_over: Callable[[], bool], seconds: float = 60) -> None:
        """Play until a condition holds."""
        deadline = time.monotonic() + seconds
        while not is_over():
            assert time.monotonic() < deadline, bytes(self._terminal.output[-500:])
            self._terminal.read(time.monotonic_ns() + 10 * MS)
            new = bytes(self._terminal.output[self._read_to :])
            self._read_to = len(self._terminal.output)
            self._answer(new)
            now = time.monotonic_ns()
            for due, key in [one for one in self._due if one[0] <= now]:
                self._terminal.press(key)
                self._due.remove((due, key))

    def _answer(self, new: bytes) -> None:
        now = time.monotonic_ns()
        if b"Enter" in new:
            self._due.append((now + 900 * MS, "enter"))
            self._digits = ""
        for pattern, keys in self._answers:
            for found in pattern.finditer(new):
                if pattern.groups:
                    self._digits += found[1].decode()
                elif not keys:  # types what it has seen
                    self._due += [
                        (now + 80 * MS * place, digit)
                        for place, digit in enumerate(self._digits, 2)
                    ]
                    self._digits = ""
                self._due += [(now + ms * MS, key) for ms, key in keys]


@pytest.fixture
def tasks(tmp_path: Path) -> Path:
    """A folder of tasks outside the checkout."""
    folder = tmp_path / "mytasks"
    for name in ("oddball", "span", "cueing"):
        shutil.copytree(OWN / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    write_documented(folder, "beat")
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("paradigm", PARADIGMS, ids=lambda paradigm: paradigm.task)
def test_it_is_played_killed_resumed_and_replayed(
    data: Path, tasks: Path, paradigm: Paradigm
) -> None:
    settings = QUICK | {"attempts": 1, "speech": f"file:{data}-sounds"}
    where = ("--data", str(data), "--tasks", str(tasks))
    words = (
        "run",
        paradigm.task,
        "-p",
        "P01",
        "--seed",
        "3",
        *where,
        *(f"--set={n}={v}" for n, v in settings.items()),
    )
    with Terminal(command(*words)) as terminal:
        Player(terminal, {}).play(lambda: paradigm.killed_at.encode() in terminal.output)
        terminal.kill()
        terminal.wait()
    with Terminal(command("resume", only_session(data), *where)) as terminal:
        Player(terminal, paradigm.answers).play(lambda: b"see how it went" in terminal.output)
        see_the_summary(terminal)
        terminal.confirm()
        assert terminal.wait() == 0
    trials = rows(data, "SELECT response, correct, timing FROM trials ORDER BY attempt, trial")
    assert len(trials) == paradigm.trials
    assert any(correct for _, correct, _ in trials)
    for field in paradigm.stored:
        assert any(json.loads(timing).get(field) for *_, timing in trials)
    assert rows(data, "SELECT status FROM sessions") == [("completed",)]
    assert replays_identically(data, "--tasks", str(tasks))
