"""The agent: time from the stop key to stillness, and effect on the timing of prompts."""

import json
import sqlite3
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import msgspec

from benchmarks.silent_app import MOTOR, PLAYER
from sar_tui.store.database import FILE
from sar_tui.timing.closed_loop import (
    LEAVE_KEYS,
    SAR_TUI,
    Block,
    Mismatch,
    Program,
    Row,
    take_turns,
)
from sar_tui.timing.pty import Terminal
from sar_tui.timing.scripted_participant import ScriptedParticipant, random_answers
from sar_tui.timing.verdict import ErrorStatistics, error_statistics

WORST_STOP_MS = 100.0
MEDIAN_ALLOWANCE_MS, IQR_RATIO = 0.2, 1.5
"""Limits for the agent's effect on reaction-time errors: added to the median, and ratio of the
IQRs.
"""
BLOCKS = 5
PER_ATTEMPT = 10
MOST_ATTEMPTS = 200
_F2 = b"\x1bOQ"
_UNDER_WAY = {("speech", "say"), ("screen", "gesture"), ("servo", "gesture")}
_PATIENCE_S = 30.0
_OVER = ("done", "aborted", "failed")


class NotStopped(RuntimeError):
    """The agent did not stop as it should."""


class Stop(NamedTuple):
    """One press of the stop key: ms from the key to each report of stillness, and to each record
    that shows it.
    """

    reported: dict[str, float]
    observed: dict[str, float]

    @property
    def worst(self) -> float:
        return max(*self.reported.values(), *self.observed.values())


def measure(
    stops: int, trials: int, folder: Path, on_stop: Callable[[], None], on_press: Callable[[], None]
) -> dict[str, Any]:
    """Measure stops and reaction times, and check them against the limits.

    Args:
        stops: number of presses of the stop key.
        trials: number of reaction times with the agent, and again without.
        folder: on the disk to write to.
        on_stop, on_press: called after each.

    Raises:
        NotStopped, Mismatch, NoPrompt: the agent or the program did not behave as expected.
    """
    stopped = _stops(stops, folder / "stops", on_stop)
    measured = take_turns((SILENT, SPEAKING), trials, BLOCKS, folder, lambda name: on_press())
    errors = {name: [trial.error_ms for trial in done] for name, done in measured.items()}
    figures = {name: error_statistics(of_program) for name, of_program in errors.items()}
    return {
        "stops": {name: _summary(values) for name, values in _by_name(stopped).items()},
        "stops_ms": [stop.reported | stop.observed for stop in stopped],
        "programs": {
            name: msgspec.structs.asdict(of_program) for name, of_program in figures.items()
        },
        "errors_ms": {
            name: [round(error, 4) for error in of_program] for name, of_program in errors.items()
        },
        "checks": {
            f"everything still within {WORST_STOP_MS:g} ms of the key": max(
                s.worst for s in stopped
            )
            < WORST_STOP_MS,
            **_checks(figures[SPEAKING.name], figures[SILENT.name]),
        },
    }


def _checks(speaking: ErrorStatistics, silent: ErrorStatistics) -> dict[str, bool]:
    added = abs(speaking.median_ms) - abs(silent.median_ms)
    return {
        f"the agent adds ≤ {MEDIAN_ALLOWANCE_MS} ms to |median|": added <= MEDIAN_ALLOWANCE_MS,
        f"IQR with the agent ≤ {IQR_RATIO} × without": speaking.iqr_ms <= IQR_RATIO * silent.iqr_ms,
    }


# --- the onset, with and without the agent


def _program(name: str, outputs: str) -> Program:
    """Return sar-tui in attempts of ten prompts, with feedback on each through some outputs."""

    def command(folder: Path, block: Block) -> list[str]:
        attempts = -(-block.prompts // PER_ATTEMPT)
        per_attempt = -(-block.prompts // attempts)
        ordered = SAR_TUI.command(folder, block)
        settings = [
            f"outputs={outputs}",
            f"attempts={attempts}",
            f"prompts_per_attempt={per_attempt}",
        ]
        said = [word for setting in settings for word in ("--set", setting)]
        return [
            sys.executable,
            "-m",
            "benchmarks.silent_app",
            str(folder),
            *ordered[ordered.index("run") :],
            *said,
        ]

    def recorded(folder: Path) -> list[Row]:
        rows = SAR_TUI.read_trials(folder)
        _check_speech(folder, outputs, len(rows))
        return rows

    return Program(name, command, recorded, SAR_TUI.quit_keys)


def _check_speech(folder: Path, outputs: str, trials: int) -> None:
    """Raise Mismatch unless the outputs in use gave a tone with every prompt, and speech."""
    reports = _Log(folder).read("SELECT message FROM events WHERE topic='output/report'")
    done = [report["deed"] for report in reports if report["state"] == "done"]
    if "tones" in outputs and done.count("tone") < trials:
        raise Mismatch(f"Of {trials} prompts only {done.count('tone')} had their tone.")
    if ("speech" in outputs) != ("say" in done):
        raise Mismatch(
            f"With the outputs {outputs or 'none'}, speech was "
            f"{'' if 'say' in done else 'not '}heard."
        )


SILENT = _program("without the agent", "")
SPEAKING = _program("face, speech and tones", "screen,speech,tones")


# --- the stop key


def _stops(count: int, folder: Path, on_stop: Callable[[], None]) -> list[Stop]:
    """Press the stop key during feedback, while the agent speaks and moves."""
    folder.mkdir()
    settings = {
        "attempts": MOST_ATTEMPTS,
        "prompts_per_attempt": 1,
        "threshold": 5000,
        "difficulty_policy": "fixed",
        "encouragement": "no",
        "rest_every": 0,
        "quiet_ms": 20,
        "foreperiod_min_ms": 40,
        "foreperiod_max_ms": 80,
    }
    command = [
        sys.executable,
        "-m",
        "benchmarks.silent_app",
        str(folder),
        "run",
        "keyboard",
        "-p",
        "BENCH",
        "--new",
    ]
    command += ["--data", str(folder), "--seed", "1", "--outputs", "screen,speech,servo"]
    command += [word for name, value in settings.items() for word in ("--set", f"{name}={value}")]
    stopped: list[Stop] = []
    with Terminal(command) as terminal:
        participant = ScriptedParticipant(terminal, random_answers(1, 150, 350))
        log = _Log(folder)
        for attempt in range(1, MOST_ATTEMPTS + 1):
            if attempt > 1:
                terminal.confirm()  # the request was not read by ``participant``
            participant.run(attempt)
            if log.wait_until_acting(terminal, attempt):
                stopped.append(_stop(terminal, log, folder))
                on_stop()
            if len(stopped) == count:
                break
        for key in LEAVE_KEYS:
            terminal.confirm(key)
        terminal.wait()
    if len(stopped) < count:
        raise NotStopped(f"The agent spoke and moved at once only {len(stopped)} times of {count}.")
    return stopped


def _stop(terminal: Terminal, log: "_Log", folder: Path) -> Stop:
    """Press the key, and wait for the outputs' reports and for the records."""
    pressed = terminal.write(_F2)
    terminal.settle(silence_ms=300, seconds=3)
    painted = terminal.read_at
    reported = log.wait_for_stops(terminal, pressed)
    return Stop(
        {output: (at - pressed) / 1e6 for output, at in reported.items()},
        {
            "the player stopped": (_first(folder / PLAYER, pressed, -1) - pressed) / 1e6,
            "the motor was released": (_first(folder / MOTOR, pressed, 0) - pressed) / 1e6,
            "the screen stood still": (painted - pressed) / 1e6,
        },
    )


def _first(file: Path, since: int, column: int) -> int:
    """Return the first time after ``since`` in a record. Raises NotStopped."""
    deadline = time.monotonic() + _PATIENCE_S
    while time.monotonic() < deadline:
        lines = file.read_text().splitlines() if file.exists() else []
        for line in lines:
            if (at := int(line.split()[column])) >= since:
                return at
        time.sleep(0.02)
    raise NotStopped(f"{file.stem} has not stopped.")


class _Log:
    """The session's messages so far, read from its database."""

    def __init__(self, folder: Path) -> None:
        self._file = f"file:{folder / FILE}?mode=ro"

    def read(self, query: str, *given: object) -> list[dict[str, Any]]:
        """Return the messages that a query finds."""
        with closing(sqlite3.connect(self._file, uri=True)) as database:
            return [json.loads(message) for (message,) in database.execute(query, given)]

    def wait_until_acting(self, terminal: Terminal, attempt: int) -> bool:
        """Wait until all parts of the feedback on an attempt are under way; False if one is over by
        then.
        """
        deadline = time.monotonic() + _PATIENCE_S
        query = "SELECT message FROM events WHERE topic='arbiter/action' ORDER BY seq DESC LIMIT 1"
        while time.monotonic() < deadline:
            terminal.read(time.monotonic_ns() + 10_000_000)
            said = self.read(query)
            if said and (said[0]["kind"], said[0]["attempt"]) == ("feedback", attempt):
                reports = self.read(
                    "SELECT message FROM events WHERE topic='output/report' AND "
                    "json_extract(message, '$.action')=?",
                    said[0]["id"],
                )
                states = {(report["output"], report["deed"]): report["state"] for report in reports}
                found = [states.get(part, "queued") for part in _UNDER_WAY]
                if "failed" in found:
                    raise NotStopped(
                        next(report["detail"] for report in reports if report["state"] == "failed")
                    )
                if any(state in _OVER for state in found):
                    return False
                if all(state == "started" for state in found):
                    return True
        raise NotStopped(f"The agent gave no feedback on attempt {attempt}.")

    def wait_for_stops(self, terminal: Terminal, since: int) -> dict[str, int]:
        """Return the time at which each output reported its stop after ``since``; raise NotStopped
        if one did not.
        """
        outputs = {output for output, _ in _UNDER_WAY}
        deadline = time.monotonic() + _PATIENCE_S
        while time.monotonic() < deadline:
            terminal.read(time.monotonic_ns() + 10_000_000)
            stops = self.read("SELECT message FROM events WHERE topic='output/stopped'")
            reports = {stop["output"]: stop for stop in stops if stop["asked"] >= since}
            if set(reports) == outputs:
                if details := [stop["detail"] for stop in reports.values() if stop.get("detail")]:
                    raise NotStopped(details[0])
                return {output: stop["at"] for output, stop in reports.items()}
        raise NotStopped("Not every output reported its stop.")


def _by_name(stops: Sequence[Stop]) -> dict[str, list[float]]:
    found = [
        {f"{output} reported it": ms for output, ms in stop.reported.items()} | stop.observed
        for stop in stops
    ]
    return {name: [stop[name] for stop in found] for name in found[0]}


def _summary(values: Sequence[float]) -> dict[str, float]:
    return {"n": len(values), "median_ms": median(values), "max_ms": max(values)}
