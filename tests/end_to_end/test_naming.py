"""The documented task with pictures, in a real terminal: seen, killed, resumed, replayed and
simulated.
"""

import json
import re
import subprocess
import time
from pathlib import Path

import pytest
from PIL import Image

from sar_tui.timing.pty import Terminal
from tests.documented import write_documented
from tests.end_to_end.participant_terminal import (
    QUICK,
    ScreenReader,
    command,
    only_session,
    replays_identically,
    rows,
    see_the_summary,
)

PROMPTS = 4
COLORS = {"apple": "#ff0000", "banana": "#00ff00"}
_PATIENCE = 60.0


def name_pictures(terminal: Terminal, reader: ScreenReader, count: int) -> None:
    """Press the first letter of what is seen, told by its colour, for a number of prompts."""
    for _ in range(count):
        deadline = time.monotonic() + _PATIENCE
        while "What is it?" not in reader.text():
            assert time.monotonic() < deadline, reader.text()
            terminal.read(time.monotonic_ns() + 20_000_000)
        terminal.settle(silence_ms=100)
        terminal.press({"ff0000": "a", "00ff00": "b"}[reader.color_of("▀")])
        while "What is it?" in reader.text():
            assert time.monotonic() < deadline
            terminal.read(time.monotonic_ns() + 20_000_000)


def naming(tmp_path: Path) -> Path:
    """Write the documented task with fewer prompts, and its pictures."""
    task = write_documented(tmp_path / "mytasks", "naming")
    source = (
        (task / "task.py").read_text(encoding="utf-8").replace("return 10", f"return {PROMPTS}")
    )
    (task / "task.py").write_text(source, encoding="utf-8")
    (task / "pictures").mkdir()
    for name, color in COLORS.items():
        Image.new("RGB", (60, 40), color).save(task / "pictures" / f"{name}.png")
    return task


def begin(terminal: Terminal) -> None:
    """Continue from the instructions to the first foreperiod."""
    terminal.wait_for("Press Enter to go on.")
    terminal.confirm()
    terminal.wait_for("Press Enter to begin")
    terminal.settle()
    terminal.confirm()


@pytest.mark.slow
def test_pictures_are_named_killed_resumed_replayed_and_simulated(
    data: Path, tmp_path: Path
) -> None:
    task = naming(tmp_path)
    where = ("--data", str(data), "--tasks", str(task.parent))
    settings = [f"--set={name}={value}" for name, value in (QUICK | {"attempts": 1}).items()]
    with Terminal(
        command("run", "naming", "-p", "P01", "--seed", "7", *where, *settings)
    ) as terminal:
        reader = ScreenReader(terminal)
        begin(terminal)
        name_pictures(terminal, reader, 2)
        terminal.kill()
        terminal.wait()
    done = rows(data, "SELECT count(*) FROM trials")[0][0]
    assert done in (1, 2), "at most the last press is lost"
    with Terminal(command("resume", only_session(data), *where)) as terminal:
        reader = ScreenReader(terminal)
        terminal.wait_for("Enter")
        terminal.settle()
        terminal.confirm()
        name_pictures(terminal, reader, PROMPTS - done)
        see_the_summary(terminal)
        terminal.confirm()
        assert terminal.wait() == 0
    trials = rows(data, "SELECT stimulus, response, correct, timing FROM trials ORDER BY trial")
    assert [response for _, response, *_ in trials] == [stimulus[0] for stimulus, *_ in trials]
    for _, _, correct, timing in trials:
        assert correct
        assert json.loads(timing)["onset_source"] == "flush"
        assert json.loads(timing)["flags"] == []
    shown = rows(data, "SELECT message FROM events WHERE topic='screen/shown'")
    assert {json.loads(message)["picture"] for (message,) in shown} == {"half blocks"}
    ((software,),) = rows(data, "SELECT software FROM sessions")
    assert sorted(json.loads(software)["task"]["pictures"]) == [
        "pictures/apple.png",
        "pictures/banana.png",
    ]
    assert rows(data, "SELECT count(*) FROM events WHERE topic='framework/fault'") == [(0,)]
    assert replays_identically(data, "--tasks", str(task.parent))
    simulated = command(
        "simulate", "naming", "--user", "average", "--seed", "3", "--attempts", "2", *where
    )
    assert subprocess.run(simulated, capture_output=True, check=False).returncode == 0
    assert rows(
        data, "SELECT count(*) FROM trials JOIN sessions ON id=session WHERE mode='simulated'"
    ) == [(8,)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("way", "answers", "picture"),
    [
        (
            "sixel",
            {"\x1b[c": b"\x1b[?62;4c", "\x1b[16t": b"\x1b[6;20;10t"},
            rb"\x1bP0;0;0q.*\x1b\\\x1b8.*What is it\?",
        ),
        (
            "kitty",
            {"\x1b[c": b"\x1b[?62c", "a=q": b"", "\x1b[16t": b"\x1b[6;20;10t"},
            "\U0010eeee.*What is it\\?".encode(),
        ),
    ],
)
def test_graphics_of_the_terminal_are_flushed_with_the_text(
    data: Path, tmp_path: Path, way: str, answers: dict[str, bytes], picture: bytes
) -> None:
    where = ("--data", str(data), "--tasks", str(naming(tmp_path).parent))
    settings = [f"--set={name}={value}" for name, value in (QUICK | {"attempts": 1}).items()]
    words = command("run", "naming", "-p", "P01", "--seed", "7", *where, *settings)
    with Terminal(words, environment={"COLORTERM": "truecolor"}) as terminal:
        for question, answer in answers.items():
            terminal.wait_for(question)
            terminal.settle(silence_ms=20)
            number = re.search(rb"_Gi=(\d+)", terminal.output)
            terminal.write(answer or b"\x1b_Gi=%s;OK\x1b\\" % number[1] if number else answer)
        begin(terminal)
        start = len(terminal.output)
        terminal.wait_for("What is it?", since=start)
        terminal.settle(silence_ms=100)
        assert re.search(picture, bytes(terminal.output[start:]), re.DOTALL)
        terminal.press("a")
        terminal.settle()
        terminal.press("ctrl+q")
    (message,) = rows(
        data, "SELECT message FROM events WHERE topic='screen/shown' ORDER BY seq LIMIT 1"
    )[0]
    assert (json.loads(message)["picture"], json.loads(message)["source"]) == (way, "flush")
