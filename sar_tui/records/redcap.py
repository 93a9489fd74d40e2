"""Forms as instruments of REDCap: written as the zip that its designer takes, read from such a zip or
from a data dictionary.

What REDCap has no column for (the scores' rules, reversed items, source, licence) stands in the field
annotation of the first row, after ``sar-tui:``. What a form here cannot express is refused, with the
row and the reason; what is layout only is left out, with a sentence.
"""

import csv
import html
import io
import json
import math
import re
import zipfile
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

from sar_tui.records.kind import MOST_SHOWN_POINTS, Field, Kind, toml_problem
from sar_tui.records.scoring import Score, items_of

COLUMNS = (
    "Variable / Field Name", "Form Name", "Section Header", "Field Type", "Field Label",
    "Choices, Calculations, OR Slider Labels", "Field Note",
    "Text Validation Type OR Show Slider Number", "Text Validation Min", "Text Validation Max",
    "Identifier?", "Branching Logic (Show field only if...)", "Required Field?",
    "Custom Alignment", "Question Number (surveys only)", "Matrix Group Name", "Matrix Ranking?",
    "Field Annotation",
)  # fmt: skip
"""The columns of a data dictionary, in order."""
(
    NAME, FORM, SECTION, TYPE, LABEL, CHOICES, NOTE, VALIDATION, LOWEST, HIGHEST, IDENTIFIER,
    BRANCHING, REQUIRED, ALIGNMENT, NUMBER, MATRIX, RANKING, ANNOTATION,
) = COLUMNS  # fmt: skip
LONGEST_NAME = 26
"""Characters of a variable's name, as REDCap advises."""
INSTRUMENT, ORIGIN = "instrument.csv", "OriginID.txt"
"""The files of an instrument's zip."""
_OWN = "sar-tui: "
_SLIDER = (0, 100)
_YES_NO = {"yesno": ("Yes", "No"), "truefalse": ("True", "False")}
_LARGEST_FILE = 4_000_000
_NUMBER = re.compile(r"-?\d{1,15}(\.\d{1,15})?")
_CODE = re.compile(r"-?[0-9]{1,9}")
_VARIABLE = re.compile("[a-z][a-z0-9_]*")
_TAG = re.compile(r"</?[a-zA-Z][^<>]*>|<!--.*?-->", re.DOTALL)
"""A tag of HTML, which "<5" is none of."""
_LINE_BREAK = re.compile(r"<(?:br|/p|/div|/li)\b[^<>]*>", re.IGNORECASE)
_PIPED = re.compile(r"\[[a-z][a-z0-9_]*(?:[(:-][^\[\]]*)?\]")
"""Another answer, which REDCap puts into a text: [age], [ill(1)], [event-name]."""
_ACTION_TAG = re.compile(r"(?:^|\s)(@[A-Z][A-Z0-9_-]*)")
_TYPES = frozenset(
    "text notes dropdown radio checkbox yesno truefalse calc file slider descriptive sql".split()
)

Row = dict[str, str]


class RedcapError(ValueError):
    """A form cannot be written for REDCap, or a file is none of its. The message is one sentence."""


# --- writing


def instrument_zip(kind: Kind, language: str = "en") -> bytes:
    """Return a form as the zip of an instrument.

    Args:
        kind: the form.
        language: of its words.

    Raises:
        RedcapError: REDCap cannot express it.
    """
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(ORIGIN, "sar-tui")
        archive.writestr(INSTRUMENT, dictionary(kind, language))
    return written.getvalue()


def dictionary(kind: Kind, language: str = "en") -> bytes:
    """Return the rows of a form as REDCap writes them: UTF-8 with a byte order mark.

    Raises:
        RedcapError: REDCap cannot express it.
    """
    rows = [dict(zip(COLUMNS, COLUMNS, strict=True)), *rows_of(kind, language)]
    lines = [",".join(_cell(row.get(column, "")) for column in COLUMNS) for row in rows]
    return "".join(f"{line}\r\n" for line in lines).encode("utf-8-sig")


def _cell(text: str) -> str:
    """Return a text as a cell of REDCap, which reads each as it is: also one that a spreadsheet
    would take for a formula.
    """
    quoted = text.replace('"', '""')
    return f'"{quoted}"' if re.search('[",\r\n]|^\\s|\\s$', text) else text


def rows_of(kind: Kind, language: str = "en") -> list[Row]:
    """Return the rows of a form: its items, then its scores. Raises RedcapError."""
    assert kind.form
    form, shown = _identifier(kind.name), kind.in_language(language)
    names = {item.name: _variable(kind, form, item.name) for item in kind.items}
    rows = [
        {NAME: names[item.name], FORM: form, LABEL: item.title or _label_of(item), **_typed(item)}
        | ({NOTE: item.hint} if item.hint else {})
        for item in shown.items
    ]
    rows[0][SECTION] = kind.instruction_in(language)
    rows[0][ANNOTATION] = _head(kind, shown)
    rows += [
        {
            NAME: _variable(kind, form, score.name),
            FORM: form,
            TYPE: "calc",
            LABEL: score.title,
            CHOICES: calculation(score, kind.items, names),
        }
        for score in kind.scores
    ]
    used = Counter(row[NAME] for row in rows)
    if twice := next((name for name, count in used.items() if count > 1), None):
        raise RedcapError(f"{kind.name}: two variables would be named {twice}.")
    return rows


def _identifier(name: str) -> str:
    """Return a name as REDCap has it: a-z, 0-9 and _, beginning with a letter."""
    plain = re.sub("[^a-z0-9]+", "_", name.lower()).strip("_")
    return plain if plain[:1].isalpha() else f"form_{plain}".rstrip("_")


def _variable(kind: Kind, form: str, name: str) -> str:
    """Return the name of a variable: unique in a project, because it begins with that of the form."""
    assert kind.form
    plain = _identifier(name)
    if kind.form.redcap_names:
        return plain
    room = LONGEST_NAME - len(plain) - 1
    if room < 1:
        raise RedcapError(f"{kind.name}: the name of {name} is too long for REDCap.")
    return f"{form[:room].rstrip('_')}_{plain}"


def _label_of(item: Field) -> str:
    return " – ".join(item.labels)


def _typed(item: Field) -> Row:
    """Return the columns that say what can be answered."""
    for label in item.labels:
        if "|" in label or "\n" in label or label != label.strip():
            raise RedcapError(f"{item.name}: REDCap has no label {label!r:.40}.")
    points, labels = item.points, item.labels
    if item.type == "choice":
        for type, words in _YES_NO.items():
            if labels == words:
                return {TYPE: type}
        return {TYPE: "dropdown", CHOICES: _coded(enumerate(labels, 1))}
    if points and (points[0], points[-1], item.step) == (*_SLIDER, 1) and len(labels) in (0, 2):
        ends = f"{labels[0]} |  | {labels[1]}" if labels else ""
        return {TYPE: "slider", CHOICES: ends, VALIDATION: "number"}
    if 1 < len(points) <= MOST_SHOWN_POINTS:
        if len(labels) != len(points):
            first, last = labels[:1] or ("",), labels[-1:] or ("",)
            labels = (*first, *("",) * (len(points) - 2), *last)
        choices = [label or str(point) for point, label in zip(points, labels, strict=True)]
        return {TYPE: "radio", CHOICES: _coded(zip(points, choices, strict=True))}
    if item.is_number:
        if item.step != 1 or item.labels:
            raise RedcapError(f"{item.name}: REDCap has no such scale of {len(points)} points.")
        bounds = {
            column: f"{value:g}"
            for column, value in ((LOWEST, item.lowest), (HIGHEST, item.highest))
            if math.isfinite(value)
        }
        return {TYPE: "text", VALIDATION: item.type, **bounds}
    return {TYPE: "text"}


def _coded(choices: "Iterator[tuple[int, str]] | enumerate[str] | zip[tuple[int, str]]") -> str:
    return " | ".join(f"{code}, {label}" for code, label in choices)


class _Head(msgspec.Struct, omit_defaults=True):
    """The parts of a form that REDCap has no column for. ``bare``: numbers of items whose text is in
    their labels.
    """

    name: str = ""
    title: str = ""
    items: tuple[str, ...] = ()
    reversed: tuple[int, ...] = ()
    bare: tuple[int, ...] = ()
    scores: tuple[Score, ...] = ()
    source: str = ""
    licence: str = ""
    permission: str = ""
    needs_permission: bool = False
    redcap_names: bool = True


def _head(kind: Kind, shown: Kind) -> str:
    """Return what REDCap has no column for, as the annotation of the first row."""
    assert kind.form
    head = _Head(
        name=kind.name,
        title=shown.title,
        items=tuple(item.name for item in kind.items),
        reversed=tuple(number for number, item in enumerate(kind.items, 1) if item.reversed),
        bare=tuple(number for number, item in enumerate(shown.items, 1) if not item.title),
        scores=kind.scores,
        source=kind.source,
        licence=kind.licence,
        permission=kind.permission,
        needs_permission=kind.form.needs_permission,
        redcap_names=kind.form.redcap_names,
    )
    return _OWN + msgspec.json.encode(head).decode()


def _short(score: Score) -> dict[str, Any]:
    """Return what a score declares beside the defaults."""
    usual = msgspec.to_builtins(Score())
    declared = msgspec.to_builtins(score).items()
    return {key: value for key, value in declared if value != usual[key]}


def calculation(score: Score, items: Sequence[Field], names: Mapping[str, str]) -> str:
    """Return the calculation of a score, with the names of the items' variables. A field that is
    blank is a missing item.
    """
    own = items_of(score, items)
    turned = []
    for item in own:
        name = f"[{names[item.name]}]"
        both = _figure(item.lowest + item.highest)
        value = f"({both}-{name})" if item.reversed else name
        if score.missing == "middle":
            value = f"if({name}='', {_figure((item.lowest + item.highest) / 2)}, {value})"
        elif score.missing == "others":
            value = f"if({name}='', '', {value})"
        turned.append(value)
    count, times = len(own), _figure(score.times)
    if score.rule == "sum" and score.missing != "others":
        total = f"({'+'.join(turned)}-{_figure(count * score.subtract)})*{times}"
    else:
        is_of_others = score.missing == "others"
        mean = f"mean({', '.join(turned)})" if is_of_others else f"(({'+'.join(turned)})/{count})"
        total = f"({mean}-{_figure(score.subtract)})*{times}"
        total += f"*{count}" if score.rule == "sum" else ""
    if score.missing == "no score":
        return total
    answered = "+".join(f"if([{names[item.name]}]='', 0, 1)" for item in own)
    return f"if(({answered})>={max(1, score.at_least)}, {total}, '')"


def _figure(value: float) -> str:
    return f"{value:.15g}" if value >= 0 else f"({value:.15g})"


# --- reading


class FoundForm(NamedTuple):
    """A form of a data dictionary.

    Attributes:
        name: of the form there. ``kind``: of the kind of record here.
        declaration: the text of a file that declares it here; empty if it is refused.
        refused: why, a sentence for each row. ``left_out``: what of it is not taken over.
    """

    name: str
    kind: str
    declaration: str
    refused: list[str]
    left_out: list[str]


def read(path: Path) -> list[FoundForm]:
    """Return the forms of a data dictionary (CSV), or of an instrument's zip.

    Raises:
        RedcapError: the file is neither.
    """
    try:
        if path.stat().st_size > _LARGEST_FILE:
            raise RedcapError(f"{path.name} is too large for a data dictionary.")
        is_zip = zipfile.is_zipfile(path)
        content = _from_zip(path) if is_zip else path.read_bytes()
    except OSError as error:
        why = error.strerror or error
        raise RedcapError(f"{path.name} cannot be read: {why}.") from error
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise RedcapError(f"{path.name} is not UTF-8. Save it as CSV UTF-8.") from error
    rows = _rows(path.name, text)
    if is_zip or not rows or not _is_record_id(rows[0][1]):
        return list(_forms(rows))
    (number, id), *others = rows
    found = list(_forms(others))
    for form in found:
        if form.name == id[FORM]:
            said = f"Row {number}: {id[NAME]} is left out, as the record's id."
            form.left_out.insert(0, said)
    return found


def _is_record_id(first: Row) -> bool:
    """Return True if the first row of a dictionary is the record's id, as in one of a whole project."""
    return first[TYPE] == "text" and not first[ANNOTATION].startswith(_OWN)


def _from_zip(path: Path) -> bytes:
    try:
        with zipfile.ZipFile(path) as archive:
            if archive.getinfo(INSTRUMENT).file_size > _LARGEST_FILE:
                raise RedcapError(f"{path.name} is too large for an instrument.")
            return archive.read(INSTRUMENT)
    except KeyError:
        raise RedcapError(
            f"{path.name} is no instrument of REDCap: it has no {INSTRUMENT}."
        ) from None
    except (
        zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError, EOFError,
    ) as error:  # fmt: skip
        raise RedcapError(f"{path.name} is a damaged zip.") from error


def _rows(name: str, text: str) -> list[tuple[int, Row]]:
    """Return the rows with their numbers in the file, 1 for the head."""
    first = text.splitlines()[0] if text else ""
    between = ";" if first.count(";") > first.count(",") else ","
    try:
        lines = list(csv.reader(io.StringIO(text, newline=""), delimiter=between, strict=True))
    except csv.Error as error:
        raise RedcapError(f"{name} is no CSV: {error}.") from error
    head = [column.strip() for column in lines[0]] if lines else []
    needed = (NAME, FORM, TYPE, LABEL)
    if missing := [column for column in needed if column not in head]:
        raise RedcapError(f"{name} is no data dictionary: it has no column {missing[0]!r}.")
    found = []
    for number, cells in enumerate(lines[1:], 2):
        if any(cell.strip() for cell in cells):
            if any(cell.strip() for cell in cells[len(head) :]):
                raise RedcapError(f"{name}: row {number} has more cells than there are columns.")
            given = {column: cell.strip() for column, cell in zip(head, cells, strict=False)}
            found.append((number, dict.fromkeys(COLUMNS, "") | given))
    return found


def _forms(rows: Sequence[tuple[int, Row]]) -> Iterator[FoundForm]:
    by_form: dict[str, list[tuple[int, Row]]] = {}
    used: dict[str, int] = {}
    twice: dict[str, list[str]] = {}
    before = ""
    for number, row in rows:
        form, name = row[FORM], row[NAME]
        if name in used:
            said = f"Row {number}: {name} is the name of row {used[name]}, too."
            twice.setdefault(form, []).append(said)
        if form in by_form and form != before:
            twice.setdefault(form, []).append(f"Row {number}: the rows of {form} are not together.")
        used.setdefault(name, number)
        before = form
        by_form.setdefault(form, []).append((number, row))
    for form, own in by_form.items():
        yield _FormReader(form, own, twice.get(form, [])).found()


def _without_html(text: str) -> str:
    """Return a text without the tags of HTML, and with a blank where a line ended."""
    return html.unescape(_TAG.sub("", _LINE_BREAK.sub(" ", text))).strip()


class _Refused(Exception):
    """A row cannot be expressed. The message is the rest of a sentence, after its name."""


class _FormReader:
    """Reads the rows of one form."""

    def __init__(self, form: str, rows: Sequence[tuple[int, Row]], refused: list[str]) -> None:
        self._form, self._rows = form, rows
        self._refused, self._left_out = list(refused), list[str]()
        self._items: list[dict[str, Any]] = []
        self._variables: list[str] = []
        self._calculations: list[tuple[int, Row]] = []
        self._head = _Head()
        self._instruction = ""

    def found(self) -> FoundForm:
        """Return the form."""
        if not _VARIABLE.fullmatch(self._form):
            number = self._rows[0][0]
            self._refused.append(f"Row {number}: {self._form!r:.40} is no name of a form.")
        for number, row in self._rows:
            try:
                self._read(number, row)
            except _Refused as why:
                self._refused.append(f"Row {number}: {row[NAME]} {why}.")
        if not self._items and not self._refused:
            self._refused.append(f"{self._form} has no field that can be answered.")
        text = "" if self._refused else to_toml(self._declared())
        if text and (problem := toml_problem(text)):
            self._refused.append(f"{self._form}: {problem}")
        if not self._refused:
            self._check_calculations()
        name = self._head.name or self._form
        return FoundForm(
            self._form, name, "" if self._refused else text, self._refused, self._left_out
        )

    def _read(self, number: int, row: Row) -> None:
        type = row[TYPE]
        if type not in _TYPES:
            raise _Refused(f"has the type {type!r:.40}, which REDCap does not know")
        if not _VARIABLE.fullmatch(row[NAME]):
            raise _Refused("is no name of a variable: a-z, 0-9 and _, a letter first")
        if type in ("descriptive", "sql"):
            self._left_out.append(f"Row {number}: {row[NAME]} is left out, as it asks nothing.")
        elif type == "calc":
            self._calculations.append((number, row))
        else:
            self._check_conditions(row)
            self._annotation(number, row)
            item = self._item(number, row)
            self._layout(number, row)
            self._items.append(item)
            self._variables.append(row[NAME])

    def _check_conditions(self, row: Row) -> None:
        if row[BRANCHING]:
            raise _Refused("is shown only under a condition, and each item here is shown always")
        if row[IDENTIFIER].lower() == "y":
            raise _Refused("identifies a person, and this database has codes only")

    def _annotation(self, number: int, row: Row) -> None:
        annotation = row[ANNOTATION]
        if annotation.startswith(_OWN) and not self._items:
            try:
                own = annotation.removeprefix(_OWN)
                self._head = msgspec.json.decode(own, type=_Head)
            except msgspec.MsgspecError:
                raise _Refused("has an annotation of sar-tui that was changed") from None
        elif tag := _ACTION_TAG.search(annotation):
            raise _Refused(f"has the action tag {tag[1]}, which nothing here does")
        elif annotation:
            self._skip(number, row, ANNOTATION)

    def _layout(self, number: int, row: Row) -> None:
        if row[SECTION] and not self._items:
            self._instruction = self._plain(number, row, SECTION)
        if row[REQUIRED]:
            self._left_out.append(
                f"Row {number}: {row[NAME]} is not required here, as anybody may rather not say."
            )
        for column in (SECTION, ALIGNMENT, NUMBER, MATRIX, RANKING):
            if row[column] and (column != SECTION or self._items):
                self._skip(number, row, column)

    def _skip(self, number: int, row: Row, column: str) -> None:
        self._left_out.append(f"Row {number}: {row[NAME]}: {column} is left out.")

    def _plain(self, number: int, row: Row, column: str) -> str:
        """Return a text without HTML."""
        text = _without_html(row[column])
        if text != row[column]:
            self._left_out.append(f"Row {number}: {row[NAME]}: HTML of {column} is left out.")
        if _PIPED.search(text):
            raise _Refused(f"shows another answer in its {column}")
        return text

    # --- items

    def _item(self, number: int, row: Row) -> dict[str, Any]:
        title = self._plain(number, row, LABEL)
        item: dict[str, Any] = {"name": row[NAME], "title": title}
        if row[NOTE]:
            item["hint"] = self._plain(number, row, NOTE)
        return item | self._answers(number, row)

    def _answers(self, number: int, row: Row) -> dict[str, Any]:
        type = row[TYPE]
        if type in _YES_NO:
            return {"type": "choice", "labels": list(_YES_NO[type])}
        if type == "dropdown":
            codes, labels = self._choices(number, row)
            if codes != [str(code) for code in range(1, len(codes) + 1)]:
                raise _Refused("is a dropdown whose codes are not 1, 2, 3, …")
            return {"type": "choice", "labels": labels}
        if type == "radio":
            return self._radio(number, row)
        if type == "slider":
            return self._slider(number, row)
        if type in ("text", "notes"):
            if type == "notes":
                self._left_out.append(f"Row {number}: {row[NAME]} is a text of one line here.")
            return self._text(row)
        asks = {"checkbox": "several options", "file": "a file"}
        raise _Refused(f"asks for {asks.get(type, type)}, which an item here cannot")

    def _choices(self, number: int, row: Row) -> tuple[list[str], list[str]]:
        """Return the codes and the labels of a list of choices."""
        listed = self._plain(number, row, CHOICES).split("|")
        pairs = [part.split(",", 1) for part in listed if part.strip()]
        if len(pairs) < 2 or any(len(pair) < 2 for pair in pairs):
            raise _Refused("has no list of choices, such as 1, No | 2, Yes")
        codes = [code.strip() for code, _ in pairs]
        if len(set(codes)) < len(codes):
            raise _Refused("has a code twice among its choices")
        return codes, [label.strip() for _, label in pairs]

    def _radio(self, number: int, row: Row) -> dict[str, Any]:
        codes, labels = self._choices(number, row)
        if not all(map(_CODE.fullmatch, codes)):
            raise _Refused("is a radio whose codes are not whole numbers")
        points = [int(code) for code in codes]
        step = points[1] - points[0]
        if step < 1 or any(after - before != step for before, after in pairwise(points)):
            raise _Refused("is a radio whose codes do not rise in equal steps")
        words = ["" if label == code else label for code, label in zip(codes, labels, strict=True)]
        found = {"type": "integer", "lowest": points[0], "highest": points[-1], "step": step}
        if all(words):
            return {**found, "labels": words}
        if words[0] and words[-1] and not any(words[1:-1]):
            return {**found, "labels": [words[0], words[-1]]}
        if any(words):
            raise _Refused("has words at some points of its scale only")
        return found

    def _slider(self, number: int, row: Row) -> dict[str, Any]:
        parts = [part.strip() for part in self._plain(number, row, CHOICES).split("|")]
        if len(parts) > 2 and parts[1]:
            raise _Refused("has words in the middle of its slider")
        if (row[LOWEST] or "0", row[HIGHEST] or "100") != ("0", "100"):
            raise _Refused("is a slider that does not go from 0 to 100")
        labels = [parts[0], parts[-1]] if len(parts) > 1 and parts[0] and parts[-1] else []
        if not labels and any(parts):
            raise _Refused("has words at one end of its slider only")
        found: dict[str, Any] = {"type": "integer", "lowest": 0, "highest": 100}
        return {**found, "labels": labels} if labels else found

    def _text(self, row: Row) -> dict[str, Any]:
        validation = row[VALIDATION]
        if not validation:
            return {"type": "text"}
        if validation not in ("integer", "number"):
            raise _Refused(f"must be of the form {validation!r:.40}, which nothing here checks")
        found: dict[str, Any] = {"type": validation}
        for column, key in ((LOWEST, "lowest"), (HIGHEST, "highest")):
            if row[column]:
                if not _NUMBER.fullmatch(row[column]):
                    raise _Refused(f"has {row[column]!r:.40} as a bound")
                found[key] = float(row[column])
        return found

    # --- the whole

    def _declared(self) -> dict[str, Any]:
        head, items = self._head, self._items
        form: dict[str, Any] = {}
        if len(head.items) == len(items):
            items = [{**item, "name": name} for item, name in zip(items, head.items, strict=True)]
        if head.redcap_names:
            form["redcap_names"] = True
        if head.needs_permission:
            form["needs_permission"] = True
        for number, item in enumerate(items, 1):
            if number in head.reversed:
                item["reversed"] = True
            if number in head.bare:
                item["title"] = ""
        found: dict[str, Any] = {
            "name": head.name or self._form,
            "title": head.title or self._form.replace("_", " ").capitalize(),
            "group": "form",
            "entered_by": "participant",
            "when": "When it was filled in",
            "has_time": True,
            "source": head.source,
            "licence": head.licence,
            "permission": head.permission,
            "form": form,
            "scores": [_short(score) for score in head.scores],
            "fields": items,
        }
        if self._instruction:
            found["words"] = {"en": {"instruction": self._instruction}}
        self._items = items
        return found

    def _check_calculations(self) -> None:
        """Refuse scores that REDCap would compute otherwise; leave out those of others."""
        scores = self._head.scores
        items = [msgspec.convert(each, Field) for each in self._items]
        names = dict(zip((item.name for item in items), self._variables, strict=True))
        own = {calculation(score, items, names) for score in scores}
        for number, row in self._calculations:
            if not scores:
                self._left_out.append(
                    f"Row {number}: {row[NAME]} is left out: declare it as a score (docs/forms.md)."
                )
            elif row[CHOICES] not in own:
                self._refused.append(
                    f"Row {number}: {row[NAME]} was changed: it is computed otherwise than the score."
                )


def to_toml(declared: Mapping[str, Any]) -> str:
    """Return a declaration of a kind as the text of its file."""
    lines = [f"{key} = {_value(each)}" for key, each in declared.items() if not _is_table(each)]
    for key, each in declared.items():
        if isinstance(each, Mapping):
            if key == "words":
                for code, words in each.items():
                    lines += ["", f"[words.{code}]", *_pairs(words)]
            else:
                lines += ["", f"[{key}]", *_pairs(each)]
        elif _is_table(each):
            for part in each:
                lines += ["", f"[[{key}]]", *_pairs(part)]
    return "\n".join(lines) + "\n"


def _is_table(value: object) -> bool:
    """Return True of a table, of a list of tables, and of an empty list, which is not written."""
    is_list = isinstance(value, list) and all(isinstance(each, Mapping) for each in value)
    return is_list or isinstance(value, Mapping)


def _pairs(table: Mapping[str, Any]) -> list[str]:
    return [f"{key} = {_value(each)}" for key, each in table.items()]


def _value(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)
