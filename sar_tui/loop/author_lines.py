"""Lines of a plug-in's own source, as ``task.py:12``: of what its classes define,
and of its texts. Its methods, compared with those that the framework calls.
"""

import ast
import functools
import inspect
import sys
from collections.abc import Iterator
from pathlib import Path
from types import FunctionType
from typing import Any

from sar_tui.plugin_calls import is_own


def at(line: str, problem: str) -> str:
    """Return a problem with its line before it: both are needed."""
    return f"{line}: {problem}" if line and problem else problem


def line_of(owner: type, name: str) -> str:
    """Return the line on which a class of a plug-in, or a base of it, defines a name; else that of
    the class itself.
    """
    sources = [found for base in owner.__mro__ if (found := _class_source(base))]
    for file, declared in sources:
        for node in declared.body:
            match node:
                case (
                    ast.FunctionDef(name=defined)
                    | ast.ClassDef(name=defined)
                    | ast.Assign(targets=[ast.Name(id=defined)])
                    | ast.AnnAssign(target=ast.Name(id=defined))
                ) if defined == name:
                    return f"{file}:{node.lineno}"
    return f"{sources[0][0]}:{sources[0][1].lineno}" if sources else ""


def _class_source(owner: type) -> tuple[str, ast.ClassDef] | None:
    """Return the name of the file that defines a class of a plug-in, and the definition."""
    if is_own(owner.__module__) or owner.__module__.partition(".")[0] in sys.stdlib_module_names:
        return None
    try:
        path = Path(inspect.getfile(owner))
        tree = ast.parse(path.read_bytes())
    except (TypeError, OSError, SyntaxError):
        return None
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef) and node.name == owner.__name__:
            return path.name, node
    return None


def line_of_text(folder: Path, text: str) -> str:
    """Return the first line of a folder's files that holds a text, or has an argument of that
    name; empty if none does.
    """
    for path in sorted(folder.glob("*.py")):
        for node in ast.walk(ast.parse(path.read_bytes())):
            match node:
                case ast.Constant(value=str(found)) | ast.keyword(arg=str(found)) if found == text:
                    return f"{path.name}:{node.lineno}"
    return ""


def hook_problem(own: type, contract: type) -> str:
    """Return sentences that name the methods of a class that cannot be called like those of the
    contract that they replace; empty if all can.
    """
    return " ".join(
        at(line_of(own, name), f"{problem}.")
        for name, promised in vars(contract).items()
        if (name == "__init__" or not name.startswith("_"))
        and (problem := _replacement_problem(name, promised, inspect.getattr_static(own, name)))
    )


def _replacement_problem(name: str, promised: object, given: object) -> str:
    problem = ""
    match promised, given:
        case property(), FunctionType():
            problem = f"{name} is a property: write @property above it"
        case FunctionType(), property() | functools.cached_property():
            problem = f"{name}() is a method, and no property: remove the line above it"
        case classmethod(), FunctionType():
            problem = f"{name}() is a class method: write @classmethod above it"
        case (FunctionType() | classmethod(), None | bool() | int() | float() | str() | tuple()):
            problem = f"{name}() is a method, found {given!r:.60}"
        case FunctionType(), FunctionType():
            problem = _arguments_problem(name, promised, given)
        case classmethod(), classmethod():
            problem = _arguments_problem(name, promised.__func__, given.__func__)
    return problem


def _arguments_problem(name: str, promised: Any, given: Any) -> str:
    """Return what is wrong if a function cannot be called with the arguments of another, in their
    order.
    """
    signature = inspect.signature(given)
    expected, found = list(inspect.signature(promised).parameters), list(signature.parameters)
    try:
        signature.bind(*expected)
    except TypeError:
        return f"{name}() takes {_listed(expected)}, found {_listed(found)}"
    return ""


def _listed(arguments: list[str]) -> str:
    """Return the arguments without the first one, which is the object or its class."""
    return f"({', '.join(each for each in arguments if each not in ('self', 'cls'))})"


def strangers(own: type, contract: type) -> Iterator[tuple[str, str]]:
    """Yield the public methods of a class that its contract does not have, but with a name like
    one that it has and that the class leaves as it is: with that name.
    """
    import difflib

    left = [name for name in vars(contract) if not name.startswith("_") and name not in vars(own)]
    for name, value in list(vars(own).items()):
        is_method = isinstance(value, FunctionType | property | classmethod)
        if not is_method or name.startswith("_") or hasattr(contract, name):
            continue
        if near := difflib.get_close_matches(name, left, 1, cutoff=0.8):
            yield name, near[0]
