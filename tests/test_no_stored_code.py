"""No module of the program makes code of what is stored: it imports no module that does so, and
calls no eval.
"""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
_MODULES = frozenset(
    {"pickle", "_pickle", "cPickle", "dill", "cloudpickle", "joblib", "marshal", "shelve"}
)
_CALLS = frozenset({"eval", "exec", "compile", "__import__"})
_METHODS = frozenset({"read_pickle", "to_pickle"})


def dangers(path: Path) -> Iterator[str]:
    """Yield the places of a module that could run what is stored."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        match node:
            case ast.Import(names=names):
                found = [name.name.partition(".")[0] for name in names]
            case ast.ImportFrom(module=str(module)):
                found = [module.partition(".")[0]]
            case ast.Call(func=ast.Name(id=name)) if name in _CALLS:
                yield f"{path.name}:{node.lineno}: {name}()"
                continue
            case ast.Call(func=ast.Attribute(attr=name)) if name in _METHODS:
                yield f"{path.name}:{node.lineno}: {name}()"
                continue
            case ast.keyword(arg="allow_pickle", value=ast.Constant(value=value)) if value:
                found = ["pickle"]
            case _:
                continue
        yield from (f"{path.name}:{node.lineno}: {name}" for name in found if name in _MODULES)


@pytest.mark.parametrize("folder", ["sar_tui", "tasks"])
def test_no_module_makes_code_of_data(folder: str) -> None:
    paths = sorted((ROOT / folder).rglob("*.py"))
    assert len(paths) > 20
    assert [danger for path in paths for danger in dangers(path)] == []
