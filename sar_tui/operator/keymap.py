"""What an operator can do, and the key of each."""

import unicodedata
from typing import Literal, NamedTuple

from textual.binding import Binding
from textual.keys import KEY_NAME_REPLACEMENTS, Keys

PREFIX = "wizard-"
"""Before an id, in the ids of Textual's bindings: they are the app's, too."""
MOST_EVENTS = 6
"""Keys there are for marking an event."""


class KeyCommand(NamedTuple):
    """Something an operator can do: its id in the file, its keys, its action, what the footer calls it, and what it is.

    ``group``: under which heading the help lists it. ``acts``: not for an observer. ``foot``: the footer shows it.
    """

    id: str
    keys: str
    action: str
    short: str
    words: str
    group: Literal["Proposals", "Session", "Palette", "Words and notes", "Panel"]
    acts: bool = True
    foot: bool = False


DEEDS = (
    KeyCommand("approve", "enter", "approve", "Approve", "Approve", "Proposals"),
    KeyCommand("veto", "x,delete", "veto", "Veto", "Veto", "Proposals"),
    KeyCommand("edit", "e", "edit", "Edit", "Change its words, or level", "Proposals"),
    KeyCommand("positive", "plus", "valence('positive')", "Positive", "A positive face, same words", "Proposals"),
    KeyCommand("neutral", "equals_sign", "valence('neutral')", "Neutral", "A neutral face, same words", "Proposals"),
    KeyCommand("negative", "minus", "valence('negative')", "Negative", "A negative face, same words", "Proposals"),
    KeyCommand("next", "right,down", "select(1)", "Next", "The next proposal", "Proposals", acts=False),
    KeyCommand("previous", "left,up", "select(-1)", "Previous", "The one before", "Proposals", acts=False),
    KeyCommand("stop", "f2", "stop", "Stop", "Stop the agent, at once", "Session", foot=True),
    KeyCommand("pause", "space", "pause", "Pause", "Pause, or go on", "Session", foot=True),
    KeyCommand("skip", "s", "skip", "Skip", "Skip this prompt", "Session", foot=True),
    KeyCommand("repeat", "r", "repeat", "Repeat", "Repeat this prompt", "Session", foot=True),
    KeyCommand("level-up", "u", "level(1)", "Up", "Level up", "Session", foot=True),
    KeyCommand("level-down", "d", "level(-1)", "Down", "Level down", "Session", foot=True),
    KeyCommand("hold", "h", "hold", "Hold", "Hold the level, or let go", "Session", foot=True),
    KeyCommand("end", "end", "end", "End", "End the session (asks once)", "Session"),
    *(
        KeyCommand(
            f"pick-{number % 10}", str(number % 10), f"pick({index})", "", f"Number {number} of the palette", "Palette"
        )
        for index, number in enumerate(range(1, 11))
    ),
    KeyCommand("page", "tab", "page(1)", "Page", "Next page", "Palette", acts=False),
    KeyCommand("page-back", "shift+tab", "page(-1)", "Page back", "Page before", "Palette", acts=False),
    KeyCommand("phrases", "p", "show('phrases')", "Phrases", "Phrases", "Palette", acts=False),
    KeyCommand("gestures", "g", "show('gestures')", "Gestures", "Gestures", "Palette", acts=False),
    KeyCommand("marks", "m", "show('marks')", "Marks", "Marks of a trial", "Palette", acts=False),
    KeyCommand("modes", "o", "show('modes')", "Modes", "Who decides", "Palette", acts=False),
    KeyCommand("queue", "c", "show('queue')", "Queue", "What waits its turn", "Palette", acts=False),
    KeyCommand("say", "t", "say", "Say", "Say something of your own", "Words and notes", foot=True),
    KeyCommand("note", "n", "note", "Note", "A note, of this moment", "Words and notes", foot=True),
    *(
        KeyCommand(
            f"event-{number}", f"f{4 + number}", f"event({number - 1})", "", f"Event mark {number}", "Words and notes"
        )
        for number in range(1, MOST_EVENTS + 1)
    ),
    KeyCommand("seat", "a", "seat", "Seat", "To the other participant", "Words and notes"),
    KeyCommand("baton", "b", "baton", "Baton", "Take the baton", "Panel"),
    KeyCommand("keys", "f1,question_mark", "keys", "Keys", "All keys", "Panel", acts=False, foot=True),
    KeyCommand("close", "q", "close", "Leave", "Leave the panel (asks once)", "Panel", acts=False),
    KeyCommand("leave", "escape", "leave", "Close", "Close what is open", "Panel", acts=False),
)


def bindings() -> list[Binding]:
    """The keys as Textual wants them, each with an id by which it can be mapped anew."""
    return [
        Binding(d.keys, d.action, d.short or d.words, show=d.foot, id=PREFIX + d.id, priority=d.id == "stop")
        for d in DEEDS
    ]


def parted(keys: str) -> list[str]:
    """Keys parted by commas, each once, by Textual's name: ``plus`` for ``+``."""
    return list(dict.fromkeys(_textual_name(key.strip()) for key in keys.split(",")))


def key_name(key: str) -> str:
    """A key as it is called on the keyboard."""
    *modifiers, name = key.split("+")
    called = _NAMES.get(name) or (name.capitalize() if len(name) > 1 else name)
    if name in _LOOKED_UP:
        called = _LOOKED_UP[name]
    return "-".join((*(modifier.capitalize() for modifier in modifiers), called))


def is_key(key: str) -> bool:
    """Whether a terminal can send it, as far as can be told."""
    *modifiers, name = key.split("+")
    if not set(modifiers) <= {"ctrl", "shift", "alt"}:
        return False
    return key in _KNOWN or name in _KNOWN or name in _LOOKED_UP or (len(name) == 1 and name.isalnum())


def _textual_name(key: str) -> str:
    """As `textual.keys` names a character that is neither a letter nor a figure."""
    if len(key) != 1 or key.isalnum():
        return key
    name = unicodedata.name(key, key).lower().replace("-", "_").replace(" ", "_")
    return KEY_NAME_REPLACEMENTS.get(name, name)


_NAMES = {"escape": "Esc", "delete": "Del", "left": "←", "right": "→", "up": "↑", "down": "↓"}
_LOOKED_UP = {_textual_name(chr(code)): chr(code) for code in range(33, 127) if not chr(code).isalnum()}
"""Characters by the names of their keys."""
_KNOWN = {key.value for key in Keys if "<" not in key.value}
