"""Tones of prompts in a process of their own: on a card that is not there, on one that nobody
hears, and in files.
"""

import queue
import wave
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from sar_tui.drivers import child_process
from sar_tui.loop.bus import Bus
from sar_tui.loop.clock import VirtualClock, host_now
from sar_tui.loop.topics import TONE_BEGAN, TONE_DUE, TONES_AHEAD, VOIDED
from sar_tui.model import messages as m
from sar_tui.model.tone import Tone
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs import prompt_tones
from sar_tui.outputs.prompt_tones import PromptTones, cue, warm
from sar_tui.outputs.sound.child import TONES, SoundProgram
from sar_tui.outputs.sound.protocol import Drop, Ended, Reply, Setup, Started
from tests.outputs.test_node import SENT, Loop, Sent
from tests.outputs.voice_fixtures import DEADLINE_S, NOBODY

BEEP = Tone(880, 50)


@contextmanager
def playing(setup: Setup) -> Iterator[tuple[SoundProgram, Callable[[], Reply | None]]]:
    """Provide the program of the tones of prompts, and a function that returns its next reply."""
    replies: queue.SimpleQueue[Reply | None] = queue.SimpleQueue()
    program = SoundProgram(TONES, setup, replies.put)
    program.start()
    try:
        yield program, lambda: replies.get(timeout=DEADLINE_S)
    finally:
        program.end()


def test_onsets_are_by_the_clock_of_the_card_and_a_process_that_is_lost_can_be_started_again() -> (
    None
):
    with playing(Setup(backends=NOBODY)) as (program, following):
        program.prepare("tones", warm([BEEP]))
        program.send(cue(1, BEEP, 0))
        first: Any = following()
        planned = host_now() + 2000 * MS
        program.send(cue(2, BEEP, planned))
        onset: Any = following()
        assert program._process
        child_process.kill(program._process)
        assert following() is None
        assert not program.is_running
        program.start()
        program.send(cue(3, BEEP, 0))
        again: Any = following()
    assert [(type(one), one.job, one.by) for one in (first, onset, again)] == [
        (Started, job, "device") for job in (1, 2, 3)
    ]
    assert abs(onset.at - planned) < MS, "it is planned to the sample"


def test_a_tone_without_a_card_fails_with_a_sentence() -> None:
    with playing(Setup(backends=("JACK",))) as (program, following):
        program.send(cue(1, BEEP, 0))
        onset = following()
    assert isinstance(onset, Ended)
    assert (onset.job, onset.state) == (1, "failed")
    assert "There is no sound card that can be used" in onset.detail


def test_a_repeated_tone_is_written_into_a_file(tmp_path: Path) -> None:
    with playing(Setup(str(tmp_path / "sounds"))) as (program, following):
        program.send(cue(1, Tone(500, 100, times=3, every_ms=400), 0))
        started = following()
    assert isinstance(started, Started)
    assert started.by == "host"
    (file,) = (tmp_path / "sounds").iterdir()
    with wave.open(str(file), "rb") as sound:
        assert sound.getnframes() / sound.getframerate() == pytest.approx(0.9, abs=0.001)


class Clock:
    """A clock that stands still; unlike the virtual one it is that of a live session."""

    def now(self) -> int:
        return 5 * SECOND

    def call_soon(self, callback: Callable[[], object]) -> None:
        callback()


class Program:
    """Notes the requests to a program that is never started."""

    def __init__(self, program: object, setup: object, on_reply: Callable[[Any], object]) -> None:
        self.reply = on_reply
        self.asked: list[object] = []
        self.starts = 0
        self.problem: OSError | None = None

    def start(self) -> None:
        self.starts += 1
        if self.problem:
            raise self.problem

    def prepare(self, what: str, request: object) -> None:
        self.asked.append(request)

    def send(self, request: object) -> None:
        self.asked.append(request)

    def end(self) -> None:
        self.asked.append("end")


class EventHandler(Loop):
    """Stands in for the event handler."""

    name = "event_handler"
    emits = (TONES_AHEAD, TONE_DUE, VOIDED)


AHEAD = m.TonesAhead(tones=(BEEP,))
DUE = m.ToneDue(attempt=1, trial=2, presentation=1, frame=3, tone=BEEP, at=7)
PAUSED = m.PromptVoided(attempt=1, trial=2, presentation=1, reason="pause")


class Rig:
    """A bus with the node, whose program is replaced, and the onsets that were reported."""

    def __init__(self, clock: Any = None) -> None:
        self.began: list[m.ToneBegan] = []
        self.node = PromptTones("sound")
        self.program: Any = self.node._program
        self._bus = Bus(clock or Clock())
        for each in (EventHandler(), self.node):
            each.attach(self._bus)
        self._bus.subscribe(TONE_BEGAN, self.began.append)

    def send(self, *messages: m.Message) -> None:
        for message in messages:
            self._bus.publish(SENT, Sent(message=message))

    @property
    def failed(self) -> list[str]:
        return [one.detail for one in self.began if one.source == "failed"]


@pytest.fixture
def rig(monkeypatch: pytest.MonkeyPatch) -> Rig:
    monkeypatch.setattr(prompt_tones, "SoundProgram", Program)
    return Rig()


def test_a_tone_is_prepared_played_and_its_onset_reported(rig: Rig) -> None:
    rig.send(AHEAD, DUE)
    assert rig.program.asked == [warm([BEEP]), cue(1, BEEP, 7)]
    rig.program.reply(Started(1, 9, 0.05, by="device"))
    assert rig.began == [
        m.ToneBegan(attempt=1, trial=2, presentation=1, frame=3, at=9, source="device")
    ]


def test_what_has_not_sounded_is_dropped_with_the_prompt(rig: Rig) -> None:
    rig.send(DUE, PAUSED)
    assert rig.program.asked[-1] == Drop(1)
    rig.program.reply(Started(1, 9, 0.05, by="device"))
    assert rig.began == []
    rig.node.detach()
    assert rig.program.asked[-1] == "end"


def test_a_tone_that_cannot_be_played_has_failed(rig: Rig) -> None:
    rig.send(DUE)
    rig.program.reply(Ended(1, "failed", 9, "There is no card."))
    rig.program.reply(None)
    assert rig.failed == [
        "There is no card.",
        "The program that plays the tones of prompts has ended.",
    ]
    rig.send(PAUSED, DUE)
    assert rig.program.starts == 2, "it is started again, if it has ended"


def test_a_program_that_cannot_be_started_fails_the_tone(rig: Rig) -> None:
    rig.program.problem = OSError(11, "no more processes")
    rig.send(DUE)
    assert rig.failed == ["They cannot be played (no more processes)."]


@pytest.mark.usefixtures("rig")
def test_on_a_virtual_clock_nothing_is_played() -> None:
    rig = Rig(VirtualClock(5 * SECOND))
    rig.send(AHEAD, DUE)
    assert (rig.program.asked, rig.program.starts) == ([], 0)
    assert [(one.source, one.at) for one in rig.began] == [("virtual", 5 * SECOND)]
