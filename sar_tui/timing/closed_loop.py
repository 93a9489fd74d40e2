"""Compares the reaction times that programs record with the true ones of a scripted participant.

A block is one run of one program in a terminal of its own. The programs take turns, so that
disturbances of the machine affect them alike.
"""

import gc
import json
import sqlite3
import tempfile
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, closing, nullcontext
from functools import partial
from pathlib import Path
from typing import Any

import msgspec

from sar_tui.drivers import child_process
from sar_tui.timing.pty import Terminal, visible
from sar_tui.timing.scripted_participant import ScriptedParticipant, random_answers

Row = dict[str, Any]

SHORTEST_MS, LONGEST_MS = 150, 350
"""Bounds of the planned delays: longer than an anticipation, and short enough to measure
hundreds.
"""
FOREPERIOD_MS = 40, 80
"""Bounds of the foreperiod."""
QUIET_MS = 20
"""Quiet time before the foreperiod, in programs that have one."""
ERROR_RATE = 0.05
"""Share of planned wrong keys."""


class Block(msgspec.Struct, frozen=True):
    """The number of prompts of one run of a program, and its seed."""

    prompts: int
    seed: int


class Program(msgspec.Struct, frozen=True):
    """A program that shows prompts and records reaction times.

    Args:
        name: its name in tables.
        command: makes the command from an empty folder to write in, and a block.
        read_trials: reads the recorded trials, in order, from that folder: ``response``,
            ``correct``, ``reaction_time_ms``, and ``timing`` if there is one.
        quit_keys: the keys that end it, if it does not end by itself.
        companion: makes a context manager from that folder and the terminal; it is entered before
            the first prompt.
    """

    name: str
    command: Callable[[Path, Block], list[str]]
    read_trials: Callable[[Path], list[Row]]
    quit_keys: tuple[str, ...] = ()
    companion: Callable[[Path, Terminal], AbstractContextManager[object]] = (
        lambda folder, terminal: nullcontext()
    )


class Trial(msgspec.Struct, frozen=True):
    """The error of one recorded reaction time (ms, positive: too long), and its stored timing
    quality.
    """

    error_ms: float
    timing: Row


class Mismatch(RuntimeError):
    """The recorded trials do not match the pressed keys."""


def python_program(name: str, module: str) -> Program:
    """Return a program with the command line and the output file of ``sar_tui.timing.baseline``."""

    def command(folder: Path, block: Block) -> list[str]:
        shortest, longest = FOREPERIOD_MS
        options = ["--prompts", str(block.prompts), "--seed", str(block.seed)]
        waits = ["--shortest-ms", str(QUIET_MS + shortest), "--longest-ms", str(QUIET_MS + longest)]
        return child_process.python(module, str(folder / "trials.jsonl"), *options, *waits)

    def read_trials(folder: Path) -> list[Row]:
        return [json.loads(line) for line in (folder / "trials.jsonl").read_text().splitlines()]

    return Program(name, command, read_trials)


def _sar_tui(folder: Path, block: Block) -> list[str]:
    shortest, longest = FOREPERIOD_MS
    settings = {
        "attempts": 1,
        "prompts_per_attempt": block.prompts,
        "foreperiod_min_ms": shortest,
        "foreperiod_max_ms": longest,
        "quiet_ms": QUIET_MS,
    }
    command = child_process.python(
        "sar_tui", "run", "keyboard", "-p", "BENCH", "--new", "--data", str(folder)
    )
    command += ["--seed", str(block.seed)]
    return command + [
        word for name, value in settings.items() for word in ("--set", f"{name}={value}")
    ]


def _trials_table(folder: Path) -> list[Row]:
    with closing(sqlite3.connect(folder / "sar-tui.db")) as database:
        database.row_factory = sqlite3.Row
        rows = database.execute("SELECT * FROM trials ORDER BY attempt, trial").fetchall()
    return [
        {**row, "correct": bool(row["correct"]), "timing": json.loads(row["timing"])}
        for row in rows
    ]


BASELINE = python_program("bare loop", "sar_tui.timing.baseline")
LEAVE_KEYS = ("ctrl+q", "down", "enter")
"""Keys that leave a session of sar-tui: it asks first."""
SAR_TUI = Program("sar-tui", _sar_tui, _trials_table, LEAVE_KEYS)
MAX_PROMPTS = 200
"""The largest number of prompts in an attempt of sar-tui."""


def run_block(
    program: Program, block: Block, folder: Path, on_press: Callable[[], None] = lambda: None
) -> list[Trial]:
    """Run a program once, respond to its prompts, and compare its record with the true reaction
    times.

    Args:
        program: what to run.
        block: its prompts and seed.
        folder: where to make a temporary folder, on the disk to measure.
        on_press: called after each press.

    Raises:
        Mismatch: the record differs from the pressed keys, or the program failed.
        NoPrompt: the program stopped showing prompts.
    """
    planned = random_answers(block.seed, SHORTEST_MS, LONGEST_MS, ERROR_RATE)

    def answer(number: int, expected: str) -> tuple[float, str]:
        on_press()
        return planned(number, expected)

    with (
        tempfile.TemporaryDirectory(prefix="sar-tui-", dir=folder) as own,
        Terminal(program.command(Path(own), block)) as terminal,
        program.companion(Path(own), terminal),
    ):
        participant = ScriptedParticipant(terminal, answer)
        gc.collect()
        gc.disable()
        try:
            participant.run(block.prompts)
        finally:
            gc.enable()
        if program.quit_keys and not terminal.ended:
            for key in program.quit_keys:
                terminal.confirm(key)
        if terminal.wait(seconds=10) != 0:
            raise Mismatch(
                f"{program.name} ended with an error: {visible(bytes(terminal.output))[-300:]}"
            )
        rows = program.read_trials(Path(own))
    if [row["response"] for row in rows] != [press.key for press in participant.presses]:
        raise Mismatch(
            f"{program.name} recorded {len(rows)} trials, which do not match the pressed keys."
        )
    if [row["correct"] for row in rows] != [
        press.key == press.expected for press in participant.presses
    ]:
        raise Mismatch(f"{program.name} recorded right keys as wrong, or wrong ones as right.")
    return [
        Trial(row["reaction_time_ms"] - press.reaction_time_ms, row.get("timing", {}))
        for row, press in zip(rows, participant.presses, strict=True)
    ]


def take_turns(
    programs: Sequence[Program],
    trials: int,
    blocks: int,
    folder: Path,
    on_press: Callable[[str], None] = lambda name: None,
) -> dict[str, list[Trial]]:
    """Run programs in turns, in a different order in each block, and return the trials by the name
    of the program.

    Raises:
        Mismatch, NoPrompt: as ``run_block``.
    """
    done: dict[str, list[Trial]] = {program.name: [] for program in programs}
    for number in range(blocks):
        prompts = trials * (number + 1) // blocks - trials * number // blocks
        first = number % len(programs)
        for program in (*programs[first:], *programs[:first]):
            name = program.name
            block = Block(prompts, number + 1)
            done[name] += run_block(program, block, folder, partial(on_press, name))
    return done
