"""The operator: latency from their keys to the participant's screen, and effect on reaction
times.
"""

import contextlib
import json
import re
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from statistics import median, quantiles
from typing import Any

import msgspec

from benchmarks.unattended_panel import panel
from sar_tui.model.units import MS, SECOND
from sar_tui.operator.commands import TOO_SOON
from sar_tui.operator.keymap import KEY_COMMANDS, key_name
from sar_tui.store.database import FILE
from sar_tui.timing.closed_loop import LEAVE_KEYS, SAR_TUI, Block, Mismatch, Row, take_turns
from sar_tui.timing.pty import Terminal, read_together, visible
from sar_tui.timing.verdict import ErrorStatistics, error_statistics

MEDIAN_MS, P99_MS = 20.0, 100.0
"""Limits from an operator's key to the participant's screen."""
MEDIAN_ALLOWANCE_MS, IQR_RATIO = 0.05, 1.5
"""Limits on what an operator adds to the median error of a reaction time, and on the ratio of its
IQR.
"""
BLOCKS = 5
MAX_ATTEMPTS = 200
_TIMEOUT_S = 30.0
_RESPONSE_MS = 120
_ENTER, _PROMPT = "Press Enter", re.compile(rb"Press: ([^\x00-\x20\x7f]+)(?=[\x00-\x20\x7f])")


class NoAnswer(TimeoutError):
    """One of the two programs did not respond as expected."""


def measure(
    acts: int, trials: int, folder: Path, on_act: Callable[[], None], on_press: Callable[[], None]
) -> Any:
    """Measure latencies and reaction times, and check them against the limits.

    Args:
        acts: number of presses of each key, at most 200.
        trials: number of reaction times with an operator, and again without.
        folder: to write to.
        on_act, on_press: called after each.

    Raises:
        NoAnswer, Mismatch, NoPrompt: a program did not respond as expected.
    """
    latencies = _acts(min(acts, MAX_ATTEMPTS), folder / "operator", on_act)
    measured = take_turns((ALONE, OPERATED), trials, BLOCKS, folder, lambda name: on_press())
    errors = {name: [trial.error_ms for trial in done] for name, done in measured.items()}
    figures = {name: error_statistics(of_program) for name, of_program in errors.items()}
    acts_done = {name: _summary(values) for name, values in latencies.items()}
    return {
        "acts": acts_done,
        "acts_ms": {
            name: [round(each, 3) for each in values] for name, values in latencies.items()
        },
        "programs": {
            name: msgspec.structs.asdict(of_program) for name, of_program in figures.items()
        },
        "errors_ms": {
            name: [round(error, 4) for error in of_program] for name, of_program in errors.items()
        },
        "checks": {
            f"operator's key to participant's screen: p50 < {MEDIAN_MS:g} ms, p99 < {P99_MS:g} "
            "ms": all(
                act["median_ms"] < MEDIAN_MS and act["p99_ms"] < P99_MS
                for act in acts_done.values()
            ),
            **_checks(figures[OPERATED.name], figures[ALONE.name]),
        },
    }


def _checks(operated: ErrorStatistics, alone: ErrorStatistics) -> dict[str, bool]:
    added = abs(operated.median_ms) - abs(alone.median_ms)
    return {
        f"an operator adds ≤ {MEDIAN_ALLOWANCE_MS} ms to |median|": added <= MEDIAN_ALLOWANCE_MS,
        f"IQR with an operator ≤ {IQR_RATIO} × without": operated.iqr_ms
        <= IQR_RATIO * alone.iqr_ms,
    }


def _summary(values: list[float]) -> dict[str, float]:
    percentiles = quantiles(values, n=100, method="inclusive")
    return {
        "n": len(values),
        "median_ms": median(values),
        "p99_ms": percentiles[98],
        "max_ms": max(values),
    }


# --- the onset, with and without an operator


@contextlib.contextmanager
def _attended(folder: Path, terminal: Terminal) -> Iterator[None]:
    """Run an unattended panel beside the session from its first screen on."""
    terminal.wait_for(_ENTER)
    log = Log(folder)
    command = [sys.executable, "-m", "benchmarks.unattended_panel", log.session(), str(folder)]
    with subprocess.Popen(command, stdin=subprocess.PIPE) as other:
        try:
            log.wait(terminal, lambda: log.messages("operator/presence"), "the operator to join")
            terminal.settle()
            terminal.confirm()  # the request was read elsewhere
            yield
        finally:
            assert other.stdin
            other.stdin.close()
            try:
                other.wait(5)
            except subprocess.TimeoutExpired:
                other.kill()


def _operated(folder: Path, block: Block) -> list[str]:
    return [*SAR_TUI.command(folder, block), "--operator"]


def _recorded(folder: Path) -> list[Row]:
    states = [changed["state"] for changed in Log(folder).messages("operator/presence")]
    # nobody presses a key of this panel
    if states[:2] != ["joined", "baton"] or set(states[2:]) - {"unproven"}:
        raise Mismatch(
            f"The operator should have been present all the time, but was: {', '.join(states)}."
        )
    return SAR_TUI.read_trials(folder)


ALONE = msgspec.structs.replace(SAR_TUI, name="without an operator")
OPERATED = msgspec.structs.replace(
    SAR_TUI, name="with an operator", command=_operated, read_trials=_recorded, companion=_attended
)


# --- the operator's keys


def _acts(count: int, folder: Path, on_act: Callable[[], None]) -> dict[str, list[float]]:
    """Press each key ``count`` times; return the ms from writing the key until its effect was
    read.
    """
    folder.mkdir()
    settings = {
        "attempts": count,
        "prompts_per_attempt": 1,
        "neutral_band": 5000,
        "difficulty_policy": "fixed",
        "encouragement": "no",
        "rest_every": 0,
        "filler": "never",
        "min_rt_ms": 50,
        "quiet_ms": 20,
        "foreperiod_min_ms": 40,
        "foreperiod_max_ms": 80,
        "operator_feedback": "approve",
        "operator_gesture": "manual",  # so that the session does not wait for gestures
        "operator_time_ms": 120_000,
    }
    command = [
        sys.executable,
        "-m",
        "sar_tui",
        "run",
        "keyboard",
        "-p",
        "BENCH",
        "--data",
        str(folder),
        "--seed",
        "1",
    ]
    command.append("--new")
    command += [
        "--operator",
        *(word for name, value in settings.items() for word in ("--set", f"{name}={value}")),
    ]
    done: dict[str, list[float]] = {
        "approve → the words are seen": [],
        "free text → it is seen": [],
    }
    approve, say = done.values()
    with Terminal(command) as participant:
        participant.wait_for(_ENTER)
        with panel(Log(folder).session(), folder) as operator:
            read_together(participant, operator)
            terminals = _Terminals(participant, operator, Log(folder))
            for number in range(count):
                terminals.answer(number)
                approve.append(terminals.approve())
                on_act()
                say.append(terminals.say(f"Number{number}a, and on we go."))
                on_act()
        for key in LEAVE_KEYS:
            participant.confirm(key)
        participant.wait()
    return done


class _Terminals:
    """Participant's and operator's terminals."""

    def __init__(self, participant: Terminal, operator: Terminal, log: "Log") -> None:
        self._participant, self._operator, self._log = participant, operator, log
        self._last_proposal = ""
        self._entered_at = 0
        log.wait(participant, lambda: log.messages("operator/presence"), "the operator to join")

    def answer(self, attempt: int) -> None:
        """Start the next attempt and answer its prompt."""
        terminal = self._participant
        for _ in range(2 if attempt == 0 else 1):
            self._entered_at = terminal.wait_for(_ENTER, since=self._entered_at)
            terminal.settle(silence_ms=60, seconds=1)
            self._entered_at = len(terminal.output)
            terminal.confirm()
        until = time.monotonic_ns() + round(_TIMEOUT_S * SECOND)
        while not (prompt := _PROMPT.search(terminal.output, self._entered_at)):
            if not terminal.read(until):
                raise NoAnswer("No prompt came.")
        self._read_for(_RESPONSE_MS)
        self._entered_at = len(terminal.output)
        terminal.press(prompt[1].decode())

    def approve(self) -> float:
        """Approve the feedback once it can have been read."""
        log = self._log
        log.wait(
            self._participant,
            lambda: log.proposal_after(self._last_proposal),
            "a proposal that an operator can see",
        )
        proposal = log.proposal_after(self._last_proposal)
        assert proposal
        self._last_proposal, text, seen = proposal
        self._read_for(max(0, seen + TOO_SOON - time.monotonic_ns()) / MS + 20)
        return self._timed(key_of("approve"), " ".join(text.split()[:2]))

    def say(self, text: str) -> float:
        """Make the agent say a text."""
        at = len(self._operator.output)
        self._operator.press(key_of("say"))
        self._operator.wait_for("Say:", since=at)
        for character in text:
            self._operator.press(character)
        self._operator.wait_for(text[-6:], since=at)
        self._read_for(50)
        return self._timed("enter", text.partition(",")[0])

    def _timed(self, key: str, text: str) -> float:
        """Press an operator's key; return the ms until the participant's terminal shows a text."""
        since = len(self._participant.output)
        pressed = self._operator.press(key)
        try:
            self._participant.wait_for(text, since=since, seconds=_TIMEOUT_S)
        except TimeoutError as error:
            raise NoAnswer(
                f"{error} The panel shows: {visible(bytes(self._operator.output))[-300:]!r}"
            ) from None
        return (self._participant.read_at - pressed) / MS

    def _read_for(self, ms: float) -> None:
        until = time.monotonic_ns() + round(ms * MS)
        while self._participant.read(until):
            pass


def key_of(id: str) -> str:
    """Return the key of a command of the panel, by its id."""
    first = next(each for each in KEY_COMMANDS if each.id == id).keys.split(",")[0]
    name = key_name(first)
    return name if len(name) == 1 else first


class Log:
    """Database of a running session."""

    def __init__(self, folder: Path) -> None:
        self._file = f"file:{folder / FILE}?mode=ro"

    def read(self, query: str, *given: object) -> list[tuple[Any, ...]]:
        """Return the rows of a query."""
        with closing(sqlite3.connect(self._file, uri=True)) as database:
            return database.execute(query, given).fetchall()

    def session(self) -> str:
        """Return the id of the only session."""
        ((session,),) = self.read("SELECT id FROM sessions")
        return str(session)

    def messages(self, topic: str) -> list[dict[str, Any]]:
        """Return the messages of a topic."""
        found = self.read("SELECT message FROM events WHERE topic=? ORDER BY seq", topic)
        return [json.loads(message) for (message,) in found]

    def proposal_after(self, id: str) -> tuple[str, str, int] | None:
        """Return the last feedback proposed, unless it is this one or not yet shown: id, text, time
        shown (ns).
        """
        query = (
            "SELECT id, proposed, shown_ns FROM actions WHERE kind='feedback' ORDER BY "
            "proposed_ns DESC LIMIT 1"
        )
        for found, proposed, shown in self.read(query):
            if found != id and shown:
                return found, json.loads(proposed)["text"], shown
        return None

    def wait(self, terminal: Terminal, holds: Callable[[], object], what: str) -> None:
        """Read a terminal until something holds. Raises NoAnswer."""
        until = time.monotonic() + _TIMEOUT_S
        while not holds():
            if time.monotonic() > until:
                raise NoAnswer(f"Timed out waiting for {what}.")
            terminal.read(time.monotonic_ns() + 10 * MS)
