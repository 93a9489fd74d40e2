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
        if not (self.is_number and math.isfinite(self.lowest) and math.isfinite(self.highest)):
            return ""
        return f"{self.lowest:g} to {self.highest:g} {self.unit}".rstrip()

    def read(self, given: Value | None) -> Value | None:
        """Return a value as it is stored; None if it is left empty.

        Raises:
            RecordError: the field has no such value, or needs one.
        """
        if given is None or not str(given).strip():
            if self.required:
                raise RecordError(self.problem or f"{self.title} is missing.", self.name)
            return None
        if self.is_number:
            return self._number(given)
        text = str(given).strip()
        if self.type == "choice":
            return self._choice(text)
        return self._text(text)

    def _number(self, given: Value) -> Value:
        try:
            number = float(given.replace(",", ".") if isinstance(given, str) else given)
        except ValueError:
            raise RecordError(f"{self.title} is a number, not {given!r:.40}.", self.name) from None
        if not math.isfinite(number) or not self.lowest <= number <= self.highest:
            raise RecordError(
                f"{self.title} lies within {self.range}, not at {number:g}.", self.name
            )
        if self.type == "number":
            return number
        if number != round(number):
            raise RecordError(f"{self.title} is a whole number, not {number:g}.", self.name)
        return round(number)

    def _choice(self, text: str) -> str:
        for label in self.labels:
            if text.casefold() == label.casefold():
                return label
        options = f"{', '.join(self.labels[:-1])} or {self.labels[-1]}"
        raise RecordError(f"{self.title} is {options}, not {text!r:.40}.", self.name)

    def _text(self, text: str) -> str:
        if len(text) > LONGEST_TEXT:
            problem = f"{self.title} is too long: at most {LONGEST_TEXT} characters."
            raise RecordError(problem, self.name)
        try:
            text.encode()
        except UnicodeEncodeError:
            raise RecordError(f"{self.title} has bytes that are not UTF-8.", self.name) from None
        if found := obeyed(text, _LINES):
            problem = f"{self.title} has control characters: {', '.join(found)}."
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

    def read(self, given: Mapping[str, Value | None]) -> dict[str, Value]:
        """Return the values of a record as they are stored; fields that are left empty have none.

        Raises:
            RecordError: a value is missing, unknown or not valid.
        """
        for name in given:
            self.field(name)
        values = {field.name: field.read(given.get(field.name)) for field in self.fields}
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
