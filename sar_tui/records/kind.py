"""Kinds of record, declared in TOML: their fields with bounds and units, who enters them, their source.

The kinds that ship are the files in `sar_tui/records/kinds`; a clinic puts its own into the folder
``records`` beside its tasks. A kind of the same name replaces one that ships.

A form is a kind with items, which a participant answers one by one, and scores (docs/forms.md). Its
items are fields. The fields of its scores, and of how it was filled in, are added to them.
"""

import functools
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

import msgspec
import platformdirs
from msgspec.structs import replace

from sar_tui.model.language import ENGLISH, Language
from sar_tui.model.toml_lines import TomlError, TomlLines, decode
from sar_tui.model.visible_text import control_problem, obeyed
from sar_tui.records import scoring
from sar_tui.records.scoring import Score

SHIPPED = Path(__file__).parent / "kinds"
NOT_SAID = "not said"
"""Value of an item that somebody would rather not answer."""
NOT_FOUND = "not found"
"""Method or interval of a published change that was not told in what was read of its source."""
STATUS, LANGUAGE, PERMISSION = "status", "language", "permission"
"""Fields of each form: how far it is filled in, in which language, and who allowed its use."""
OPEN, COMPLETE = "open", "complete"
"""Values of the field ``status``."""
LONGEST_TEXT = 2000
"""Characters of a text in a record."""
MOST_SHOWN_POINTS = 31
"""Points of a scale that are shown one by one; of more, the number is typed."""
_MOST_POINTS = 101
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
        step: distance between the points of an integer with bounds.
        unit: of a number.
        better: direction of improvement of a score; empty if it is none.
        reversed: True if scores of its form count it from the other end.
        labels: the options of a choice; of a number, the words at both ends, or of each point.
        required: False if it may be left empty.
        later: True if it is often known only later, so that people are reminded of it.
        hint: shown in the empty field of a form.
        problem: sentence for people if the field is missing, instead of the usual one.
        may_decline: True if ``NOT_SAID`` is a value of it, as of each item of a form.
        typed: False of a text that nobody writes freely, such as the name of a study.
    """

    name: str
    title: str
    type: Literal["number", "integer", "choice", "text"]
    lowest: float = -math.inf
    highest: float = math.inf
    step: float = 1.0
    unit: str = ""
    reversed: bool = False
    better: Literal["higher", "lower", ""] = ""
    labels: tuple[str, ...] = ()
    required: bool = True
    later: bool = False
    hint: str = ""
    problem: str = ""
    may_decline: bool = False
    typed: bool = True

    @property
    def points(self) -> tuple[int, ...]:
        """The values of a scale, an integer with bounds; none of other fields, or if there are
        more than 101.
        """
        if self.type != "integer" or not math.isfinite(self.highest - self.lowest):
            return ()
        count = int((self.highest - self.lowest) / self.step) + 1
        if count > _MOST_POINTS:
            return ()
        return tuple(round(self.lowest + number * self.step) for number in range(count))

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
        if self.may_decline and given == NOT_SAID:
            return NOT_SAID
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
        if self.step != 1 and (number - self.lowest) % self.step:
            raise RecordError(
                tr(
                    "{field} goes in steps of {step} from {low}, so it is not {number}.",
                    field=title,
                    step=f"{self.step:g}",
                    low=f"{self.lowest:g}",
                    number=f"{number:g}",
                ),
                self.name,
            )
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
    """A published minimal detectable change or important difference (``MCID``) of the first field
    of a kind.

    Attributes:
        kind: ``MDC95`` and ``MDC90`` hold with 95 and 90 % confidence; of ``MDC`` it is not known.
        low, high: equal for a single value.
        of: the people it holds for: condition, phase, number and setting.
        source: author, year and DOI.
        method: how it was found; of an MCID, by which anchor or from the distribution.
        interval: between the two tests of an MDC, or the two assessments of an MCID.
        read: what was read of the source; empty if that is not declared.
    """

    kind: Literal["MDC", "MDC95", "MDC90", "MCID"]
    low: float
    high: float
    of: str
    source: str
    method: str = NOT_FOUND
    interval: str = NOT_FOUND
    read: Literal["abstract", "whole paper", ""] = ""


class Words(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The words of a form in a language.

    Attributes:
        title: of the form. ``instruction``: shown with each item.
        labels: of the points of each item, or of both ends.
        items: the text of each item. ``ends``: its own labels, in place of ``labels``.
    """

    title: str = ""
    instruction: str = ""
    labels: tuple[str, ...] = ()
    items: tuple[str, ...] = ()
    ends: tuple[tuple[str, ...], ...] = ()


class Form(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The table of a kind that makes it a form.

    Attributes:
        items: number of its items. Without ``fields`` they are named ``q1``, ``q2``, … and are
            integers from ``lowest`` to ``highest`` in steps of ``step``.
        reversed: numbers of those that are reversed, from 1.
        needs_permission: True if its owner must have allowed its use (``permission`` of the kind).
        redcap_names: True if the names of its items are those of a REDCap project.
    """

    items: int = 0
    lowest: float = 1
    highest: float = 5
    step: float = 1
    reversed: tuple[int, ...] = ()
    needs_permission: bool = False
    redcap_names: bool = False


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
        form: of a form; None of other kinds. ``scores``: its scores. ``words``: its words by
            language. ``permission``: who has allowed its use, and when.
    """

    name: str
    title: str
    group: str = "other"
    entered_by: Literal["therapist", "participant", "program"] = "therapist"
    when: str = "Date"
    has_time: bool = False
    once_a_day: bool = False
    fields: tuple[Field, ...] = ()
    source: str = ""
    licence: str = ""
    published: tuple[Published, ...] = ()
    form: Form | None = None
    scores: tuple[Score, ...] = ()
    words: dict[str, Words] = {}
    permission: str = ""

    @property
    def score(self) -> Field | None:
        """The field that says how well a person does; None if the kind has none."""
        return next((field for field in self.fields if field.better), None)

    @property
    def items(self) -> tuple[Field, ...]:
        """The items of a form, in order; none of other kinds."""
        return self.fields[: self.form.items] if self.form else ()

    def field(self, name: str) -> Field:
        """Return a field by its name. Raises RecordError if there is none."""
        for field in self.fields:
            if field.name == name:
                return field
        names = ", ".join(field.name for field in self.fields)
        raise RecordError(f"{self.name} has no field {name}. It has: {names}.", name)

    def read(self, given: Mapping[str, Value | None], tr: Language = ENGLISH) -> dict[str, Value]:
        """Return the values of a record as they are stored; fields that are left empty have none.
        Scores of a form are computed. ``tr``: the language in which an error is raised.

        Raises:
            RecordError: a value is missing, unknown or not valid.
        """
        for name in given:
            self.field(name)
        values = {field.name: field.read(given.get(field.name), tr) for field in self.fields}
        found = {name: value for name, value in values.items() if value is not None}
        return self._scored(found, tr) if self.form else found

    def _scored(self, values: dict[str, Value], tr: Language) -> dict[str, Value]:
        """Return the values of a form with its scores, once it is complete."""
        if not any(item.name in values for item in self.items):
            raise RecordError(tr("{kind} has no answers.", kind=tr(self.title)))
        derived = {name for score in self.scores for name in (score.name, missing_of(score))}
        found = {name: value for name, value in values.items() if name not in derived}
        if all(item.name in found for item in self.items):
            found[STATUS] = COMPLETE
        found.setdefault(STATUS, COMPLETE)
        if self.permission:
            found.setdefault(PERMISSION, self.permission)
        for score in self.scores if found[STATUS] == COMPLETE else ():
            computed = scoring.compute(score, self.items, found)
            if computed.value is not None:
                found[score.name] = computed.value
            found[missing_of(score)] = computed.missing
        return found

    # --- forms

    @property
    def languages(self) -> tuple[str, ...]:
        """The languages that a form has words in, by code; its declaration counts as English."""
        return tuple(self.words) or ("en",)

    def language_shown(self, code: str) -> str:
        """Return the language in which a form is shown to somebody who speaks this one: that, or
        English, or the first that it has words in.
        """
        for known in (code, code.partition("-")[0], "en"):
            if known in self.words:
                return known
        return self.languages[0]

    def in_language(self, code: str) -> "Kind":
        """Return a form with its words in a language; as it is declared if it has none in that."""
        if (words := self.words.get(self.language_shown(code))) is None:
            return self
        items = tuple(_worded(item, words, at) for at, item in enumerate(self.items))
        fields = (*items, *self.fields[len(items) :])
        return replace(self, title=words.title or self.title, fields=fields)

    def instruction_in(self, code: str) -> str:
        """Return what is shown with each item of a form; empty if nothing is."""
        words = self.words.get(self.language_shown(code))
        return words.instruction if words else ""

    @property
    def why_unusable(self) -> str:
        """Why nobody can fill in a form here, in one or two sentences; empty if they can."""
        assert self.form
        if not _has_text(self.items):
            return (
                f"The text of {self.name} is not here, as its owner has not allowed that. Put a file "
                f"with its words into {own_folder()} (docs/forms.md)."
            )
        return self.why_not_allowed

    @property
    def why_not_allowed(self) -> str:
        """Why records of a form cannot be stored here, in a sentence; empty if they can."""
        if self.form and self.form.needs_permission and not self.permission.strip():
            return (
                f"{self.name} may be used only if its owner allows it: name who did, and when, as "
                f"permission in its file in {own_folder()}."
            )
        return ""


def missing_of(score: Score) -> str:
    """Return the name of the field with the number of missing items of a score."""
    return f"{score.name}_missing"


def time_of(item: Field) -> str:
    """Return the name of the field with the time that an item took."""
    return f"{item.name}_ms"


def _has_text(items: Sequence[Field]) -> bool:
    """Return True if each item says what it asks: in words, or by labels that others have not."""
    bare = [item.labels for item in items if not item.title]
    return all(bare) and (len(bare) < 2 or len(set(bare)) > 1)


def _worded(item: Field, words: Words, at: int) -> Field:
    """Return an item of a form with its words."""
    title = (words.items[at] if at < len(words.items) else "") or item.title
    labels = (words.ends[at] if at < len(words.ends) else ()) or words.labels
    if item.type not in ("integer", "number", "choice"):
        labels = ()
    return replace(item, title=title, labels=labels or item.labels)


def own_folder() -> Path:
    """Return the folder of a clinic's own kinds."""
    return platformdirs.user_config_path("sar-tui") / "records"


def kinds() -> dict[str, Kind]:
    """Return all kinds by name that can be used: the bundled ones, and the clinic's own."""
    return {**_read_folder(SHIPPED).kinds, **_own().kinds}


def unusable_files() -> tuple[str, ...]:
    """Return why files of the clinic cannot be used, a sentence for each."""
    return tuple(_own().problems.values())


def find(name: str) -> Kind:
    """Return a kind by its name, in capital letters or not.

    Raises:
        KindError: there is none, or the file of this name cannot be used.
    """
    known, problems, sought = kinds(), _own().problems, name.strip().casefold()
    if problem := problems.get(sought):
        raise KindError(problem)
    for kind in known.values():
        if kind.name.casefold() == sought:
            return kind
    none = f"There is no kind of record {name}. Choose one of: {', '.join(known)}."
    raise KindError(" ".join((*problems.values(), none)))


def of_group(group: str) -> Iterator[Kind]:
    """Return the kinds of a group."""
    return (kind for kind in kinds().values() if kind.group == group)


class _Folder(NamedTuple):
    """The kinds of a folder by name, and why files are none, by their names in small letters."""

    kinds: dict[str, Kind]
    problems: dict[str, str]


def _own() -> _Folder:
    folder = own_folder()
    return _read_folder(folder) if folder.is_dir() else _Folder({}, {})


@functools.lru_cache(maxsize=8)
def _read_folder(folder: Path) -> _Folder:
    found = _Folder({}, {})
    for path in sorted(folder.glob("*.toml")):
        try:
            kind = read_kind(path)
        except KindError as error:
            found.problems[path.stem.casefold()] = str(error)
        else:
            found.kinds[kind.name] = kind
    return found


def read_kind(path: Path) -> Kind:
    """Return the kind that a file declares.

    Raises:
        KindError: it cannot be read, or declares something that cannot be.
    """
    try:
        text = path.read_bytes().decode()
        return _declared(text)
    except OSError as error:
        reason = error.strerror or error
        raise KindError(f"The kind of record cannot be read: {reason}: {path.name}.") from error
    except UnicodeDecodeError:
        raise KindError(f"{path.name} is not a text in UTF-8.") from None
    except TomlError as error:
        raise KindError(f"{path.name}, {error}") from error
    except msgspec.ValidationError as error:
        raise KindError(TomlLines(text, path.name).invalid(str(error))) from error
    except KindError as error:
        raise KindError(f"{path.name}: {error}") from None


def toml_problem(text: str) -> str:
    """Return why the text of a file declares no kind; empty if it does."""
    try:
        _declared(text)
    except (KindError, TomlError, msgspec.ValidationError) as error:
        return str(error)
    return ""


def _declared(text: str) -> Kind:
    kind = msgspec.convert(_with_base(decode(text)), Kind)
    if problem := _problem(kind):
        raise KindError(problem)
    return kind if kind.form is None else _as_form(kind)


_BASED_ON = "based_on"


def _with_base(declared: dict[str, Any]) -> dict[str, Any]:
    """Return a declaration with what it takes from the kind that ships and that it is based on."""
    if _BASED_ON not in declared:
        return declared
    own = {name: value for name, value in declared.items() if name != _BASED_ON}
    for path in SHIPPED.glob("*.toml"):
        base = msgspec.toml.decode(path.read_bytes())
        if base["name"] == declared[_BASED_ON]:
            return {**base, **own}
    raise KindError(f"No kind {declared[_BASED_ON]!r:.40} ships.")


def _as_form(kind: Kind) -> Kind:
    """Return a form with the fields of its items, its scores, and of how it was filled in."""
    items = _items(kind)
    scores, missing = [], []
    for score in kind.scores:
        low, high = scoring.bounds(score, items)
        scores.append(
            Field(
                name=score.name,
                title=score.title,
                type="number",
                lowest=low,
                highest=high,
                better=score.better,
                required=False,
            )
        )
        missing.append(_added(missing_of(score), f"{score.title}: missing items", "integer"))
    fields = (
        *items,
        *scores,
        *missing,
        replace(_added(STATUS, "Status", "choice"), labels=(COMPLETE, OPEN)),
        replace(_added(LANGUAGE, "Language", "text"), typed=False),
        _added(PERMISSION, "Permission held by", "text"),
        *(replace(_added(time_of(item), "Time", "integer"), unit="ms") for item in items),
    )
    assert kind.form
    words = {"en": Words(), **kind.words} if _has_text(items) else kind.words
    form = replace(kind.form, items=len(items))
    return replace(kind, fields=fields, form=form, words=words).in_language("en")


def _added(name: str, title: str, type: Literal["integer", "choice", "text"]) -> Field:
    return Field(name=name, title=title, type=type, required=False)


def _items(kind: Kind) -> tuple[Field, ...]:
    """Return the items of a form as they are declared; none if it has no form."""
    if (form := kind.form) is None:
        return ()
    items = kind.fields or tuple(
        Field(
            name=f"q{number}",
            title="",
            type="integer",
            lowest=form.lowest,
            highest=form.highest,
            step=form.step,
            reversed=number in form.reversed,
        )
        for number in range(1, form.items + 1)
    )
    return tuple(replace(item, required=False, may_decline=True) for item in items)


def _problem(kind: Kind) -> str:
    """Return why a kind cannot be used, in one sentence; empty if it can."""
    fields = kind.fields or _items(kind)
    names = [field.name for field in fields]
    if kind.form:
        names += [name for score in kind.scores for name in (score.name, missing_of(score))]
        names += [STATUS, LANGUAGE, PERMISSION, *map(time_of, fields)]
    if twice := next((name for name, count in Counter(names).items() if count > 1), None):
        return f"Two fields are named {twice!r}."
    if not fields or not all(word.strip() for word in (kind.name, kind.title, *names)):
        return "A kind has a name, a title and fields, and each field has a name."
    wrong = next(filter(None, map(_field_problem, fields)), "")
    return wrong or (_form_problem(kind) if kind.form else _not_of_form(kind))


def _not_of_form(kind: Kind) -> str:
    if kind.scores or kind.words:
        return "Scores and words belong to a form: add a table [form]."
    return ""


def _field_problem(field: Field) -> str:
    """Return why a field cannot be used, in one sentence; empty if it can."""
    if field.type == "choice" and len(field.labels) < 2:
        return f"The choice {field.name} needs two labels or more."
    if field.lowest > field.highest:
        return f"{field.name} has bounds that no number lies within."
    if not field.step > 0 or field.step != round(field.step):
        return f"The step of {field.name} is a whole number from 1."
    shown = "".join((field.title, field.hint, *field.labels))
    return control_problem(f"The field {field.name}", shown)


_MOST_OPTIONS = 9
"""Options of a choice of a form, each with its digit."""


def _form_problem(kind: Kind) -> str:
    """Return why a form cannot be used, in one sentence; empty if it can."""
    assert kind.form
    items = _items(kind)
    if kind.entered_by != "participant":
        return 'A form is filled in by the participant: entered_by = "participant".'
    if kind.fields and kind.form.items not in (0, len(items)):
        return f"The form has {len(items)} fields, not {kind.form.items} items."
    if kind.fields and kind.form.reversed:
        return "A field of the form is reversed by its own: reversed = true."
    if any(not 1 <= number <= len(items) for number in kind.form.reversed):
        return f"The form has reversed items from 1 to {len(items)}."
    problems = (
        *(_words_problem(code, words, items) for code, words in kind.words.items()),
        *map(_item_problem, items),
        *(scoring.problem(each, items) for each in kind.scores),
    )
    return next(filter(None, problems), "")


def _words_problem(code: str, words: Words, items: Sequence[Field]) -> str:
    """Return why the words of a form in a language cannot be used; empty if they can."""
    if any(len(given) not in (0, len(items)) for given in (words.items, words.ends)):
        return f"The words in {code} have another number of items than the form, {len(items)}."
    for at, declared in enumerate(items):
        item = _worded(declared, words, at)
        if item.type == "choice" and len(item.labels) != len(declared.labels):
            return f"The choice {item.name} has another number of labels in {code}."
        if problem := _item_problem(item):
            return problem
    ends = [label for own in words.ends for label in own]
    shown = "".join((words.title, words.instruction, *words.items, *words.labels, *ends))
    return control_problem(f"The words in {code}", shown)


def _item_problem(item: Field) -> str:
    """Return why an item cannot be asked, in one sentence; empty if it can."""
    labels, points = item.labels, item.points
    if item.type == "choice":
        if len(labels) > _MOST_OPTIONS:
            return f"The choice {item.name} has at most {_MOST_OPTIONS} labels."
        if len({label.casefold() for label in labels}) < len(labels):
            return f"The choice {item.name} has two labels that are the same."
        if not all(label and label == label.strip() for label in labels):
            return f"The choice {item.name} has a label that is empty, or with blanks at its ends."
    if points and (item.lowest, item.highest) != (points[0], points[-1]):
        return f"Lowest and highest of {item.name} are whole numbers, and points of its scale."
    each = len(points) if len(points) <= MOST_SHOWN_POINTS else 0
    if item.is_number and len(labels) not in (0, 2, each):
        return f"{item.name} has labels for both ends, for each point, or none."
    return ""
