"""The child program that speaks and plays one sound after another (see `child`)."""

import contextlib
import queue
import threading
from array import array
from collections.abc import Callable
from typing import NoReturn

import msgspec

from sar_tui.loop.clock import host_now
from sar_tui.outputs.sound.child import Channel
from sar_tui.outputs.sound.engine import Engine
from sar_tui.outputs.sound.player import Destination, Folder, NoSound, Playback, SoundCard
from sar_tui.outputs.sound.protocol import (
    Ended,
    Examine,
    Examined,
    Reply,
    Request,
    Say,
    Setup,
    SoundError,
    Started,
    Stop,
    Tone,
    Warm,
)
from sar_tui.outputs.sound.samples import tone


def main() -> NoReturn:
    """Do the requests from standard input until it ends."""
    channel = Channel()
    voice = Voice(channel.setup, channel.send)
    listener = threading.Thread(
        target=channel.serve, args=(voice.request,), name="requests", daemon=True
    )
    listener.start()
    voice.work()


class Voice:
    """Does one job after another on the main thread, as the speech engine requires."""

    def __init__(self, setup: Setup, send: Callable[[Reply], object]) -> None:
        self._send = send
        self._jobs: queue.SimpleQueue[tuple[Request, Playback]] = queue.SimpleQueue()
        self._latest: tuple[int, Playback] = (0, Playback())
        self._engine = Engine()
        self._card = SoundCard(setup.backends)
        self._destination: Destination = self._card
        if setup.folder:
            self._destination = Folder(setup.folder, setup.in_real_time)
        elif not setup.in_real_time:
            self._destination = NoSound()

    def request(self, asked: Request) -> None:
        """Queue a request, from any thread. A stop takes effect at once."""
        match asked:
            case Stop(job):
                latest, playback = self._latest
                if job == latest:
                    playback.halt()
            case Say(job) | Tone(job):
                self._latest = job, Playback()
                self._jobs.put((asked, self._latest[1]))
            case _:
                self._jobs.put((asked, Playback()))

    def work(self) -> NoReturn:
        """Do the requests in order, until the program ends."""
        while True:
            self._do(*self._jobs.get())

    def _do(self, asked: Request, playback: Playback) -> None:
        match asked:
            case Say(job, name, text, voicing):
                self._sound(job, name, lambda: self._engine.speak(text, voicing), playback)
            case Tone(job, name, notes):
                self._sound(job, name, lambda: tone(notes), playback)
            case Warm():
                self._warm(asked)
            case Examine():
                self._send(self._examined())
            case _:
                pass

    def _sound(
        self, job: int, name: str, make: Callable[[], "array[int]"], playback: Playback
    ) -> None:
        try:
            samples = make()
            if not playback.is_halted:
                self._destination.play(
                    name,
                    samples,
                    playback,
                    lambda at, seconds: self._send(Started(job, at, seconds)),
                )
        except SoundError as error:
            self._send(Ended(job, "failed", host_now(), str(error), not error.is_of_text))
        else:
            self._send(Ended(job, "aborted" if playback.is_halted else "done", host_now()))

    def _warm(self, asked: Warm) -> None:
        """Prepare; problems are reported by the jobs to come."""
        for notes in asked.tones:
            tone(notes)
        with contextlib.suppress(SoundError):
            if self._destination is self._card:
                self._card.open()
        with contextlib.suppress(SoundError):
            if asked.voicing:
                self._engine.speak("1", asked.voicing)

    def _examined(self) -> Examined:
        try:
            found = Examined(voices=self._engine.voices())
        except SoundError as error:
            found = Examined(no_voices=str(error))
        try:
            return msgspec.structs.replace(found, card=self._card.open())
        except SoundError as error:
            return msgspec.structs.replace(found, no_card=str(error))


if __name__ == "__main__":
    main()
