"""Pictures in a real terminal: its graphics are flushed with the prompt's text."""

import json
import re
from pathlib import Path

import pytest
from PIL import Image

from sar_tui.timing.pty import Terminal
from tests.documented import write_documented
from tests.end_to_end.participant_terminal import command, rows

COLORS = {"apple": "#ff0000", "banana": "#00ff00"}


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
    task = write_documented(tmp_path / "mytasks", "naming")
    (task / "pictures").mkdir()
    for name, color in COLORS.items():
        Image.new("RGB", (60, 40), color).save(task / "pictures" / f"{name}.png")
    where = ("--data", str(data), "--tasks", str(task.parent))
    words = command("run", "naming", "-p", "P01", "--seed", "7", *where, "--set=attempts=1")
    with Terminal(words, environment={"COLORTERM": "truecolor"}) as terminal:
        for question, answer in answers.items():
            terminal.wait_for(question)
            terminal.settle(silence_ms=20)
            number = re.search(rb"_Gi=(\d+)", terminal.output)
            terminal.write(answer or b"\x1b_Gi=%s;OK\x1b\\" % number[1] if number else answer)
        terminal.wait_for("Press Enter to go on.")
        terminal.confirm()
        terminal.wait_for("Press Enter to begin")
        terminal.settle()
        terminal.confirm()
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
