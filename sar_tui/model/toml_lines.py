"""TOML texts, and the lines at which their values stand, so that a mistake can be shown where it is."""

import difflib
import re
import tomllib
from typing import Any, NamedTuple

from msgspec import inspect

Key = tuple[str | int, ...]
"""Place of a value: names of tables and keys, and indices in arrays of tables."""

_NAME = r"""(?:[\w-]+|"[^"]*"|'[^']*')"""
_NAMES = rf"{_NAME}(?:\s*\.\s*{_NAME})*"
_HEADER = re.compile(rf"\s*(\[\[?)\s*({_NAMES})\s*\]\]?\s*(?:#.*)?$")
_KEY = re.compile(rf"\s*({_NAMES})\s*=")
_PART = re.compile(_NAME)
_PLACE = re.compile(r"^(?P<said>.*?) - at `\$(?P<place>.*)`$", re.DOTALL)
_STEP = re.compile(r"\.([\w -]+)|\[(\d+|\.\.\.)\]")
_ANY = "..."
"""In place of a name in an error of msgspec."""
_UNKNOWN = re.compile(r"Object contains unknown field `([^`]*)`")
_MISSING = re.compile(r"Object missing required field `([^`]*)`")
_ENUM = re.compile(r"Invalid enum value (.*)$")
_EXPECTED = re.compile(r"Expected `([^`]*)`, got `[^`]*`$")
_TYPES = {
    "str": "a text, in quotes",
    "int": "a whole number",
    "float": "a number",
    "bool": "true or false",
    "array": "a list, in [ ]",
    "object": "a table, such as { name = value }",
    "null": "",
}
"""Types as msgspec names them, in words."""
_SYNTAX = re.compile(r" \(at (?:line (\d+), column \d+|end of document)\)")


class Mistake(NamedTuple):
    """A mistake in a file: its line (from 1), and a sentence."""

    line: int
    why: str

    def __str__(self) -> str:
        return f"line {self.line}: {self.why}"


class TomlError(ValueError):
    """A text is not TOML."""

    def __init__(self, mistake: Mistake) -> None:
        self.mistake = mistake
        super().__init__(str(mistake))


def decode(text: str) -> dict[str, Any]:
    """Return the content of a TOML text. Raises TomlError."""
    try:
        return tomllib.loads(text)
    except RecursionError:
        why, line = "it is nested too deeply", 1
    except tomllib.TOMLDecodeError as error:
        why = str(error)
        last = len(text.splitlines())
        found = _SYNTAX.search(why)
        line = int(found[1]) if found and found[1] else max(1, last)
        why = _SYNTAX.sub("", why).rstrip(".")
    raise TomlError(Mistake(line, f"This is not valid TOML: {why[0].lower()}{why[1:]}."))


class TomlLines:
    """The lines of a text. ``name``: of its file, for messages."""

    def __init__(self, text: str, name: str = "") -> None:
        self._name = name
        self._lines: dict[Key, int] = {}
        counts: dict[Key, int] = {}
        table: Key = ()
        quote = ""
        for number, line in enumerate(text.split("\n"), 1):
            if quote:  # within a text of several lines
                quote = "" if quote in line else quote
            elif header := _HEADER.match(line):
                parts = _indexed(_parts(header[2]), counts)
                if header[1] == "[[":
                    counts[parts] = counts.get(parts, -1) + 1
                    parts = (*parts, counts[parts])
                table = parts
                self._note(table, number)
            elif key := _KEY.match(line):
                self._note((*table, *_parts(key[1])), number)
                rest = line[key.end() :]
                quote = next((q for q in ('"""', "'''") if rest.count(q) == 1), "")

    def _note(self, key: Key, number: int) -> None:
        """Note the line of a value, if it is the first one of it or of what is around it."""
        for length in range(1, len(key) + 1):
            self._lines.setdefault(key[:length], number)

    def line(self, key: Key) -> int:
        """Return the line of a value, or of the innermost table around it; 1 if none is known."""
        while key:
            if key in self._lines:
                return self._lines[key]
            key = key[:-1]
        return 1

    def at(self, key: Key, said: str) -> str:
        """Return a message on a value, with its line."""
        return f"{self._name}, line {self.line(key)}: {said}"

    def invalid(self, error: str, above: Key = (), kind: Any = None) -> str:
        """Return a message on what msgspec says of a value, with its line.

        Args:
            error: of msgspec.
            above: place of what was converted, if it is a part of the file.
            kind: type to which it was converted, so that names and values that are allowed can be
                told.
        """
        found = _PLACE.match(error)
        said, place = (found["said"], found["place"]) if found else (error, "")
        key = tuple(
            int(index) if index.isdigit() else name or index for name, index in _STEP.findall(place)
        )
        wanted_type = _type_at(kind, key)
        if unknown := _UNKNOWN.search(said):
            near = difflib.get_close_matches(unknown[1], _fields(wanted_type), 1)
            meant = f" Did you mean {near[0]}?" if near else ""
            return self.at(
                self._known((*above, *key, unknown[1])),
                f"There is nothing named {unknown[1]} here.{meant}",
            )
        if missing := _MISSING.search(said):
            said = f"{missing[1]} is missing"
        elif (value := _ENUM.match(said)) and (allowed := _values(wanted_type)):
            said = f"This must be one of {', '.join(map(repr, allowed))}, not {value[1]}"
        elif wanted := _EXPECTED.match(said):
            names = (_TYPES.get(name, name) for name in wanted[1].split(" | "))
            said = f"This must be {' or '.join(filter(None, names))}"
        return self.at(self._known((*above, *key)), f"{said}.")

    def _known(self, key: Key) -> Key:
        """Return a place in which msgspec left out a name: the first that is like it."""
        if _ANY not in key:
            return key
        alike = (
            each
            for each in self._lines
            if len(each) == len(key) and all(a in (b, _ANY) for a, b in zip(key, each, strict=True))
        )
        return next(alike, key[: key.index(_ANY)])


def _parts(dotted: str) -> Key:
    return tuple(part.strip("\"'") for part in _PART.findall(dotted))


def _indexed(parts: Key, counts: dict[Key, int]) -> Key:
    """Return the place of a table, with the index of the newest element of each array above it."""
    found: Key = ()
    for at, part in enumerate(parts):
        found = (*found, part)
        if found in counts and at < len(parts) - 1:
            found = (*found, counts[found])
    return found


def _type_at(kind: Any, key: Key) -> Any:
    """Return msgspec's description of the type at a place in another type; None if it is not
    known.
    """
    here = inspect.type_info(kind) if kind else None
    for step in key:
        for each in here.types if isinstance(here, inspect.UnionType) else (here,):
            match each:
                case inspect.StructType():
                    fields = {field.encode_name: field.type for field in each.fields}
                    here = fields.get(str(step))
                case inspect.DictType():
                    here = each.value_type
                case inspect.VarTupleType() | inspect.ListType():
                    here = each.item_type
                case _:
                    continue
            break
        else:
            return None
    return here


def _fields(kind: Any) -> list[str]:
    """Return the names of the fields of a type, or of those in a union."""
    kinds = getattr(kind, "types", (kind,))
    return [field.encode_name for each in kinds for field in getattr(each, "fields", ())]


def _values(kind: Any) -> list[object]:
    """Return the values of a type that lists them."""
    kinds = getattr(kind, "types", (kind,))
    return [value for each in kinds for value in getattr(each, "values", ())]
