"""A live visit: session at home, the clinic's router and a panel, over lines of different quality.

A proxy between home and router delays and stalls the line. Measured are the latency of an act, from
the operator's key to the participant's screen, and the error of reaction times beside a visitor.
"""

import contextlib
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from statistics import median, quantiles
from typing import Any, NamedTuple

import msgspec

from benchmarks.operator import (
    BLOCKS,
    IQR_RATIO,
    MEDIAN_ALLOWANCE_MS,
    Log,
    NoAnswer,
    key_of,
)
from sar_tui.link.authority import Authority
from sar_tui.link.invitation import write
from sar_tui.link.visits import keep_home
from sar_tui.link.zenoh_settings import Endpoint, Guest
from sar_tui.model.units import MS
from sar_tui.timing.closed_loop import (
    LEAVE_KEYS,
    SAR_TUI,
    Block,
    Mismatch,
    Program,
    Row,
    take_turns,
)
from sar_tui.timing.pty import Terminal, read_together
from sar_tui.timing.verdict import error_statistics


class Line(NamedTuple):
    """A line from the home: added round trip, and stalls (ms)."""

    name: str
    round_trip_ms: int
    stall_ms: int = 0
    every_ms: int = 5000


LINES = (
    Line("no delay", 0),
    Line("50 ms", 50),
    Line("200 ms", 200),
    Line("1 s stalls", 0, stall_ms=1000),
)
"""The stall is the retransmission time-out of a new connection (RFC 6298), every 5 s."""
ALONE = msgspec.structs.replace(SAR_TUI, name="without a visitor")
_ASKED, _ENTER, _PRESENCE = "not today", "Press Enter", "operator/presence"
_IN_CONTROL = "You have control"
_BETWEEN_ACTS_MS = 330
_LEAST_OF_BLOCK = 5
"""Reaction times in a block, so that few of them do not take many sessions."""
_TIMEOUT_S = 30.0


def measure(
    lines: Sequence[Line],
    acts: int,
    trials: int,
    folder: Path,
    on_act: Callable[[], None],
    on_press: Callable[[], None],
) -> Any:
    """Measure latencies and reaction times over each line, and check the reaction times.

    Args:
        lines: those to measure.
        acts: number of acts over each line.
        trials: number of reaction times with a visitor over each line, and without one.
        folder: to write to.
        on_act, on_press: called after each.

    Raises:
        NoAnswer, Mismatch, NoPrompt: a program did not respond as expected.
    """
    with _Clinic(folder / "clinic", lines) as clinic:
        latencies = {
            line.name: _acts(acts, clinic, place, folder / f"acts-{number}", on_act)
            for number, (line, place) in enumerate(clinic.lines.items())
        }
        visited = [_visited(clinic, line, place) for line, place in clinic.lines.items()]
        programs = (ALONE, *visited)
        blocks = min(BLOCKS, max(1, trials // _LEAST_OF_BLOCK))
        measured = take_turns(programs, trials, blocks, folder, lambda name: on_press())
    errors = {name: [trial.error_ms for trial in done] for name, done in measured.items()}
    figures = {name: error_statistics(of_program) for name, of_program in errors.items()}
    alone = figures[ALONE.name]
    added = [abs(figures[each.name].median_ms) - abs(alone.median_ms) for each in visited]
    return {
        "acts": {name: _summary(values) for name, values in latencies.items()},
        "acts_ms": {name: [round(each, 3) for each in of] for name, of in latencies.items()},
        "programs": {name: msgspec.structs.asdict(each) for name, each in figures.items()},
        "errors_ms": {name: [round(each, 4) for each in of] for name, of in errors.items()},
        "checks": {
            f"a visitor adds ≤ {MEDIAN_ALLOWANCE_MS} ms to |median|, over any line": max(added)
            <= MEDIAN_ALLOWANCE_MS,
            f"IQR with a visitor ≤ {IQR_RATIO} × without, over any line": all(
                figures[each.name].iqr_ms <= IQR_RATIO * alone.iqr_ms for each in visited
            ),
        },
    }


def _summary(values: list[float]) -> dict[str, float]:
    percentiles = quantiles(values, n=100, method="inclusive")
    return {
        "n": len(values),
        "median_ms": median(values),
        "p95_ms": percentiles[94],
        "max_ms": max(values),
    }


# --- the clinic


class _Clinic(contextlib.ExitStack):
    """The router, the lines to it, and the invitations of a home over each line and of an operator.

    Attributes:
        operator: the operator's invitation.
        lines: the home's invitation over each line, by the line.
    """

    def __init__(self, folder: Path, lines: Sequence[Line]) -> None:
        super().__init__()
        router = _free_port()
        authority = Authority.open_or_create(folder)
        self.operator = folder / "operator.sar-link"
        here = Endpoint("127.0.0.1", router)
        write(authority.invite(Guest("bench", "operator"), [here], 1, router=True), self.operator)
        self.lines: dict[Line, Path] = {}
        commands = []
        for number, line in enumerate(lines):
            port, file = _free_port(), folder / f"home-{number}.sar-link"
            there = [Endpoint("127.0.0.1", port)]
            write(authority.invite(Guest(f"home{number}", "home"), there, 1), file)
            self.lines[line] = file
            shape = line.round_trip_ms, line.stall_ms, line.every_ms
            commands.append(["benchmarks.shaping_proxy", *map(str, (port, router, *shape))])
        listen = ["link", "router", "--listen", f"127.0.0.1:{router}", "--data", str(folder)]
        commands.append(["sar_tui", *listen])
        self._commands = commands

    def __enter__(self) -> "_Clinic":
        for command in self._commands:
            child = subprocess.Popen(
                [sys.executable, "-m", *command],
                stdin=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            )
            self.callback(child.wait, 10)
            self.callback(child.terminate)
        return self


def _free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def _home_of(file: Path) -> str:
    return file.stem.replace("home-", "home")


# --- reaction times beside a visitor


def _visited(clinic: _Clinic, line: Line, invitation: Path) -> Program:
    """Return the program of a session that is visited over a line."""

    def command(folder: Path, block: Block) -> list[str]:
        keep_home(folder, invitation)
        return SAR_TUI.command(folder, block)

    @contextlib.contextmanager
    def visited(folder: Path, terminal: Terminal) -> Iterator[None]:
        words = ["benchmarks.unattended_panel", _home_of(invitation), str(folder)]
        panel = [sys.executable, "-m", *words, str(clinic.operator)]
        with subprocess.Popen(panel, stdin=subprocess.PIPE) as other:
            try:
                _agree(terminal, Log(folder))
                yield
            finally:
                assert other.stdin
                other.stdin.close()
                try:
                    other.wait(5)
                except subprocess.TimeoutExpired:
                    other.kill()

    return msgspec.structs.replace(
        SAR_TUI,
        name=f"visited, {line.name}",
        command=command,
        read_trials=_recorded,
        companion=visited,
    )


def _agree(terminal: Terminal, log: Log) -> None:
    """Agree to the visit, and go on to the first attempt."""
    asked = terminal.wait_for(_ASKED)
    terminal.settle()
    terminal.confirm()
    log.wait(terminal, lambda: log.messages(_PRESENCE), "the visitor to join")
    terminal.wait_for(_ENTER, since=asked)
    terminal.settle()
    terminal.confirm()


def _recorded(folder: Path) -> list[Row]:
    states = [changed["state"] for changed in Log(folder).messages(_PRESENCE)]
    if "lost" in states or states[:1] != ["joined"]:
        raise Mismatch(f"The visitor should have been there all the time: {', '.join(states)}.")
    return SAR_TUI.read_trials(folder)


# --- the visitor's acts


def _acts(
    count: int, clinic: _Clinic, invitation: Path, folder: Path, on_act: Callable[[], None]
) -> list[float]:
    """Let the visitor say ``count`` texts; return the ms from their key until each was read at
    home.
    """
    folder.mkdir()
    keep_home(folder, invitation)
    python = [sys.executable, "-m", "sar_tui"]
    session = [*python, "run", "keyboard", "-p", "BENCH", "--data", str(folder), "--new"]
    session += ["--seed", "1", "--set", "filler=never"]
    words = ["wizard", _home_of(invitation), "--link", str(clinic.operator)]
    panel = [*python, *words, "--data", str(folder / "panel")]
    log, done = Log(folder), []
    with Terminal(session) as participant:
        participant.wait_for(_ENTER)
        with Terminal(panel, columns=100, rows=30) as operator:
            read_together(participant, operator)
            asked = participant.wait_for(_ASKED)
            participant.settle()
            participant.confirm()
            log.wait(participant, lambda: log.messages(_PRESENCE), "the visitor to join")
            participant.wait_for(_ENTER, since=asked)
            operator.wait_for(_IN_CONTROL)
            for number in range(count):
                done.append(_say(participant, operator, f"Number{number}a, and on we go."))
                on_act()
                _read_for(participant, _BETWEEN_ACTS_MS)  # so that stalls meet some of them
        for key in LEAVE_KEYS:
            participant.confirm(key)
        participant.wait()
    return done


def _say(participant: Terminal, operator: Terminal, text: str) -> float:
    """Type a text at the panel, press Enter, and return the ms until the participant sees it."""
    at = len(operator.output)
    operator.press(key_of("say"))
    operator.wait_for("Say:", since=at)
    for character in text:
        operator.press(character)
    operator.wait_for(text[-6:], since=at)
    _read_for(participant, 50)
    since = len(participant.output)
    pressed = operator.press("enter")
    said = text.partition(",")[0]
    try:
        participant.wait_for(said, since=since, seconds=_TIMEOUT_S)
    except TimeoutError as error:
        raise NoAnswer(str(error)) from None
    return (participant.read_at - pressed) / MS


def _read_for(terminal: Terminal, ms: float) -> None:
    until = time.monotonic_ns() + round(ms * MS)
    while terminal.read(until):
        pass
