"""Tasks of the page whose prompts follow from each other: in a terminal, killed, resumed, and
replayed.
"""

import json
import sqlite3
from pathlib import Path

import pytest

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
from tests.end_to_end.test_paradigms import Keys, Player

LEFT: Keys = ((150, "left"),)
RIGHT: Keys = ((150, "right"),)


def play(
    tmp_path: Path, data: Path, task: str, answers: dict[str, Keys], killed_after: int
) -> None:
    """Play one attempt of a task of the page; the program is killed when it has shown some of its
    prompts.
    """
    tasks = tmp_path / "mytasks"
    write_documented(tasks, task)
    settings = QUICK | {"attempts": 1}
    where = ("--data", str(data), "--tasks", str(tasks))
    words = (
        "run",
        task,
        "-p",
        "P01",
        "--seed",
        "3",
        *where,
        *(f"--set={n}={v}" for n, v in settings.items()),
    )
    with Terminal(command(*words)) as terminal:
        Player(terminal, answers).play(lambda: _trials(data) >= killed_after)
        terminal.kill()
        terminal.wait()
    with Terminal(command("resume", only_session(data), *where)) as terminal:
        Player(terminal, answers).play(lambda: b"see how it went" in terminal.output)
        see_the_summary(terminal)
        terminal.confirm()
        assert terminal.wait() == 0
    assert rows(data, "SELECT status FROM sessions") == [("completed",)]
    assert replays_identically(data, "--tasks", str(tasks))


def _trials(data: Path) -> int:
    try:
        return int(rows(data, "SELECT count(*) FROM trials")[0][0])
    except sqlite3.OperationalError:  # the database is being made
        return 0


@pytest.mark.slow
def test_a_staircase_goes_on_where_it_was(data: Path, tmp_path: Path) -> None:
    play(tmp_path, data, "larger", {r"\d\d:50": LEFT, r"50:\d\d": RIGHT}, killed_after=7)
    found = rows(data, "SELECT stimulus, correct FROM trials ORDER BY trial")
    assert len(found) == 30
    assert [int(value) for value, _ in found[:8]] == [24, 24, 16, 16, 8, 8, 1, 1]
    assert all(correct for _, correct in found)


@pytest.mark.slow
def test_points_are_shown_after_each_choice_and_stamped(data: Path, tmp_path: Path) -> None:
    play(tmp_path, data, "harvest", {r"Left or right\?": LEFT}, killed_after=3)
    topics = (
        "event_handler/trial_feedback",
        "screen/trial_feedback",
        "input/key",
        "event_handler/prompt",
    )
    due, seen, keys, prompts = (
        [json.loads(text) | {"at_ns": at} for text, at in rows(data, _messages(topic))]
        for topic in topics
    )
    assert len(due) == 12
    assert {one["text"] for one in due} == {"+10", "0"}
    assert {one["source"] for one in seen} == {"flush"}
    assert len(seen) >= len(due) - 1, "the program may be killed before one was flushed"
    assert keys
    assert len(prompts) >= 12


def _messages(topic: str) -> str:
    return f"SELECT message, at_ns FROM events WHERE topic='{topic}' ORDER BY seq"


@pytest.mark.slow
def test_questions_between_attempts_are_asked_again_after_a_kill_and_none_is_lost(
    data: Path, tmp_path: Path
) -> None:
    arrows: dict[str, Keys] = {
        r"Press: left": LEFT,
        r"Press: right": RIGHT,
        "It was fun": ((750, "3"),),
    }
    tasks = tmp_path / "mytasks"
    write_documented(tasks, "effort")
    where = ("--data", str(data), "--tasks", str(tasks))
    settings = QUICK | {"attempts": 2}
    words = (
        "run",
        "effort",
        "-p",
        "P01",
        "--seed",
        "3",
        *where,
        *(f"--set={n}={v}" for n, v in settings.items()),
    )
    effort: dict[str, Keys] = {"How hard was that": ((750, "5"),)}
    with Terminal(command(*words)) as terminal:
        Player(terminal, arrows).play(lambda: b"How hard was that" in terminal.output)
        terminal.kill()
        terminal.wait()
    assert rows(data, "SELECT step, status FROM answers ORDER BY number") == [("read", "done")]
    with Terminal(command("resume", only_session(data), *where)) as terminal:
        Player(terminal, arrows | effort).play(lambda: b"see how it went" in terminal.output)
        see_the_summary(terminal)
        terminal.confirm()
        assert terminal.wait() == 0
    assert rows(data, "SELECT attempt, step, run, answer FROM answers ORDER BY number") == [
        (0, "read", 1, None), (1, "effort", 2, "5.0"), (2, "effort", 2, "5.0"), (2, "fun", 2, "3"),
    ]  # fmt: skip
    assert rows(data, "SELECT count(*) FROM trials") == [(4,)]
    assert replays_identically(data, "--tasks", str(tasks))


@pytest.mark.slow
def test_a_killed_attempt_of_a_task_with_memory_begins_again(data: Path, tmp_path: Path) -> None:
    play(tmp_path, data, "twoback", {r"Letter: [A-Z]": ((150, "space"),)}, killed_after=2)
    found = rows(data, "SELECT attempt, count(*) FROM trials GROUP BY 1")
    assert found[0][0] == 1
    assert found[0][1] >= 2
    assert found[1] == (2, 20)
    assert rows(data, "SELECT attempt, trials FROM attempts") == [(2, 20)]
