"""The voice: the program of the child process that speaks and sounds, and that may hang or be killed at any time.

It reads requests from its standard input and writes replies to what was its standard output (see `protocol`).
It ends with the program that started it, whatever it is doing: when its input ends, and on Linux by the kernel too.
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

from sar_tui.framework.clock import host_now
from sar_tui.outputs.sound.engine import Engine
from sar_tui.outputs.sound.player import Card, Folder, Nowhere, Place, Turn
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
    line,
    request,
)
from sar_tui.outputs.sound.samples import tone

_PR_SET_PDEATHSIG = 1


class Voice:
    """Does one job after another, on the main thread."""

    def __init__(self, setup: Setup, replies: BinaryIO) -> None:
        self._replies = replies
        self._engine = Engine()
        self._card = Card(setup.backends)
        self._place: Place = self._card
        if setup.folder:
            self._place = Folder(setup.folder, setup.in_real_time)
        elif not setup.in_real_time:
            self._place = Nowhere()

    def do(self, asked: Request, turn: Turn) -> None:
        match asked:
            case Say(job, name, text, voicing):
                self._sound(job, name, lambda: self._engine.speak(text, voicing), turn)
            case Tone(job, name, notes):
                self._sound(job, name, lambda: tone(notes), turn)
            case Warm():
                self._warm(asked)
            case Examine():
                self._send(self._examined())
            case _:
                pass

    def _sound(self, job: int, name: str, make: Callable[[], "array[int]"], turn: Turn) -> None:
        try:
            samples = make()
            if not turn.is_halted:
                self._place.play(name, samples, turn, lambda at, seconds: self._send(Started(job, at, seconds)))
        except SoundError as error:
            at_fault = not isinstance(error, Unreadable)
            self._send(Ended(job, "failed", host_now(), str(error), at_fault))
        else:
            self._send(Ended(job, "aborted" if turn.is_halted else "done", host_now()))

    def _warm(self, asked: Warm) -> None:
        """Whatever is wrong is told by the jobs to come."""
        for notes in asked.tones:
            tone(notes)
        with contextlib.suppress(SoundError):
            if self._place is self._card:
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
        self._replies.write(line(reply))


def main() -> NoReturn:
    """Do what standard input asks for, until it ends."""
    requests, replies = _own_channels()
    _end_with_parent()
    first = request(requests.readline())
    if not isinstance(first, Setup):
        raise SystemExit(2)
    jobs: queue.SimpleQueue[tuple[Request, Turn]] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(requests, jobs), name="requests", daemon=True).start()
    voice = Voice(first, replies)
    while True:
        voice.do(*jobs.get())


def _listen(requests: BinaryIO, jobs: "queue.SimpleQueue[tuple[Request, Turn]]") -> None:
    """Hand on requests, but for those to stop, which count at once; and end the process when there are no more."""
    latest, turn = 0, Turn()
    try:
        for each in requests:
            match request(each):
                case Stop(job):
                    if job == latest:
                        turn.halt()
                case Say(job) | Tone(job) as asked:
                    latest, turn = job, Turn()
                    jobs.put((asked, turn))
                case asked:
                    jobs.put((asked, Turn()))
    finally:
        os._exit(0)


def _own_channels() -> tuple[BinaryIO, BinaryIO]:
    """Standard input and output, for us alone: libraries that print or read find nothing there."""
    requests = os.fdopen(os.dup(0), "rb")
    replies = os.fdopen(os.dup(1), "wb", buffering=0)
    nothing = os.open(os.devnull, os.O_RDWR)
    for standard in (0, 1, 2):
        os.dup2(nothing, standard)
    os.close(nothing)
    return requests, replies


def _end_with_parent() -> None:
    """Have the kernel kill us when the program goes, for a thread of ours may not get its turn (Linux only)."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


if __name__ == "__main__":
    main()
