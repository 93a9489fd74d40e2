"""Key commands of the panel, and the file in which an operator changes keys, phrases and event
marks.
"""

import unicodedata
from itertools import zip_longest
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import msgspec
from msgspec import Meta
from textual.binding import Binding
from textual.content import Content
from textual.keys import KEY_NAME_REPLACEMENTS, Keys

from sar_tui.operator import status_view
from sar_tui.operator.phrases import Phrase, phrase_problem
from sar_tui.operator.session_state import SessionState
from sar_tui.operator.text_charts import Piece, cut

PREFIX = "wizard-"
"""Prefix of the ids of Textual's bindings, which the whole app shares."""
EVENT_KEYS = ("f5", "f6", "f7", "f8", "f9", "f10,f12")
"""Keys of the event marks. Some terminals open a menu by F10."""
MAX_EVENTS = len(EVENT_KEYS)


class KeyCommand(NamedTuple):
    """Command of an operator and its keys.

    Attributes:
        id: its name in the operator's file.
        keys: separated by commas, by Textual's names.
        action: the screen's action.
        label: text in the footer.
        description: text in the key help.
        group: heading in the key help.
        acts: True if it needs control of the session, so that it is not for observers.
        in_footer: True if the footer shows it.
    """

    id: str
    keys: str
    action: str
    label: str
    description: str
    group: Literal["Proposals", "Session", "Palette", "Speech and notes", "Panel"]
    acts: bool = True
    in_footer: bool = False


KEY_COMMANDS = (
    KeyCommand("approve", "enter", "approve", "Approve", "Approve", "Proposals"),
    KeyCommand("veto", "x,delete", "veto", "Veto", "Veto", "Proposals"),
    KeyCommand("edit", "e", "edit", "Edit", "Edit the text or level", "Proposals"),
    KeyCommand(
        "positive",
        "plus",
        "valence('positive')",
        "Positive",
        "A positive face, same words",
        "Proposals",
    ),
    KeyCommand(
        "neutral",
        "equals_sign",
        "valence('neutral')",
        "Neutral",
        "A neutral face, same words",
        "Proposals",
    ),
    KeyCommand(
        "negative",
        "minus",
        "valence('negative')",
        "Negative",
        "A negative face, same words",
        "Proposals",
    ),
    KeyCommand("next", "right,down", "select(1)", "Next", "Next proposal", "Proposals", acts=False),
    KeyCommand(
        "previous",
        "left,up",
        "select(-1)",
        "Previous",
        "Previous proposal",
        "Proposals",
        acts=False,
    ),
    KeyCommand(
        "stop",
        "f2",
        "stop",
        "Stop",
        "Stop the agent at once",
        "Session",
        acts=False,
        in_footer=True,
    ),
    KeyCommand("pause", "space", "pause", "Pause", "Pause or resume", "Session", in_footer=True),
    KeyCommand(
        "skip", "s", "skip", "Skip", "Skip prompt, question, rest", "Session", in_footer=True
    ),
    KeyCommand("repeat", "r", "repeat", "Repeat", "Repeat this prompt", "Session", in_footer=True),
    KeyCommand("level-up", "u", "level(1)", "Up", "Level up", "Session", in_footer=True),
    KeyCommand("level-down", "d", "level(-1)", "Down", "Level down", "Session", in_footer=True),
    KeyCommand("hold", "h", "hold", "Hold", "Hold or release the level", "Session", in_footer=True),
    KeyCommand("undo", "ctrl+z", "undo", "Undo", "Undo your act (10 s)", "Session"),
    KeyCommand("end", "end", "end", "End", "End the session (asks once)", "Session"),
    *(
        KeyCommand(
            f"pick-{number % 10}",
            str(number % 10),
            f"pick({index})",
            "",
            f"Number {number} of the palette",
            "Palette",
        )
        for index, number in enumerate(range(1, 11))
    ),
    KeyCommand("page", "tab", "page(1)", "Page", "Next page", "Palette", acts=False),
    KeyCommand(
        "page-back", "shift+tab", "page(-1)", "Page back", "Previous page", "Palette", acts=False
    ),
    KeyCommand("phrases", "p", "show('phrases')", "Phrases", "Phrases", "Palette", acts=False),
    KeyCommand("gestures", "g", "show('gestures')", "Gestures", "Gestures", "Palette", acts=False),
    KeyCommand("marks", "m", "show('marks')", "Marks", "Trial marks", "Palette", acts=False),
    KeyCommand("modes", "o", "show('modes')", "Modes", "Modes: who decides", "Palette", acts=False),
    KeyCommand("queue", "c", "show('queue')", "Queue", "Queued actions", "Palette", acts=False),
    KeyCommand("say", "t", "say", "Say", "Say something", "Speech and notes", in_footer=True),
    KeyCommand("note", "n", "note", "Note", "Add a note", "Speech and notes", in_footer=True),
    *(
        KeyCommand(
            f"event-{number}",
            keys,
            f"event({number - 1})",
            "",
            f"Event mark {number}",
            "Speech and notes",
        )
        for number, keys in enumerate(EVENT_KEYS, 1)
    ),
    KeyCommand("seat", "a", "seat", "Seat", "Switch participant", "Speech and notes"),
    KeyCommand("control", "b", "take_control", "Control", "Take control", "Panel"),
    KeyCommand(
        "keys", "f1,question_mark", "keys", "Keys", "All keys", "Panel", acts=False, in_footer=True
    ),
    KeyCommand("close", "q", "close", "Leave", "Leave the panel (asks once)", "Panel", acts=False),
    KeyCommand("leave", "escape", "leave", "Close", "Close what is open", "Panel", acts=False),
)


def bindings() -> list[Binding]:
    """Return Textual's bindings, with ids by which they can be remapped."""
    return [
        Binding(
            c.keys,
            c.action,
            c.label or c.description,
            show=c.in_footer,
            id=PREFIX + c.id,
            priority=c.id == "stop",
        )
        for c in KEY_COMMANDS
    ]


def split_keys(keys: str) -> list[str]:
    """Split keys at commas, without repetitions, by Textual's names: ``plus`` for ``+``."""
    return list(dict.fromkeys(_textual_name(key.strip()) for key in keys.split(",")))


def key_name(key: str) -> str:
    """Return the name of a key as it is written on a keyboard."""
    *modifiers, name = key.split("+")
    label = _NAMES.get(name) or (name.capitalize() if len(name) > 1 else name)
    if name in _CHARACTERS:
        label = _CHARACTERS[name]
    return "-".join((*(modifier.capitalize() for modifier in modifiers), label))


def is_key(key: str) -> bool:
    """Return True if a terminal may be able to send the key."""
    *modifiers, name = key.split("+")
    if not set(modifiers) <= {"ctrl", "shift", "alt"}:
        return False
    return (
        key in _KNOWN
        or name in _KNOWN
        or name in _CHARACTERS
        or (len(name) == 1 and name.isalnum())
    )


def _textual_name(key: str) -> str:
    """Return the name that `textual.keys` gives to punctuation; other keys unchanged."""
    if len(key) != 1 or key.isalnum():
        return key
    name = unicodedata.name(key, key).lower().replace("-", "_").replace(" ", "_")
    return KEY_NAME_REPLACEMENTS.get(name, name)


_NAMES = {"escape": "Esc", "delete": "Del", "left": "←", "right": "→", "up": "↑", "down": "↓"}
_CHARACTERS = {
    _textual_name(chr(code)): chr(code) for code in range(33, 127) if not chr(code).isalnum()
}
"""Punctuation by the names of its keys."""
_KNOWN = {key.value for key in Keys if "<" not in key.value}

# --- the operator's file

FILE = "wizard-keys.toml"
"""Name of the file in the data folder."""
EVENTS = ("distracted", "spoken to", "technical trouble", "something else")
"""Event marks, unless the file names others."""


class KeymapFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Content of the file: keys by command id, phrases (a text or a table), names of event
    marks.
    """

    keys: dict[str, str] = {}
    phrases: tuple[str | Phrase, ...] = ()
    events: Annotated[tuple[str, ...], Meta(max_length=MAX_EVENTS)] = EVENTS

    @property
    def own_phrases(self) -> tuple[Phrase, ...]:
        """The phrases, each as a `Phrase`."""
        return tuple(Phrase(each) if isinstance(each, str) else each for each in self.phrases)

    @property
    def keymap(self) -> dict[str, str]:
        """The changed keys, by the ids of Textual's bindings."""
        return {PREFIX + id: ",".join(split_keys(keys)) for id, keys in self.keys.items()}

    def keys_of(self, command: KeyCommand) -> list[str]:
        """Return the keys of a command, by Textual's names."""
        return split_keys(self.keys.get(command.id, command.keys))


def read(folder: Path) -> tuple[KeymapFile, str]:
    """Read the operator's file. If something is wrong with it, return the defaults and a sentence
    that says what.
    """
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
    return (KeymapFile(), f"{FILE} is ignored: {problem.rstrip('.')}.") if problem else (file, "")


def _problem(file: KeymapFile) -> str:
    """Return what is wrong with the content, to follow a colon; empty if nothing is."""
    known = {command.id for command in KEY_COMMANDS}
    if unknown := [id for id in file.keys if id not in known]:
        return f"there is no command {unknown[0]!r}"
    taken: dict[str, str] = {}
    for command in KEY_COMMANDS:
        for key in file.keys_of(command):
            if not is_key(key):
                return f"{key!r}, for {command.id}, is not the name of a key"
            if key in taken:
                return f"the key {key_name(key)} is used for both {taken[key]} and {command.id}"
            taken[key] = command.id
    return next(
        (found for phrase in file.own_phrases if (found := phrase_problem(phrase.text))), ""
    )


_BY_ID = {command.id: command for command in KEY_COMMANDS}
_COLUMN = 38
_QUESTIONS = {
    "end": "End the session? Press {key} again to end it, Esc to continue.",
    "close": "Leave the panel? Press {key} again to leave, Esc to stay. The session goes on.",
    "resume": "{why}. Press {key} again within 3 s to resume.",
}
_CONFIRMING = {"resume": "pause"}
"""Command whose key confirms a question, if it is not the question's own."""
_PAGES = ("phrases", "gestures", "marks", "modes", "queue")


def key_label(id: str, file: KeymapFile) -> str:
    """Return the name of a command's first key."""
    return key_name(file.keys_of(_BY_ID[id])[0])


def palette_keys(file: KeymapFile) -> str:
    """Return the keys of the palette's pages."""
    return " ".join(f"{key_label(id, file)} {_BY_ID[id].label.lower()}" for id in _PAGES)


def question(name: str, state: SessionState, file: KeymapFile) -> str:
    """Return a question with the key that confirms it; empty if there is none, or it no longer
    applies.
    """
    if not name or (name == "resume" and not state.is_their_pause):
        return ""
    key = key_label(_CONFIRMING.get(name, name), file)
    return _QUESTIONS[name].format(key=key, why=status_view.waiting_text(state))


def footer(file: KeymapFile, question: str, width: int, *, is_observer: bool) -> Content:
    """Return the most used keys, or a question that must be answered first."""
    if question:
        return Content.assemble((cut(question, width), "$warning bold"))
    parts: list[Piece] = []
    for command in KEY_COMMANDS:
        if command.in_footer and not (is_observer and command.acts):
            key = key_label(command.id, file)
            if sum(len(text) for text, _ in parts) + len(key) + len(command.label) + 1 > width:
                break
            parts += [(key, "$accent bold"), (f" {command.label} ", "$text-muted")]
    return Content.assemble(*parts)


def help_sheet(file: KeymapFile, *, is_observer: bool) -> Content:
    """Return all keys in two columns, under their headings."""
    groups: dict[str, list[KeyCommand]] = {}
    for command in _observer_commands() if is_observer else KEY_COMMANDS:
        groups.setdefault(command.group, []).append(command)
    rows: list[tuple[Piece, Piece]] = []
    for group, commands in groups.items():
        rows.append(((group, "$accent bold"), ("", "")))
        rows += [
            ((f"{_keys(command, file):<9} ", "bold"), (cut(text, _COLUMN - 11), ""))
            for command in commands
            if (text := _description(command, file))
        ]
    half = (len(rows) + 1) // 2
    parts: list[Piece] = []
    for left, right in zip_longest(rows[:half], rows[half:], fillvalue=(("", ""), ("", ""))):
        parts += [
            *left,
            (" " * (_COLUMN - len(left[0][0]) - len(left[1][0])), ""),
            *right,
            ("\n", ""),
        ]
    return Content.assemble(*parts)


def _observer_commands() -> list[KeyCommand]:
    """Return the commands of an observer, who has no palette."""
    return [command for command in KEY_COMMANDS if not command.acts and command.group != "Palette"]


def _keys(command: KeyCommand, file: KeymapFile) -> str:
    if command.id == "pick-1":  # stands for all ten
        return f"{key_label(command.id, file)}…{key_label('pick-0', file)}"
    return " ".join(key_name(key) for key in file.keys_of(command))


def _description(command: KeyCommand, file: KeymapFile) -> str:
    """Return the description; of an event mark, its name. Empty for a command without a line of its
    own.
    """
    if command.id.startswith("event-"):
        number = int(command.id.removeprefix("event-")) - 1
        return f"Event: {file.events[number]}" if number < len(file.events) else ""
    if command.id.startswith("pick-"):
        return "Choose from the page" if command.id == "pick-1" else ""
    return command.description
