"""The keyboard as a sensor: keys, pastes and window focus become messages with the terminal's
stamps.
"""

from typing import TypeVar

from sar_tui.loop.bus import Bus, Topic
from sar_tui.loop.node import Node
from sar_tui.loop.topics import FOCUS, KEY, PASTE, SWITCH, UNREADABLE
from sar_tui.model.messages import (
    FocusChanged,
    InputDropped,
    KeyPressed,
    Message,
    Pasted,
    SwitchPressed,
)
from sar_tui.model.units import SECOND
from sar_tui.rules.scanning import Pressed

M = TypeVar("M", bound=Message)

_IGNORED = ("ctrl+", "alt+", "super+", "meta+", "hyper+")
_NAMED = {"return": "enter", " ": "space", "\r": "enter", "\t": "tab"}


def key_name(key: str, character: str | None) -> str | None:
    """Return a key's name in messages: the character it types, otherwise its name; None if it is no
    response key.

    Escape, function keys and chords control the program; they are never a response.

    Args:
        key: the terminal library's name, such as ``question_mark`` or ``left``.
        character: the character it types, if any.
    """
    if key == "escape" or key.startswith(_IGNORED) or (key[:1] == "f" and key[1:].isdigit()):
        return None
    if character and character.isprintable() and not character.isspace():
        return character
    return _NAMED.get(key, key)


class Keyboard(Node):
    """Publishes keyboard events. A terminal reports presses only, never releases.

    A stamp is the terminal library's time in seconds, on the session's clock. Events before the
    start of the session are ignored.
    """

    name = "keyboard"
    emits = (KEY, SWITCH, PASTE, UNREADABLE, FOCUS)

    def __init__(self) -> None:
        super().__init__()
        self._attached = False

    def attach(self, bus: Bus) -> None:
        """Join a bus; events are published from here on."""
        super().attach(bus)
        self._attached = True

    def pressed(
        self,
        key: str,
        character: str | None,
        seconds: float,
        loop_lag: int = 0,
        stalled: bool = False,
    ) -> None:
        """Publish a key press. ``loop_lag`` (ns) and ``stalled`` as in `messages.KeyPressed`."""
        if name := key_name(key, character):
            self._publish(
                KEY, KeyPressed(key=name, at=_ns(seconds), loop_lag=loop_lag, stalled=stalled)
            )

    def switched(self, key: str, seconds: float, pressed: Pressed, interval_ms: int) -> None:
        """Publish a press of a switch."""
        message = SwitchPressed(
            key=key,
            at=_ns(seconds),
            outcome=pressed.outcome,
            choice=pressed.choice,
            interval_ms=interval_ms,
            press_ms=pressed.press_ms,
        )
        self._publish(SWITCH, message)

    def pasted(self, length: int, seconds: float) -> None:
        """Publish a paste."""
        self._publish(PASTE, Pasted(length=length, at=_ns(seconds)))

    def dropped(self, what: str, seconds: float) -> None:
        """Publish that input was dropped."""
        self._publish(UNREADABLE, InputDropped(what=what, at=_ns(seconds)))

    def focused(self, focused: bool, seconds: float) -> None:
        """Publish a change of the window's focus."""
        self._publish(FOCUS, FocusChanged(focused=focused, at=_ns(seconds)))

    def _publish(self, topic: Topic[M], message: M) -> None:
        if self._attached:
            self.bus.post(topic, message)


def _ns(seconds: float) -> int:
    return round(seconds * SECOND)
