"""The voice process, which speaks and plays. It may hang or be killed at any time.

It reads requests from its standard input and writes replies to its original standard output (see
`protocol`). It ends when its input ends; on Linux the kernel also kills it with the program that
started it, even if it hangs.
"""

import contextlib
import ctypes
import os
import queue
import signal
import sys
import threading
from array import array
from collections.abc import Callable
from typing import BinaryIO, NoReturn

import msgspec

from sar_tui.loop.clock import host_now
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
    Unreadable,
    Warm,
    decode_request,
    encode,
)
from sar_tui.outputs.sound.samples import tone

_PR_SET_PDEATHSIG = 1


class Voice:
    """Does one job after another on the main thread."""

    def __init__(self, setup: Setup, replies: BinaryIO) -> None:
        self._replies = replies
        self._engine = Engine()
        self._card = SoundCard(setup.backends)
        self._destination: Destination = self._card
        if setup.folder:
            self._destination = Folder(setup.folder, setup.in_real_time)
        elif not setup.in_real_time:
            self._destination = NoSound()

    def do(self, asked: Request, playback: Playback) -> None:
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
            at_fault = not isinstance(error, Unreadable)
            self._send(Ended(job, "failed", host_now(), str(error), at_fault))
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

    def _send(self, reply: Reply) -> None:
        self._replies.write(encode(reply))


def main() -> NoReturn:
    """Do the requests from standard input until it ends."""
    requests, replies = own_channels()
    end_with_parent()
    first = decode_request(requests.readline())
    if not isinstance(first, Setup):
        raise SystemExit(2)
    jobs: queue.SimpleQueue[tuple[Request, Playback]] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(requests, jobs), name="requests", daemon=True).start()
    voice = Voice(first, replies)
    while True:
        voice.do(*jobs.get())


def _listen(requests: BinaryIO, jobs: "queue.SimpleQueue[tuple[Request, Playback]]") -> None:
    """Queue requests, except stops, which take effect at once. Ends the process after the last
    request.
    """
    latest, playback = 0, Playback()
    try:
        for each in requests:
            match decode_request(each):
                case Stop(job):
                    if job == latest:
                        playback.halt()
                case Say(job) | Tone(job) as asked:
                    latest, playback = job, Playback()
                    jobs.put((asked, playback))
                case asked:
                    jobs.put((asked, Playback()))
    finally:
        os._exit(0)


def own_channels() -> tuple[BinaryIO, BinaryIO]:
    """Take over standard input and output; libraries that print or read get the null device."""
    requests = os.fdopen(os.dup(0), "rb")
    replies = os.fdopen(os.dup(1), "wb", buffering=0)
    nothing = os.open(os.devnull, os.O_RDWR)
    for standard in (0, 1, 2):
        os.dup2(nothing, standard)
    os.close(nothing)
    return requests, replies


def end_with_parent() -> None:
    """Have the kernel kill this process when its parent ends, as our own thread may not get to run
    (Linux only).
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


if __name__ == "__main__":
    main()
