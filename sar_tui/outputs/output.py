"""The contract of an output: a medium through which the agent reaches the participant."""

from collections.abc import Callable
from typing import Literal, NamedTuple

from sar_tui.framework.clock import Clock
from sar_tui.framework.messages import ActionPart, PartState
from sar_tui.framework.theme import Theme

Gaze = Literal["ahead", "left", "right", "up", "down"]


class Report(NamedTuple):
    """What became of a deed: ``action`` and ``deed`` say which, ``at`` when (ns of the session's clock).

    ``state``: ``started`` (it can be heard or seen), ``done``, ``aborted`` (stopped before its end: when it was still;
    a ``detail`` says why it may not be), ``failed`` (``detail`` says why, and what to do about it).
    """

    action: str
    deed: ActionPart
    state: PartState
    at: int
    detail: str = ""


class Output:
    """A medium. Subclass it, name it, say what it ``can`` do, and override those methods; the rest is never called.

    Each deed that is asked for is reported once as over (``done``, ``aborted`` or ``failed``), and before that as
    ``started`` if it ever began; ``tell`` may be called from any thread. What is asked for while something is under
    way waits its turn (within one kind of deed). No method waits for a device, or raises for one that is missing:
    what is asked of it then fails. ``stop`` makes everything still at once, and each deed aborted; after it the
    output can be used again.
    """

    name: str
    """What it is called in settings and in the log."""
    can: frozenset[ActionPart] = frozenset()
    """Which of ``say``, ``show``, ``gesture``, ``gaze`` and ``tone`` it does."""

    def open(self, theme: Theme, clock: Clock, tell: Callable[[Report], None]) -> None:
        """Get ready. ``theme`` has the language, the voice, the gestures; ``clock`` the time of all reports."""
        self.clock = clock
        self._tell = tell
        self.wear(theme)

    def wear(self, theme: Theme) -> None:
        """Take on a theme: at the beginning, and again whenever it is edited. What is under way may go on as it was."""
        self.theme = theme

    def say(self, action: str, text: str) -> None:
        """Speak ``text``, as it is to be spoken."""
        raise NotImplementedError

    def show(self, action: str, text: str, face: str) -> None:
        """Put up words and an expression (one of `theme.FACES`). Done when others take their place."""
        raise NotImplementedError

    def gesture(self, action: str, name: str) -> None:
        """Move through one of the theme's gestures."""
        raise NotImplementedError

    def gaze(self, action: str, where: str) -> None:
        """Look somewhere (see `Gaze`)."""
        raise NotImplementedError

    def tone(self, action: str, name: str) -> None:
        """Sound one of the theme's short tones."""
        raise NotImplementedError

    def stop(self, action: str = "") -> None:
        """Be still: one action, or all of them. Harmless when nothing is under way.

        Raises OutputError, a clear sentence for the log, if something may be going on that no deed tells of any more.
        """

    def close(self) -> None:
        """Be still, and let go of devices, threads and processes. Nothing is reported afterwards. Harmless twice."""

    def tell(self, action: str, deed: ActionPart, state: PartState, detail: str = "") -> None:
        """Report what became of a deed, now."""
        self._tell(Report(action, deed, state, self.clock.now(), detail))


class OutputError(Exception):
    """An output cannot be made from what was asked for; one or two clear sentences."""
