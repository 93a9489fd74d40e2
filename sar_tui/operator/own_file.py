"""The operator's own file: other keys, phrases of their own, names for event marks."""

from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta

from sar_tui.operator.keymap import DEEDS, MOST_EVENTS, PREFIX, KeyCommand, is_key, key_name, parted
from sar_tui.operator.phrases import Phrase, phrase_problem

FILE = "wizard-keys.toml"
"""In the data folder."""
EVENTS = ("distracted", "spoken to", "technical trouble", "something else")
"""The event marks there are, unless the file names others."""


class KeymapFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the file says: keys by the ids of `deeds.DEEDS`, phrases (a text, or a table), names of event marks."""

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

    def keys_of(self, deed: KeyCommand) -> list[str]:
        """The keys that do something, by Textual's names."""
        return parted(self.keys.get(deed.id, deed.keys))


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
    known = {deed.id for deed in DEEDS}
    if unknown := [id for id in file.keys if id not in known]:
        return f"there is nothing called {unknown[0]!r} that could have a key"
    taken: dict[str, str] = {}
    for deed in DEEDS:
        for key in file.keys_of(deed):
            if not is_key(key):
                return f"{key!r}, for {deed.id}, is not the name of a key"
            if key in taken:
                return f"the key {key_name(key)} would be both {taken[key]} and {deed.id}"
            taken[key] = deed.id
    return next((found for phrase in file.own_phrases if (found := phrase_problem(phrase.text))), "")
