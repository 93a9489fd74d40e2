"""Lines of a TOML text at which its values stand, so that a mistake can be shown where it is."""

import re

Key = tuple[str | int, ...]
"""Place of a value: names of tables and keys, and indices in arrays of tables."""

_HEADER = re.compile(r"\s*(\[\[?)\s*(.+?)\s*\]\]?\s*(?:#.*)?$")
_KEY = re.compile(r'\s*((?:[\w-]+|"[^"]*")(?:\s*\.\s*(?:[\w-]+|"[^"]*"))*)\s*=')
_PART = re.compile(r'"([^"]*)"|([\w-]+)')
_PLACE = re.compile(r"^(?P<said>.*?) - at `\$(?P<place>.*)`$", re.DOTALL)
_STEP = re.compile(r"\.([\w -]+)|\[(\d+|\.\.\.)\]")
_ANY = "..."
"""In place of a name in an error of msgspec."""
_UNKNOWN = re.compile(r"Object contains unknown field `([^`]*)`")
_MISSING = re.compile(r"Object missing required field `([^`]*)`")
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
_SYNTAX = re.compile(r"\(at line (\d+), column \d+\)")


class TomlLines:
    """The lines of a text. ``name``: of its file, for messages."""

    def __init__(self, text: str, name: str) -> None:
        self._name = name
        self._lines: dict[Key, int] = {}
        counts: dict[Key, int] = {}
        table: Key = ()
        quote = ""
        for number, line in enumerate(text.splitlines(), 1):
            if quote:  # within a text of several lines
                quote = "" if quote in line else quote
            elif header := _HEADER.match(line):
                parts = _indexed(_parts(header[2]), counts)
                if header[1] == "[[":
                    counts[parts] = counts.get(parts, -1) + 1
                    parts = (*parts, counts[parts])
                table = parts
                self._lines.setdefault(table, number)
            elif key := _KEY.match(line):
                self._lines.setdefault((*table, *_parts(key[1])), number)
                rest = line[key.end() :]
                quote = next((q for q in ('"""', "'''") if rest.count(q) == 1), "")

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

    def invalid(self, error: str) -> str:
        """Return a message on what msgspec says of a value, with its line."""
        found = _PLACE.match(error)
        said, place = (found["said"], found["place"]) if found else (error, "")
        key = tuple(
            int(index) if index.isdigit() else name or index for name, index in _STEP.findall(place)
        )
        if unknown := _UNKNOWN.search(said):
            key, said = (*key, unknown[1]), f"There is nothing named {unknown[1]} here"
        elif missing := _MISSING.search(said):
            said = f"{missing[1]} is missing"
        elif wanted := _EXPECTED.match(said):
            names = (_TYPES.get(name, name) for name in wanted[1].split(" | "))
            said = f"This must be {' or '.join(filter(None, names))}"
        return self.at(self._known(key), f"{said}.")

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

    def syntax_error(self, said: str) -> str:
        """Return a message on a text that is no TOML, with the line that the parser named."""
        found = _SYNTAX.search(said)
        reason = _SYNTAX.sub("", said).strip().rstrip(".")
        line = int(found[1]) if found else 1
        return f"{self._name}, line {line}: This is not valid TOML: {reason}."


def _parts(dotted: str) -> Key:
    return tuple(quoted or plain for quoted, plain in _PART.findall(dotted))


def _indexed(parts: Key, counts: dict[Key, int]) -> Key:
    """Return the place of a table, with the index of the newest element of each array above it."""
    found: Key = ()
    for at, part in enumerate(parts):
        found = (*found, part)
        if found in counts and at < len(parts) - 1:
            found = (*found, counts[found])
    return found
