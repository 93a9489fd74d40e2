"""Reads ``theme.toml``: the agent's look, movements and voice."""

import tomllib
import unicodedata
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import Meta

from sar_tui import API
from sar_tui.model.contrast import contrast, cut, is_color
from sar_tui.model.gesture import GESTURES, Gesture, Keyframe
from sar_tui.model.theme import (
    FACES,
    GAZES,
    GROUNDS,
    MANNERS,
    TONES,
    Colors,
    Manner,
    Note,
    Theme,
    ThemeError,
    Voice,
)
from sar_tui.model.visible_text import control_problem, visible
from sar_tui.plugin_calls import check_api_number

LEAST_CONTRAST = 4.5
"""Least contrast of legible text; a theme may ask for more (WCAG 2.2, AA)."""
_SETTINGS = {
    "title": Annotated[str, Meta(min_length=1)],
    "summary": str,
    "dark": bool,
    "minimum_contrast": Annotated[float, Meta(ge=LEAST_CONTRAST, le=21)],
}
_TABLES = ("colors", "faces", "voice", "manner", "gestures", "tones", "images")
_NOTES = Annotated[tuple[Note, ...], Meta(min_length=1, max_length=8)]
_LONGEST = 60
"""Letters of a name that an error message quotes."""
_BLACK, _WHITE = "#000000", "#ffffff"


class Look(msgspec.Struct, frozen=True):
    """The parts of a `Theme` in ``theme.toml``, and its problems by part."""

    parts: dict[str, Any]
    problems: dict[str, list[str]]


def read_toml(path: Path) -> dict[str, Any]:
    """Return the contents of a file. Raises ThemeError, with one sentence, if it is missing or not
    TOML.
    """
    try:
        return tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except FileNotFoundError as error:
        raise ThemeError(f"There is no {path.name}.") from error
    except OSError as error:
        raise ThemeError(f"{path.name} cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        line = path.read_bytes()[: error.start].count(b"\n") + 1
        raise ThemeError(
            f"{path.name} is not UTF-8 text from line {line} on; save it as UTF-8."
        ) from error
    except (ValueError, RecursionError) as error:
        raise ThemeError(f"{path.name} is not TOML: {error}.") from error


def read_look(folder: Path, base: Theme | None) -> Look:
    """Read a folder's ``theme.toml``; unusable parts are taken from ``base``.

    Raises:
        ThemeError: it cannot be read.
        WrongApi: it was written for another API.
    """
    table = read_toml(folder / "theme.toml")
    check_api_number("theme", folder.name, table.pop("api", API))
    reader = _Reader(folder, table, base)
    return Look(reader.parts(), reader.problems)


class _Reader:
    """Reads one ``theme.toml``."""

    def __init__(self, folder: Path, table: dict[str, Any], base: Theme | None) -> None:
        self._folder = folder
        self._table = table
        self._base = base
        self.problems: dict[str, list[str]] = {
            part: [] for part in ("settings", "colors", "faces", "gestures", "manner")
        }

    def parts(self) -> dict[str, Any]:
        """Return all parts, read in the order in which they depend on each other."""
        known = (*_SETTINGS, "mouth_line", *_TABLES)
        self.problems["settings"] += [
            f"theme.toml has no use for {name}." for name in self._table if name not in known
        ]
        settings = {name: self._setting(name) for name in _SETTINGS}
        mouth_line = self._mouth_line()
        gestures = self._gestures()
        return {
            **settings,
            "colors": self._colors(settings["minimum_contrast"]),
            "mouth_line": mouth_line,
            "faces": self._faces(mouth_line),
            "images": self._images(),
            "voice": self._converted("manner", "voice", self._table.get("voice", {}), Voice)
            or Voice(),
            "gestures": gestures,
            "manners": self._manners(gestures),
            "tones": self._tones(),
        }

    # --- one value, one table

    def _converted(self, part: str, name: str, value: object, kind: Any) -> Any:
        """Return a value as its type; None if it cannot be converted."""
        try:
            return msgspec.convert(value, kind)
        except msgspec.ValidationError as error:
            self.problems[part].append(f"{name} in theme.toml cannot be used: {error}.")
            return None

    def _entries(self, part: str, name: str) -> dict[str, Any]:
        """Return a table; empty if it is missing or not a table."""
        entries = self._table.get(name, {})
        if isinstance(entries, dict):
            return entries
        self.problems[part].append(f"{name} in theme.toml must be a table.")
        return {}

    def _setting(self, name: str) -> Any:
        default = {
            "title": self._folder.name,
            "summary": "",
            "dark": True,
            "minimum_contrast": LEAST_CONTRAST,
        }
        if name not in self._table:
            self.problems["settings"].append(f"theme.toml does not say its {name}.")
        elif name == "minimum_contrast" and _is_below(self._table[name], LEAST_CONTRAST):
            least = f"{LEAST_CONTRAST:g}, below which text is hard to read"
            self.problems["settings"].append(
                f"minimum_contrast is {_printable(str(self._table[name]))}; it must be at least "
                f"{least}."
            )
        else:
            value = self._converted("settings", name, self._table[name], _SETTINGS[name])
            if (
                problem := control_problem(f"{name} in theme.toml", value)
                if isinstance(value, str)
                else ""
            ):
                self.problems["settings"].append(problem)
            if value is not None:
                return value
        return getattr(self._base, name) if self._base and name == "dark" else default[name]

    # --- colours

    def _colors(self, minimum: float) -> Colors:
        """Return the colours; invalid ones are the base's, and text with too little contrast
        becomes black or white.
        """
        given, problems = self._entries("colors", "colors"), self.problems["colors"]
        names = [field.name for field in msgspec.structs.fields(Colors)]
        problems += [
            f"{name} is not a colour of a theme; these are: {', '.join(names)}."
            for name in given
            if name not in names
        ]
        found = {}
        for name in names:
            value = given.get(name, "")
            if not (isinstance(value, str) and is_color(value)):
                problems.append(f"{name} is not a colour like #a0b1c2: {value or 'nothing'}.")
                value = getattr(self._base.colors, name) if self._base else ""
            found[name] = value
        colors = Colors(**found)
        faint = {
            (name, ground): ratio
            for (name, ground), ratio in colors.contrasts().items()
            if ratio < minimum
        }
        for (name, ground), ratio in faint.items():
            problems.append(
                f"{name} on {ground} has a contrast of {cut(ratio):g}, less than {minimum:g}."
            )
        if not self._base:
            return colors
        return msgspec.structs.replace(colors, **{name: _legible(colors) for name, _ in faint})

    # --- faces

    def _mouth_line(self) -> int:
        line = self._converted(
            "faces", "mouth_line", self._table.get("mouth_line", 2), Annotated[int, Meta(ge=0)]
        )
        return 2 if line is None else int(line)

    def _faces(self, mouth_line: int) -> dict[str, str]:
        """Return the drawings, all of one size; a missing or unusable one is the base's."""
        given, problems = self._entries("faces", "faces"), self.problems["faces"]
        problems += [
            f"{name} is not an expression; these are: {', '.join(FACES)}."
            for name in given
            if name not in FACES
        ]
        drawn = {}
        for name in FACES:
            face = given.get(name)
            if not isinstance(face, str) or not face.strip():
                problems.append(f"There is no face for {name}.")
            elif wrong := drawing_problems(name, face.strip("\n"), mouth_line):
                problems += wrong
            else:
                drawn[name] = face.strip("\n")
        heights = sorted({len(face.split("\n")) for face in drawn.values()})
        if len(heights) > 1:
            problems.append(
                f"The faces have {' and '.join(map(str, heights))} lines; all must have the same "
                "number."
            )
        return fitted({**(self._base.faces if self._base else {}), **drawn})

    def _images(self) -> dict[str, str]:
        """Return the image files of faces; those outside the folder are left out."""
        good = {}
        folder = self._folder.resolve()
        for name, file in self._entries("faces", "images").items():
            if name not in FACES:
                self.problems["faces"].append(
                    f"images.{name} is not an expression; these are: {', '.join(FACES)}."
                )
            elif not isinstance(file, str) or (path := _file(folder, file)) is None:
                self.problems["faces"].append(
                    f"There is no image {_printable(str(file))} for {name}."
                )
            elif not path.is_relative_to(folder):
                self.problems["faces"].append(
                    f"The image {file} for {name} must be in the theme's folder."
                )
            else:
                good[name] = file
        return good

    # --- gestures and manner

    def _gestures(self) -> dict[str, Gesture]:
        """Return the gestures; a missing or unusable one is the base's."""
        given, problems = self._entries("gestures", "gestures"), self.problems["gestures"]
        good: dict[str, Gesture] = {}
        for name, frames in given.items():
            keyframes = self._converted(
                "gestures", f"gestures.{name}", frames, tuple[Keyframe, ...]
            )
            if keyframes is None:
                continue
            gesture = Gesture(keyframes)
            if wrong := gesture.problems(name):
                problems += wrong
            else:
                good[name] = gesture
        problems += [f"There is no gesture {name}." for name in GESTURES if name not in given]
        return {**(self._base.gestures if self._base else {}), **good}

    def _manners(self, gestures: dict[str, Gesture]) -> dict[str, Manner]:
        """Return the manners that the theme sets; what a table leaves out is the default of its
        kind.
        """
        good = {}
        for name, value in self._entries("manner", "manner").items():
            if name not in MANNERS:
                self.problems["manner"].append(
                    f"{name} has no manner; these have: {', '.join(MANNERS)}."
                )
                continue
            usual = msgspec.structs.asdict(MANNERS[name])
            asked = {**usual, **value} if isinstance(value, dict) else value
            manner = self._converted("manner", f"manner.{name}", asked, Manner)
            if manner is None:
                continue
            unknown = [
                f"The manner of {name} has the {kind} {chosen}, which does not exist."
                for kind, known in (
                    ("face", FACES),
                    ("gesture", gestures),
                    ("gaze", GAZES),
                    ("tone", TONES),
                )
                if (chosen := getattr(manner, kind)) and chosen not in known
            ]
            self.problems["manner"] += unknown
            if not unknown:
                good[name] = manner
        return good

    def _tones(self) -> dict[str, tuple[Note, ...]]:
        good = {}
        for name, value in self._entries("manner", "tones").items():
            if name not in TONES:
                self.problems["manner"].append(
                    f"{name} is not a tone; these are: {', '.join(TONES)}."
                )
            elif notes := self._converted("manner", f"tones.{name}", value, _NOTES):
                good[name] = notes
        return good


def _file(folder: Path, name: str) -> Path | None:
    """Return a file by its name; None if there is none or the name is invalid."""
    try:
        path = (folder / name).resolve()
        return path if path.is_file() else None
    # a name that is too long or contains NUL, or a cycle of links
    except (
        OSError,
        ValueError,
        RuntimeError,
    ):
        return None


def _is_below(value: object, least: float) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and value < least


def _legible(colors: Colors) -> str:
    """Return black or white, whichever has more contrast on both backgrounds."""
    return max(
        (_BLACK, _WHITE),
        key=lambda one: min(contrast(one, getattr(colors, ground)) for ground in GROUNDS),
    )


def _printable(name: str) -> str:
    """Return a name shortened, with control characters made visible, for an error message."""
    return visible(name if len(name) <= _LONGEST else f"{name[:_LONGEST]}…")


WIDTH, HEIGHT = 11, 4
"""Largest number of columns and lines of a face; arms are drawn beside it."""


def drawing_problems(name: str, face: str, mouth_line: int) -> list[str]:
    """Return what is wrong with a drawing, one sentence each."""
    lines = face.split("\n")
    found = []
    if len(lines) > HEIGHT or max(map(len, lines)) > WIDTH:
        found.append(f"The face {name} is larger than {WIDTH} columns and {HEIGHT} lines.")
    if mouth_line >= len(lines):
        found.append(
            f"The face {name} has no line {mouth_line}, counted from 0, for its mouth (mouth_line)."
        )
    odd = sorted(
        {character for line in lines for character in line if not _is_one_column(character)}
    )
    if odd:
        found.append(
            f"The face {name} is drawn with what does not fill one column: "
            f"{', '.join(map(ascii, odd))}."
        )
    return found


def fitted(faces: Mapping[str, str]) -> dict[str, str]:
    """Return faces padded to the size of the largest: editors strip trailing spaces."""
    lines = {name: face.split("\n") for name, face in faces.items()}
    height = max(map(len, lines.values()), default=0)
    width = max((len(line) for face in lines.values() for line in face), default=0)
    return {
        name: "\n".join(line.ljust(width) for line in [*face, *[""] * (height - len(face))])
        for name, face in lines.items()
    }


def _is_one_column(character: str) -> bool:
    """Return whether a character takes one column: no emoji, wide East Asian or combining
    character.
    """
    return (
        unicodedata.category(character)[0] not in "MC"
        and unicodedata.east_asian_width(character) not in "WF"
    )
