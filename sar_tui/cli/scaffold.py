"""New tasks and themes: a template, or a copy of one that is installed."""

import re
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from sar_tui.cli.errors import Refused

if TYPE_CHECKING:
    from sar_tui.plugins import Catalogue

_TEMPLATE = Path(__file__).parent / "new_task"
_OWN_TEXT = (".py", ".toml", ".md")
"""Kinds of files that may name the task that is copied."""
_CLASS = re.compile(r"^class (\w+)Task\(Task\)", re.MULTILINE)
_THEME_NAME = "[a-z][a-z0-9]*(-[a-z0-9]+)*"


def new_task(name: str, to: Path, model: str | None, catalogue: "Catalogue") -> Path:
    """Create the folder of a new task and return its absolute path.

    Args:
        name: of the task and its folder.
        to: the folder that it is created in.
        model: the task to copy; None for the template, a choice reaction.
        catalogue: where the model is found.

    Raises:
        Refused: the name cannot be used.
        PluginError: there is no such model.
    """
    from sar_tui.plugins import task_folder  # help loads no plug-ins

    if not name.isidentifier() or not name.islower():
        raise Refused(
            f"{name!r} is not a valid name of a task. Use a Python name in small letters, such as "
            "tapping."
        )
    source = _TEMPLATE if model is None else task_folder(catalogue.task(model))
    folder = _new_folder(name, to)
    with _whole_or_nothing(folder):
        _copy(source, folder)
        stem = _CLASS.findall((source / "task.py").read_text(encoding="utf-8"))[0]
        for path in (path for path in folder.rglob("*") if path.suffix in _OWN_TEXT):
            text = path.read_text(encoding="utf-8")
            path.write_text(_renamed(text, model or "example", stem, name), encoding="utf-8")
        if model is None:
            _fill_in(folder)
        else:
            shutil.copyfile(_TEMPLATE / "test_task.py", folder / "test_task.py")
    return folder


def new_theme(name: str, to: Path, model: str, catalogue: "Catalogue") -> Path:
    """Create the folder of a new theme, a copy of ``model``, and return its absolute path.

    Raises:
        Refused: the name cannot be used.
        PluginError: there is no such model.
    """
    if not re.fullmatch(_THEME_NAME, name):
        raise Refused(
            f"{name!r} is not a valid name of a theme. Use small letters, such as evening or "
            "warm-light."
        )
    source = catalogue.theme_folder(model)
    folder = _new_folder(name, to, taken=name in catalogue.theme_names())
    with _whole_or_nothing(folder):
        _copy(source, folder)
        look = folder / "theme.toml"
        title = f'title = "{name.replace("-", " ").capitalize()}"'
        text = look.read_text(encoding="utf-8-sig")
        titled = re.sub(r"^title\s*=.*$", title, text, count=1, flags=re.MULTILINE)
        look.write_text(titled, encoding="utf-8")
    return folder


def _new_folder(name: str, to: Path, *, taken: bool = False) -> Path:
    """Return the path of a folder that does not exist yet. ``taken``: the name is in use."""
    folder = to.resolve() / name
    if folder.exists():
        raise Refused(f"{folder} exists already. Choose another name, or another folder with --to.")
    if taken:
        raise Refused(f"There is a theme {name} already. Choose another name.")
    return folder


@contextmanager
def _whole_or_nothing(folder: Path) -> Iterator[None]:
    """Make a folder; remove it if it cannot be filled, so that the command can be run again."""
    folder.mkdir(parents=True)
    try:
        yield
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


def _copy(source: Path, folder: Path) -> None:
    """Copy the contents of files, and not who may read or write them."""
    for path in sorted(source.rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts:
            copy = folder / path.relative_to(source)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(path.read_bytes())


def _renamed(text: str, model: str, stem: str, name: str) -> str:
    """Return a text of the model with the name of the new task, and those of its classes."""
    title = "".join(word.capitalize() for word in name.split("_"))
    text = re.sub(rf"\b{stem}(Task|Parameters|Details)\b", rf"{title}\1", text)
    text = re.sub(rf'^(\s+name = )"{model}"', rf'\1"{name}"', text, flags=re.MULTILINE)
    return re.sub(rf"sar-tui (simulate|run) {model}\b", rf"sar-tui \1 {name}", text)


def _fill_in(folder: Path) -> None:
    """Fill in the paths in the commands of the template's README."""
    readme = folder / "README.md"
    text = readme.read_text(encoding="utf-8").replace("PATH", str(folder))
    readme.write_text(text.replace("FOLDER", str(folder.parent)), encoding="utf-8")


# --- what is installed


T = TypeVar("T")
Row = dict[str, Any]


def installed(
    names: Iterable[str], load: Callable[[str], T], facts: Callable[[T], Row]
) -> tuple[list[Row], list[Row]]:
    """Return a row with the facts on each plug-in that loads, and one with the error of each that
    does not.
    """
    from sar_tui.plugins import PluginError

    rows: list[Row] = []
    broken: list[Row] = []
    for name in names:
        try:
            rows.append({"name": name, **facts(load(name))})
        except PluginError as error:
            broken.append({"name": name, "error": str(error)})
    return rows, broken


def replaced_lines(replaced: Mapping[str, Path]) -> list[str]:
    """Return a sentence for each of the user's own tasks that replaces a built-in one, given their
    folders by name.
    """
    return [
        f"{name}: your own in {folder} replaces the built-in one."
        for name, folder in replaced.items()
    ]
