"""The child program that plays the tones of prompts (see `child`).

Its sound card is a stream that never stops, so that tones begin at times of the card's own clock.
"""

import threading
from array import array
from collections import deque
from collections.abc import Callable, Generator, Sequence
from typing import NamedTuple, NoReturn

from sar_tui.loop.clock import host_now
from sar_tui.model.theme import Note
from sar_tui.model.units import SECOND
from sar_tui.outputs.sound.child import Channel
from sar_tui.outputs.sound.player import Folder, Playback, SoundCard
from sar_tui.outputs.sound.protocol import (
    Cue,
    Drop,
    Ended,
    Examine,
    Examined,
    Reckon,
    Reply,
    Request,
    Setup,
    SoundError,
    Started,
    Warm,
)
from sar_tui.outputs.sound.samples import RATE, seconds, tone

_REMEMBERED = 20
"""Number of requests of the card from which its clock is estimated: 0.2 s."""
_SILENT = (
    "The sound card does not play: connect loudspeakers, and choose them in the system's settings."
)


def main() -> NoReturn:
    """Do the requests from standard input until it ends."""
    channel = Channel()
    channel.serve(Tones(channel.setup, channel.send).do)


class Tones:
    """Plays tones on a sound card that is opened with the first request; into files, if a folder
    was named.
    """

    def __init__(self, setup: Setup, send: Callable[[Reply], object]) -> None:
        self._setup, self._send = setup, send
        self._card = SoundCard(setup.backends)
        self._stream: ToneStream | None = None

    def do(self, asked: Request) -> None:
        """Do a request. A tone that cannot be played is reported."""
        match asked:
            case Warm(tones=tones):
                for notes in tones:
                    tone(notes)
                self._ready()
            case Cue(job=job):
                if problem := self._ready():
                    self._send(Ended(job, "failed", host_now(), problem))
                else:
                    self._play(asked)
            case Drop(job):
                if self._stream:
                    self._stream.drop(job)
            case Reckon(job):
                if self._stream:
                    self._send(Started(job, self._stream.onset(job), 0.0, by="device"))
            case Examine():
                problem = self._ready()
                waits = self._stream.clock.buffer_ms if self._stream else 0.0
                self._send(Examined(card=self._card.name, no_card=problem, buffer_ms=waits))
            case _:
                pass

    def _ready(self) -> str:
        """Start the sound card if it is needed and not started; return why it cannot be."""
        if self._setup.folder or self._stream:
            return ""
        stream = ToneStream(self._card)
        try:
            if not stream.start():
                return _SILENT
        except SoundError as error:
            return str(error)
        self._stream = stream
        return ""

    def _play(self, cue: Cue) -> None:
        samples = tone((Note(cue.hz, cue.ms),))  # type: ignore[arg-type]
        if self._stream:
            at = self._stream.play(cue.job, samples, cue.at, cue.offsets_ms)
            self._send(Started(cue.job, at, seconds(samples), by="device"))
        else:
            self._write(cue)

    def _write(self, cue: Cue) -> None:
        """Write a tone with its repetitions into a file."""
        notes = [Note(cue.hz, cue.ms)]  # type: ignore[arg-type]
        for _ in cue.offsets_ms[1:]:
            notes += [Note(0, cue.offsets_ms[1] - cue.ms), notes[0]]  # type: ignore[arg-type]
        folder = Folder(self._setup.folder, in_real_time=False)
        try:
            folder.play(
                f"prompt-{cue.job}",
                tone(tuple(notes)),
                Playback(),
                lambda at, lasts: self._send(Started(cue.job, at, lasts)),
            )
        except SoundError as error:
            self._send(Ended(cue.job, "failed", host_now(), str(error)))


class DeviceClock:
    """The clock of a sound card: when each sample is heard, in ns of the host's clock.

    A card that plays asks for samples whenever a part of its buffer is free. A request may be late,
    never early, so the earliest of the last ones tells the time (a lower envelope). At its start
    the card asks until its buffer is full, which tells how long a sample waits in it. Delays beyond
    that buffer (a mixing server, the card, a wireless loudspeaker) are not known to the program.
    """

    def __init__(self, rate: int = RATE) -> None:
        self._rate = rate
        self._requests: deque[int] = deque(maxlen=_REMEMBERED)
        self._last: int | None = None
        self._waits: int | None = None
        self.asked_for = 0

    def asked(self, at: int, count: int) -> None:
        """Note that the card asked ``at`` (ns) for the next ``count`` samples."""
        if (
            self._waits is None
            and self._last is not None
            and at - self._last > self._ns(count) // 2
        ):
            self._waits = max(0, self.asked_for - count)
        self._last = at
        self._requests.append(at - self._ns(self.asked_for))
        self.asked_for += count

    @property
    def is_known(self) -> bool:
        """True once the card has begun to play."""
        return self._waits is not None

    @property
    def buffer_ms(self) -> float:
        """Time that a sample waits in the card's buffer."""
        return (self._waits or 0) / self._rate * 1000

    def heard_at(self, sample: int) -> int:
        """Return when a sample is heard (ns). Only if the clock is known."""
        return min(self._requests) + self._ns(sample + (self._waits or 0))

    def sample_at(self, at: int) -> int:
        """Return the number of the sample that is heard at a time (ns)."""
        return round((at - min(self._requests)) * self._rate / SECOND) - (self._waits or 0)

    def _ns(self, samples: int) -> int:
        return round(samples * SECOND / self._rate)


class _Part(NamedTuple):
    """Samples that begin with a certain sample of the stream."""

    job: int
    first: int
    samples: "array[int]"


class ToneStream:
    """Plays silence on a sound card, and tones in it at given times."""

    def __init__(self, card: SoundCard) -> None:
        self._card = card
        self._parts: list[_Part] = []
        self._first: dict[int, int] = {}
        self._lock = threading.Lock()
        self._began = threading.Event()
        self.clock = DeviceClock()

    def start(self, patience_s: float = 2.0) -> bool:
        """Start the card, and wait until its clock is known; False if it has not begun to play by
        then.

        Raises:
            SoundError: there is no sound card; it says what to do.
        """
        stream = self._stream()
        next(stream)
        self._card.start(stream)
        return self._began.wait(patience_s)

    def play(
        self, job: int, samples: "array[int]", at: int, offsets_ms: Sequence[float] = (0.0,)
    ) -> int:
        """Play samples ``at`` a time (ns) or as soon as possible after it, and again after each
        offset.

        Returns:
            When the first of them is heard, in ns.
        """
        with self._lock:
            first = max(self.clock.asked_for, self.clock.sample_at(at))
            starts = [first + round(offset * RATE / 1000) for offset in offsets_ms]
            self._first[job] = first
            self._parts += [_Part(job, start, samples) for start in starts]
            return self.clock.heard_at(first)

    def onset(self, job: int) -> int:
        """Return when a job is heard, as the card's clock tells now (ns)."""
        with self._lock:
            return self.clock.heard_at(self._first[job])

    def drop(self, job: int) -> None:
        """Leave out what a job has not begun to play."""
        with self._lock:
            self._parts = [
                part for part in self._parts if part.job != job or part.first < self.clock.asked_for
            ]

    def _stream(self) -> Generator["array[int]", int, None]:
        count = yield array("h")
        while True:
            with self._lock:
                self.clock.asked(host_now(), count)
                samples = self._next(count)
            if self.clock.is_known:
                self._began.set()
            count = yield samples

    def _next(self, count: int) -> "array[int]":
        """Return the samples that were asked for: silence, and what the parts have in it."""
        end = self.clock.asked_for
        begin = end - count
        mixed = array("h", bytes(2 * count))
        for part in self._parts:
            if part.first < end:
                skip = max(0, begin - part.first)
                piece = part.samples[skip : skip + end - max(begin, part.first)]
                place = max(0, part.first - begin)
                mixed[place : place + len(piece)] = piece
        self._parts = [part for part in self._parts if part.first + len(part.samples) > end]
        return mixed


if __name__ == "__main__":
    main()
