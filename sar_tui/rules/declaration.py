"""Declares parameters: title, unit, bounds and help; reads, shows and translates them."""

import math
import re
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Literal

import msgspec
from msgspec import Meta, inspect

from sar_tui.model.language import Language, Sentence, joined

COMMON = Path(__file__).parent
"""The folder of the translations of common settings and of those of policies. A task's own are in
its folder.
"""

_LONG = 60
"""Largest number of characters of a value that an error message quotes."""
ENDLESS = 1e5
"""Upper bounds from here on are not told: nobody gets near them."""
_MS_IN_S = 1000.0
_MS = re.compile(r"(\d+(?:\.\d+)?) ms\b")
_TYPED = re.compile(r"([-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+))\s*(ms|s|%)?")
"""A number as people type it: 0.9, 0,9, 900 ms, 80 %."""


def meta(
    title: str,
    unit: str = "",
    help: str = "",
    takes: str = "",
    group: str = "",
    personal: bool = False,
    labels: Mapping[str, str] | None = None,
    **bounds: Any,
) -> Meta:
    """Describe a parameter for the people who set it.

    The settings form shows milliseconds ("ms") in seconds, and a number of 0 to 1 without a unit as
    a percentage. What is stored stays the same.

    Args:
        title: its name on the settings form.
        unit: shown beside the field.
        help: one or two plain sentences.
        takes: what a text may be, in words: "a code in lower case, such as en".
        group: its heading on the settings form. A task's own parameters need none; a common one
            that a task redeclares keeps its heading.
        personal: True if it belongs to the person or the place (hand, language, sensor, limits),
            not to the exercise, so that no preset changes it (see `runs.presets`).
        labels: choices in words, where those that are stored say too little to a therapist.
        bounds: ``ge`` and ``le`` (both inclusive), or ``min_length``, ``max_length``, ``pattern``.
            Those of a tuple's items stand in its type: ``tuple[Annotated[float, Meta(ge=0, le=1)],
            ...]``.
    """
    extra = {"unit": unit, "takes": takes, "group": group, "personal": personal}
    extra["labels"] = dict(labels or {})
    return Meta(title=title, description=help or None, extra=extra, **bounds)


def in_group(group: str) -> Callable[..., Meta]:
    """Return ``meta`` for settings under one heading."""
    return partial(meta, group=group)


class Settings(msgspec.Struct, frozen=True, kw_only=True):
    """Base of a group of parameters, declared with ``meta``. Each has a default."""

    def problems(self) -> dict[str, str]:
        """Return settings that do not fit together: parameter name to one clear sentence."""
        return {}


class ParameterError(ValueError):
    """One or more parameters are invalid. ``problems`` maps each name to one clear sentence."""

    def __init__(self, problems: Mapping[str, str]) -> None:
        self.problems = dict(problems)
        super().__init__(joined(problems.values()))


class Field(msgspec.Struct, frozen=True):
    """A declared parameter, as needed by forms, checks and documentation (see ``meta``).

    ``ge`` and ``le``: inclusive bounds of a number. ``least`` and ``most``: bounds of the length of
    a text or list. ``labels``: choices as they are shown, if they are shown in another way than
    they are stored.
    """

    name: str
    title: str
    unit: str
    help: str
    default: Any
    kind: Literal["int", "float", "bool", "choice", "text", "list"]
    ge: float | None = None
    le: float | None = None
    choices: tuple[str, ...] = ()
    items: Literal["words", "numbers"] = "words"
    takes: str = ""
    least: int | None = None
    most: int | None = None
    group: str = ""
    labels: dict[str, str] = {}
    personal: bool = False

    @property
    def bounds(self) -> str:
        """The allowed values, in words: "1 to 200", "estimate (last results), fixed"."""
        if self.choices:
            return ", ".join(map(self._explained, self.choices))
        if self.kind == "list":
            return f"{' '.join(filter(None, (self.items, self._range)))}, spaced"
        return "yes or no" if self.kind == "bool" else self._range

    def _explained(self, choice: str) -> str:
        label = self.labels.get(choice)
        return f"{choice} ({label})" if label else choice

    @property
    def size(self) -> float:
        """The stored value of 1 on the settings form: 1000 ms for 1 s, 0.01 for 1 %, else 1."""
        if self.kind not in ("int", "float"):
            return 1.0
        if self.unit == "ms":
            return _MS_IN_S
        is_share = self.kind == "float" and not self.unit and (self.ge, self.le) == (0, 1)
        return 0.01 if is_share else 1.0

    @property
    def on_form(self) -> "Field":
        """The same in the unit of the settings form: that unit, and the bounds in it. Its default
        is as it is stored.
        """
        if self.size == 1:
            return self
        low, high = (
            bound if bound is None or bound >= ENDLESS else bound / self.size
            for bound in (self.ge, self.le)
        )
        unit = "s" if self.size == _MS_IN_S else "%"
        return msgspec.structs.replace(self, kind="float", unit=unit, ge=low, le=high)

    def shown(self, value: object, tr: Language) -> str:
        """Return a stored value as the settings form shows it: "0.9" for 900 ms. What is not a
        number stays as it is.
        """
        text = show(value)
        if self.kind not in ("int", "float") or (number := _number(text)) is None:
            return self.labels.get(text, text)
        return tr.figures(text if self.size == 1 else f"{number / self.size:.10g}")

    def stored(self, typed: str) -> str:
        """Return what was typed into the settings form as it is stored: "900" for 0.9 s. What is
        not a number stays as it is.
        """
        found = _TYPED.fullmatch(typed.strip())
        if self.kind not in ("int", "float") or not found:
            return typed
        text, unit = found[1].replace(",", "."), found[2]
        if unit and unit not in (self.unit, self.on_form.unit):
            return typed
        if self.size == 1 or unit == self.unit:
            return text
        return f"{float(text) * self.size:.10g}"

    @property
    def _range(self) -> Sentence:
        """The bounds of a number, or of each in a list: "1 to 200"; empty without bounds."""
        if self.ge is None or self.le is None:
            return Sentence("")
        least, most = f"{self.ge:g}", f"{self.le:g}"
        if self.le < ENDLESS:
            return Sentence("{least} to {most}", least=least, most=most)
        return Sentence("{least} or more", least=least)

    def problem(self, value: object) -> Sentence:
        """Return why ``value`` is invalid and what is allowed."""
        shown = show(value)
        shown = shown if len(shown) <= _LONG else f"{shown[:_LONG]}…"
        found = {"title": Sentence(self.title), "shown": shown or Sentence("empty")}
        if self.choices:
            allowed = tuple(map(Sentence, self.choices))
            return Sentence("{title} is one of {allowed}, not {shown}.", allowed=allowed, **found)
        if self.kind == "int" and self._range:
            text = "{title} is a whole number, {range}, not {shown}."
            return Sentence(text, range=self._range, **found)
        if self.kind == "float" and self._range:
            return Sentence(
                "{title} is a number, {range}, not {shown}.", range=self._range, **found
            )
        if self.kind == "bool":
            return Sentence("{title} is yes or no, not {shown}.", **found)
        return Sentence("{title} takes {allowed}, not {shown}.", allowed=self._allowed, **found)

    @property
    def _allowed(self) -> Sentence:
        """The allowed texts or lists: "at most 8 space-separated words"."""
        if self.takes:
            return Sentence(self.takes)
        if self.kind != "list":
            parts = Sentence("letters")
        elif self.items == "words":
            parts = Sentence("space-separated words")
        elif self._range:
            parts = Sentence("space-separated numbers {range}", range=self._range)
        else:
            parts = Sentence("space-separated numbers")
        least, most = self.least, self.most
        if not least and most is None:
            return parts if self.kind == "list" else Sentence("a text")
        if not least:
            return Sentence("at most {most} {parts}", most=most, parts=parts)
        if most is None:
            return Sentence("{least} or more {parts}", least=least, parts=parts)
        return Sentence("{least} to {most} {parts}", least=least, most=most, parts=parts)


def declared_field(field: inspect.Field) -> Field:
    """Return what a field of a msgspec struct declares."""
    kind = field.type
    declared: dict[str, Any] = {
        "name": field.name,
        "title": field.name.replace("_", " ").capitalize(),
        "unit": "",
        "help": "",
    }
    while isinstance(kind, inspect.Metadata):
        schema = kind.extra_json_schema or {}
        declared["title"] = schema.get("title", declared["title"])
        declared["help"] = schema.get("description", declared["help"])
        declared |= kind.extra or {}
        kind = kind.type
    declared["default"] = (
        field.default_factory() if field.default is msgspec.NODEFAULT else field.default
    )
    match kind:
        case inspect.IntType(ge=ge, le=le):
            return Field(**declared, kind="int", ge=ge, le=le)
        case inspect.FloatType(ge=ge, le=le):
            return Field(**declared, kind="float", ge=ge, le=le)
        case inspect.BoolType():
            return Field(**declared, kind="bool")
        case inspect.LiteralType(values=values):
            return Field(
                **declared, kind="choice", choices=_in_order(field, tuple(map(str, values)))
            )
        case inspect.VarTupleType() | inspect.ListType():
            numbers = isinstance(kind.item_type, inspect.IntType | inspect.FloatType)
            items: Literal["words", "numbers"] = "numbers" if numbers else "words"
            item = kind.item_type
            ge, le = (
                (item.ge, item.le)
                if isinstance(item, inspect.IntType | inspect.FloatType)
                else (None, None)
            )
            return Field(
                **declared,
                kind="list",
                items=items,
                least=kind.min_length,
                most=kind.max_length,
                ge=ge,
                le=le,
            )
        case _:
            lengths = (
                (kind.min_length, kind.max_length)
                if isinstance(kind, inspect.StrType)
                else (None, None)
            )
            return Field(**declared, kind="text", least=lengths[0], most=lengths[1])


def _in_order(field: inspect.Field, values: tuple[str, ...]) -> tuple[str, ...]:
    """Return the default first, then the rest by name: msgspec does not keep their order."""
    return tuple(sorted(values, key=lambda value: (value != field.default, value)))


def read(field: Field, text: str) -> object:
    """Convert what a person typed for a field to a value that ``build`` checks."""
    text = text.strip()
    if field.kind == "list":
        return text.replace(",", " ").split()
    if field.kind == "bool":
        return {
            "yes": True,
            "true": True,
            "on": True,
            "no": False,
            "false": False,
            "off": False,
        }.get(text.lower(), text)
    return text


def show(value: object) -> str:
    """Return a value as a person would type it: the inverse of ``read``."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list | tuple):
        return " ".join(map(show, value))
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return str(value)


def _number(text: str) -> float | None:
    """Return the number that a text is; None if it is none."""
    try:
        number = float(text)
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def in_seconds(text: str) -> str:
    """Return a text about settings with its milliseconds in seconds, as the settings form has
    them.
    """
    return _MS.sub(lambda found: f"{float(found[1]) / _MS_IN_S:g} s", text)


def translated(field: Field, tr: Language) -> Field:
    """Return a setting in another language. What has no translation stays English; its name and
    values are the same.
    """
    return msgspec.structs.replace(
        field,
        title=tr(field.title),
        unit=tr(field.unit),
        help="\n".join(map(tr, field.help.split("\n"))),
        takes=tr(field.takes),
        group=tr(field.group),
        labels={
            choice: own
            for choice in field.choices
            if (own := tr(field.labels.get(choice, choice))) != choice
        },
    )


def texts(field: Field) -> set[str]:
    """Return the texts of a setting that have a translation."""
    named = {field.title, field.unit, field.help, field.takes, field.group}
    return (named | {*field.labels.values()}) - {""}
