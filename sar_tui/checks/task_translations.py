"""Checks a task's texts: their translations in ``words.<language>.toml``, and remarks without
numbers.
"""

import ast
import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec

import sar_tui
from sar_tui.loop.author_lines import at, line_of, line_of_text
from sar_tui.loop.phrase_keys import holds_number
from sar_tui.loop.task import Task
from sar_tui.model.language import language, read_words, slot_problem
from sar_tui.plugins import Catalogue, PluginError, task_folder

_FRAMEWORK = Path(sar_tui.__file__).parent / "loop"
_APP = Path(sar_tui.__file__).parent / "app"
_SYMBOLS = ("ms", "s", "Hz", "cm", "%", "/s")
"""Units that are the same in all languages."""


def problems(kind: type[Task]) -> list[str]:
    """Return what is missing or wrong in a task's files of translations, one sentence each."""
    folder = task_folder(kind)
    code = [path.read_text("utf-8") for path in folder.glob("*.py")]
    texts = sorted(declared(kind).union(*map(texts_in, code), *map(sentences_in, code)))
    return [
        problem
        for path in sorted(folder.glob("words.*.toml"))
        for problem in _problems(kind, path, texts)
    ]


def _problems(kind: type[Task], path: Path, texts: list[str]) -> Iterator[str]:
    try:
        own = msgspec.toml.decode(path.read_bytes().decode("utf-8-sig"))
    except (OSError, ValueError) as error:
        yield f"{path.name} cannot be read: {error}."
        return
    known = language(path.name.split(".")[1], _FRAMEWORK).texts
    for text in texts:
        if text not in own and text not in known:
            line = line_of_text(path.parent, text) or line_of(kind, "metric")  # made of its names
            yield at(line, f"{path.name} has no translation of {text!r}.")
    for english, translation in own.items():
        if not isinstance(translation, str):
            yield f"The translation of {english!r} in {path.name} is not a text."
        elif problem := slot_problem(english, translation):
            yield f"The translation of {english!r} in {path.name} {problem}."


def declared(kind: type[Task]) -> set[str]:
    """Return the declared texts of a task that participants read."""
    metric = kind.metric
    texts = {kind.title, kind.summary, kind.trains, kind.trials}
    texts |= set() if metric.is_none else {metric.label, metric.improved, metric.worsened}
    texts.update(text for quality in kind.qualities for text in (quality.improved, quality.aim))
    texts.update(
        text
        for measure in kind.measured
        for text in (measure.title, measure.unit)
        if text not in _SYMBOLS
    )
    texts.update(text for mark in kind.marks for text in (mark.title, mark.remark))
    return texts - {""}


def numbers(kind: type[Task]) -> list[str]:
    """Return a sentence for each text with a number that a task adds to feedback in words, in any
    of its languages.
    """
    metric, folder = kind.metric, task_folder(kind)
    said = {metric.improved, metric.worsened, *(mark.remark for mark in kind.marks)}
    said.update(text for quality in kind.qualities for text in (quality.improved, quality.aim))
    said.update(*(remarks_in(path.read_text("utf-8")) for path in folder.glob("*.py")))
    codes = dict.fromkeys(
        ("en", *sorted(path.name.split(".")[1] for path in folder.glob("words.*.toml")))
    )
    return [
        f"{own!r} holds a number ({tr.code}); feedback in words has none."
        for tr in (language(code, _FRAMEWORK, folder) for code in codes)
        for own in sorted(map(tr, said))
        if holds_number(own, tr.code)
    ]


def all_texts(catalogue: Catalogue) -> set[str]:
    """Return all English texts that a participant can read, except the agent's phrases and tasks
    that fail to load.

    The Spanish translations of the app and the framework are complete, so their keys are all of
    their texts.
    """
    texts = {*read_words(_APP / "words.es.toml"), *read_words(_FRAMEWORK / "words.es.toml")}
    for name in catalogue.task_names():
        try:
            kind = catalogue.task(name)
        except PluginError:
            continue
        texts |= declared(kind).union(
            *(texts_in(path.read_text("utf-8")) for path in task_folder(kind).glob("*.py"))
        )
    return texts


def translated(catalogue: Catalogue, code: str) -> set[str]:
    """Return the English texts of the screens and tasks that are translated into a language,
    whatever the theme.
    """
    kinds = []
    for name in catalogue.task_names():
        with contextlib.suppress(PluginError):
            kinds.append(catalogue.task(name))
    return set(language(code, _FRAMEWORK, _APP, *map(task_folder, kinds)).texts)


def texts_in(source: str) -> set[str]:
    """Return the texts that a module passes to ``tr``: literals or its constants."""
    return _Module(ast.parse(source)).passed_to("tr")


def sentences_in(source: str) -> set[str]:
    """Return the texts that a module makes a `Sentence` of, for therapists."""
    return _Module(ast.parse(source)).passed_to("Sentence")


def remarks_in(source: str) -> set[str]:
    """Return the texts that a module uses as the remark of a `Result` or the text of an `Again`."""
    return _Module(ast.parse(source)).remarks()


class _Module:
    """A parsed module, with the expressions assigned to each name."""

    def __init__(self, tree: ast.Module) -> None:
        self._tree = tree
        self._named: dict[str, list[ast.expr]] = {}
        for node in ast.walk(tree):
            match node:
                case ast.Assign(targets=[target], value=value):
                    self._name(target, value)
                case ast.AnnAssign(target=target, value=ast.expr() as value):
                    self._name(target, value)
                case (
                    ast.For(target=target, iter=value)
                    | ast.comprehension(target=target, iter=value)
                ):
                    self._name(target, value)

    def _name(self, target: ast.expr, value: ast.expr) -> None:
        for name in ast.walk(target):
            if isinstance(name, ast.Name):
                self._named.setdefault(name.id, []).append(value)

    def passed_to(self, name: str) -> set[str]:
        found: set[str] = set()
        for node in ast.walk(self._tree):
            match node:
                case ast.Call(
                    func=ast.Name(id=called) | ast.Attribute(attr=called), args=[text, *_]
                ) if called == name:
                    found.update(self._strings(text, frozenset()))
        return found - {""}

    def remarks(self) -> set[str]:
        found: set[str] = set()
        for node in ast.walk(self._tree):
            match node:
                case ast.Call(
                    func=ast.Name(id="Again") | ast.Attribute(attr="Again"),
                    args=args,
                    keywords=keywords,
                ):
                    texts = [
                        *args[1:],
                        *(keyword.value for keyword in keywords if keyword.arg == "text"),
                    ]
                    found.update(self._all(texts, frozenset()))
                case ast.keyword(arg="remark", value=value):
                    found.update(self._strings(value, frozenset()))
        return found - {""}

    def _strings(self, node: ast.expr, seen: frozenset[str]) -> Iterator[str]:
        """Yield the texts that an expression can be: a literal, one of two, an entry of a dict or
        tuple.
        """
        match node:
            case ast.Constant(value=str() as text):
                yield text
            case ast.IfExp(body=body, orelse=orelse):
                yield from self._all((body, orelse), seen)
            case ast.Dict(values=values) | ast.Tuple(elts=values) | ast.List(elts=values):
                yield from self._all(values, seen)
            case ast.Subscript(value=table):
                yield from self._strings(table, seen)
            case ast.Call(func=ast.Name(id="tr") | ast.Attribute(attr="tr"), args=[text, *_]):
                yield from self._strings(text, seen)
            case ast.Call(func=ast.Attribute(value=table, attr="get"), args=[_, *default]):
                yield from self._all((table, *default), seen)
            case ast.Name(id=name) if name not in seen:
                yield from self._all(self._named.get(name, ()), seen | {name})

    def _all(self, nodes: Sequence[ast.expr], seen: frozenset[str]) -> Iterator[str]:
        for node in nodes:
            yield from self._strings(node, seen)
