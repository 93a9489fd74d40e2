"""Kinds of record, declared in TOML: their fields with bounds and units, who enters them, their source.

The kinds that ship are the files in `sar_tui/records/kinds`; a clinic puts its own into the folder
``records`` beside its tasks. A kind of the same name replaces one that ships.
"""

import functools
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Literal

import msgspec
import platformdirs

from sar_tui.model.language import ENGLISH, Language
from sar_tui.model.visible_text import control_problem, obeyed

SHIPPED = Path(__file__).parent / "kinds"
LONGEST_TEXT = 2000
"""Characters of a text in a record."""
_LINES = "\n\r\t"
"""Control characters that a text of several lines has."""

Value = int | float | str | bool
Values = Mapping[str, Value]


class KindError(ValueError):
    """A kind of record cannot be used. The message is one or two sentences."""


class RecordError(ValueError):
    """A record is not as its kind declares. The message is one sentence.

    Attributes:
        field: name of the field that is wrong; empty if it is no field.
    """

    def __init__(self, message: str, field: str = "") -> None:
        super().__init__(message)
        self.field = field


class Field(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A field of a record.

    Attributes:
        name: key of its value in the database.
        title: shown at it in forms and lists.
        type: ``number``, ``integer``, ``choice`` (one of ``labels``) or ``text``.
        lowest, highest: inclusive bounds of a number.
        unit: of a number.
        better: direction of improvement of a score; empty if it is none.
        labels: the options of a choice; of a number, the words at both ends.
        required: False if it may be left empty.
        later: True if it is often known only later, so that people are reminded of it.
        hint: shown in the empty field of a form.
        problem: sentence for people if the field is missing, instead of the usual one.
    """

    name: str
    title: str
    type: Literal["number", "integer", "choice", "text"]
    lowest: float = -math.inf
    highest: float = math.inf
    unit: str = ""
    better: Literal["higher", "lower", ""] = ""
    labels: tuple[str, ...] = ()
    required: bool = True
    later: bool = False
    hint: str = ""
    problem: str = ""

    @property
    def is_number(self) -> bool:
        """True if its values are numbers."""
        return self.type in ("number", "integer")

    @property
    def range(self) -> str:
        """The bounds and the unit in words, such as "0 to 66 points"; empty without bounds."""
        return self.range_in(ENGLISH)

    def range_in(self, tr: Language) -> str:
        """Return the bounds and the unit in a language."""
        if not (self.is_number and math.isfinite(self.lowest) and math.isfinite(self.highest)):
            return ""
        bounds = tr("{low} to {high}", low=f"{self.lowest:g}", high=f"{self.highest:g}")
        return f"{bounds} {tr(self.unit)}".rstrip()

    def read(self, given: Value | None, tr: Language = ENGLISH) -> Value | None:
        """Return a value as it is stored; None if it is left empty. ``tr``: the language in which
        an error is raised.

        Raises:
            RecordError: the field has no such value, or needs one.
        """
        if given is None or not str(given).strip():
            if self.required:
                missing = tr("{field} is missing.", field=tr(self.title))
                raise RecordError(tr(self.problem) or missing, self.name)
            return None
        if self.is_number:
            return self._number(given, tr)
        text = str(given).strip()
        if self.type == "choice":
            return self._choice(text, tr)
        return self._text(text, tr)

    def _number(self, given: Value, tr: Language) -> Value:
        title = tr(self.title)
        try:
            number = float(given.replace(",", ".") if isinstance(given, str) else given)
        except ValueError:
            problem = tr("{field} is a number, not {given}.", field=title, given=f"{given!r:.40}")
            raise RecordError(problem, self.name) from None
        if not math.isfinite(number) or not self.lowest <= number <= self.highest:
            problem = tr(
                "{field} lies within {range}, not at {number}.",
                field=title,
                range=self.range_in(tr),
                number=f"{number:g}",
            )
            raise RecordError(problem, self.name)
        if self.type == "number":
            return number
        if number != round(number):
            problem = tr(
                "{field} is a whole number, not {number}.", field=title, number=f"{number:g}"
            )
            raise RecordError(problem, self.name)
        return round(number)

    def _choice(self, text: str, tr: Language) -> str:
        """Return the label that was typed, in English or in the language."""
        for label in self.labels:
            if text.casefold() in (label.casefold(), tr(label).casefold()):
                return label
        problem = tr(
            "{field} is {options} or {last}, not {given}.",
            field=tr(self.title),
            options=", ".join(map(tr, self.labels[:-1])),
            last=tr(self.labels[-1]),
            given=f"{text!r:.40}",
        )
        raise RecordError(problem, self.name)

    def _text(self, text: str, tr: Language) -> str:
        title = tr(self.title)
        if len(text) > LONGEST_TEXT:
            problem = tr(
                "{field} is too long: at most {most} characters.", field=title, most=LONGEST_TEXT
            )
            raise RecordError(problem, self.name)
        try:
            text.encode()
        except UnicodeEncodeError:
            problem = tr("{field} has bytes that are not UTF-8.", field=title)
            raise RecordError(problem, self.name) from None
        if found := obeyed(text, _LINES):
            problem = tr(
                "{field} has control characters: {found}.", field=title, found=", ".join(found)
            )
            raise RecordError(problem, self.name)
        return text


class Published(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A published minimal detectable change, at 95 % (``MDC``) or 90 % (``MDC90``), or important
    difference (``MCID``), of the first field of a kind.

    ``low`` and ``high`` are equal for a single value. ``of``: the people it holds for.
    """

    kind: Literal["MDC", "MDC90", "MCID"]
    low: float
    high: float
    of: str
    source: str


class Kind(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A kind of record.

    Attributes:
        name: how commands and the database call it.
        title: its name for people, as in "a Fugl-Meyer assessment".
        group: the list in which it is shown: ``event``, ``score``, ``wellbeing`` or another.
        entered_by: who enters it: ``therapist``, ``participant``, or ``program`` if it follows from a session.
        when: title of the date it is of: "Onset", "Day it was measured".
        has_time: True if that date may have a time of day.
        once_a_day: True if a second record of a person and day replaces the first.
        fields: in the order of the form.
        source: where the measure comes from. ``licence``: on what terms its text is here.
        published: what is published of its changes.
    """

    name: str
    title: str
    group: str = "other"
    entered_by: Literal["therapist", "participant", "program"] = "therapist"
    when: str = "Date"
    has_time: bool = False
    once_a_day: bool = False
    fields: tuple[Field, ...]
    source: str = ""
    licence: str = ""
    published: tuple[Published, ...] = ()

    @property
    def score(self) -> Field | None:
        """The field that says how well a person does; None if the kind has none."""
        return next((field for field in self.fields if field.better), None)

    def field(self, name: str) -> Field:
        """Return a field by its name. Raises RecordError if there is none."""
        for field in self.fields:
            if field.name == name:
                return field
        names = ", ".join(field.name for field in self.fields)
        raise RecordError(f"{self.name} has no field {name}. It has: {names}.", name)

    def read(self, given: Mapping[str, Value | None], tr: Language = ENGLISH) -> dict[str, Value]:
        """Return the values of a record as they are stored; fields that are left empty have none.
        ``tr``: the language in which an error is raised.

        Raises:
            RecordError: a value is missing, unknown or not valid.
        """
        for name in given:
            self.field(name)
        values = {field.name: field.read(given.get(field.name), tr) for field in self.fields}
        return {name: value for name, value in values.items() if value is not None}


def own_folder() -> Path:
    """Return the folder of a clinic's own kinds."""
    return platformdirs.user_config_path("sar-tui") / "records"


def kinds() -> dict[str, Kind]:
    """Return all kinds by name: the bundled ones, and the clinic's own.

    Raises:
        KindError: a file cannot be used.
    """
    own = own_folder()
    return {**_read_folder(SHIPPED), **(_read_folder(own) if own.is_dir() else {})}


def find(name: str) -> Kind:
    """Return a kind by its name, in capital letters or not.

    Raises:
        KindError: there is none, or a file cannot be used.
    """
    known = kinds()
    for kind in known.values():
        if kind.name.casefold() == name.strip().casefold():
            return kind
    raise KindError(f"There is no kind of record {name}. Choose one of: {', '.join(known)}.")


def of_group(group: str) -> Iterator[Kind]:
    """Return the kinds of a group."""
    return (kind for kind in kinds().values() if kind.group == group)


@functools.lru_cache(maxsize=8)
def _read_folder(folder: Path) -> dict[str, Kind]:
    read = (read_kind(path) for path in sorted(folder.glob("*.toml")))
    return {kind.name: kind for kind in read}


def read_kind(path: Path) -> Kind:
    """Return the kind that a file declares.

    Raises:
        KindError: it cannot be read, or declares something that cannot be.
    """
    try:
        kind = msgspec.toml.decode(path.read_bytes(), type=Kind)
    except OSError as error:
        reason = error.strerror or error
        raise KindError(f"The kind of record cannot be read: {reason}: {path.name}.") from error
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise KindError(f"{path.name} is no kind of record: {error}.") from error
    if problem := _problem(kind):
        raise KindError(f"{path.name}: {problem}")
    return kind


def _problem(kind: Kind) -> str:
    """Return why a kind cannot be used, in one sentence; empty if it can."""
    names = [field.name for field in kind.fields]
    if twice := next((name for name in names if names.count(name) > 1), None):
        return f"Two fields are named {twice!r}."
    if not names or not all(word.strip() for word in (kind.name, kind.title, *names)):
        return "A kind has a name, a title and fields, and each field has a name."
    return next(filter(None, map(_field_problem, kind.fields)), "")


def _field_problem(field: Field) -> str:
    """Return why a field cannot be used, in one sentence; empty if it can."""
    if field.type == "choice" and len(field.labels) < 2:
        return f"The choice {field.name} needs two labels or more."
    if field.lowest > field.highest:
        return f"{field.name} has bounds that no number lies within."
    shown = "".join((field.title, field.hint, *field.labels))
    return control_problem(f"The field {field.name}", shown)
