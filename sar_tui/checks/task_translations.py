"""What a task says in English, how much of it its ``words.<language>.toml`` has, and whether it keeps to words."""

import ast
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec

import sar_tui
from sar_tui.framework.language import language, read_words, slot_problem
from sar_tui.framework.phrase_keys import holds_number
from sar_tui.framework.task import Task
from sar_tui.plugins import Catalogue, PluginError, task_folder

_FRAMEWORK = Path(sar_tui.__file__).parent / "framework"
_APP = Path(sar_tui.__file__).parent / "app"


def problems(kind: type[Task]) -> list[str]:
    """What is missing or wrong in a task's own files of words, a sentence each. Without files it speaks English."""
    folder = task_folder(kind)
    texts = sorted(declared(kind).union(*(texts_in(path.read_text("utf-8")) for path in folder.glob("*.py"))))
    return [problem for path in sorted(folder.glob("words.*.toml")) for problem in _problems(path, texts)]


def _problems(path: Path, texts: list[str]) -> Iterator[str]:
    try:
        own = msgspec.toml.decode(path.read_bytes().decode("utf-8-sig"))
    except (OSError, ValueError) as error:
        yield f"{path.name} cannot be read: {error}."
        return
    known = language(path.name.split(".")[1], _FRAMEWORK).texts
    for text in texts:
        if text not in own and text not in known:
            yield f"{path.name} has no translation of {text!r}."
    for english, translation in own.items():
        if not isinstance(translation, str):
            yield f"The translation of {english!r} in {path.name} is not a text."
        elif problem := slot_problem(english, translation):
            yield f"The translation of {english!r} in {path.name} {problem}."


def declared(kind: type[Task]) -> set[str]:
    """The texts that a task declares, and that its participants read."""
    metric = kind.metric
    texts = {kind.title, kind.summary, kind.trials, metric.label, metric.improved, metric.worsened}
    texts.update(text for quality in kind.qualities for text in (quality.improved, quality.aim))
    texts.update(text for mark in kind.marks for text in (mark.title, mark.remark))
    return texts - {""}


def numbers(kind: type[Task]) -> list[str]:
    """The numbers in what a task adds to feedback in words, in any of its languages; a sentence each."""
    metric, folder = kind.metric, task_folder(kind)
    said = {metric.improved, metric.worsened, *(mark.remark for mark in kind.marks)}
    said.update(text for quality in kind.qualities for text in (quality.improved, quality.aim))
    said.update(*(remarks_in(path.read_text("utf-8")) for path in folder.glob("*.py")))
    codes = dict.fromkeys(("en", *sorted(path.name.split(".")[1] for path in folder.glob("words.*.toml"))))
    return [
        f"{own!r} holds a number ({tr.code}); feedback in words has none."
        for tr in (language(code, _FRAMEWORK, folder) for code in codes)
        for own in sorted(map(tr, said))
        if holds_number(own, tr.code)
    ]


def all_texts(catalogue: Catalogue) -> set[str]:
    """All that a participant can read in English, but for the agent's phrases; a task that does not load says nothing.

    The Spanish of the app and of the framework is whole, so that its keys are their texts.
    """
    texts = {*read_words(_APP / "words.es.toml"), *read_words(_FRAMEWORK / "words.es.toml")}
    for name in catalogue.task_names():
        try:
            kind = catalogue.task(name)
        except PluginError:
            continue
        texts |= declared(kind).union(*(texts_in(path.read_text("utf-8")) for path in task_folder(kind).glob("*.py")))
    return texts


def texts_in(source: str) -> set[str]:
    """The texts that a module hands to ``tr``: written there, or in its constants."""
    return _Module(ast.parse(source)).texts()


def remarks_in(source: str) -> set[str]:
    """Those of them that a module makes remarks of: of a `Result`, or of an `Again` (the last of which is one)."""
    return _Module(ast.parse(source)).remarks()


class _Module:
    """A module as read: what it calls by which name."""

    def __init__(self, tree: ast.Module) -> None:
        self._tree = tree
        self._named: dict[str, list[ast.expr]] = {}
        for node in ast.walk(tree):
            match node:
                case ast.Assign(targets=[target], value=value):
                    self._name(target, value)
                case ast.AnnAssign(target=target, value=ast.expr() as value):
                    self._name(target, value)
                case ast.For(target=target, iter=value) | ast.comprehension(target=target, iter=value):
                    self._name(target, value)

    def _name(self, target: ast.expr, value: ast.expr) -> None:
        for name in ast.walk(target):
            if isinstance(name, ast.Name):
                self._named.setdefault(name.id, []).append(value)

    def texts(self) -> set[str]:
        found: set[str] = set()
        for node in ast.walk(self._tree):
            match node:
                case ast.Call(func=ast.Name(id="tr") | ast.Attribute(attr="tr"), args=[text, *_]):
                    found.update(self._strings(text, frozenset()))
        return found - {""}

    def remarks(self) -> set[str]:
        found: set[str] = set()
        for node in ast.walk(self._tree):
            match node:
                case ast.Call(func=ast.Name(id="Again") | ast.Attribute(attr="Again"), args=args, keywords=keywords):
                    texts = [*args[1:], *(keyword.value for keyword in keywords if keyword.arg == "text")]
                    found.update(self._all(texts, frozenset()))
                case ast.keyword(arg="remark", value=value):
                    found.update(self._strings(value, frozenset()))
        return found - {""}

    def _strings(self, node: ast.expr, seen: frozenset[str]) -> Iterator[str]:
        """What an expression can be: a text, one of two, one of those in a table or tuple."""
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
