"""The contract of an output: a medium through which the agent reaches the participant."""

from collections.abc import Callable
from typing import Any, Literal, NamedTuple

from sar_tui.loop.clock import Clock
from sar_tui.model.messages import ActionPart, PartState
from sar_tui.model.theme import Theme
from sar_tui.plugin_calls import mark_methods

Gaze = Literal["ahead", "left", "right", "up", "down"]


class Report(NamedTuple):
    """State of one part of an action at a time ``at`` (ns of the session's clock).

    ``state``: ``started`` (it can be heard or seen), ``done``, ``aborted`` (stopped before its end;
    ``at`` is when it was still, and ``detail`` says why it may not be), ``failed`` (``detail`` says
    why, and what to do about it).
    """

    action: str
    part: ActionPart
    state: PartState
    at: int
    detail: str = ""


class Output:
    """A medium. Subclass it, set ``name`` and ``can``, and override the methods of those parts; no
    others are called.

    Report each part once as over (``done``, ``aborted`` or ``failed``), and before that as
    ``started`` if it began; ``report`` may be called from any thread. Queue requests that arrive
    while another one of the same part is under way. Never wait for a device, and never raise if one
    is missing: report the part as failed. ``stop`` halts everything at once, and each part is
    aborted; the output can be used again afterwards.
    """

    name: str
    """Its name in settings and in the log."""
    can: frozenset[ActionPart] = frozenset()
    """The parts of an action that it performs: ``say``, ``show``, ``gesture``, ``gaze``,
    ``tone``.
    """
    simulated: bool = False
    """True in a simulated session, where nobody is there and time jumps. Set before it is
    opened.
    """

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        mark_methods(cls, "output")
        if "wear" in vars(cls):
            raise OutputError(
                f"{cls.__name__} is written for an earlier version of sar-tui: rename its method "
                "wear to apply_theme."
            )

    def open(self, theme: Theme, clock: Clock, report: Callable[[Report], None]) -> None:
        """Get ready. ``theme`` has the language, voice and gestures; ``clock`` gives the time of
        all reports.
        """
        self.clock = clock
        self._send_report = report
        self.apply_theme(theme)

    def apply_theme(self, theme: Theme) -> None:
        """Use a theme: on opening, and again whenever it is edited. Parts under way may finish with
        the old one.
        """
        self.theme = theme

    def say(self, action: str, text: str) -> None:
        """Speak ``text``, which is written as it is to be spoken."""
        raise self._without("say")

    def show(self, action: str, text: str, face: str) -> None:
        """Display a text and an expression (one of `theme.FACES`). Done when others replace
        them.
        """
        raise self._without("show")

    def gesture(self, action: str, name: str) -> None:
        """Perform one of the theme's gestures."""
        raise self._without("gesture")

    def gaze(self, action: str, where: str) -> None:
        """Look somewhere (see `Gaze`)."""
        raise self._without("gaze")

    def tone(self, action: str, name: str) -> None:
        """Play one of the theme's short tones."""
        raise self._without("tone")

    def _without(self, part: ActionPart) -> "OutputError":
        """Return the error of an output that lists a part in ``can`` and does not perform it."""
        return OutputError(
            f"{type(self).__name__} lists {part} in its can, but has no method {part}."
        )

    def stop(self, action: str = "") -> None:
        """Stop one action, or all of them. Harmless if nothing is under way.

        Raises OutputError, a clear sentence for the log, if something that is no longer reported
        may still go on.
        """

    def close(self) -> None:
        """Stop, and release devices, threads and processes. Nothing is reported afterwards. May be
        called twice.
        """

    def report(self, action: str, part: ActionPart, state: PartState, detail: str = "") -> None:
        """Report the present state of a part."""
        self._send_report(Report(action, part, state, self.clock.now(), detail))

    tell = report
    """Its name in earlier versions, for outputs that were written for them."""


class OutputError(Exception):
    """An output cannot be made as requested. The message is one or two clear sentences."""
