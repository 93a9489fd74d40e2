"""Finds and loads tasks and themes: bundled ones, the user's own, and tasks from entry points.

A task folder is loaded by path under a synthetic package (`plugin_calls.TASKS`), so that bundled,
checkout and user folders work alike.
"""

import ast
import importlib
import inspect
import sys
import types
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import platformdirs

import sar_tui
from sar_tui.loop.entry_points import entry_points
from sar_tui.loop.task_pictures import SUFFIXES, pictures_in
from sar_tui.model.theme import ENGLISH, Theme, ThemeError
from sar_tui.plugin_calls import PLUGIN_ERRORS, TASKS, WrongApi, calling, check_api_number

if TYPE_CHECKING:  # loaded with the first task: the app's first screen is shown before
    from importlib.metadata import EntryPoint

    from sar_tui.loop.task import Task

_GROUP = "sar_tui.tasks"
DEFAULT_THEME = "calm"
CURRENT_NAMES = "The names of this version are in docs/task-reference.md."
"""Hint for a task that uses a name that sar-tui does not have."""
_EMPTY = "with an empty name"
_FORMER = {"sensed": "sensor_seats"}
"""Former names of methods that a task overrides, which would have no effect now."""


class PluginError(Exception):
    """A task or theme cannot be found or loaded; the message is one or two clear sentences."""


class Catalogue:
    """Installed tasks and themes.

    Args:
        tasks: more folders with tasks, searched before the bundled ones (`--tasks DIR`).
        themes: more folders with themes.
    """

    def __init__(self, tasks: tuple[Path, ...] = (), themes: tuple[Path, ...] = ()) -> None:
        for folder in tasks:
            if not folder.is_dir():
                raise PluginError(f"There is no folder {folder} for tasks.")
        self.extra_tasks = tasks
        self._tasks = (*tasks, user_folder() / "tasks", _shipped("tasks"))
        self._themes = (*themes, user_folder() / "themes", _shipped("themes"))

    def task_names(self) -> list[str]:
        """Return the names of all tasks, including those that fail to load."""
        folders = (path.parent.name for path in _children(self._tasks, "task.py"))
        return sorted({*folders, *(entry.name for entry in entry_points(_GROUP))})

    def task(self, name: str) -> "type[Task]":
        """Load a task by name. Raises PluginError."""
        for path in _children(self._tasks, "task.py"):
            if path.parent.name == name:
                return load_task(path.parent)
        for entry in entry_points(_GROUP):
            if entry.name == name:
                return _from_entry_point(entry)
        raise PluginError(
            f"There is no task {name or _EMPTY}. Choose one of: {', '.join(self.task_names())}."
        )

    def may_have_pictures(self) -> bool:
        """Return True if there is a picture in a task's folder, or in a package that offers a
        task.
        """
        folders = (path.parent for path in _children(self._tasks, "task.py"))
        return any(map(pictures_in, folders)) or any(map(_has_pictures, entry_points(_GROUP)))

    def replaced_tasks(self) -> dict[str, Path]:
        """Return the folders of the user's own tasks that replace a built-in one, by name."""
        used: dict[str, Path] = {}
        for path in _children(self._tasks, "task.py"):
            used.setdefault(path.parent.name, path.parent)
        built_in = _shipped("tasks")
        return {
            name: folder
            for name, folder in used.items()
            if (built_in / name / "task.py").is_file() and not _is_built_in(folder)
        }

    def theme_names(self) -> list[str]:
        """Return the names of all themes."""
        return sorted({path.parent.name for path in _children(self._themes, "theme.toml")})

    def theme_folder(self, name: str) -> Path:
        """Return the folder of a theme. Raises PluginError."""
        for path in _children(self._themes, "theme.toml"):
            if path.parent.name == name:
                return path.parent
        raise PluginError(
            f"There is no theme {name or _EMPTY}. Choose one of: {', '.join(self.theme_names())}."
        )

    def theme(self, name: str, language: str = ENGLISH) -> Theme:
        """Load a theme by name. Raises PluginError."""
        return load_theme(self.theme_folder(name), language)


def user_folder() -> Path:
    """Return the folder of a user's own tasks and themes."""
    return platformdirs.user_config_path("sar-tui")


def _shipped(kind: str) -> Path:
    """Return the folder of bundled tasks or themes: inside an installed package, beside it in a
    checkout.
    """
    package = Path(sar_tui.__file__).parent
    inside = package / kind
    return inside if inside.is_dir() else package.parent / kind


def _children(folders: tuple[Path, ...], file: str) -> Iterator[Path]:
    for folder in folders:
        if folder.is_dir():
            yield from sorted(folder.glob(f"*/{file}"))


def task_folder(task: "type[Task]") -> Path:
    """Return the folder that a task was loaded from."""
    return Path(inspect.getfile(task)).parent


def task_code(task: "type[Task]") -> Path:
    """Return what holds a task's code: its folder, or its file if it is a module of no package.

    Beside such a module are all other packages that are installed.
    """
    return task_folder(task) if "." in task.__module__ else Path(inspect.getfile(task))


def task_source(task: "type[Task]") -> str:
    """Return where a task comes from: ``built-in``, ``own`` (a folder), or ``installed`` (a
    package's entry point).
    """
    if not task.__module__.startswith(f"{TASKS}."):
        return "installed"
    return "built-in" if _is_built_in(task_folder(task)) else "own"


def _is_built_in(folder: Path) -> bool:
    return folder.resolve().parent == _shipped("tasks").resolve()


def load_task(folder: Path) -> "type[Task]":
    """Load the one task of a folder. Raises PluginError."""
    if not (folder / "task.py").is_file():
        raise PluginError(f"There is no task.py in {folder}.")
    if not folder.name.isidentifier():
        raise PluginError(
            f"{folder.name} cannot name a task's folder. Use a Python name, such as tapping."
        )
    name = _package_of(folder)
    try:
        module = _import(folder, f"{name}.task")
    except WrongApi as error:
        raise PluginError(str(error)) from error
    except PLUGIN_ERRORS as error:
        _check_api_of_source(folder)
        raise PluginError(f"The task {folder.name} cannot be loaded: {_why(error)}") from error
    own = [
        value
        for value in vars(module).values()
        if getattr(value, "__module__", None) == module.__name__
    ]
    found = [value for value in own if _is_task(value)]
    if not found and (missing := _missing_methods(own)):
        raise PluginError(f"The task {folder.name} does not define {', '.join(missing)}.")
    if len(found) != 1:
        raise PluginError(f"{folder / 'task.py'} must define one Task; it defines {len(found)}.")
    return _checked(found[0], folder.name)


def module_beside(task: "type[Task]", name: Literal["view", "effect"]) -> types.ModuleType | None:
    """Load the ``view.py`` or the ``effect.py`` beside a task's module; None if there is none.
    Raises PluginError.
    """
    folder, (package, _, _) = task_folder(task), task.__module__.rpartition(".")
    if not package or not (folder / f"{name}.py").is_file():
        return None
    if package.startswith(f"{TASKS}."):
        package = _package_of(folder)
    try:
        return _import(folder, f"{package}.{name}")
    except WrongApi as error:
        raise PluginError(str(error)) from error
    except PLUGIN_ERRORS as error:
        raise PluginError(
            f"The {name} of the task {task.name} cannot be loaded: {_why(error)}"
        ) from error


def _check_api_of_source(folder: Path) -> None:
    """Raise PluginError if a task that cannot be imported was written for another API: it may use
    names that this one does not have.
    """
    try:
        source = ast.parse((folder / "task.py").read_bytes())
    except (OSError, SyntaxError, ValueError):
        return
    for node in ast.walk(source):
        match node:
            case ast.Assign(targets=[ast.Name(id="api")], value=ast.Constant(value=int(number))):
                try:
                    check_api_number("task", folder.name, number)
                except WrongApi as error:
                    raise PluginError(str(error)) from error


def _import(folder: Path, name: str) -> types.ModuleType:
    """Import a module of a task's folder, of which Python may remember an older listing of
    files.
    """
    if name not in sys.modules:
        for path in [path for path in sys.path_importer_cache if path.startswith(str(folder))]:
            del sys.path_importer_cache[path]
    with calling("task", folder.name):
        return importlib.import_module(name)


def _package_of(folder: Path) -> str:
    """Return the package of a task folder's modules; modules of another folder of that name are
    unloaded.
    """
    name = f"{TASKS}.{folder.name}"
    _make_package(TASKS, [])
    known = sys.modules.get(name)
    if known is None or list(known.__path__) != [str(folder)]:
        for loaded in [m for m in sys.modules if m == name or m.startswith(f"{name}.")]:
            del sys.modules[loaded]
        _make_package(name, [str(folder)])
    return name


def _from_entry_point(entry: "EntryPoint") -> "type[Task]":
    try:
        with calling("task", entry.name):
            found = entry.load()
    except WrongApi as error:
        raise PluginError(str(error)) from error
    except PLUGIN_ERRORS as error:
        raise PluginError(f"The task {entry.name} cannot be loaded: {_why(error)}") from error
    if not _is_task(found):
        raise PluginError(f"The entry point {entry.name} ({entry.value}) is not a Task.")
    return _checked(found, entry.name)


def _has_pictures(entry: "EntryPoint") -> bool:
    """Return True if there is a picture in the package of an entry point, without importing it."""
    files = entry.dist.files if entry.dist else None
    return any(file.suffix.lower() in SUFFIXES for file in files or ())


def _why(error: BaseException) -> str:
    if isinstance(error, SyntaxError):
        return f"line {error.lineno} of {Path(error.filename or '').name}: {error.msg}."
    if isinstance(error, ImportError) and (error.name or "").split(".")[0] == sar_tui.__name__:
        missing = str(error).partition(" (")[0]  # without the path of the module
        return f"{missing}. {CURRENT_NAMES}"
    return f"{type(error).__name__}: {error}."


def _make_package(name: str, path: list[str]) -> None:
    if name not in sys.modules:
        package = types.ModuleType(name)
        package.__path__ = path
        sys.modules[name] = package


def _missing_methods(values: list[object]) -> list[str]:
    """Return the methods that an incomplete task among the values does not define."""
    from sar_tui.loop.task import Task

    unfinished = (value for value in values if isinstance(value, type) and issubclass(value, Task))
    return sorted(next((value.__abstractmethods__ for value in unfinished), frozenset()))


def _is_task(value: object) -> bool:
    from sar_tui.loop.task import Task

    return (
        isinstance(value, type)
        and issubclass(value, Task)
        and value is not Task
        and not inspect.isabstract(value)
    )


def _checked(task: "type[Task]", name: str) -> "type[Task]":
    from sar_tui.loop.task_declaration import problem as declaration_problem

    missing = [
        attribute for attribute in ("name", "title", "metric") if not hasattr(task, attribute)
    ]
    if missing:
        raise PluginError(f"The task {name} does not declare its {' or its '.join(missing)}.")
    better = getattr(task.metric, "better", "lower")
    if better not in ("lower", "higher"):
        raise PluginError(
            f"The metric of the task {name} has better={better}; use lower or higher."
        )
    if problem := declaration_problem(task):
        raise PluginError(
            f"The task {name} cannot be used: {problem}. See docs/write-your-own-task.md."
        )
    for former, current in _FORMER.items():
        if hasattr(task, former):
            raise PluginError(
                f"The task {name} defines {former}, which is named {current} now. {CURRENT_NAMES}"
            )
    if task.name != name:
        raise PluginError(
            f"The task in the folder {name} has the name {task.name}; the two must be the same."
        )
    return task


def load_theme(folder: Path, language: str = ENGLISH) -> Theme:
    """Load a theme's folder in a language, with missing or wrong parts from the default theme
    (`Theme.repairs`).

    Raises:
        PluginError: its files cannot be read.
    """
    from sar_tui.theme_folder import read_theme

    default = _shipped("themes") / DEFAULT_THEME
    try:
        folder.name.encode()
        base = read_theme(default, language) if folder != default else None
        return read_theme(folder, language, base)
    except UnicodeEncodeError:
        raise PluginError(
            f"The theme {folder.name} cannot be read: the name of its folder is not UTF-8."
        ) from None
    except WrongApi as error:
        raise PluginError(str(error)) from error
    except ThemeError as error:
        raise PluginError(f"The theme {folder.name} cannot be read: {error}") from error
