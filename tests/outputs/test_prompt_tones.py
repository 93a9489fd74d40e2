"""Tones of prompts in a process of their own: on a card that is not there, on one that nobody
hears, and in files.
"""

import queue
import wave
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from sar_tui.loop.bus import Bus
from sar_tui.loop.clock import VirtualClock, host_now
from sar_tui.loop.node import Node, on
from sar_tui.loop.topics import KEY, TONE_BEGAN, TONE_DUE, TONES_AHEAD, VOIDED
from sar_tui.model import messages as m
from sar_tui.model.tone import Tone
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.prompt_tones import PromptTones
from sar_tui.outputs.sound import tone_process
from sar_tui.outputs.sound.tone_process import Onset, ToneProcess
from tests.outputs.voice_fixtures import DEADLINE_S, NOBODY

BEEP = Tone(880, 50)


class Player:
    """A process, and the onsets that it has reported."""

    def __init__(self, where: str = "sound", backends: tuple[str, ...] = NOBODY) -> None:
        self._onsets: queue.SimpleQueue[Onset] = queue.SimpleQueue()
        self.process = ToneProcess(self._onsets.put, where, backends)

    def next(self) -> Onset:
        return self._onsets.get(timeout=DEADLINE_S)


@pytest.fixture
def player() -> Iterator[Player]:
    player = Player()
    yield player
    player.process.close()


def test_the_onset_of_a_tone_is_by_the_clock_of_the_card(player: Player) -> None:
    player.process.prepare([BEEP])
    player.process.play(1, BEEP, 0)
    first = player.next()
    assert (first.job, first.source) == (1, "device")
    planned = host_now() + 2000 * MS
    player.process.play(2, BEEP, planned)
    onset = player.next()
    assert (onset.job, onset.source) == (2, "device")
    assert abs(onset.at - planned) < MS, "it is planned to the sample"


def test_the_loss_of_the_process_is_reported(player: Player) -> None:
    player.process.play(1, BEEP, 0)
    player.next()
    player.process._child.kill()
    lost = player.next()
    assert (lost.job, lost.source) == (0, "failed")
    assert "has ended" in lost.detail
    assert player.process.has_ended


def test_a_tone_without_a_card_fails_with_a_sentence() -> None:
    player = Player(backends=("JACK",))
    try:
        player.process.play(1, BEEP, 0)
        onset = player.next()
    finally:
        player.process.close()
    assert (onset.job, onset.source) == (1, "failed")
    assert "There is no sound card that can be used" in onset.detail


def test_a_repeated_tone_is_written_into_a_file(tmp_path: Path) -> None:
    player = Player(f"file:{tmp_path / 'sounds'}", ())
    try:
        player.process.play(1, Tone(500, 100, times=3, every_ms=400), 0)
        assert player.next().source == "host"
    finally:
        player.process.close()
    (file,) = (tmp_path / "sounds").iterdir()
    with wave.open(str(file), "rb") as sound:
        assert sound.getnframes() / sound.getframerate() == pytest.approx(0.9, abs=0.001)


class Clock:
    """A clock that a test sets; unlike the virtual one it is that of a live session."""

    def now(self) -> int:
        return 5 * SECOND

    def call_at(self, when: int, callback: Callable[[], object]) -> Any:
        raise NotImplementedError

    def call_soon(self, callback: Callable[[], object]) -> None:
        callback()


class Process:
    """Notes what it is asked for."""

    has_ended = False

    def __init__(self, on_onset: Callable[[Onset], object], *_: object) -> None:
        self.report = on_onset
        self.asked: list[tuple[Any, ...]] = []

    def prepare(self, tones: Sequence[Tone]) -> None:
        self.asked.append(("prepare", *tones))

    def play(self, job: int, tone: Tone, at: int) -> None:
        self.asked.append(("play", job, tone, at))

    def drop(self, job: int) -> None:
        self.asked.append(("drop", job))

    def close(self) -> None:
        self.asked.append(("close",))


class Source(Node):
    """Publishes what the event handler would, when a test presses a key."""

    name = "source"
    emits = (TONES_AHEAD, TONE_DUE, VOIDED)
    due = m.ToneDue(attempt=1, trial=2, presentation=1, frame=3, tone=BEEP, at=7)

    @on(KEY)
    def pressed(self, press: m.KeyPressed) -> None:
        match press.key:
            case "a":
                self.emit(TONES_AHEAD, m.TonesAhead(tones=(BEEP,)))
            case "d":
                self.emit(TONE_DUE, self.due)
            case "v":
                self.emit(
                    VOIDED, m.PromptVoided(attempt=1, trial=2, presentation=1, reason="pause")
                )


@pytest.fixture
def rig(monkeypatch: pytest.MonkeyPatch) -> tuple[Bus, PromptTones, list[m.ToneBegan]]:
    """A bus with the node, whose process is replaced, and the onsets that were reported."""
    monkeypatch.setattr(tone_process, "ToneProcess", Process)
    bus, node, began = Bus(Clock()), PromptTones("sound"), list[m.ToneBegan]()
    for each in (Source(), node):
        each.attach(bus)
    bus.subscribe(TONE_BEGAN, began.append)
    return bus, node, began


def press(bus: Bus, keys: str) -> None:
    for key in keys:
        bus.publish(KEY, m.KeyPressed(key=key, at=1))


def test_a_tone_is_prepared_played_and_its_onset_reported(
    rig: tuple[Bus, PromptTones, list[m.ToneBegan]],
) -> None:
    bus, node, began = rig
    press(bus, "ad")
    process: Any = node._process
    assert process.asked == [("prepare", BEEP), ("play", 1, BEEP, 7)]
    process.report(Onset(1, 9, "device"))
    assert began == [
        m.ToneBegan(attempt=1, trial=2, presentation=1, frame=3, at=9, source="device")
    ]


def test_what_has_not_sounded_is_dropped_with_the_prompt(
    rig: tuple[Bus, PromptTones, list[m.ToneBegan]],
) -> None:
    bus, node, began = rig
    press(bus, "dv")
    process: Any = node._process
    assert process.asked[-1] == ("drop", 1)
    process.report(Onset(1, 9, "device"))
    assert began == []
    node.detach()
    assert process.asked[-1] == ("close",)


def test_a_lost_process_fails_the_tone_and_is_replaced(
    rig: tuple[Bus, PromptTones, list[m.ToneBegan]],
) -> None:
    bus, node, began = rig
    press(bus, "d")
    first: Any = node._process
    first.has_ended = True
    first.report(Onset(0, 9, "failed", "It has ended."))
    assert [(one.source, one.detail) for one in began] == [("failed", "It has ended.")]
    press(bus, "vd")
    assert node._process is not first


def test_a_process_that_cannot_be_started_fails_the_tone(
    rig: tuple[Bus, PromptTones, list[m.ToneBegan]], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise OSError(11, "no more processes")

    monkeypatch.setattr(tone_process, "ToneProcess", fail)
    bus, _, began = rig
    press(bus, "d")
    assert [(one.source, one.detail) for one in began] == [
        ("failed", "They cannot be played (no more processes).")
    ]


def test_on_a_virtual_clock_nothing_is_played(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(tone_process, "ToneProcess")
    clock = VirtualClock(5 * SECOND)
    bus, began = Bus(clock), list[m.ToneBegan]()
    for each in (Source(), PromptTones("sound")):
        each.attach(bus)
    bus.subscribe(TONE_BEGAN, began.append)
    press(bus, "ad")
    assert [(one.source, one.at) for one in began] == [("virtual", 5 * SECOND)]
