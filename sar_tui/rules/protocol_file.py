"""Reads ``protocol.toml``, the operator's protocol, and names each mistake with its line. Pure."""

import hashlib
import re
from collections.abc import Callable, Collection
from typing import Any, Literal, NamedTuple, TypeVar, cast, get_args

from sar_tui.model.messages import ControlledKind
from sar_tui.model.protocol import (
    REASONS,
    Comparison,
    Condition,
    Measure,
    Moment,
    ProtocolRule,
    ProtocolStep,
    Reason,
    WizardProtocol,
)
from sar_tui.model.toml_lines import Mistake, TomlError, TomlLines, decode
from sar_tui.model.visible_text import obeyed

T = TypeVar("T")

MAX_BYTES = 12_000
"""Longest file: it is sent to the session as one act."""
_MAX_TEXT = 400
_MAX_ITEMS = 60
_NAME = re.compile(r"[a-z][a-z0-9-]{0,39}")
_KEYS = {"name", "version", "late_after_s", "steps", "rules", "phrases", "reasons"}
_AT = re.compile(r"(start|pause|end)|(attempt|after attempt) ([1-9][0-9]{0,3})")
_TOKEN = re.compile(r"<=|>=|<|>|=|-?[0-9]+(?:\.[0-9]+)?|%|[^\W\d]+(?:/[^\W\d]+)?")
_NUMBER = re.compile(r"-?[0-9]+(?:\.[0-9]+)?")
_RANGES: dict[str, tuple[float, float]] = {
    "accuracy": (0, 100),
    "timeouts": (0, 10_000),
    "level": (1, 1000),
    "pain": (0, 10),
    "tiredness": (0, 10),
    "effort": (0, 11),
}
_WHOLE = ("timeouts", "level")
_KINDS: dict[str, ControlledKind] = {
    "feedback": "feedback",
    "encouragement": "encouragement",
    "instruction": "instruction",
    "gesture": "gesture",
    "level": "difficulty",
}
"""Kinds of proposal by the words of a protocol."""


class ProtocolMistakes(ValueError):
    """The file has mistakes, in the order of their lines."""

    def __init__(self, mistakes: list[Mistake]) -> None:
        self.mistakes = sorted(set(mistakes))
        super().__init__("\n".join(map(str, self.mistakes)))


class Deed(NamedTuple):
    """A ``do`` as the panel understands it.

    Attributes:
        verb: ``say`` (``text``), ``key`` (say a phrase of the theme with this key, ``text``),
            ``phrase`` (say one of the protocol's, ``number``), ``gesture`` (``text``), ``level``
            (set it to ``number``), ``level by`` (change it by ``number``), ``veto`` and
            ``approve`` (the proposal of ``kind``), ``other`` (something that only the operator
            can do).
    """

    verb: Literal[
        "say", "key", "phrase", "gesture", "level", "level by", "veto", "approve", "other"
    ]
    text: str = ""
    number: int = 0
    kind: ControlledKind | None = None


def parse(source: bytes, phrase_keys: Collection[str] = ()) -> WizardProtocol:
    """Return the protocol of a file.

    Args:
        source: its content.
        phrase_keys: keys of the phrases of themes that can be said.

    Raises:
        ProtocolMistakes: the file has mistakes.
    """
    if len(source) > MAX_BYTES:
        why = f"The file has {len(source)} bytes, and at most {MAX_BYTES} are possible."
        raise ProtocolMistakes([Mistake(1, why)])
    try:
        text = source.decode()
        content = decode(text)
    except UnicodeDecodeError:
        raise ProtocolMistakes([Mistake(1, "The file is not text in UTF-8.")]) from None
    except TomlError as error:
        raise ProtocolMistakes([error.mistake]) from None
    return _Reader(text, content, phrase_keys).protocol(hashlib.sha256(source).hexdigest())


def parse_condition(text: str) -> Condition:
    """Return the condition of a rule. Raises ValueError with a sentence."""
    tokens = _TOKEN.findall(text)
    if "".join(tokens) != "".join(text.split()):
        raise ValueError(f"{text!r} is not a condition: write as in 'accuracy < 60 % twice'.")
    if len(tokens) < 3:
        raise ValueError(
            f"{text!r} is not complete: write a measure, a comparison and a value, as in "
            "'accuracy < 60 %'."
        )
    measure, comparison, written, *rest = tokens
    if measure not in get_args(Measure):
        known = ", ".join(get_args(Measure))
        raise ValueError(f"There is no measure {measure!r}; the measures are {known}.")
    if comparison not in get_args(Comparison):
        known = " ".join(get_args(Comparison))
        raise ValueError(f"{comparison!r} is not a comparison; write one of {known}.")
    value = _value(measure, comparison, written)
    unit = ""
    if rest and rest[0] not in ("twice", "in") and not _NUMBER.fullmatch(rest[0]):
        unit, *rest = rest
    if unit and not (measure == "metric" or (measure, unit) == ("accuracy", "%")):
        expected = "only %" if measure == "accuracy" else "no unit"
        raise ValueError(f"{measure} has {expected}, so {unit!r} is not possible.")
    times, in_a_row = _times(rest)
    return Condition(
        measure=cast(Measure, measure),
        comparison=cast(Comparison, comparison),
        value=value,
        unit="" if unit == "%" and measure == "accuracy" else unit,
        times=times,
        in_a_row=in_a_row,
    )


def _value(measure: str, comparison: str, written: str) -> float:
    if measure == "success":
        if comparison != "=" or written not in ("yes", "no"):
            raise ValueError("success is compared as 'success = yes' or 'success = no'.")
        return float(written == "yes")
    if not _NUMBER.fullmatch(written):
        raise ValueError(f"{measure} is compared with a number, not with {written!r}.")
    value = float(written)
    least, most = _RANGES.get(measure, (value, value))
    if not least <= value <= most:
        raise ValueError(f"{measure} is from {least:g} to {most:g}, and never {written}.")
    if measure in _WHOLE and value != int(value):
        raise ValueError(f"{measure} is a whole number, not {written}.")
    return value


def _times(rest: list[str]) -> tuple[int, bool]:
    """Return how often a condition must hold, and if in a row, from the end of its text."""
    in_a_row = rest[-3:] == ["in", "a", "row"]
    match rest[:-3] if in_a_row else rest:
        case []:
            if in_a_row:
                raise ValueError("'in a row' needs a number, as in '3 times in a row'.")
            return 1, False
        case ["twice"]:
            return 2, in_a_row
        case [number, "times"] if number.isdecimal() and 1 <= int(number) <= 1000:
            return int(number), in_a_row
        case other:
            raise ValueError(
                f"{' '.join(other)!r} is not a number of times: write 'twice' or '3 times', and "
                "'in a row' if no other attempt may be between."
            )


def parse_deed(text: str, phrases: int, phrase_keys: Collection[str] = ()) -> Deed:
    """Return what ``do`` says. Raises ValueError with a sentence.

    Args:
        text: as written.
        phrases: number of the protocol's phrases.
        phrase_keys: keys of phrases of themes. Empty: none is checked.
    """
    verb, _, rest = text.strip().partition(" ")
    rest = rest.strip()
    if verb in ("say", "gesture", "level", "veto", "approve") and not rest:
        raise ValueError(f"{text!r} does not say what: write '{_EXAMPLES[verb]}'.")
    match verb:
        case "say":
            return _said(rest, phrases, phrase_keys)
        case "gesture":
            return Deed("gesture", rest.replace(" ", "_"))
        case "level":
            if not re.fullmatch(r"[+-]?[1-9][0-9]{0,2}", rest):
                raise ValueError(
                    f"{text!r} is not a level: write 'level +1', 'level -1' or a level."
                )
            return Deed("level by" if rest[0] in "+-" else "level", number=int(rest))
        case "veto" | "approve":
            if rest not in _KINDS:
                raise ValueError(
                    f"There are no proposals {rest!r}; write one of {', '.join(_KINDS)}."
                )
            return Deed(cast(Any, verb), kind=_KINDS[rest])
    if not rest:
        known = ", ".join(_EXAMPLES.values())
        raise ValueError(f"{text!r} is neither a sentence for the operator nor one of: {known}.")
    return Deed("other", text.strip())


def deed_of(do: str, protocol: WizardProtocol) -> Deed:
    """Return what ``do`` of a protocol that a session follows says; what this version cannot read is
    for the operator alone.
    """
    try:
        return parse_deed(do, len(protocol.phrases))
    except ValueError:
        return Deed("other", do)


_EXAMPLES = {
    "say": "say greeting",
    "gesture": "gesture nod",
    "level": "level +1",
    "veto": "veto level",
    "approve": "approve feedback",
}


def _said(rest: str, phrases: int, phrase_keys: Collection[str]) -> Deed:
    if number := re.fullmatch(r"phrase ([0-9]+)", rest):
        if not 1 <= int(number[1]) <= phrases:
            raise ValueError(f"There is no phrase {number[1]}: the protocol has {phrases}.")
        return Deed("phrase", number=int(number[1]))
    if re.fullmatch(r"[a-z]+(_[a-z]+)*", rest):
        if phrase_keys and rest not in phrase_keys:
            known = ", ".join(phrase_keys)
            raise ValueError(
                f"{rest!r} is no key of a phrase. Keys are {known}; text that is no single word is "
                "said as it stands."
            )
        return Deed("key", rest)
    return Deed("say", rest)


class _Reader:
    """Reads the content of a file, and collects its mistakes."""

    def __init__(self, text: str, content: dict[str, Any], phrase_keys: Collection[str]) -> None:
        self._lines = TomlLines(text)
        self._content = content
        self._phrase_keys = phrase_keys
        self._phrase_count = 0
        self._mistakes: list[Mistake] = []

    def protocol(self, hash: str) -> WizardProtocol:
        """Return the protocol. Raises ProtocolMistakes."""
        content = self._content
        for key in content.keys() - _KEYS:
            self._note(f"{key!r} is not known; known are {', '.join(sorted(_KEYS))}.", key)
        name = content.get("name")
        if not isinstance(name, str) or not _NAME.fullmatch(name):
            self._note("name must be a word of a-z, 0-9 and '-', as in name = \"praise\".", "name")
        version = content.get("version")
        if type(version) is not int or not 1 <= version <= 10_000:
            self._note("version must be a whole number from 1, as in version = 1.", "version")
        late = content.get("late_after_s", 15)
        if type(late) not in (int, float) or not 1 <= late <= 600:
            self._note("late_after_s must be a number of seconds from 1 to 600.", "late_after_s")
        phrases, reasons = self._phrases(), self._reasons()
        self._phrase_count = len(phrases)
        steps = self._tables("steps", ("at", "do"), self._step)
        rules = self._tables("rules", ("when", "do"), self._rule)
        self._check_order(steps)
        if not (steps or rules or self._mistakes):
            self._note("The protocol has no [[steps]] and no [[rules]].")
        if self._mistakes:
            raise ProtocolMistakes(self._mistakes)
        return WizardProtocol(
            name=cast(str, name),
            version=cast(int, version),
            hash=hash,
            late_after_s=float(late),
            steps=tuple(each for _, each in steps),
            rules=tuple(each for _, each in rules),
            phrases=tuple(phrases),
            reasons=reasons,
        )

    def _note(self, why: str, *place: str | int) -> None:
        self._mistakes.append(Mistake(self._lines.line(place), why))

    def _phrases(self) -> list[str]:
        found = self._content.get("phrases", [])
        if isinstance(found, list) and all(map(_is_text, found)) and len(found) <= _MAX_ITEMS:
            return found
        self._note(f"phrases must be a list of texts on one line each, {_LIMITS}.", "phrases")
        return found if isinstance(found, list) else []

    def _reasons(self) -> tuple[Reason, ...]:
        found = self._content.get("reasons")
        if found is None:
            return REASONS
        if (
            isinstance(found, dict)
            and found
            and all(len(code) == 1 and code.isdecimal() for code in found)
            and all(map(_is_text, found.values()))
        ):
            return tuple(Reason(int(code), text) for code, text in found.items())
        self._note(
            'reasons must be digits with their texts, as in reasons.1 = "wrong moment".', "reasons"
        )
        return REASONS

    def _tables(
        self,
        kind: str,
        keys: tuple[str, str],
        read: Callable[[dict[str, str], int], T | None],
    ) -> list[tuple[int, T]]:
        """Return what is read of each table of a kind, with its line."""
        found = self._content.get(kind, [])
        if not (isinstance(found, list) and all(isinstance(each, dict) for each in found)):
            self._note(f"{kind} must be tables: write [[{kind}]] above each.", kind)
            return []
        if len(found) > _MAX_ITEMS:
            self._note(f"There are {len(found)} {kind}, and at most {_MAX_ITEMS} can be.", kind)
        read_ones = []
        for index, table in enumerate(found):
            is_right = self._has_texts(kind, index, table, keys)
            made = read(table, index) if is_right else None
            if made is not None:
                read_ones.append((self._lines.line((kind, index)), made))
        return read_ones

    def _has_texts(
        self, kind: str, index: int, table: dict[str, Any], keys: tuple[str, str]
    ) -> bool:
        before = len(self._mistakes)
        for key in table.keys() - set(keys):
            why = f"{key!r} is not known in [[{kind}]]; known are {' and '.join(keys)}."
            self._note(why, kind, index, key)
        for key in keys:
            if key not in table:
                self._note(f"This [[{kind}]] has no {key!r}.", kind, index)
            elif not _is_text(table[key]):
                why = f"{key!r} must be a text on one line, {_LIMITS}."
                self._note(why, kind, index, key)
        return len(self._mistakes) == before

    def _step(self, table: dict[str, str], index: int) -> ProtocolStep | None:
        at = _AT.fullmatch(" ".join(table["at"].split()))
        if at is None:
            why = (
                f"{table['at']!r} is not a moment: write start, attempt 3, after attempt 3, pause "
                "or end."
            )
            self._note(why, "steps", index, "at")
        is_right = self._deed_is_right("steps", table["do"], index)
        if at is None or not is_right:
            return None
        moment = cast(Moment, at[1] or at[2])
        return ProtocolStep(moment, table["do"].strip(), int(at[3] or 0))

    def _rule(self, table: dict[str, str], index: int) -> ProtocolRule | None:
        is_right = self._deed_is_right("rules", table["do"], index)
        try:
            condition = parse_condition(table["when"])
        except ValueError as error:
            self._note(str(error), "rules", index, "when")
            return None
        text = " ".join(table["when"].split())
        return ProtocolRule(condition, text, table["do"].strip()) if is_right else None

    def _deed_is_right(self, kind: str, do: str, index: int) -> bool:
        try:
            parse_deed(do, self._phrase_count, self._phrase_keys)
        except ValueError as error:
            self._note(str(error), kind, index, "do")
            return False
        return True

    def _check_order(self, steps: list[tuple[int, ProtocolStep]]) -> None:
        latest = (0, 0, 0)
        for line, each in steps:
            if each.at == "pause":
                continue
            place = _place(each)
            if place < latest:
                why = "Steps stand in the order in which they are due: this one is due earlier."
                self._mistakes.append(Mistake(line, why))
            latest = max(latest, place)


def _place(each: ProtocolStep) -> tuple[int, int, int]:
    """Return a step's place in a session, to be compared."""
    if each.at == "start":
        return (0, 0, 0)
    if each.at == "end":
        return (2, 0, 0)
    return (1, each.attempt, int(each.at == "after attempt"))


_LIMITS = f"of at most {_MAX_TEXT} characters and not empty"


def _is_text(value: object) -> bool:
    return (
        isinstance(value, str)
        and bool(value.strip())
        and len(value) <= _MAX_TEXT
        and "\n" not in value
        and not obeyed(value)
    )
