"""Calls of a plug-in's code by the framework, marked while they last, so that one that does not
return can be ended.

The classes that plug-ins subclass mark their methods (`mark_methods`); what a plug-in gives to the
bus or to a clock is marked by these (`inherited`). Only the outermost call counts: it began when
the framework lost control.
"""

import functools
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from inspect import getattr_static
from types import FunctionType
from typing import Any, Generic, Literal, TypeVar

from sar_tui import API

T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., Any])
Kind = Literal["task", "node", "output", "sensor", "format", "theme", "policy"]

TASKS = "sar_tui_tasks"
"""Package under which the folders of tasks are loaded."""
LIMIT_S = 10.0
"""Longest duration of a call of a plug-in's code."""


class NotResponding(Exception):
    """Raised inside a call of a plug-in's code that does not return (see
    `runs.plugin_watchdog`).
    """

    def __str__(self) -> str:
        return f"it took longer than {LIMIT_S:g} s"


class WrongApi(Exception):
    """A plug-in was written for an API that this program does not have; the message says so."""


def check_api(kind: str, name: str, plugin: object) -> None:
    """Raise WrongApi if a plug-in, or its module, has another number as its ``api`` than this
    program has. Without one, it is taken to fit.
    """
    module = sys.modules.get(getattr(plugin, "__module__", None) or "")
    for owner in (plugin, module):
        number = getattr_static(owner, "api", None)
        if isinstance(number, int):
            check_api_number(kind, name, number)
            return


def check_api_number(kind: str, name: str, number: object) -> None:
    """Raise WrongApi if this program does not have the API of this number."""
    if number != API:
        raise WrongApi(
            f"The {kind} {name} was written for API {number!r}; this program has API {API}. "
            f"Update {'sar-tui' if isinstance(number, int) and number > API else f'the {kind}'}."
        )


class PluginCall:
    """A call that is under way.

    Args:
        kind: of the plug-in.
        subject: the plug-in's object or class, or its name.
    """

    __slots__ = ("kind", "subject")

    def __init__(self, kind: Kind, subject: object) -> None:
        self.kind = kind
        self.subject = subject

    @property
    def plugin(self) -> str:
        """Name of the plug-in, such as ``task reaching``. No code of the plug-in runs for it."""
        if isinstance(self.subject, str):
            return f"{self.kind} {self.subject}"
        made_by = self.subject if isinstance(self.subject, type) else type(self.subject)
        package, _, rest = made_by.__module__.partition(".")
        if package == TASKS and rest:  # a node or a view of a task's folder
            return f"task {rest.partition('.')[0]}"
        name = getattr_static(self.subject, "name", None)
        return f"{self.kind} {name if isinstance(name, str) and name else made_by.__name__}"


_under_way: dict[int, PluginCall] = {}
"""The outermost call of each thread."""


def under_way(thread: int) -> PluginCall | None:
    """Return the outermost call of a plug-in's code that a thread is in; None if it is in none."""
    return _under_way.get(thread)


@contextmanager
def calling(kind: Kind, subject: object) -> Iterator[None]:
    """Mark what is done inside as a call of a plug-in's code."""
    thread = threading.get_ident()
    if thread in _under_way:
        yield
        return
    try:
        _under_way[thread] = PluginCall(kind, subject)
        try:
            yield
        finally:
            _under_way.pop(thread, None)
    except NotResponding:  # it may have struck just before the mark was removed
        _under_way.pop(thread, None)
        raise


def mark_methods(cls: type, kind: Kind) -> None:
    """Mark all methods that a class of a plug-in defines. Classes of the framework stay as they
    are. Raises WrongApi.
    """
    if is_own(cls.__module__):
        return
    name = getattr_static(cls, "name", None)
    check_api(kind, name if isinstance(name, str) else cls.__name__, cls)
    for name, value in list(vars(cls).items()):
        if (
            not (name.startswith("__") and name != "__init__")
            and (marked := _marked(value, kind, cls)) is not value
        ):
            setattr(cls, name, marked)
            if isinstance(marked, functools.cached_property):
                marked.__set_name__(cls, name)


def inherited(function: F) -> F:
    """Return a function that a plug-in hands over, marked as the plug-in's; any other as it is."""
    call = _under_way.get(threading.get_ident())
    if (
        call is None
        or is_own(getattr(function, "__module__", None) or "")
        or hasattr(function, "is_marked")
    ):
        return function
    marked: F = _marked_function(function, call.kind, call.subject)
    return marked


def marked_as(kind: Kind, name: str, function: F) -> F:
    """Return a function of a plug-in with its mark."""
    marked: F = _marked_function(function, kind, name)
    return marked


def is_own(module: str) -> bool:
    """Return True for a module of the framework."""
    return module.partition(".")[0] == "sar_tui"


def _marked(value: Any, kind: Kind, cls: type) -> Any:
    """Return a method with its mark; what is no method as it is."""
    match value:
        case FunctionType() if not hasattr(value, "is_marked"):
            return _marked_function(value, kind, None)
        case classmethod():
            return classmethod(_marked_function(value.__func__, kind, None))
        case staticmethod():
            return staticmethod(_marked_function(value.__func__, kind, cls))
        case property():
            get, put, delete = (
                part and _marked_function(part, kind, None)
                for part in (value.fget, value.fset, value.fdel)
            )
            return property(get, put, delete, value.__doc__)
        case functools.cached_property():
            return functools.cached_property(_marked_function(value.func, kind, None))
    return value


def _marked_function(function: Any, kind: Kind, subject: object) -> Any:
    """Return a function with its mark. ``subject``: None if it is the first argument."""

    @functools.wraps(function)
    def call(*given: Any, **named: Any) -> Any:
        thread = threading.get_ident()
        if thread in _under_way:
            return function(*given, **named)
        whose = given[0] if subject is None else subject
        try:
            _under_way[thread] = PluginCall(kind, whose)
            try:
                result = function(*given, **named)
            finally:
                _under_way.pop(thread, None)
        except NotResponding:  # it may have struck just before the mark was removed
            _under_way.pop(thread, None)
            raise
        return _MarkedIterator(result, kind, whose) if isinstance(result, Iterator) else result

    call.is_marked = True  # type: ignore[attr-defined]
    return call


class _MarkedIterator(Generic[T]):
    """Iterator of a plug-in, such as a generator: its code runs when the framework takes the next
    value.
    """

    def __init__(self, values: Iterator[T], kind: Kind, subject: object) -> None:
        self._values, self._kind, self._subject = values, kind, subject

    def __iter__(self) -> Iterator[T]:
        return self

    def __next__(self) -> T:
        with calling(self._kind, self._subject):
            return next(self._values)


def line_of_error(error: BaseException) -> str:
    """Return the last line of a task's own files that an exception passed, such as
    ``task.py:12``; empty if it passed none.
    """
    import traceback  # with pathlib, only when something failed: a task's module loads little
    from pathlib import PurePath

    if isinstance(error, SyntaxError) and error.filename:
        return f"{PurePath(error.filename).name}:{error.lineno}"
    passed = [
        f"{PurePath(frame.f_code.co_filename).name}:{line}"
        for frame, line in traceback.walk_tb(error.__traceback__)
        if str(frame.f_globals.get("__name__")).startswith(f"{TASKS}.")
    ]
    return passed[-1] if passed else ""


PLUGIN_ERRORS = (Exception, SystemExit)
"""Errors of a task, a view or a device; `sys.exit` in a plug-in is an error, too."""


def describe(error: BaseException) -> str:
    """Return "ValueError: why"; the type alone if the error of a plug-in cannot say why."""
    try:
        return f"{type(error).__name__}: {error}"
    except PLUGIN_ERRORS:
        return type(error).__name__
