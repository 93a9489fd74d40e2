"""What an operator can do, and the key of each."""

import unicodedata
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import msgspec
from msgspec import Meta
from textual.binding import Binding
from textual.keys import KEY_NAME_REPLACEMENTS, Keys

from sar_tui.operator.phrases import Phrase, phrase_problem

PREFIX = "wizard-"
"""Before an id, in the ids of Textual's bindings: they are the app's, too."""
MOST_EVENTS = 6
"""Keys there are for marking an event."""


class KeyCommand(NamedTuple):
    """Something an operator can do: its id in the file, its keys, its action, what the footer calls it, and what it is.

    ``group``: under which heading the help lists it. ``acts``: not for an observer. ``in_footer``: the footer shows it.
    """

    id: str
    keys: str
    action: str
    short: str
    words: str
    group: Literal["Proposals", "Session", "Palette", "Words and notes", "Panel"]
    acts: bool = True
    in_footer: bool = False


KEY_COMMANDS = (
    KeyCommand("approve", "enter", "approve", "Approve", "Approve", "Proposals"),
    KeyCommand("veto", "x,delete", "veto", "Veto", "Veto", "Proposals"),
    KeyCommand("edit", "e", "edit", "Edit", "Change its words, or level", "Proposals"),
    KeyCommand("positive", "plus", "valence('positive')", "Positive", "A positive face, same words", "Proposals"),
    KeyCommand("neutral", "equals_sign", "valence('neutral')", "Neutral", "A neutral face, same words", "Proposals"),
    KeyCommand("negative", "minus", "valence('negative')", "Negative", "A negative face, same words", "Proposals"),
    KeyCommand("next", "right,down", "select(1)", "Next", "The next proposal", "Proposals", acts=False),
    KeyCommand("previous", "left,up", "select(-1)", "Previous", "The one before", "Proposals", acts=False),
    KeyCommand("stop", "f2", "stop", "Stop", "Stop the agent, at once", "Session", in_footer=True),
    KeyCommand("pause", "space", "pause", "Pause", "Pause, or go on", "Session", in_footer=True),
    KeyCommand("skip", "s", "skip", "Skip", "Skip this prompt", "Session", in_footer=True),
    KeyCommand("repeat", "r", "repeat", "Repeat", "Repeat this prompt", "Session", in_footer=True),
    KeyCommand("level-up", "u", "level(1)", "Up", "Level up", "Session", in_footer=True),
    KeyCommand("level-down", "d", "level(-1)", "Down", "Level down", "Session", in_footer=True),
    KeyCommand("hold", "h", "hold", "Hold", "Hold the level, or let go", "Session", in_footer=True),
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
    KeyCommand("say", "t", "say", "Say", "Say something of your own", "Words and notes", in_footer=True),
    KeyCommand("note", "n", "note", "Note", "A note, of this moment", "Words and notes", in_footer=True),
    *(
        KeyCommand(
            f"event-{number}",
            f"f{4 + number}",
            f"event({number - 1})",
            "",
            f"Event mark {number}",
            "Words and notes",
        )
        for number in range(1, MOST_EVENTS + 1)
    ),
    KeyCommand("seat", "a", "seat", "Seat", "To the other participant", "Words and notes"),
    KeyCommand("baton", "b", "baton", "Baton", "Take the baton", "Panel"),
    KeyCommand("keys", "f1,question_mark", "keys", "Keys", "All keys", "Panel", acts=False, in_footer=True),
    KeyCommand("close", "q", "close", "Leave", "Leave the panel (asks once)", "Panel", acts=False),
    KeyCommand("leave", "escape", "leave", "Close", "Close what is open", "Panel", acts=False),
)


def bindings() -> list[Binding]:
    """The keys as Textual wants them, each with an id by which it can be mapped anew."""
    return [
        Binding(d.keys, d.action, d.short or d.words, show=d.in_footer, id=PREFIX + d.id, priority=d.id == "stop")
        for d in KEY_COMMANDS
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

# --- the operator's own file --------------------------------------------------------------------------------


FILE = "wizard-keys.toml"
"""In the data folder."""
EVENTS = ("distracted", "spoken to", "technical trouble", "something else")
"""The event marks there are, unless the file names others."""


class KeymapFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the file says: keys by the ids of `KEY_COMMANDS`, phrases (a text, or a table), names of event marks."""

    keys: dict[str, str] = {}
    phrases: tuple[str | Phrase, ...] = ()
    events: Annotated[tuple[str, ...], Meta(max_length=MOST_EVENTS)] = EVENTS

    @property
    def own_phrases(self) -> tuple[Phrase, ...]:
        """The phrases, each as one."""
        return tuple(Phrase(each) if isinstance(each, str) else each for each in self.phrases)

    @property
    def keymap(self) -> dict[str, str]:
        """The keys that are others than usual, by the ids of Textual's bindings."""
        return {PREFIX + id: ",".join(parted(keys)) for id, keys in self.keys.items()}

    def keys_of(self, key_command: KeyCommand) -> list[str]:
        """The keys that do something, by Textual's names."""
        return parted(self.keys.get(key_command.id, key_command.keys))


def read(folder: Path) -> tuple[KeymapFile, str]:
    """The operator's file; and a sentence on what is wrong with it: then all is as if there were none."""
    path = folder / FILE
    try:
        file = msgspec.toml.decode(path.read_bytes(), type=KeymapFile)
        problem = _problem(file)
    except FileNotFoundError:
        return KeymapFile(), ""
    except OSError as error:
        file, problem = KeymapFile(), f"it cannot be read ({error.strerror})"
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        file, problem = KeymapFile(), str(error)
    return (KeymapFile(), f"{FILE} is left out: {problem.rstrip('.')}.") if problem else (file, "")


def _problem(file: KeymapFile) -> str:
    """What is wrong with a file that could be read, to follow a colon; empty where nothing is."""
    known = {key_command.id for key_command in KEY_COMMANDS}
    if unknown := [id for id in file.keys if id not in known]:
        return f"there is nothing called {unknown[0]!r} that could have a key"
    taken: dict[str, str] = {}
    for key_command in KEY_COMMANDS:
        for key in file.keys_of(key_command):
            if not is_key(key):
                return f"{key!r}, for {key_command.id}, is not the name of a key"
            if key in taken:
                return f"the key {key_name(key)} would be both {taken[key]} and {key_command.id}"
            taken[key] = key_command.id
    return next((found for phrase in file.own_phrases if (found := phrase_problem(phrase.text))), "")
