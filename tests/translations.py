"""Finds what a bundled language lacks: ``python -m tests.translations`` prints it, a line for each.

Each text has a translation with the same slots in every language, and none is left of a text that
is gone. A theme has the same situations in every language; its own texts of screens precede those
of the app, so that it needs none.
"""

import ast
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, get_args

import msgspec

from sar_tui.checks.task_translations import declared, sentences_in, texts_in
from sar_tui.loop.phrase_keys import PHRASE_KEYS, wording_problems
from sar_tui.model import messages
from sar_tui.model.language import BUNDLED, read_words, slot_problem
from sar_tui.model.protocol import REASONS
from sar_tui.operator.keymap import EVENTS, KEY_COMMANDS
from sar_tui.plugins import Catalogue, task_folder
from sar_tui.records.kind import Kind, read_kind
from sar_tui.rules import declaration
from sar_tui.rules.difficulty import INCLUDED
from sar_tui.rules.parameters import TaskParameters, fields

ROOT = Path(__file__).parents[1]
_PRODUCT = ROOT / "sar_tui"
OTHERS = tuple(code for code in BUNDLED if code != "en")
_UNITS = {"ms", "s", "min", "%", "cm", "rad/s"}
"""Units that are the same in all languages."""
_NAMED = (
    messages.Kind,
    messages.Degree,
    messages.EndStatus,
    messages.Mode,
    messages.SensorState,
    messages.Valence,
)
"""Values whose names the operator's panel shows."""


class Room(NamedTuple):
    """A folder with a file of translations for each language.

    Args:
        folder: of the files.
        needed: English texts that must be translated.
        used: those that may be.
        inherited: those that another folder translates.
    """

    folder: Path
    needed: set[str]
    used: set[str]
    inherited: set[str] = set()


def problems() -> list[str]:
    """Return what the bundled languages lack, one line each: the file, and the text."""
    catalogue = Catalogue()
    found = list(rooms(catalogue))
    shown = set[str]().union(*(room.used for room in found))
    return [
        *(problem for room in found for problem in room_problems(room)),
        *(
            problem
            for name in catalogue.theme_names()
            for problem in theme_problems(catalogue.theme_folder(name), shown)
        ),
    ]


def rooms(catalogue: Catalogue) -> Iterator[Room]:
    """Yield the folders of the product and of the bundled tasks."""
    app = _room(
        "app",
        "widgets",
        "tui",
        "reports/charts.py",
        "store/troubles.py",
        beside=("rules/wellbeing.py", "store/wellbeing.py", "records/kind.py"),
    )
    # "palette" is Textual's own key in the footer
    shown = {"palette"}.union(*map(_labels, code_in("app", "widgets", "tui")))
    shown = shown.union(*(_about(catalogue.theme_folder(name)) for name in catalogue.theme_names()))
    # errors that therapists read
    shown |= said_in("app", "store", "runs", "inputs", "outputs", "study")
    shown |= said_in("letterbox/folder.py", "letterbox/identity.py")
    rules = _rules()
    app = Room(app.folder, app.needed | shown, app.used | shown, translated_in(rules))
    # what participants read is in a file of its own, so that a theme's author sees only that
    participants = app._replace(needed=set())
    inherited = translated_in(app) | translated_in(rules)
    therapists = Room(app.folder / "therapist", app.needed, app.used, inherited)
    yield from (participants, therapists, rules)
    loop = _room("loop", "model", beside=("rules",))
    yield loop
    panel = _room("operator", "link/discovery.py", beside=("loop", "link", "outputs/node.py"))
    above = translated_in(participants) | translated_in(therapists) | translated_in(loop)
    shown = _names() | _texts_of_keys()
    yield panel._replace(needed=panel.needed | shown, used=panel.used | shown, inherited=above)
    reports = _room(
        "reports",
        "records",
        "store/records.py",
        beside=("cli/progress.py", "rules/wellbeing.py", "model/session_mode.py"),
    )
    files = list((_PRODUCT / "records").rglob("*.toml"))
    kinds = set[str]().union(*map(_texts_of_kind, files))
    entered = set[str]().union(*map(_texts_of_form, map(read_kind, files)))
    # `reports/charts.py` speaks the language of the app
    yield reports._replace(
        needed=reports.needed | entered,
        used=reports.used | kinds,
        inherited=translated_in(app) | translated_in(therapists),
    )
    for name in catalogue.task_names():
        kind = catalogue.task(name)
        code = [path.read_text("utf-8") for path in task_folder(kind).glob("*.py")]
        presets = {read(path)["summary"] for path in task_folder(kind).glob("presets/*.toml")}
        needed = declared(kind).union(
            presets, _settings(kind.Parameters), *map(texts_in, code), *map(sentences_in, code)
        )
        inherited = translated_in(loop) | translated_in(rules)
        yield Room(task_folder(kind), needed, needed | strings(code), inherited)


def _rules() -> Room:
    """Return the room of the settings that all tasks have, and of the policies."""
    common = _settings(TaskParameters) | said_in("rules")
    common |= {text for policy in INCLUDED.values() for text in (policy.title, policy.summary)}
    return Room(
        _PRODUCT / "rules", common, common | strings(code_in("rules", "runs/start_level.py"))
    )


def room_problems(room: Room) -> Iterator[str]:
    """Yield what the files of a folder lack, and what they have too much."""
    needed = (room.needed - room.inherited) | (translated_in(room) & room.used)
    for code in OTHERS:
        path = room.folder / f"words.{code}.toml"
        try:
            own = read(path)
        except (OSError, ValueError) as error:
            yield f"{_named(path)}: cannot be read: {error}"
            continue
        for text in sorted(needed - own.keys()):
            yield f"{_named(path)}: no translation of {text!r}"
        yield from text_problems(path, own, room.used)


def text_problems(path: Path, own: Mapping[str, object], used: set[str]) -> Iterator[str]:
    """Yield the translations of a file that are left of texts that are gone, or have other
    slots.
    """
    for text, translation in own.items():
        if text not in used:
            yield f"{_named(path)}: no text any more: {text!r}"
        elif not isinstance(translation, str):
            yield f"{_named(path)}: not a text: {text!r}"
        elif problem := slot_problem(text, translation):
            yield f"{_named(path)}: {problem}: {text!r}"


def theme_problems(folder: Path, shown: set[str]) -> Iterator[str]:
    """Yield what a theme lacks in a language: situations, words and units; and its own texts of
    screens that no screen shows.
    """
    english = read(folder / "phrases.en.toml")
    for code in BUNDLED:
        path = folder / f"phrases.{code}.toml"
        try:
            own = read(path)
            words = read(path.with_name(f"words.{code}.toml"), missing={})
        except (OSError, ValueError) as error:
            yield f"{_named(path)}: cannot be read: {error}"
            continue
        for name in sorted(english.keys() - own.keys()):
            yield f"{_named(path)}: no phrases for {name!r}"
        for name in sorted(own.keys() - english.keys()):
            yield f"{_named(path)}: no situation any more: {name!r}"
        for table in ("vocabulary", "units"):
            for name in sorted(english[table].keys() ^ own.get(table, {}).keys()):
                yield f"{_named(path)}: {table} differs from English in {name!r}"
        for name in sorted(PHRASE_KEYS.keys() & own.keys()):
            for wording in own[name]:
                for problem in wording_problems(name, wording, code):
                    yield f"{_named(path)}: {problem}"
        yield from text_problems(path.with_name(f"words.{code}.toml"), words, shown)


# --- texts in the code


def code_in(*places: str) -> list[str]:
    """Return the sources of some modules and packages of the product."""
    paths: list[Path] = []
    for place in places:
        path = _PRODUCT / place
        paths += [path] if path.is_file() else sorted(path.rglob("*.py"))
    return [path.read_text("utf-8") for path in paths]


def said_in(*places: str) -> set[str]:
    """Return the sentences that some modules and packages of the product make for errors."""
    return set[str]().union(*map(sentences_in, code_in(*places)))


def strings(sources: Iterable[str]) -> set[str]:
    """Return all text constants of some sources."""
    return set[str]().union(*map(_strings, sources))


@cache
def _strings(source: str) -> set[str]:
    return {
        node.value
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }


def translated_in(room: Room) -> set[str]:
    """Return the texts that a folder translates into any language."""
    return set[str]().union(*(read_words(room.folder / f"words.{code}.toml") for code in OTHERS))


def read(path: Path, missing: dict[str, Any] | None = None) -> dict[str, Any]:
    """Return what a file of translations holds. Raises OSError or ValueError."""
    if missing is not None and not path.exists():
        return missing
    return msgspec.toml.decode(path.read_text("utf-8"), type=dict[str, Any])


def _room(name: str, *more: str, beside: tuple[str, ...]) -> Room:
    """Return a package of the product, whose texts are also in ``more``; those ``beside`` hold
    some that it may translate.
    """
    code = code_in(name, *more)
    texts = set[str]().union(*(texts_in(source) for source in code))
    needed = {text for text in texts if re.search("[a-z]", text)}
    return Room(_PRODUCT / name, needed, needed | strings([*code, *code_in(*beside)]))


@cache
def _labels(source: str) -> set[str]:
    """Return the names of the keys that a module binds, and lists in the footer."""
    found = set[str]()
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.Call(
                func=ast.Name(id="Binding"),
                args=[_, _, ast.Constant(value=str() as label)],
                keywords=keywords,
            ) if not any(
                keyword.arg == "show" and ast.unparse(keyword.value) == "False"
                for keyword in keywords
            ):
                found.add(label)
    return found


def _names() -> set[str]:
    """Return the names of values that the operator's panel shows."""
    return {name for kind in _NAMED for name in get_args(kind)} | {each.text for each in REASONS}


def _texts_of_keys() -> set[str]:
    """Return the texts about the keys of the operator's panel, and its event marks."""
    texts = {text for key in KEY_COMMANDS for text in (key.label, key.description, key.group)}
    return texts.union(EVENTS) - {""}


def _about(theme: Path) -> set[str]:
    """Return the texts with which a theme is chosen."""
    declared = read(theme / "theme.toml")
    return {declared["title"], declared["summary"]}


def _settings(kind: type[TaskParameters]) -> set[str]:
    """Return the texts of settings."""
    return {text for field in fields(kind) for text in declaration.texts(field)} - _UNITS


def _texts_of_form(kind: Kind) -> set[str]:
    """Return the texts of a kind of record that therapists enter and read."""
    if kind.entered_by != "therapist":
        return set()
    texts = {kind.title, kind.when}
    for change in kind.published:
        texts |= {change.of, change.method, change.interval}
    for field in kind.fields:
        texts |= {field.title, field.hint, field.problem, field.unit, *field.labels}
    return texts - _UNITS - {""}


def _texts_of_kind(path: Path) -> set[str]:
    """Return the texts of a kind of record."""
    found: set[str] = set()
    values: list[object] = [read(path)]
    while values:
        match values.pop():
            case str(text):
                found.add(text)
            case dict() as table:
                values += table.values()
            case list(items):
                values += items
    return found


def _named(path: Path) -> str:
    return str(path.relative_to(ROOT)) if path.is_relative_to(ROOT) else str(path)


if __name__ == "__main__":
    found = problems()
    print("\n".join(found), file=sys.stderr)
    sys.exit(bool(found))
