"""The program's side of the process that plays the tones of prompts."""

from collections.abc import Callable, Iterable, Sequence
from typing import Literal, NamedTuple

from sar_tui.drivers import child_process
from sar_tui.loop.clock import host_now
from sar_tui.model.theme import Note
from sar_tui.model.tone import Tone
from sar_tui.outputs.sound.mixer import CARD, sound_folder
from sar_tui.outputs.sound.protocol import (
    Cue,
    Drop,
    Ended,
    Examine,
    Examined,
    Reckon,
    Reply,
    Setup,
    Started,
    Warm,
)
from sar_tui.outputs.sound.voice_process import VoiceProcess

PROGRAM = child_process.python("sar_tui.outputs.sound.tone_main")
_LOST = "The program that plays the tones of prompts has ended."


class Onset(NamedTuple):
    """The time ``at`` which a tone begins to sound (ns, `host_now`), or why it is not heard.

    ``source``: as in `messages.ToneBegan`. ``job``: of the tone; 0 for all, if the process has
    ended.
    """

    job: int
    at: int
    source: Literal["device", "host", "failed"]
    detail: str = ""


class ToneProcess:
    """Plays tones at given times, on the sound card or into files.

    Args:
        on_onset: called from a thread of its own when the onset of a tone is known, or that it is
            not heard.
        where: ``sound``, or ``file:FOLDER`` (see `mixer.check_sound`).
        backends: the sound systems to try, by miniaudio's names; all real ones if empty.
        on_examined: called from that thread with what `examine` found.

    Raises:
        OSError: the process cannot be started.
    """

    def __init__(
        self,
        on_onset: Callable[[Onset], object],
        where: str = CARD,
        backends: Sequence[str] = (),
        on_examined: Callable[[Examined], object] = lambda card: None,
    ) -> None:
        self._on_onset = on_onset
        self._on_examined = on_examined
        self._child = VoiceProcess(
            Setup(str(sound_folder(where) or ""), tuple(backends)), self._receive, PROGRAM
        )

    @property
    def has_ended(self) -> bool:
        """True if the process has ended."""
        return self._child.has_ended

    def prepare(self, tones: Iterable[Tone]) -> None:
        """Start the sound card, and make the samples of tones."""
        self._child.send(Warm(tones=tuple((Note(tone.hz, tone.ms),) for tone in tones)))  # type: ignore[arg-type]

    def play(self, job: int, tone: Tone, at: int) -> None:
        """Play a tone ``at`` a time (ns), or as soon as possible after it."""
        self._child.send(Cue(job, tone.hz, tone.ms, at, tone.offsets_ms))

    def drop(self, job: int) -> None:
        """Leave out what of a tone has not begun to sound."""
        self._child.send(Drop(job))

    def examine(self) -> None:
        """Start the sound card, and report it."""
        self._child.send(Examine())

    def reckon(self, job: int) -> None:
        """Have the onset of a tone reported again, as the clock of the card tells now."""
        self._child.send(Reckon(job))

    def close(self) -> None:
        """End the process."""
        self._child.kill()

    def _receive(self, _: VoiceProcess, reply: Reply | None) -> None:
        match reply:
            case Started(job, at, by=by):
                self._on_onset(Onset(job, at, by))
            case Ended(job, "failed", at, detail):
                self._on_onset(Onset(job, at, "failed", detail))
            case Examined():
                self._on_examined(reply)
            case None:
                self._on_onset(Onset(0, host_now(), "failed", _LOST))
