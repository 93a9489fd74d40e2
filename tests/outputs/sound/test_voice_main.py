"""The voice process, with noisy libraries and a program that ends."""

import os
import queue
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from sar_tui.loop.clock import host_now
from sar_tui.model.theme import Note
from sar_tui.outputs.sound.child import SoundProgram
from sar_tui.outputs.sound.protocol import (
    Ended,
    Reply,
    Say,
    Setup,
    Started,
    Stop,
    Tone,
    Voicing,
    Warm,
    encode,
)
from tests.needs_speech import needs_speech
from tests.outputs.voice_fixtures import (
    DEADLINE_S,
    ENGINE,
    NOBODY,
    is_alive,
    pids,
    program_with,
    real_program,
    until,
)

pytestmark = needs_speech

NOISY = f"""{ENGINE}
import sys
def speak(engine):
    print("Audio saved to a file")
    print("a warning", file=sys.stderr)
    os.write(1, b"from C to standard output")
    os.write(2, b"from C to standard error")
    assert sys.stdin.read() == ""
    beep(engine)
"""
HANGS_IN_C = f"""{ENGINE}
import ctypes
def speak(engine):
    ctypes.PyDLL(None).sleep(120)  # without letting any other thread of the process run
"""
PARENT = """
import sys, time
from sar_tui.outputs.sound.child import SoundProgram
from sar_tui.outputs.sound.protocol import *

child = SoundProgram(sys.argv[1:], Setup(backends=("NULL",)), lambda reply: print(reply, flush=True))
child.start()
child.send(Say(1, "a1", "One word after the other. " * 40, Voicing("en")))
time.sleep(30)
"""
"""A program with a voice. It ends by itself, and the voice with it, if the test cannot end it."""
HELLO = Voicing("en")
SETUP = Setup(backends=NOBODY)


class Talk:
    """A voice, and its replies."""

    def __init__(self, program: list[str], setup: Setup = SETUP) -> None:
        self._replies: queue.SimpleQueue[Reply | None] = queue.SimpleQueue()
        self.child = SoundProgram(program, setup, self._replies.put)
        self.child.start()

    def next(self) -> Reply | None:
        return self._replies.get(timeout=DEADLINE_S)


def test_output_printed_by_libraries_is_discarded(capfd: pytest.CaptureFixture[str]) -> None:
    talk = Talk(program_with(NOISY))
    talk.child.send(Say(1, "a1", "Well done.", HELLO))
    assert isinstance(talk.next(), Started)
    assert talk.next() == Ended(1, "done", pytest.approx(host_now(), abs=1_000_000_000))
    talk.child.end()
    assert capfd.readouterr() == ("", "")


def test_times_are_those_of_the_programs_own_clock() -> None:
    talk = Talk(real_program(Path(os.devnull)))
    before = host_now()
    talk.child.send(Tone(1, "a1", (Note(880, 200),)))
    started, ended = talk.next(), talk.next()
    after = host_now()
    talk.child.end()
    assert isinstance(started, Started)
    assert isinstance(ended, Ended)
    assert before < started.at < ended.at < after
    assert started.seconds == pytest.approx(0.2, abs=0.001)
    assert ended.at - started.at > 150_000_000


@pytest.mark.slow
def test_neither_a_stop_of_a_job_that_is_over_nor_getting_ready_disturbs_what_is_under_way() -> (
    None
):
    talk = Talk(real_program(Path(os.devnull)))
    talk.child.send(Tone(1, "a1", (Note(880, 20),)))
    talk.child.send(Tone(2, "a2", (Note(880, 100),)))
    talk.child.send(Stop(1))
    replies = [talk.next() for _ in range(4)]
    assert [each.state for each in replies if isinstance(each, Ended)] == ["done", "done"]
    talk.child.send(Tone(3, "a3", (Note(880, 1000),) * 60))
    assert isinstance(talk.next(), Started)
    talk.child.send(Warm(HELLO, ((Note(440, 100),),)))
    talk.child.send(Stop(3))
    ended = talk.next()
    talk.child.end()
    assert isinstance(ended, Ended)
    assert ended.state == "aborted"


VOICE = [sys.executable, "-P", "-m", "sar_tui.outputs.sound.voice_main"]


def run(given: bytes) -> "subprocess.CompletedProcess[bytes]":
    return subprocess.run(VOICE, input=given, capture_output=True, timeout=DEADLINE_S, check=False)


def test_it_ends_when_nobody_asks_any_more_or_the_first_line_is_no_setup() -> None:
    done = run(encode(Setup(backends=NOBODY)) + encode(Tone(1, "a1", (Note(880, 1000),) * 60)))
    assert (done.returncode, done.stderr) == (0, b"")
    for rubbish in (b"", b"\n", b"rubbish\n", encode(Stop(1))):
        done = run(rubbish)
        assert done.returncode != 0
        assert (done.stdout, done.stderr) == (b"", b"")


def test_it_ends_when_the_program_is_killed_while_it_speaks(tmp_path: Path) -> None:
    file = tmp_path / "pids"
    with subprocess.Popen(
        [sys.executable, "-c", PARENT, *real_program(file)], stdout=subprocess.PIPE
    ) as parent:
        assert parent.stdout
        assert parent.stdout.readline().startswith(b"Started")
        (pid,) = pids(file)
        parent.send_signal(signal.SIGKILL)
    until(lambda: not is_alive(pid))


def test_it_ends_when_the_program_is_killed_while_it_hangs(tmp_path: Path) -> None:
    """None of its threads can react, so the kernel ends it (Linux)."""
    file = tmp_path / "pids"
    log_pid = f"print(os.getpid(), file=open({str(file)!r}, 'a'), flush=True)"
    engine = HANGS_IN_C.replace("    ctypes.PyDLL", f"    {log_pid}\n    ctypes.PyDLL")
    with subprocess.Popen([sys.executable, "-c", PARENT, *program_with(engine)]) as parent:
        until(lambda: pids(file))
        (pid,) = pids(file)
        parent.send_signal(signal.SIGKILL)
    until(lambda: not is_alive(pid))
