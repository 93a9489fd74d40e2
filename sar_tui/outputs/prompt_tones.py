"""The tones of prompts: has them played in a process of its own, and reports when each began."""

import itertools
from collections.abc import Iterable, Sequence
from typing import Any, ClassVar

from sar_tui.loop.bus import Topic
from sar_tui.loop.clock import VirtualClock, host_now
from sar_tui.loop.node import Node, on
from sar_tui.loop.topics import TONE_BEGAN, TONE_DUE, TONES_AHEAD, TRIAL, VOIDED
from sar_tui.model import messages as m
from sar_tui.model.theme import Note
from sar_tui.model.tone import Tone
from sar_tui.outputs.sound.child import TONES, SoundProgram
from sar_tui.outputs.sound.mixer import sound_folder
from sar_tui.outputs.sound.protocol import Cue, Drop, Ended, Reply, Setup, Started, Warm

_LOST = "The program that plays the tones of prompts has ended."


class PromptTones(Node):
    """Plays the tones of prompts, on the sound card or into files. A session without such tones
    starts no process.

    On a virtual clock nothing is played.

    Args:
        where: ``sound``, or ``file:FOLDER`` (see `sound.mixer.check_sound`).
        backends: the sound systems to try, by miniaudio's names; all real ones if empty.
    """

    name = "prompt_tones"
    emits: ClassVar[tuple[Topic[Any], ...]] = (TONE_BEGAN,)

    def __init__(self, where: str, backends: Sequence[str] = ()) -> None:
        super().__init__()
        setup = Setup(str(sound_folder(where) or ""), tuple(backends))
        self._program = SoundProgram(TONES, setup, self._receive)
        self._jobs = itertools.count(1)
        self._due: dict[int, m.ToneDue] = {}

    @on(TONES_AHEAD)
    def get_ready(self, ahead: m.TonesAhead) -> None:
        if not self._is_virtual:
            try:
                self._program.prepare("tones", warm(ahead.tones))
            except OSError as error:
                self._cannot_start(error)

    @on(TONE_DUE)
    def play(self, due: m.ToneDue) -> None:
        if self._is_virtual:
            self._report(due, max(due.at, self.now), "virtual")
            return
        job = next(self._jobs)
        self._due[job] = due
        try:
            self._program.start()
        except OSError as error:
            self._cannot_start(error)
        else:
            self._program.send(cue(job, due.tone, due.at))

    @on(TRIAL)
    def trial_ended(self, _: m.TrialEnded) -> None:
        self._drop()

    @on(VOIDED)
    def voided(self, _: m.PromptVoided) -> None:
        self._drop()

    def detach(self) -> None:
        """End the process."""
        self._program.end()

    @property
    def _is_virtual(self) -> bool:
        return isinstance(self.bus.clock, VirtualClock)

    def _drop(self) -> None:
        """Leave out what has not sounded."""
        due, self._due = self._due, {}
        for job in due:
            self._program.send(Drop(job))

    def _receive(self, reply: Reply | None) -> None:
        """Report an onset, from a thread of the program."""
        match reply:
            case Started(job, at, by=by) if due := self._due.get(job):
                self._report(due, at, by)
            case Ended(job, "failed", at, detail) if due := self._due.get(job):
                self._report(due, at, "failed", detail)
            case None:
                self._fail(host_now(), _LOST)

    def _cannot_start(self, error: OSError) -> None:
        self._fail(self.now, f"They cannot be played ({error.strerror or error}).")

    def _fail(self, at: int, detail: str) -> None:
        for due in list(self._due.values()):
            self._report(due, at, "failed", detail)

    def _report(self, due: m.ToneDue, at: int, source: Any, detail: str = "") -> None:
        began = m.ToneBegan(
            seat=due.seat,
            attempt=due.attempt,
            trial=due.trial,
            presentation=due.presentation,
            frame=due.frame,
            at=at,
            source=source,
            detail=detail,
        )
        self.bus.post(TONE_BEGAN, began)


def warm(tones: Iterable[Tone]) -> Warm:
    """Return the request to prepare tones of prompts."""
    return Warm(tones=tuple((Note(tone.hz, tone.ms),) for tone in tones))  # type: ignore[arg-type]


def cue(job: int, tone: Tone, at: int) -> Cue:
    """Return the request to play a tone ``at`` a time (ns), or as soon as possible after it."""
    return Cue(job, tone.hz, tone.ms, at, tone.offsets_ms)
