"""The catalogue of tasks and themes: bundled ones, the user's own, and those of installed packages.

A task folder is loaded by path under a synthetic package (`plugin_calls.TASKS`), so that bundled,
checkout and user folders work alike.
"""

import ast
import importlib
import inspect
import types
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import sar_tui
from sar_tui import plugin_loader
from sar_tui.loop.task_pictures import SUFFIXES, pictures_in
from sar_tui.model.theme import ENGLISH, Theme, ThemeError
from sar_tui.plugin_calls import TASKS, WrongApi, check_api_number
from sar_tui.plugin_loader import Group, PluginError, entry_points, import_from

if TYPE_CHECKING:  # loaded with the first task: the app's first screen is shown before
    from importlib.metadata import EntryPoint

    from sar_tui.loop.task import Task

__all__ = [
    "DEFAULT_THEME",
    "Catalogue",
    "PluginError",
    "load_task",
    "load_theme",
    "module_beside",
    "task_code",
    "task_folder",
    "task_source",
]

_TASKS = Group("sar_tui.tasks", "task")
_THEMES = Group("sar_tui.themes", "theme")
DEFAULT_THEME = "calm"
_EMPTY = "with an empty name"


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
        self.extra_tasks = tuple(folder.absolute() for folder in tasks)
        self._tasks = (*self.extra_tasks, plugin_loader.user_folder() / "tasks", _shipped("tasks"))
        self._themes = (*themes, plugin_loader.user_folder() / "themes", _shipped("themes"))

    def task_names(self) -> list[str]:
        """Return the names of all tasks, including those that fail to load."""
        folders = (path.parent.name for path in _children(self._tasks, "task.py"))
        return sorted({*folders, *_TASKS.names()})

    def task(self, name: str) -> "type[Task]":
        """Load a task by name. Raises PluginError."""
        for path in _children(self._tasks, "task.py"):
            if path.parent.name == name:
                return load_task(path.parent)
        if (found := _TASKS.load(name)) is not None:
            if not _is_task(found):
                raise PluginError(f"The entry point {name} of {_TASKS.name} is not a Task.")
            return _checked(found, name)
        raise PluginError(
            f"There is no task {name or _EMPTY}. Choose one of: {', '.join(self.task_names())}."
        )

    def may_have_pictures(self) -> bool:
        """Return True if there is a picture in a task's folder, or in a package that offers a
        task.
        """
        folders = (path.parent for path in _children(self._tasks, "task.py"))
        return any(map(pictures_in, folders)) or any(map(_has_pictures, entry_points(_TASKS.name)))

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
        folders = (path.parent.name for path in _children(self._themes, "theme.toml"))
        return sorted({*folders, *_THEMES.names()})

    def theme_folder(self, name: str) -> Path:
        """Return the folder of a theme. Raises PluginError."""
        for path in _children(self._themes, "theme.toml"):
            if path.parent.name == name:
                return path.parent
        if (package := _THEMES.load(name)) is not None:
            return _theme_package(package, name)
        raise PluginError(
            f"There is no theme {name or _EMPTY}. Choose one of: {', '.join(self.theme_names())}."
        )

    def may_have_faces(self) -> bool:
        """Return True if a theme's folder may have images for faces, or a package that offers a
        theme has some.
        """
        from sar_tui.theme_folder import may_have_images

        folders = (path.parent for path in _children(self._themes, "theme.toml"))
        return any(map(may_have_images, folders)) or any(
            map(_has_pictures, entry_points(_THEMES.name))
        )

    def theme(self, name: str, language: str = ENGLISH) -> Theme:
        """Load a theme by name. Raises PluginError."""
        return load_theme(self.theme_folder(name), language)


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
    package = f"{TASKS}.{folder.name}"
    try:
        module = _TASKS.guarded(
            folder.name, folder.name, lambda: import_from(folder, package, "task")
        )
    except PluginError:
        _check_api_of_source(folder)
        raise
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

    def imported() -> types.ModuleType:
        if package.startswith(f"{TASKS}."):
            return import_from(folder, f"{TASKS}.{folder.name}", name)
        return importlib.import_module(f"{package}.{name}")

    module: types.ModuleType = _TASKS.guarded(f"{task.name}, its {name}.py,", task.name, imported)
    return module


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


def _has_pictures(entry: "EntryPoint") -> bool:
    """Return True if there is a picture in the package of an entry point, without importing it."""
    files = entry.dist.files if entry.dist else None
    return any(file.suffix.lower() in SUFFIXES for file in files or ())


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
    from sar_tui.loop.task_declaration import declaration_problem

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
    if task.name != name:
        raise PluginError(
            f"The task in the folder {name} has the name {task.name}; the two must be the same."
        )
    return task


def _theme_package(package: object, name: str) -> Path:
    """Return the folder of a theme that is a package. Raises PluginError."""
    for path in getattr(package, "__path__", ()):
        if (Path(path) / "theme.toml").is_file() and Path(path).name == name:
            return Path(path)
    raise PluginError(
        f"The entry point {name} of {_THEMES.name} is not a package {name} with a theme.toml."
    )


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
