"""The tones of prompts: has them played in a process of its own, and reports when each began."""

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from sar_tui.loop.bus import Topic
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.node import Node, on
from sar_tui.loop.topics import TONE_BEGAN, TONE_DUE, TONES_AHEAD, TRIAL, VOIDED
from sar_tui.model import messages as m

if TYPE_CHECKING:
    from sar_tui.outputs.sound.tone_process import Onset, ToneProcess


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
        self._where, self._backends = where, backends
        self._process: ToneProcess | None = None
        self._jobs = itertools.count(1)
        self._due: dict[int, m.ToneDue] = {}

    @on(TONES_AHEAD)
    def get_ready(self, ahead: m.TonesAhead) -> None:
        if process := None if self._is_virtual else self._started():
            process.prepare(ahead.tones)

    @on(TONE_DUE)
    def play(self, due: m.ToneDue) -> None:
        if self._is_virtual:
            self._report(due, max(due.at, self.now), "virtual")
            return
        job = next(self._jobs)
        self._due[job] = due
        if process := self._started():
            process.play(job, due.tone, due.at)

    @on(TRIAL)
    def trial_ended(self, _: m.TrialEnded) -> None:
        self._drop()

    @on(VOIDED)
    def voided(self, _: m.PromptVoided) -> None:
        self._drop()

    def detach(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process:
            process.close()

    @property
    def _is_virtual(self) -> bool:
        return isinstance(self.bus.clock, VirtualClock)

    def _drop(self) -> None:
        """Leave out what has not sounded."""
        due, self._due = self._due, {}
        if self._process:
            for job in due:
                self._process.drop(job)

    def _started(self) -> "ToneProcess | None":
        """Return the process, started if it has not been or has ended; None if it cannot be."""
        if self._process is None or self._process.has_ended:
            from sar_tui.outputs.sound.tone_process import ToneProcess

            try:
                self._process = ToneProcess(self._began, self._where, self._backends)
            except OSError as error:
                self._fail(self.now, f"They cannot be played ({error.strerror or error}).")
        return self._process

    def _began(self, onset: "Onset") -> None:
        """Report an onset. Called from a thread of the process."""
        if onset.job == 0:
            self._fail(onset.at, onset.detail)
        elif due := self._due.get(onset.job):
            self._report(due, onset.at, onset.source, onset.detail)

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
