"""The keyboard as a sensor: keys, pastes and the window's focus become messages, with the terminal's stamps."""

from typing import TypeVar

from sar_tui.framework.bus import Bus, Topic
from sar_tui.framework.clock import SECOND
from sar_tui.framework.messages import FocusChanged, KeyPressed, Message, Pasted
from sar_tui.framework.node import Node
from sar_tui.framework.topics import FOCUS, KEY, PASTE

M = TypeVar("M", bound=Message)

_IGNORED = ("ctrl+", "alt+", "super+", "meta+", "hyper+")
_NAMED = {"return": "enter", " ": "space", "\r": "enter", "\t": "tab"}


def key_name(key: str, character: str | None) -> str | None:
    """How a key is called in messages: the character it types, else its name; None for no response key.

    Escape, function keys and chords steer the program; they are never a response.

    Args:
        key: the terminal library's name, e.g. ``question_mark``, ``left``.
        character: what it types, if anything.
    """
    if key == "escape" or key.startswith(_IGNORED) or (key[:1] == "f" and key[1:].isdigit()):
        return None
    if character and character.isprintable() and not character.isspace():
        return character
    return _NAMED.get(key, key)


class Keyboard(Node):
    """Publishes what a person does at the keyboard. A terminal tells presses only, never releases.

    A stamp is the terminal library's time in seconds, on the session's clock. What is done before the session has
    begun is nobody's response, and is let pass.
    """

    name = "keyboard"
    emits = (KEY, PASTE, FOCUS)

    def __init__(self) -> None:
        super().__init__()
        self._attached = False

    def attach(self, bus: Bus) -> None:
        """Join a bus; from here on there is somebody to tell."""
        super().attach(bus)
        self._attached = True

    def pressed(self, key: str, character: str | None, seconds: float, loop_lag: int = 0) -> None:
        """A key was pressed. ``loop_lag`` in ns, as `messages.KeyPressed`."""
        if name := key_name(key, character):
            self._tell(KEY, KeyPressed(key=name, at=_ns(seconds), loop_lag=loop_lag))

    def pasted(self, length: int, seconds: float) -> None:
        """Text was pasted."""
        self._tell(PASTE, Pasted(length=length, at=_ns(seconds)))

    def focused(self, focused: bool, seconds: float) -> None:
        """The window gained or lost the focus."""
        self._tell(FOCUS, FocusChanged(focused=focused, at=_ns(seconds)))

    def _tell(self, topic: Topic[M], message: M) -> None:
        if self._attached:
            self.bus.post(topic, message)


def _ns(seconds: float) -> int:
    return round(seconds * SECOND)
