"""The documented task with pictures, in a real terminal: seen, killed, resumed, replayed and simulated."""

import json
import subprocess
import time
from pathlib import Path

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


def test_pictures_are_named_killed_resumed_replayed_and_simulated(data: Path, tmp_path: Path) -> None:
    task = write_documented(tmp_path / "mytasks", "naming")
    source = (task / "task.py").read_text(encoding="utf-8").replace("return 10", f"return {PROMPTS}")
    (task / "task.py").write_text(source, encoding="utf-8")
    (task / "pictures").mkdir()
    for name, color in COLORS.items():
        Image.new("RGB", (60, 40), color).save(task / "pictures" / f"{name}.png")
    where = ("--data", str(data), "--tasks", str(task.parent))
    settings = [f"--set={name}={value}" for name, value in (QUICK | {"attempts": 1}).items()]
    with Terminal(command("run", "naming", "-p", "P01", "--seed", "7", *where, *settings)) as terminal:
        reader = ScreenReader(terminal)
        terminal.wait_for("Press Enter to go on.")
        terminal.press("enter")
        terminal.wait_for("Press Enter to begin")
        terminal.settle()
        terminal.press("enter")
        name_pictures(terminal, reader, 2)
        terminal.kill()
        terminal.wait()
    done = rows(data, "SELECT count(*) FROM trials")[0][0]
    assert done in (1, 2), "at most the last press is lost"
    with Terminal(command("resume", only_session(data), *where)) as terminal:
        reader = ScreenReader(terminal)
        terminal.wait_for("Enter")
        terminal.settle()
        terminal.press("enter")
        name_pictures(terminal, reader, PROMPTS - done)
        see_the_summary(terminal)
        terminal.press("enter")
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
    assert sorted(json.loads(software)["task"]["pictures"]) == ["pictures/apple.png", "pictures/banana.png"]
    assert rows(data, "SELECT count(*) FROM events WHERE topic='framework/fault'") == [(0,)]
    assert replays_identically(data, "--tasks", str(task.parent))
    simulated = command("simulate", "naming", "--user", "average", "--seed", "3", "--attempts", "2", *where)
    assert subprocess.run(simulated, capture_output=True, check=False).returncode == 0
    assert rows(data, "SELECT count(*) FROM trials JOIN sessions ON id=session WHERE mode='simulated'") == [(8,)]
