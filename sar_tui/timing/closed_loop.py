"""Reaction times that programs record, against those of a scripted participant who knows the truth.

A block is one run of one program in a terminal of its own. The programs take turns, so that whatever the machine
does meanwhile befalls them alike.
"""

import gc
import json
import sqlite3
import sys
import tempfile
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, closing, nullcontext
from pathlib import Path
from typing import Any

import msgspec

from sar_tui.timing.pty import Terminal, visible
from sar_tui.timing.scripted_participant import ScriptedParticipant, random_answers

Row = dict[str, Any]

SHORTEST_MS, LONGEST_MS = 150, 350
"""The planned delays: slower than any anticipation, and quick enough to measure hundreds."""
FOREPERIOD_MS = 40, 80
"""The wait before a prompt."""
QUIET_MS = 20
"""The wait before the wait, where a program has one."""
SLIPS = 0.05
"""The share of planned wrong keys."""


class Block(msgspec.Struct, frozen=True):
    """What one run of a program is asked to do."""

    prompts: int
    seed: int


class Program(msgspec.Struct, frozen=True):
    """A program that shows prompts and records reaction times.

    Args:
        name: what tables call it.
        command: from an empty folder to write in, and a block, to a command.
        recorded: from that folder to the recorded trials in order: ``response``, ``correct``,
            ``reaction_time_ms``, and ``timing`` where there is one.
        leave: the key that ends it, if it does not end by itself.
        beside: from that folder and its terminal to what goes on beside it, begun before the first prompt.
    """

    name: str
    command: Callable[[Path, Block], list[str]]
    recorded: Callable[[Path], list[Row]]
    leave: str | None = None
    beside: Callable[[Path, Terminal], AbstractContextManager[object]] = lambda folder, terminal: nullcontext()


class Trial(msgspec.Struct, frozen=True):
    """One prompt: how wrong the recorded reaction time was (ms, positive: too long), and what was recorded of it."""

    error_ms: float
    timing: Row


class Mismatch(RuntimeError):
    """What was recorded is not what was done."""


def python_program(name: str, module: str, leave: str | None = None) -> Program:
    """A program that takes its orders as ``sar_tui.timing.baseline`` does, and writes the same lines."""

    def command(folder: Path, block: Block) -> list[str]:
        shortest, longest = FOREPERIOD_MS
        orders = ["--prompts", str(block.prompts), "--seed", str(block.seed)]
        waits = ["--shortest-ms", str(QUIET_MS + shortest), "--longest-ms", str(QUIET_MS + longest)]
        return [sys.executable, "-m", module, str(folder / "trials.jsonl"), *orders, *waits]

    def recorded(folder: Path) -> list[Row]:
        return [json.loads(line) for line in (folder / "trials.jsonl").read_text().splitlines()]

    return Program(name, command, recorded, leave)


def _sar_tui(folder: Path, block: Block) -> list[str]:
    shortest, longest = FOREPERIOD_MS
    settings = {
        "attempts": 1,
        "prompts_per_attempt": block.prompts,
        "foreperiod_min_ms": shortest,
        "foreperiod_max_ms": longest,
        "quiet_ms": QUIET_MS,
    }
    command = [sys.executable, "-m", "sar_tui", "run", "keyboard", "-p", "BENCH", "--data", str(folder)]
    command += ["--seed", str(block.seed)]
    return command + [word for name, value in settings.items() for word in ("--set", f"{name}={value}")]


def _trials_table(folder: Path) -> list[Row]:
    with closing(sqlite3.connect(folder / "sar-tui.db")) as database:
        database.row_factory = sqlite3.Row
        rows = database.execute("SELECT * FROM trials ORDER BY attempt, trial").fetchall()
    return [{**row, "correct": bool(row["correct"]), "timing": json.loads(row["timing"])} for row in rows]


BARE = python_program("bare loop", "sar_tui.timing.baseline")
SAR_TUI = Program("sar-tui", _sar_tui, _trials_table, leave="ctrl+q")
MOST_PROMPTS = 200
"""More than this sar-tui does not take in one attempt."""


def run_block(program: Program, block: Block, folder: Path, on_press: Callable[[], None] = lambda: None) -> list[Trial]:
    """Run a program once, answer its prompts, and compare.

    Args:
        program: what to run.
        block: what it is asked.
        folder: a folder to make a temporary one in: on the disk that matters.
        on_press: called after each press.

    Raises:
        Mismatch: a press is not in the record, or not as it was pressed.
        NoPrompt: the program stopped asking.
    """
    plan = random_answers(block.seed, SHORTEST_MS, LONGEST_MS, SLIPS)

    def answer(number: int, expected: str) -> tuple[float, str]:
        on_press()
        return plan(number, expected)

    with (
        tempfile.TemporaryDirectory(prefix="sar-tui-", dir=folder) as own,
        Terminal(program.command(Path(own), block)) as terminal,
        program.beside(Path(own), terminal),
    ):
        participant = ScriptedParticipant(terminal, answer)
        gc.collect()
        gc.disable()
        try:
            participant.run(block.prompts)
        finally:
            gc.enable()
        if program.leave and not terminal.ended:
            terminal.settle()
            terminal.press(program.leave)
        if terminal.wait(seconds=10) != 0:
            raise Mismatch(f"{program.name} ended with an error: {visible(bytes(terminal.output))[-300:]}")
        rows = program.recorded(Path(own))
    if [row["response"] for row in rows] != [press.key for press in participant.presses]:
        raise Mismatch(f"{program.name} recorded {len(rows)} trials, and not the keys that were pressed.")
    if [row["correct"] for row in rows] != [press.key == press.expected for press in participant.presses]:
        raise Mismatch(f"{program.name} took right keys for wrong, or wrong for right.")
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
    """Run programs in turns, each block in another order, until each has done so many trials; by their names.

    Raises:
        Mismatch, NoPrompt: as ``run_block``.
    """
    done: dict[str, list[Trial]] = {program.name: [] for program in programs}
    for number in range(blocks):
        prompts = trials * (number + 1) // blocks - trials * number // blocks
        first = number % len(programs)
        for program in (*programs[first:], *programs[:first]):
            name = program.name
            done[name] += run_block(program, Block(prompts, number + 1), folder, lambda name=name: on_press(name))  # type: ignore[misc]
    return done
