"""The one loader of plug-ins: objects that installed packages offer as entry points, and modules of
folders.

Each kind of plug-in is a `Group`, declared where its plug-ins are used. What a plug-in does wrong
while it is loaded becomes one error with one sentence.
"""

import contextlib
import functools
import importlib
import sys
import types
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import sar_tui
from sar_tui.plugin_calls import (
    PLUGIN_ERRORS,
    Kind,
    WrongApi,
    calling,
    check_api,
    describe,
    line_of_error,
)

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

CURRENT_NAMES = "The names of this version are in docs/task-reference.md."
"""Hint for a plug-in that uses a name that sar-tui does not have."""


class PluginError(Exception):
    """A plug-in cannot be found or loaded; the message is one or two clear sentences."""


class Group:
    """The plug-ins of a kind that installed packages offer.

    Args:
        name: of the entry points' group, such as ``sar_tui.tasks``.
        kind: of plug-in, as messages name it.
        error: raised for a plug-in that cannot be loaded. One that a plug-in raises passes as it
            is.
    """

    def __init__(self, name: str, kind: Kind, error: type[Exception] = PluginError) -> None:
        self.name, self.kind, self.error = name, kind, error

    def names(self) -> set[str]:
        """Return the names of all plug-ins, including those that fail to load."""
        return {entry.name for entry in entry_points(self.name)}

    def load(self, name: str, made: Callable[[Any], Any] = lambda found: found) -> Any:
        """Load a plug-in; None if no package offers one of that name.

        Args:
            name: of its entry point.
            made: returns what is needed of the loaded object; a call of the plug-in's code, too.

        Raises:
            Exception: ``error`` of the group, if two packages offer it, or it fails.
        """
        offers = [entry for entry in entry_points(self.name) if entry.name == name]
        if not offers:
            return None
        if len(offers) > 1:
            packages = " and ".join(sorted(entry.dist.name for entry in offers if entry.dist))
            raise self.error(
                f"Several packages offer the {self.kind} {name}: {packages}. Uninstall all but one."
            )
        (entry,) = offers
        return self.guarded(f"{name} ({entry.value})", name, lambda: made(self._loaded(entry)))

    def guarded(self, shown: str, name: str, load: Callable[[], Any]) -> Any:
        """Return what ``load`` returns, marked as a call of the plug-in's code, with its errors as
        the group's.
        """
        try:
            with calling(self.kind, name):
                return load()
        except self.error:
            raise
        except WrongApi as error:
            raise self.error(str(error)) from error
        except PLUGIN_ERRORS as error:
            raise self.error(f"The {self.kind} {shown} cannot be loaded: {why(error)}") from error

    def _loaded(self, entry: "EntryPoint") -> Any:
        found = entry.load()
        check_api(self.kind, entry.name, found)
        return found


def entry_points(group: str) -> "tuple[EntryPoint, ...]":
    """Return the entry points of a group. They are looked for once."""
    return _found(group, tuple(sys.path))


@functools.cache
def _found(group: str, path: tuple[str, ...]) -> "tuple[EntryPoint, ...]":
    if f"[{group}]".encode() not in _declarations(path):
        return ()
    from importlib import metadata  # takes 40 ms, and few have plug-ins

    return tuple(metadata.entry_points(group=group))


@functools.cache
def _declarations(path: tuple[str, ...]) -> bytes:
    """Return the entry points of all installed packages, as their files have them."""
    found = []
    for folder in path:
        for file in Path(folder).glob("*-info/entry_points.txt"):
            with contextlib.suppress(OSError):  # a package that cannot be read offers nothing
                found.append(file.read_bytes())
    return b"\n".join(found)


def why(error: BaseException) -> str:
    """Return the reason of a failure in one sentence, for the author of the plug-in, with the line
    of a task's own files that failed.
    """
    line = line_of_error(error)
    return f"{line}: {_reason(error)}" if line else _reason(error)


def _reason(error: BaseException) -> str:
    if isinstance(error, SyntaxError):
        return f"{error.msg}."
    if isinstance(error, ImportError) and (error.name or "").split(".")[0] == sar_tui.__name__:
        missing = str(error).partition(" (")[0]  # without the path of the module
        return f"{missing}. {CURRENT_NAMES}"
    return f"{describe(error).removesuffix('.')}."


def user_folder() -> Path:
    """Return the folder of a user's own tasks, themes and policies."""
    import platformdirs

    return platformdirs.user_config_path("sar-tui")


def import_from(folder: Path, package: str, module: str) -> types.ModuleType:
    """Import a module of a folder under a synthetic package, such as ``sar_tui_tasks.tapping``.

    Modules of another folder under that package are unloaded. Python may remember an older listing
    of the folder's files.
    """
    parent = package.partition(".")[0]
    if parent != package:
        _make_package(parent, [])
    known = sys.modules.get(package)
    if known is None or list(known.__path__) != [str(folder)]:
        for loaded in [m for m in sys.modules if m == package or m.startswith(f"{package}.")]:
            del sys.modules[loaded]
        _make_package(package, [str(folder)])
    name = f"{package}.{module}"
    if name not in sys.modules:
        for path in [path for path in sys.path_importer_cache if path.startswith(str(folder))]:
            del sys.path_importer_cache[path]
    return importlib.import_module(name)


def _make_package(name: str, path: list[str]) -> None:
    if name not in sys.modules:
        package = types.ModuleType(name)
        package.__path__ = path
        sys.modules[name] = package
