"""The process that plays the tones of prompts: its sound card never stops, so that they begin when
they are due.

It reads requests from its standard input and writes replies to its original standard output (see
`protocol`), as the voice process does; it is another one, so that speech cannot delay a tone.
"""

import os
from typing import BinaryIO, NoReturn

from sar_tui.loop.clock import host_now
from sar_tui.model.theme import Note
from sar_tui.outputs.sound.player import Folder, Playback, SoundCard
from sar_tui.outputs.sound.protocol import (
    Cue,
    Drop,
    Ended,
    Examine,
    Examined,
    Reckon,
    Request,
    Setup,
    SoundError,
    Started,
    Warm,
    decode_request,
    encode,
)
from sar_tui.outputs.sound.samples import seconds, tone
from sar_tui.outputs.sound.tone_stream import ToneStream
from sar_tui.outputs.sound.voice_main import end_with_parent, own_channels

_SILENT = (
    "The sound card does not play: connect loudspeakers, and choose them in the system's settings."
)


class Tones:
    """Plays tones on a sound card that is opened with the first request; into files, if a folder
    was named.
    """

    def __init__(self, setup: Setup, replies: BinaryIO) -> None:
        self._setup = setup
        self._replies = replies
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

    def _send(self, reply: Started | Ended | Examined) -> None:
        self._replies.write(encode(reply))


def main() -> NoReturn:
    """Do the requests from standard input until it ends."""
    requests, replies = own_channels()
    end_with_parent()
    first = decode_request(requests.readline())
    if not isinstance(first, Setup):
        raise SystemExit(2)
    tones = Tones(first, replies)
    try:
        for line in requests:
            tones.do(decode_request(line))
    finally:
        os._exit(0)  # the card's thread must not keep the process


if __name__ == "__main__":
    main()
