"""Key commands of the panel, and the file in which an operator changes keys, phrases and event
marks.
"""

import unicodedata
from itertools import zip_longest
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import msgspec
from msgspec import Meta
from rich.cells import cell_len
from textual.binding import Binding
from textual.content import Content
from textual.keys import KEY_NAME_REPLACEMENTS, Keys

from sar_tui.model.language import ENGLISH, Language
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
        label: text beside the key: in the footer, of a proposal, or of the palette's pages; empty
            if it is in none of them.
        description: text in the key help. Of an event mark, with its name.
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
    KeyCommand("approve", "enter", "approve", "approve", "Approve", "Proposals"),
    KeyCommand("veto", "x,delete", "veto", "veto", "Veto", "Proposals"),
    KeyCommand("edit", "e", "edit", "edit", "Edit the text or level", "Proposals"),
    KeyCommand(
        "positive",
        "plus",
        "valence('positive')",
        "",
        "A positive face, same words",
        "Proposals",
    ),
    KeyCommand(
        "neutral",
        "equals_sign",
        "valence('neutral')",
        "",
        "A neutral face, same words",
        "Proposals",
    ),
    KeyCommand(
        "negative",
        "minus",
        "valence('negative')",
        "",
        "A negative face, same words",
        "Proposals",
    ),
    KeyCommand("next", "right,down", "select(1)", "", "Next proposal", "Proposals", acts=False),
    KeyCommand(
        "previous",
        "left,up",
        "select(-1)",
        "",
        "Previous proposal",
        "Proposals",
        acts=False,
    ),
    KeyCommand("tick", "k", "tick", "tick", "Do what is due, or leave it", "Proposals"),
    KeyCommand("leave-out", "l", "leave_out", "leave out", "", "Proposals"),
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
    KeyCommand("undo", "ctrl+z", "undo", "Undo", "Undo your act (10 s)", "Session", in_footer=True),
    KeyCommand("end", "end", "end", "", "End the session (asks once)", "Session"),
    *(
        KeyCommand(
            f"pick-{number % 10}",
            str(number % 10),
            f"pick({index})",
            "",
            "Choose from the page",
            "Palette",
        )
        for index, number in enumerate(range(1, 11))
    ),
    KeyCommand("page", "tab", "page(1)", "", "Next page", "Palette", acts=False),
    KeyCommand("page-back", "shift+tab", "page(-1)", "", "Previous page", "Palette", acts=False),
    KeyCommand("phrases", "p", "show('phrases')", "phrases", "Phrases", "Palette", acts=False),
    KeyCommand("gestures", "g", "show('gestures')", "gestures", "Gestures", "Palette", acts=False),
    KeyCommand("marks", "m", "show('marks')", "marks", "Trial marks", "Palette", acts=False),
    KeyCommand("modes", "o", "show('modes')", "modes", "Modes: who decides", "Palette", acts=False),
    KeyCommand("queue", "c", "show('queue')", "queue", "Queued actions", "Palette", acts=False),
    KeyCommand("say", "t", "say", "Say", "Say something", "Speech and notes", in_footer=True),
    KeyCommand("note", "n", "note", "Note", "Add a note", "Speech and notes", in_footer=True),
    *(
        KeyCommand(
            f"event-{number}",
            keys,
            f"event({number - 1})",
            "",
            "Event: {name}",
            "Speech and notes",
        )
        for number, keys in enumerate(EVENT_KEYS, 1)
    ),
    KeyCommand("seat", "a", "seat", "", "Switch participant", "Speech and notes"),
    KeyCommand("control", "b", "take_control", "", "Take control", "Panel"),
    KeyCommand(
        "keys", "f1,question_mark", "keys", "Keys", "All keys", "Panel", acts=False, in_footer=True
    ),
    KeyCommand("close", "q", "close", "", "Leave the panel (asks once)", "Panel", acts=False),
    KeyCommand("leave", "escape", "leave", "", "Close what is open", "Panel", acts=False),
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


def key_name(key: str, tr: Language = ENGLISH) -> str:
    """Return the name of a key as it is written on a keyboard."""
    parts = key.split("+")
    return "-".join(
        tr(_NAMES[name])
        if name in _NAMES
        else _CHARACTERS.get(name) or _other_name(name, is_alone=len(parts) == 1)
        for name in parts
    )


def _other_name(name: str, *, is_alone: bool) -> str:
    """Return the name of a key that is the same in all languages: "F2", "x", "Z" of Ctrl-Z."""
    return name if is_alone and len(name) == 1 else name.capitalize()


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


_NAMES = {
    "alt": "Alt",
    "backspace": "Backspace",
    "ctrl": "Ctrl",
    "delete": "Del",
    "down": "↓",
    "end": "End",
    "enter": "Enter",
    "escape": "Esc",
    "home": "Home",
    "insert": "Insert",
    "left": "←",
    "pagedown": "Pagedown",
    "pageup": "Pageup",
    "right": "→",
    "shift": "Shift",
    "space": "Space",
    "tab": "Tab",
    "up": "↑",
}
"""Names of keys and modifiers that differ between keyboards, by Textual's names."""
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


def read(folder: Path, tr: Language = ENGLISH) -> tuple[KeymapFile, str]:
    """Read the operator's file. If something is wrong with it, return the defaults and a sentence
    that says what.
    """
    path = folder / FILE
    try:
        file = msgspec.toml.decode(path.read_bytes(), type=KeymapFile)
        problem = _problem(file, tr)
    except FileNotFoundError:
        return KeymapFile(), ""
    except OSError as error:
        file, problem = KeymapFile(), tr("it cannot be read ({error})", error=error.strerror)
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        file, problem = KeymapFile(), str(error)
    if not problem:
        return file, ""
    return KeymapFile(), tr("{file} is ignored: {why}.", file=FILE, why=problem.rstrip("."))


def _problem(file: KeymapFile, tr: Language) -> str:
    """Return what is wrong with the content, to follow a colon; empty if nothing is."""
    known = {command.id for command in KEY_COMMANDS}
    if unknown := [id for id in file.keys if id not in known]:
        return tr("there is no command {name}", name=repr(unknown[0]))
    taken: dict[str, str] = {}
    for command in KEY_COMMANDS:
        for key in file.keys_of(command):
            if not is_key(key):
                return tr(
                    "{key}, for {command}, is not the name of a key",
                    key=repr(key),
                    command=command.id,
                )
            if key in taken:
                return tr(
                    "the key {key} is used for both {first} and {second}",
                    key=key_name(key, tr),
                    first=taken[key],
                    second=command.id,
                )
            taken[key] = command.id
    return next(
        (found for phrase in file.own_phrases if (found := phrase_problem(phrase.text, tr))), ""
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
_BY_PROTOCOL = ("tick", "leave-out")
"""Commands that need a protocol."""
_LEAST_USED = ("repeat", "hold", "note")
"""Commands that the footer leaves out, in this order, until the others fit."""


def key_label(id: str, file: KeymapFile, tr: Language) -> str:
    """Return the name of a command's first key."""
    return key_name(file.keys_of(_BY_ID[id])[0], tr)


def palette_keys(file: KeymapFile, tr: Language) -> str:
    """Return the keys of the palette's pages."""
    return " ".join(f"{key_label(id, file, tr)} {tr(_BY_ID[id].label)}" for id in _PAGES)


def question(name: str, state: SessionState, file: KeymapFile) -> str:
    """Return a question with the key that confirms it; empty if there is none, or it no longer
    applies.
    """
    if not name or (name == "resume" and not state.is_their_pause):
        return ""
    key = key_label(_CONFIRMING.get(name, name), file, state.tr)
    return state.tr(_QUESTIONS[name], key=key, why=status_view.waiting_text(state))


def footer(
    file: KeymapFile, question: str, width: int, tr: Language, *, is_observer: bool
) -> Content:
    """Return the most used keys that there is room for, or a question that must be answered
    first.
    """
    if question:
        return Content.assemble((cut(question, width), "$warning bold"))
    shown = {
        command.id: (key_label(command.id, file, tr), tr(command.label))
        for command in KEY_COMMANDS
        if command.in_footer and not (is_observer and command.acts)
    }
    for id in _LEAST_USED:
        if sum(cell_len(f"{key} {label} ") for key, label in shown.values()) > width + 1:
            shown.pop(id, None)
    parts: list[Piece] = []
    for key, label in shown.values():
        parts += [(key, "$accent bold"), (f" {label} ", "$text-muted")]
    return Content.assemble(*parts)


def help_sheet(file: KeymapFile, tr: Language, *, is_observer: bool, has_protocol: bool) -> Content:
    """Return all keys in two columns, under their headings; those of a protocol if there is one."""
    groups: dict[str, list[KeyCommand]] = {}
    for command in _observer_commands() if is_observer else KEY_COMMANDS:
        if command.id in _BY_PROTOCOL and not has_protocol:
            continue
        groups.setdefault(command.group, []).append(command)
    rows: list[tuple[Piece, Piece]] = []
    for group, commands in groups.items():
        rows.append(((tr(group), "$accent bold"), ("", "")))
        rows += [
            ((f"{_keys(command, file, tr):<9} ", "bold"), (cut(text, _COLUMN - 11), ""))
            for command in commands
            if (text := _description(command, file, tr))
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


def _keys(command: KeyCommand, file: KeymapFile, tr: Language) -> str:
    if command.id == "tick":  # stands for both
        return f"{key_label('tick', file, tr)} {key_label('leave-out', file, tr)}"
    if command.id == "pick-1":  # stands for all ten
        return f"{key_label(command.id, file, tr)}…{key_label('pick-0', file, tr)}"
    return " ".join(key_name(key, tr) for key in file.keys_of(command))


def _description(command: KeyCommand, file: KeymapFile, tr: Language) -> str:
    """Return the description; of an event mark, its name. Empty for a command without a line of its
    own.
    """
    if command.id.startswith("event-"):
        number = int(command.id.removeprefix("event-")) - 1
        if number >= len(file.events):
            return ""
        return tr(command.description, name=tr(file.events[number]))
    if command.id.startswith("pick-") and command.id != "pick-1":
        return ""
    return tr(command.description) if command.description else ""
