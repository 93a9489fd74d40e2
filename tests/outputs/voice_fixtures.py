"""Listeners to the voice process, and programs that replace it."""

import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

from sar_tui.loop.clock import Clock
from sar_tui.model.theme import Theme
from sar_tui.outputs.output import Report
from sar_tui.outputs.sound.mixer import Sound
from sar_tui.outputs.speech import Speech, Tones
from tests.outputs.contract import OVER, host_clock

LONG = (
    "This is a long sentence that goes on for several seconds, so that there is time to do "
    "something about it."
)
DEADLINE_S = 60.0
NOBODY = ("NULL",)
"""Plays in real time, to no loudspeaker."""

_REAL = "from sar_tui.outputs.sound.voice_main import main; main()"
_MARKED = f"import os, sys; print(os.getpid(), file=open(sys.argv[1], 'a')); {_REAL}"
_FAKE = """
import sys, types
fake = types.ModuleType("pyttsx3")
source = sys.argv[1]
exec(source, fake.__dict__)
sys.modules["pyttsx3"] = fake
"""

ENGINE = """
import os, time, wave
from types import SimpleNamespace

class Engine:
    def __init__(self):
        self.proxy = SimpleNamespace(setBusy=lambda is_busy: None)
        self.listeners = {}
        self.properties = {"voice": "plain", "rate": 200}
    def connect(self, topic, callback):
        self.listeners[topic] = callback
    def getProperty(self, name):
        if name == "voices":
            return [SimpleNamespace(id="plain", name="Plain", languages=["en"])]
        return self.properties[name]
    def setProperty(self, name, value):
        self.properties[name] = value
    def save_to_file(self, text, path):
        self.text, self.path = text, path
    def runAndWait(self):
        if self.text == "1":
            beep(self)
        else:
            speak(self)
        self.listeners["finished-utterance"](name=None, completed=True)

def beep(engine, level=9000, seconds=1.0):
    with wave.open(engine.path, "wb") as sound:
        sound.setnchannels(1); sound.setsampwidth(2); sound.setframerate(22050)
        sound.writeframes(b"".join((level if n % 50 < 25 else -level).to_bytes(2, "little", signed=True)
                                   for n in range(int(22050 * seconds))))

def init():
    return Engine()
"""
"""An engine with one voice, which does what a function ``speak(engine)`` does."""


def real_program(pids: Path) -> list[str]:
    """The voice itself, which adds its process id to a file as it starts."""
    return [sys.executable, "-c", _MARKED, str(pids)]


def program_with(engine: str) -> list[str]:
    """The voice, with another engine in place of pyttsx3."""
    return [sys.executable, "-c", f"{_FAKE}{_REAL}", engine]


def until(holds: Callable[[], object]) -> None:
    """Wait for another thread or process."""
    end = time.monotonic() + DEADLINE_S
    while not holds():
        assert time.monotonic() < end, "it did not come about"
        time.sleep(0.002)


def pids(file: Path) -> list[int]:
    return [int(line) for line in file.read_text().split()] if file.exists() else []


def is_alive(pid: int) -> bool:
    """Return True if a process exists and is not a zombie. A zombie with threads left (``l``)
    cannot be reaped yet.
    """
    state = subprocess.run(
        ["ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True, check=False
    ).stdout
    return bool(state.strip()) and (not state.startswith("Z") or "l" in state)


class Listener:
    """Speech and tones, open, with their reports."""

    def __init__(self, sound: Sound, theme: Theme, clock: Clock) -> None:
        self.reports: list[Report] = []
        self._new = threading.Condition()
        self.speech, self.tones = Speech(sound), Tones(sound)
        self.speech.open(theme, clock, self._collect)
        self.tones.open(theme, clock, self._collect)

    def _collect(self, report: Report) -> None:
        with self._new:
            self.reports.append(report)
            self._new.notify_all()

    def states(self, action: str) -> list[str]:
        return [report.state for report in self.reports if report.action == action]

    def wait(self, action: str, *states: str) -> Report:
        """The first report of an action in one of the states, which may be yet to come."""
        wanted = states or OVER

        def logged() -> Report | None:
            of = (each for each in self.reports if each.action == action)
            return next((each for each in of if each.state in wanted), None)

        with self._new:
            found = self._new.wait_for(logged, DEADLINE_S)
        assert found, f"{action} was not reported as {' or '.join(wanted)}"
        return found

    def close(self) -> None:
        self.speech.close()
        self.tones.close()


@contextmanager
def listening(sound: Sound, theme: Theme, clock: Clock | None = None) -> Iterator[Listener]:
    """Provide speech and tones on one `Sound`, in real time if no clock is given; close them at the
    end.
    """
    with nullcontext(clock) if clock else host_clock() as its_clock:
        listener = Listener(sound, theme, its_clock)
        try:
            yield listener
        finally:
            listener.close()


BEEPS = f"""{ENGINE}
def speak(engine):
    beep(engine, seconds=0.1 + 0.01 * len(engine.text))
"""
"""An engine that beeps for as long as the text is."""
