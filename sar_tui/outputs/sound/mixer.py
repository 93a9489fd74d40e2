"""The one path of all that is heard: speech and tones go through it in their order, to the sound card or to files."""

import itertools
import os
import queue
import re
import threading
from collections.abc import Callable, Sequence
from pathlib import Path

from sar_tui.framework.clock import Clock, VirtualClock
from sar_tui.framework.messages import PartState
from sar_tui.framework.theme import Note
from sar_tui.outputs.output import Report
from sar_tui.outputs.sound.child import PROGRAM, Child
from sar_tui.outputs.sound.protocol import Examine, Examined, Reply, Say, Setup, SoundError, Tone, Voicing, Warm
from sar_tui.outputs.sound.supervisor import PATIENCE_S, Ask, Kind, News, Supervisor
from sar_tui.outputs.sound.turns import Turns

CARD = "sound"
"""Where sound goes if nothing else is said: the system's default sound card."""
_FILE = "file:"
_UNSAFE = re.compile(r"[^A-Za-z0-9_-]+")


def check_sound(where: str) -> None:
    """Whether sound can go there: ``sound``, or ``file:FOLDER`` for WAV files in a folder, which need not exist yet.

    Raises:
        SoundError: it cannot, and why. Whether there is a sound card is not looked at.
    """
    folder = _folder(where)
    if folder is None:
        return
    try:
        place = next(each for each in (folder, *folder.parents) if each.exists())
        is_folder = place.is_dir()
    except OSError as error:
        raise SoundError(f"{folder} cannot be a folder for sound files ({error.strerror}): name another.") from error
    if not is_folder:
        raise SoundError(f"{place} is a file: name a folder for the sound files.")
    if not os.access(place, os.W_OK | os.X_OK):
        raise SoundError(f"{place} may not be written to: name another folder for the sound files.")


def examine(program: Sequence[str] = PROGRAM, backends: Sequence[str] = (), patience_s: float = PATIENCE_S) -> Examined:
    """What there is to speak and to sound with, found out by a child process of its own.

    Raises:
        SoundError: the child gave no answer in time.
    """
    heard: queue.SimpleQueue[Reply | None] = queue.SimpleQueue()
    try:
        child = Child(Setup(backends=tuple(backends)), lambda _, reply: heard.put(reply), program)
    except OSError as error:
        raise SoundError(f"The voice cannot be started ({error.strerror or error}).") from error
    try:
        child.send(Examine())
        reply = heard.get(timeout=patience_s)
    except queue.Empty:
        raise SoundError(f"The speech engine gave no answer within {patience_s:g} s.") from None
    finally:
        child.kill()
    if not isinstance(reply, Examined):
        raise SoundError("The voice stopped working as it was asked what it can do.")
    return reply


class Sound:
    """What the outputs that are heard share; it is there from when the first joins until the last leaves.

    On a clock that jumps nothing is heard: each part is made at once, and lasts as long on that clock as it would
    sound. On any other, times are the child's: as the first samples are fed to the sound card, and as the last have
    left its buffer.

    Args:
        where: ``sound``, or ``file:FOLDER``; see `check_sound`.
        backends: the sound systems to try, by miniaudio's names (``NULL`` plays in real time to no one); all that
            have loudspeakers if empty.
        program: the child's command line.
        patience_s: how long a part may take to begin.

    Raises:
        SoundError: ``where`` is neither.
    """

    def __init__(
        self,
        where: str = CARD,
        *,
        backends: Sequence[str] = (),
        program: Sequence[str] = PROGRAM,
        patience_s: float = PATIENCE_S,
    ) -> None:
        self._folder = _folder(where)
        self._backends, self._program, self._patience_s = tuple(backends), program, patience_s
        self._jobs = itertools.count(1)
        self._lock = threading.RLock()
        self._listeners: dict[Kind, Callable[[Report], object]] = {}
        self._clock: Clock
        self._keeper: Supervisor | None = None
        self._turns: Turns | None = None
        self._news: queue.SimpleQueue[News] = queue.SimpleQueue()

    def join(self, kind: Kind, clock: Clock, tell: Callable[[Report], object]) -> None:
        """Take part, with the parts of one kind. ``tell`` hears of them, from any thread, until it leaves."""
        with self._lock:
            self._listeners[kind] = tell
        if self._keeper is None:
            is_virtual = isinstance(clock, VirtualClock)
            self._clock = clock
            self._turns = Turns(clock, self._tell) if isinstance(clock, VirtualClock) else None
            setup = Setup(str(self._folder or ""), self._backends, in_real_time=not is_virtual)
            told = self._news.put if is_virtual else self._told
            self._keeper = Supervisor(setup, told, self._program, self._patience_s)

    def leave(self, kind: Kind) -> None:
        """Be still, and tell no more. As the last leaves, the child process and the threads end. Harmless twice."""
        with self._lock:
            self._listeners.pop(kind, None)
        self.stop(kind)
        if self._keeper and not self._listeners:
            self._keeper.close()
            self._keeper = self._turns = None

    def get_ready(self, kind: Kind, voicing: Voicing | None = None, tones: Sequence[tuple[Note, ...]] = ()) -> None:
        """Load what is to come, so that it begins at once."""
        if self._keeper:
            self._keeper.warm(kind, Warm(voicing, tuple(tones)))

    def say(self, action: str, text: str, voicing: Voicing, problem: str = "") -> None:
        """Speak, after all that was asked for before; or, where there is a ``problem``, fail with it then."""
        self._ask(Ask("say", action, Say(next(self._jobs), _stem(action, "say"), text, voicing), problem))

    def tone(self, action: str, notes: tuple[Note, ...], problem: str = "") -> None:
        """Sound a tone, after all that was asked for before; or, where there is a ``problem``, fail with it then."""
        self._ask(Ask("tone", action, Tone(next(self._jobs), _stem(action, "tone"), notes), problem))

    def stop(self, kind: Kind, action: str = "") -> None:
        """Be still: the parts of a kind, of one action or of all."""
        if self._turns:
            self._turns.stop(kind, action)
        elif self._keeper:
            self._keeper.stop(kind, action)

    def _ask(self, ask: Ask) -> None:
        if self._keeper is None:
            return
        self._keeper.ask(ask)
        if self._turns:
            self._take_turn(self._turns)

    def _take_turn(self, turns: Turns) -> None:
        """Wait until the sound is made, for no time of this clock; then let its time pass on this clock."""
        seconds = 0.0
        while (news := self._news.get()).state == "started":
            seconds = news.seconds
        if news.state == "done":
            turns.add(news.ask, seconds)
        else:
            self._tell(news.ask, news.state, news.detail)

    def _told(self, news: News) -> None:
        self._tell(news.ask, news.state, news.detail, news.at)

    def _tell(self, ask: Ask, state: PartState, detail: str = "", at: int | None = None) -> None:
        with self._lock:
            if tell := self._listeners.get(ask.kind):
                tell(Report(ask.action, ask.kind, state, self._clock.now() if at is None else at, detail))


def _folder(where: str) -> Path | None:
    """The folder that sound files go to; None for the sound card."""
    if where == CARD:
        return None
    name = where.removeprefix(_FILE)
    if name == where or not name.strip():
        raise SoundError(f"Sound cannot go to {where!r}: say {CARD}, or {_FILE}FOLDER for WAV files in a folder.")
    try:
        return Path(name).expanduser().resolve()
    except (OSError, RuntimeError, ValueError) as error:
        raise SoundError(f"{name!r} is no folder for sound files: {error}.") from error


def _stem(action: str, what: str) -> str:
    return f"{_UNSAFE.sub('-', action)[:60]}-{what}"
