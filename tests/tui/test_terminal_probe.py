"""Proof that a terminal is there."""

import threading

import pytest
from textual import events
from textual._xterm_parser import XTermParser

from sar_tui.link.peer import TerminalState
from sar_tui.model.units import MS, SECOND
from sar_tui.tui import terminal_probe
from sar_tui.tui.terminal_probe import INTERVAL_S, MAX_UNANSWERED, QUERY, TerminalProbe, is_relayed

INTERVAL = round(INTERVAL_S * SECOND)


class Bench:
    """Probe with a clock that is moved by hand."""

    def __init__(self) -> None:
        self.now = 1000 * SECOND
        self.asked: list[int] = []
        self.probe = TerminalProbe(lambda _: self.asked.append(self.now), lambda: self.now)

    def pass_time(self, seconds: float, *, answers: bool) -> None:
        """Ask as the panel does, for some seconds."""
        until = self.now + round(seconds * SECOND)
        while self.now < until:
            self.now += INTERVAL
            asked = len(self.asked)
            self.probe.ask()
            if answers and len(self.asked) > asked:
                self.probe.answered()


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_before_its_first_answer_a_terminal_proves_nothing(bench: Bench) -> None:
    bench.pass_time(60, answers=False)
    assert bench.probe.state() == TerminalState(None)


def test_its_silence_is_counted_from_its_last_answer(bench: Bench) -> None:
    bench.pass_time(3, answers=True)
    assert bench.probe.state() == TerminalState(0)
    bench.now += 700 * MS
    assert bench.probe.state() == TerminalState(700 * MS)


def test_a_terminal_that_takes_nothing_is_not_filled_with_questions(bench: Bench) -> None:
    bench.pass_time(3, answers=True)
    asked = len(bench.asked)
    bench.pass_time(60, answers=False)
    assert MAX_UNANSWERED < len(bench.asked) - asked <= MAX_UNANSWERED + 60


def test_over_a_slow_line_several_questions_are_on_their_way(bench: Bench) -> None:
    for _ in range(40):
        bench.now += INTERVAL
        bench.probe.ask()
        if len(bench.asked) > 4:
            bench.probe.answered()
    assert len(bench.asked) == 40


def test_a_silence_that_is_over_is_told_once(bench: Bench) -> None:
    bench.pass_time(3, answers=True)
    bench.probe.take_longest_silence()
    bench.now += 34 * SECOND
    bench.probe.answered()
    bench.pass_time(1, answers=True)
    assert bench.probe.take_longest_silence() == 34 * SECOND
    assert bench.probe.take_longest_silence() == 0


def test_at_the_end_it_waits_for_the_answers_that_are_on_their_way(bench: Bench) -> None:
    bench.pass_time(1, answers=True)
    bench.probe.ask()
    bench.probe.ask()
    waiting = threading.Thread(target=bench.probe.await_answers)
    waiting.start()
    bench.probe.answered()
    bench.probe.answered()
    waiting.join()
    assert bench.probe.state() == TerminalState(0)


def test_an_answer_is_no_key() -> None:
    (answer,) = XTermParser().feed("\x1b[24;80R")
    assert isinstance(answer, events.CursorPosition)
    assert QUERY == "\x1b[6n"


@pytest.mark.parametrize("variable", ["TMUX", "STY", "ZELLIJ"])
def test_a_multiplexer_answers_too(monkeypatch: pytest.MonkeyPatch, variable: str) -> None:
    for name in ("TMUX", "STY", "ZELLIJ"):
        monkeypatch.delenv(name, raising=False)
    assert not is_relayed()
    monkeypatch.setenv(variable, "1")
    assert is_relayed()
    bench = Bench()
    probe = TerminalProbe(lambda _: None, lambda: bench.now, is_relayed)
    probe.ask()
    probe.answered()
    assert probe.state() == TerminalState(0, is_relayed=True)


def test_mosh_is_found_among_the_ancestors(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("TMUX", "STY", "ZELLIJ"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(terminal_probe, "_ancestors", lambda: [b"python3", b"bash", b"mosh-server"])
    assert is_relayed()
