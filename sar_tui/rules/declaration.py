"""Declares parameters: title, unit, bounds and help; reads, shows and translates them."""

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


def meta(
    title: str,
    unit: str = "",
    help: str = "",
    takes: str = "",
    group: str = "",
    personal: bool = False,
    **bounds: Any,
) -> Meta:
    """Describe a parameter for the people who set it.

    Args:
        title: its name on the settings form.
        unit: shown beside the field.
        help: one or two plain sentences.
        takes: what a text may be, in words: "a code in lower case, such as en".
        group: its heading on the settings form. A task's own parameters need none; a common one
            that a task redeclares keeps its heading.
        personal: True if it belongs to the person or the place (hand, language, sensor, limits),
            not to the exercise, so that no preset changes it (see `runs.presets`).
        bounds: ``ge`` and ``le`` (both inclusive), or ``min_length``, ``max_length``, ``pattern``.
            Those of a tuple's items stand in its type: ``tuple[Annotated[float, Meta(ge=0, le=1)],
            ...]``.
    """
    extra = {"unit": unit, "takes": takes, "group": group, "personal": personal}
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
        """The allowed values, in words: "1 to 200"."""
        if self.choices:
            return ", ".join(self.choices)
        if self.kind == "list":
            return f"{' '.join(filter(None, (self.items, self._range)))}, spaced"
        return "yes or no" if self.kind == "bool" else self._range

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
        labels={choice: own for choice in field.choices if (own := tr(choice)) != choice},
    )


def texts(field: Field) -> set[str]:
    """Return the texts of a setting that have a translation."""
    return {field.title, field.unit, field.help, field.takes, field.group} - {""}
