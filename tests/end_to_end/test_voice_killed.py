"""A session with the real speech engine continues after its voice process is killed."""

import json
import os
import signal
import sys
import time
import wave
from collections.abc import Callable
from pathlib import Path

import pytest

from sar_tui.timing.pty import Terminal
from sar_tui.timing.scripted_participant import ScriptedParticipant, random_answers
from tests.end_to_end.participant_terminal import rows, run_command, see_the_summary
from tests.needs_speech import needs_speech


def wait_until(holds: Callable[[], bool], what: str, seconds: float = 60) -> None:
    deadline = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline, f"waited in vain until {what}"
        time.sleep(0.05)


def voices(parent: int) -> list[int]:
    """The voice processes of a program."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            is_child = int((entry / "stat").read_text().rpartition(")")[2].split()[1]) == parent
            is_voice = b"sar_tui.outputs.sound.voice_main" in (entry / "cmdline").read_bytes()
        except (OSError, ValueError):  # it has ended meanwhile
            continue
        if is_child and is_voice:
            found.append(int(entry.name))
    return found


def said(data: Path) -> list[tuple[str, str]]:
    """Return the reported states of each utterance, in order."""
    reported = rows(data, "SELECT message FROM events WHERE topic='output/report' ORDER BY seq")
    reports = [json.loads(message) for (message,) in reported]
    return [(report["action"], report["state"]) for report in reports if report["deed"] == "say"]


@pytest.mark.slow
@needs_speech
@pytest.mark.skipif(sys.platform != "linux", reason="finds the process in /proc")
def test_the_session_continues_with_a_new_voice(data: Path, tmp_path: Path) -> None:
    spoken = tmp_path / "spoken"
    outputs = {"outputs": "screen speech", "speech": f"file:{spoken}"}
    with Terminal(run_command(data, prompts_per_attempt=2, attempts=1, **outputs)) as terminal:
        terminal.wait_for("Press Enter to go on.")
        wait_until(lambda: ("a1", "started") in said(data), "the greeting is spoken")
        (voice,) = voices(terminal.process.pid)
        os.kill(voice, signal.SIGKILL)
        wait_until(lambda: ("a1", "failed") in said(data), "the loss of the voice is reported")
        wait_until(lambda: ("a2", "started") in said(data), "another voice speaks")
        (another,) = voices(terminal.process.pid)
        ScriptedParticipant(terminal, random_answers(3, 120, 220)).run(2)
        see_the_summary(terminal)
        terminal.confirm()
        assert terminal.wait() == 0
    assert another != voice
    assert not Path(f"/proc/{another}").exists(), "no voice outlives its program"
    assert rows(data, "SELECT status FROM sessions") == [("completed",)]
    assert rows(data, "SELECT count(*) FROM trials") == [(2,)]
    states = said(data)
    assert states.index(("a1", "failed")) < states.index(("a2", "started"))
    for file in spoken.glob("*-a2-say.wav"):
        with wave.open(str(file)) as sound:
            assert sound.getnframes() > sound.getframerate()
