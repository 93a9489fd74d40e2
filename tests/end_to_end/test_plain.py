"""Sessions in plain lines, read as text alone in a real pseudo-terminal."""

import json
import re
import signal
import sys
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.store import participants, programmes
from sar_tui.store.database import connect
from sar_tui.store.passphrase import Passphrase
from sar_tui.store.programmes import Programme
from sar_tui.timing.pty import Terminal
from tests.end_to_end.participant_terminal import (
    QUICK,
    command,
    only_session,
    replays_identically,
    rows,
    run_command,
)
from tests.outputs.markers.receivers import udp_receiver

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")


def lines(terminal: Terminal) -> list[str]:
    """Return the lines that the program has appended, and find that it did nothing else."""
    text = terminal.output.decode()
    assert not set(text) & set("\x1b\x08\x07"), "neither cursor nor colour nor sound"
    assert "\r" not in text.replace("\r\n", ""), "no line is written again"
    assert not re.search("[\u2500-\u259f\u2800-\u28ff]", text), "no boxes, blocks and spinners"
    return text.split("\r\n")[:-1]


def answer(terminal: Terminal, *asked: tuple[str, Sequence[str]]) -> None:
    """Press keys at each of these lines."""
    since = 0
    for wanted, keys in asked:
        since = terminal.wait_for(wanted, since=since)
        terminal.settle()
        for key in keys:
            terminal.confirm(key)


def do_attempt(
    terminal: Terminal, prompts: int, until: str = "Press Enter to see how it went."
) -> None:
    """Press the key that each line asks for."""
    since = 0
    for _ in range(prompts):
        since = terminal.wait_for("Press: ", since=since)
        terminal.read(0)
        terminal.press(chr(terminal.output[since]))
    terminal.wait_for(until)


def to_the_attempt(terminal: Terminal) -> None:
    """Continue from the instructions to the first attempt."""
    terminal.wait_for("Press Enter to go on.")
    terminal.settle(silence_ms=600)
    terminal.confirm()
    terminal.wait_for("Press Enter to begin")
    terminal.settle(silence_ms=600)
    terminal.confirm()


def in_order(found: Sequence[str], *wanted: str) -> bool:
    """Return True if lines come in this order, with any others between them."""
    rest = iter(found)
    return all(line in rest for line in wanted)


def plain(data: Path, **parameters: object) -> list[str]:
    settings = {"attempts": 1, "prompts_per_attempt": 3, **parameters}
    return [*run_command(data, **settings), "--plain"]


@pytest.mark.slow
def test_a_whole_session_is_read_as_lines_and_recorded_like_any_other(data: Path) -> None:
    with Terminal(plain(data, ask_wellbeing="yes", questions="remark")) as terminal:
        answer(
            terminal,
            ("How much pain do you have now?", ("5", "enter")),
            ("Where does it hurt?", ("backspace",)),
            ("Chosen: 5.", ("2", "enter")),
            ("Where does it hurt?", ("3", "enter")),
            ("How tired are you now?", ("tab",)),
        )
        to_the_attempt(terminal)
        do_attempt(terminal, 3, until="Is there anything you would like to tell us?")
        terminal.settle(silence_ms=600)
        terminal.confirm("A")
        terminal.write(b" colt")
        terminal.wait_for("A colt")
        terminal.write(b"\x7fd \xc3\xa9te\r")
        terminal.wait_for("Press Enter to see how it went.")
        terminal.settle(silence_ms=600)
        terminal.confirm()
        end = terminal.wait_for("Press Enter to finish.")
        terminal.settle(silence_ms=600)
        terminal.confirm()
        for question in ("How much pain do you have now?", "How tired are you now?"):
            end = terminal.wait_for(question, since=end)
            terminal.settle()
            terminal.confirm("tab")
        assert terminal.wait() == 0
        found = lines(terminal)
    assert in_order(
        found,
        "How much pain do you have now?",
        "10: worst pain imaginable.",
        "Where does it hurt?",
        "You said: 5.",
        "Chosen: 5.",
        "Chosen: 2.",
        "Where does it hurt?",
        "Chosen: 3, left arm.",
        "Welcome",
        "Press that key as fast as you can, and then wait for the next one.",
        "Attempt 1 of 1",
        "Type your answer, then press Enter.",
        "A colt",
        "A cold éte",
        "All done",
        "Well done",
        "Press Enter to finish.",
    )
    asked = [line.removeprefix("Press: ") for line in found if line.startswith("Press: ")]
    recorded = rows(data, "SELECT stimulus, response, correct FROM trials ORDER BY trial")
    assert recorded == [(key, key, 1) for key in asked[-3:]]
    (machine,) = rows(data, "SELECT machine FROM runs")
    assert json.loads(machine[0])["terminal"] == "plain, xterm-256color"
    for (timing,) in rows(data, "SELECT timing FROM trials"):
        assert json.loads(timing)["onset_source"] == "flush"
    assert replays_identically(data)


@pytest.mark.slow
def test_an_answer_is_taken_back_in_lines(data: Path) -> None:
    with Terminal(plain(data, prompts_per_attempt=1, questions="exertion")) as terminal:
        to_the_attempt(terminal)
        do_attempt(terminal, 1, until="How hard was that for you?")
        terminal.settle(silence_ms=600)
        terminal.confirm("7")
        terminal.confirm()
        told = terminal.wait_for("Backspace: Take back.")
        terminal.settle(silence_ms=600)
        terminal.confirm("backspace")
        terminal.wait_for("How hard was that for you?", since=told)
        terminal.settle(silence_ms=600)
        terminal.confirm("2")
        terminal.confirm()
        terminal.wait_for("Press Enter to see how it went.", since=told)
        terminal.settle(silence_ms=600)
        terminal.confirm()
        terminal.wait_for("Press Enter to finish.")
        terminal.settle(silence_ms=600)
        terminal.confirm()
        assert terminal.wait() == 0
    assert rows(data, "SELECT answer FROM answers") == [("2",)]
    assert replays_identically(data)


@pytest.mark.slow
def test_escape_opens_a_menu_of_numbers_and_the_session_is_resumed_after_a_signal(
    data: Path,
) -> None:
    with Terminal(plain(data)) as terminal:
        before = terminal.modes()
        to_the_attempt(terminal)
        terminal.wait_for("Press: ")
        terminal.press("escape")
        terminal.wait_for("2: I am tired.")
        terminal.settle()
        terminal.confirm("2")
        terminal.confirm()
        terminal.wait_for("Have a rest")
        terminal.settle()
        assert terminal.modes() != before
        terminal.kill(signal.SIGTERM)
        assert terminal.wait() == 128 + signal.SIGTERM
        assert terminal.modes() == before, "the terminal is as it was"
        assert "Resume it: sar-tui resume" in lines(terminal)[-1]
    again = command("resume", only_session(data), "--plain", "--data", str(data))
    with Terminal(again) as terminal:
        terminal.wait_for("Press the number, then Enter.")
        terminal.settle(silence_ms=600)
        terminal.confirm("1")
        terminal.confirm()
        do_attempt(terminal, 3)
        assert in_order(lines(terminal), "Have a rest", "Chosen: 1.", "All done")
        assert lines(terminal).count("Have a rest") == 1
        terminal.press("ctrl+c")
        assert terminal.wait() == 130
    assert rows(data, "SELECT count(*) FROM trials") == [(3,)]


@pytest.mark.slow
def test_keys_that_are_held_or_come_too_soon_do_not_answer_the_advice_not_to_train(
    data: Path,
) -> None:
    with Terminal(plain(data, ask_wellbeing="yes")) as terminal:
        answer(terminal, ("How much pain do you have now?", ("9", "enter")))
        answer(terminal, ("Where does it hurt?", ("1", "enter")))
        terminal.wait_for("How tired are you now?")
        terminal.settle()
        terminal.confirm("0")
        for _ in range(12):
            terminal.press("enter")
            terminal.settle(silence_ms=40)
        terminal.wait_for("Press Enter to stop for today.")
        terminal.settle()
        terminal.confirm("g")
        terminal.wait_for("Welcome")
        terminal.hang_up()
    kept = rows(data, "SELECT content FROM records WHERE kind='pain' ORDER BY rowid")
    assert json.loads(kept[-1][0])["advice"] == "went on"


@pytest.mark.slow
def test_operators_and_markers_are_served_as_on_a_screen(data: Path) -> None:
    with udp_receiver() as receiver:
        words = [*plain(data), "--operator", "--markers", receiver.address]
        with Terminal(words) as terminal:
            to_the_attempt(terminal)
            do_attempt(terminal, 3)
            terminal.settle(silence_ms=600)
            terminal.confirm()
            terminal.wait_for("Press Enter to finish.")
            terminal.settle(silence_ms=600)
            terminal.confirm()
            assert terminal.wait() == 0
            assert "What operators did: sar-tui report wizard" in lines(terminal)[-1]
        marked = [marker["event"] for marker in receiver.until("session_end")]
    assert marked.count("prompt_onset") == 3


@pytest.mark.slow
def test_the_environment_variable_of_other_programs_asks_for_lines_too(data: Path) -> None:
    with Terminal(run_command(data), environment={"ACCESSIBLE": "1"}) as terminal:
        terminal.wait_for("Press Enter to go on.")
        assert "Welcome" in lines(terminal)
        terminal.confirm("f1")
        terminal.wait_for("To pause, press Escape; nothing is lost.")
        terminal.hang_up()


@pytest.mark.slow
@pytest.mark.parametrize("task", ["posner", "pairs"])
def test_a_task_that_lines_cannot_tell_is_refused_in_a_sentence(data: Path, task: str) -> None:
    people = ["-p", "P01"] + ["-p", "P02"] * (task == "pairs")
    words = command("run", task, *people, "--plain", "--data", str(data))
    with Terminal([*words, *([] if "--new" in words else ["--new"])]) as terminal:
        assert terminal.wait() == 2
        assert f"The task {task} cannot be told in one line" in " ".join(lines(terminal))


def alone(data: Path, **settings: object) -> list[str]:
    """Give a participant an exercise, and return the command with which they train alone."""
    with closing(connect(data)) as database:
        participants.add(database, "P01")
        programme = Programme({"attempts": 1, **QUICK, **settings})
        programmes.save(database, "P01", "keyboard", programme, after=0)
    Passphrase(data).set("quiet morning")
    return command("--patient", "P01", "--plain", "--data", str(data))


def test_a_participant_trains_alone_in_lines(data: Path) -> None:
    with Terminal(alone(data)) as terminal:
        terminal.wait_for("Press Enter to start.")
        terminal.settle()
        terminal.press("ctrl+c")
        terminal.kill(signal.SIGINT)
        terminal.confirm()
        terminal.wait_for("Press Enter to go on.")
        terminal.press("ctrl+c")
        terminal.wait_for("1: Go on.")
        terminal.press("f12")
        terminal.wait_for("Please enter the passphrase.")
        terminal.write(b"quiet morning\r")
        assert terminal.wait() == 0
        assert "quiet" not in " ".join(lines(terminal))


@pytest.mark.slow
def test_a_participant_in_pain_who_trains_alone_is_told_to_rest(data: Path) -> None:
    with Terminal(alone(data, ask_wellbeing=True)) as terminal:
        answer(
            terminal,
            ("Press Enter to start.", ("enter",)),
            ("How much pain do you have now?", ("9", "enter")),
            ("Where does it hurt?", ("1", "enter")),
            ("How tired are you now?", ("0", "enter")),
            ("Press Enter to stop for today.", ("enter",)),
        )
        terminal.wait_for("You can rest now.")
        since = terminal.wait_for("Please tell them yourself.")
        terminal.confirm("f12")
        since = terminal.wait_for("Please enter the passphrase.", since=since)
        terminal.write(b"loud morning\r")
        since = terminal.wait_for("That is not the passphrase.", since=since)
        terminal.confirm("f12")
        since = terminal.wait_for("Please enter the passphrase.", since=since)
        terminal.press("escape")
        terminal.wait_for("Please tell them yourself.", since=since)
        terminal.confirm("f12")
        terminal.wait_for("Please enter the passphrase.", since=since)
        terminal.write(b"quiet morning\r")
        assert terminal.wait() == 0
    assert rows(data, "SELECT 1 FROM sessions") == []
