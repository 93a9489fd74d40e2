"""Plays speech and tones in order, on the sound card or into files."""

import itertools
import os
import queue
import re
import threading
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from sar_tui.loop.clock import Clock, Handle, VirtualClock
from sar_tui.model.messages import PartState
from sar_tui.model.theme import Note
from sar_tui.model.units import SECOND
from sar_tui.outputs.output import Report
from sar_tui.outputs.sound.child import VOICE, SoundProgram
from sar_tui.outputs.sound.protocol import (
    Examine,
    Examined,
    Reply,
    Say,
    Setup,
    SoundError,
    Tone,
    Voicing,
    Warm,
)
from sar_tui.outputs.sound.supervisor import PATIENCE_S, Kind, PartEvent, SoundJob, Supervisor


class _TimedJob(NamedTuple):
    job: SoundJob
    seconds: float


class VirtualPlayback:
    """A queue of parts with known durations. ``on_state`` is called when each starts and when it is
    over.
    """

    def __init__(
        self, clock: VirtualClock, on_state: Callable[[SoundJob, PartState], object]
    ) -> None:
        self._clock, self._on_state = clock, on_state
        self._queue: deque[_TimedJob] = deque()
        self._end: Handle | None = None

    def add(self, job: SoundJob, seconds: float) -> None:
        """Add a part with its duration to the end of the queue."""
        self._queue.append(_TimedJob(job, seconds))
        self._begin()

    def stop(self, kind: Kind, action: str = "") -> None:
        """Abort the parts of a kind, of one action or of all."""
        meant = [
            entry
            for entry in self._queue
            if entry.job.kind == kind and action in ("", entry.job.action)
        ]
        if meant and self._end and meant[0] is self._queue[0]:
            self._end.cancel()
            self._end = None
        self._queue = deque(entry for entry in self._queue if entry not in meant)
        for entry in meant:
            self._on_state(entry.job, "aborted")
        self._begin()

    def _begin(self) -> None:
        if self._queue and self._end is None:
            job, seconds = self._queue[0]
            self._end = self._clock.call_at(self._clock.now() + round(seconds * SECOND), self._over)
            self._on_state(job, "started")

    def _over(self) -> None:
        self._end = None
        job, _ = self._queue.popleft()
        self._on_state(job, "done")
        self._begin()


CARD = "sound"
"""The default: the system's sound card."""
_FILE = "file:"
_UNSAFE = re.compile(r"[^A-Za-z0-9_-]+")


def check_sound(where: str) -> None:
    """Check a place for sound: ``sound``, or ``file:FOLDER`` for WAV files in a folder, which need
    not exist yet.

    Raises:
        SoundError: if it cannot be used. Does not check for a sound card.
    """
    folder = sound_folder(where)
    if folder is None:
        return
    try:
        place = next(each for each in (folder, *folder.parents) if each.exists())
        is_folder = place.is_dir()
    except OSError as error:
        raise SoundError(
            f"{folder} cannot be a folder for sound files ({error.strerror}): name another."
        ) from error
    if not is_folder:
        raise SoundError(f"{place} is a file: name a folder for the sound files.")
    if not os.access(place, os.W_OK | os.X_OK):
        raise SoundError(f"{place} is not writable: name another folder for the sound files.")


def examine(
    program: Sequence[str] = VOICE, backends: Sequence[str] = (), patience_s: float = PATIENCE_S
) -> Examined:
    """Find out, in a separate process, what voices and sound system there are.

    Raises:
        SoundError: if the process does not answer in time.
    """
    replies: queue.SimpleQueue[Reply | None] = queue.SimpleQueue()
    voice = SoundProgram(program, Setup(backends=tuple(backends)), replies.put)
    try:
        voice.start()
        voice.send(Examine())
        reply = replies.get(timeout=patience_s)
    except OSError as error:
        raise SoundError(f"The voice cannot be started ({error.strerror or error}).") from error
    except queue.Empty:
        raise SoundError(f"The speech engine gave no answer within {patience_s:g} s.") from None
    finally:
        voice.end()
    if not isinstance(reply, Examined):
        raise SoundError("The voice stopped working when it was asked what it can do.")
    return reply


class Sound:
    """The sound shared by outputs that can be heard, from the first that joins until the last
    leaves.

    On a virtual clock nothing is played: each part is synthesised at once, and takes as long on
    that clock as it would sound. Otherwise the times are those of the voice process: when the first
    samples are fed to the sound card, and when the last have left its buffer.

    Args:
        where: ``sound``, or ``file:FOLDER``; see `check_sound`.
        backends: the sound systems to try, by miniaudio's names (``NULL`` plays in real time
            without sound); all real ones if empty.
        program: the command line of the voice process.
        patience_s: time for a part to start.

    Raises:
        SoundError: if ``where`` is invalid.
    """

    def __init__(
        self,
        where: str = CARD,
        *,
        backends: Sequence[str] = (),
        program: Sequence[str] = VOICE,
        patience_s: float = PATIENCE_S,
    ) -> None:
        self._folder = sound_folder(where)
        self._backends, self._program, self._patience_s = tuple(backends), program, patience_s
        self._jobs = itertools.count(1)
        self._lock = threading.RLock()
        self._reporters: dict[Kind, Callable[[Report], object]] = {}
        self._clock: Clock
        self._supervisor: Supervisor | None = None
        self._playback: VirtualPlayback | None = None
        self._events: queue.SimpleQueue[PartEvent] = queue.SimpleQueue()

    def join(self, kind: Kind, clock: Clock, report: Callable[[Report], object]) -> None:
        """Join with the parts of one kind. ``report`` receives their reports, from any thread,
        until ``leave``.
        """
        with self._lock:
            self._reporters[kind] = report
        if self._supervisor is None:
            is_virtual = isinstance(clock, VirtualClock)
            self._clock = clock
            self._playback = (
                VirtualPlayback(clock, self._report) if isinstance(clock, VirtualClock) else None
            )
            setup = Setup(str(self._folder or ""), self._backends, in_real_time=not is_virtual)
            on_event = self._events.put if is_virtual else self._on_event
            self._supervisor = Supervisor(setup, on_event, self._program, self._patience_s)

    def leave(self, kind: Kind) -> None:
        """Stop, and end the reports. After the last has left, the process and the threads end. May
        be called twice.
        """
        with self._lock:
            self._reporters.pop(kind, None)
        self.stop(kind)
        if self._supervisor and not self._reporters:
            self._supervisor.close()
            self._supervisor = self._playback = None

    def get_ready(
        self, kind: Kind, voicing: Voicing | None = None, tones: Sequence[tuple[Note, ...]] = ()
    ) -> None:
        """Prepare for coming parts, so that they start at once."""
        if self._supervisor:
            self._supervisor.warm(kind, Warm(voicing, tuple(tones)))

    def say(self, action: str, text: str, voicing: Voicing, problem: str = "") -> None:
        """Speak after everything requested before. With a ``problem``, fail with it at that
        time.
        """
        self._add(
            SoundJob(
                "say", action, Say(next(self._jobs), _stem(action, "say"), text, voicing), problem
            )
        )

    def tone(self, action: str, notes: tuple[Note, ...], problem: str = "") -> None:
        """Play a tone after everything requested before. With a ``problem``, fail with it at that
        time.
        """
        self._add(
            SoundJob("tone", action, Tone(next(self._jobs), _stem(action, "tone"), notes), problem)
        )

    def stop(self, kind: Kind, action: str = "") -> None:
        """Stop the parts of a kind: those of one action, or all."""
        if self._playback:
            self._playback.stop(kind, action)
        elif self._supervisor:
            self._supervisor.stop(kind, action)

    def _add(self, job: SoundJob) -> None:
        if self._supervisor is None:
            return
        self._supervisor.add(job)
        if self._playback:
            self._play(self._playback)

    def _play(self, playback: VirtualPlayback) -> None:
        """Wait for the result, which takes no time on the virtual clock; then let its duration pass
        on that clock.
        """
        seconds = 0.0
        while (event := self._events.get()).state == "started":
            seconds = event.seconds
        if event.state == "done":
            playback.add(event.job, seconds)
        else:
            self._report(event.job, event.state, event.detail)

    def _on_event(self, event: PartEvent) -> None:
        self._report(event.job, event.state, event.detail, event.at)

    def _report(
        self, job: SoundJob, state: PartState, detail: str = "", at: int | None = None
    ) -> None:
        with self._lock:
            if report := self._reporters.get(job.kind):
                report(
                    Report(
                        job.action, job.kind, state, self._clock.now() if at is None else at, detail
                    )
                )


def sound_folder(where: str) -> Path | None:
    """Return the folder for sound files; None for the sound card."""
    if where == CARD:
        return None
    name = where.removeprefix(_FILE)
    if name == where or not name.strip():
        raise SoundError(
            f"Sound cannot go to {where!r}: use {CARD}, or {_FILE}FOLDER for WAV files in a folder."
        )
    try:
        return Path(name).expanduser().resolve()
    except (OSError, RuntimeError, ValueError) as error:
        raise SoundError(f"{name!r} is not a folder for sound files: {error}.") from error


def _stem(action: str, what: str) -> str:
    return f"{_UNSAFE.sub('-', action)[:60]}-{what}"
