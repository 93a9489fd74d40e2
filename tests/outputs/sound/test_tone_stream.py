"""Tones begin at times of the sound card's clock, which is told from its requests for samples."""

from array import array
from collections.abc import Generator

import pytest

from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.sound.player import SoundCard
from sar_tui.outputs.sound.samples import RATE
from sar_tui.outputs.sound.tone_main import DeviceClock, ToneStream

PERIOD = 220
START = 5 * SECOND


def ns(samples: int) -> int:
    return round(samples * SECOND / RATE)


def running_clock(lags_ms: tuple[float, ...] = (0.0,) * 10) -> DeviceClock:
    """A card with a buffer of four periods, whose requests are late by so much."""
    clock = DeviceClock()
    for _ in range(4):
        clock.asked(START, PERIOD)
    for number, lag in enumerate(lags_ms, 1):
        clock.asked(START + ns(number * PERIOD) + round(lag * MS), PERIOD)
    return clock


def test_the_first_sample_is_heard_when_the_card_starts_and_late_requests_do_not_move_it() -> None:
    assert not running_clock(()).is_known
    assert running_clock((0.0,)).is_known
    clock = running_clock()
    assert clock.heard_at(0) == pytest.approx(START, abs=10)
    assert clock.heard_at(RATE) == pytest.approx(START + SECOND, abs=10)
    assert clock.buffer_ms == pytest.approx(3 * PERIOD / RATE * 1000)
    assert clock.sample_at(clock.heard_at(12_345)) == 12_345
    late = running_clock((3.0, 8.0, 0.0, 5.0, 1.0, 9.0))
    assert late.heard_at(0) == pytest.approx(START, abs=10)


class Card(SoundCard):
    """A sound card that asks for samples when a test says so."""

    def __init__(self) -> None:
        super().__init__()
        self.now = START

    def start(self, stream: Generator["array[int]", int, None]) -> None:
        self._stream = stream
        for _ in range(4):
            self.ask()

    def ask(self) -> "array[int]":
        return self._stream.send(PERIOD)

    def run(self, periods: int) -> "array[int]":
        played = array("h")
        for _ in range(periods):
            self.now += ns(PERIOD)
            played += self.ask()
        return played


@pytest.fixture
def card(monkeypatch: pytest.MonkeyPatch) -> Card:
    card = Card()
    monkeypatch.setattr("sar_tui.outputs.sound.tone_main.host_now", lambda: card.now)
    return card


@pytest.fixture
def stream(card: Card) -> ToneStream:
    """A stream of a card that has played two periods."""
    stream = ToneStream(card)
    stream.start(patience_s=0)
    card.run(2)
    return stream


BLIP = array("h", [7] * 300)


def test_a_tone_begins_with_the_sample_of_its_time(card: Card, stream: ToneStream) -> None:
    begun = stream.clock.asked_for
    at = stream.play(1, BLIP, stream.clock.heard_at(begun + 500))
    played = card.run(10)
    assert at == pytest.approx(stream.clock.heard_at(begun + 500), abs=10)
    assert played == array("h", [0] * 500 + [7] * 300 + [0] * (10 * PERIOD - 800))


def test_a_tone_whose_time_is_over_begins_with_the_next_sample(
    card: Card, stream: ToneStream
) -> None:
    at = stream.play(1, BLIP, START)
    assert at == pytest.approx(stream.clock.heard_at(stream.clock.asked_for), abs=10)
    assert card.run(3)[:300] == BLIP


def test_a_repeated_tone_is_exact_to_the_sample_and_dropped_where_it_has_not_begun(
    card: Card, stream: ToneStream
) -> None:
    stream.play(1, BLIP, START, (0.0, 100.0, 200.0))
    played = card.run(12)
    stream.drop(1)
    played += card.run(40)
    begins = [place for place in range(1, len(played)) if played[place] and not played[place - 1]]
    assert (bool(played[0]), begins) == (True, [RATE // 10])
    assert sum(bool(sample) for sample in played) == 600
