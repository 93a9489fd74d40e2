"""Creates a new task as a copy of an example."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum
from pathlib import Path

from sar_tui.cli.errors import Refused

_EXAMPLES = Path(__file__).parent / "examples"
_NAME = "example"


class Pattern(Enum):
    """Examples that a new task can be like, the commonest first."""

    CHOICE = "choice"
    COUNT = "count"
    GONOGO = "gonogo"
    IMU = "imu"
    QUESTIONNAIRE = "questionnaire"


def make(name: str, to: Path, like: Pattern = Pattern.CHOICE) -> Path:
    """Create the folder of a new task and return its absolute path. Raises Refused."""
    if not name.isidentifier() or not name.islower():
        raise Refused(
            f"{name!r} is not a valid name of a task. Use a Python name in small letters, such as "
            "tapping."
        )
    folder = to.resolve() / name
    if folder.exists():
        raise Refused(f"{folder} exists already. Choose another name, or another folder with --to.")
    folder.mkdir(parents=True)
    with whole_or_nothing(folder):
        for source, file in (
            (_EXAMPLES / like.value / "task.py", "task.py"),
            (_EXAMPLES / like.value / "README.md", "README.md"),
            (_EXAMPLES / "test_example.py", "test_task.py"),
        ):
            text = source.read_text(encoding="utf-8")
            (folder / file).write_text(_renamed(text, name, folder), encoding="utf-8")
    return folder


@contextmanager
def whole_or_nothing(folder: Path) -> Iterator[None]:
    """Remove a new folder if it cannot be filled, so that the command can be run again."""
    try:
        yield
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise


def _renamed(text: str, name: str, folder: Path) -> str:
    """Return the text of the example with the name of the new task."""
    title = "".join(word.capitalize() for word in name.split("_"))
    for there, here in (
        ("ExampleParameters", f"{title}Parameters"),
        ("ExampleDetails", f"{title}Details"),
        ("ExampleTask", f"{title}Task"),
        (f'name = "{_NAME}"', f'name = "{name}"'),
        (f"simulate {_NAME}", f"simulate {name}"),
        (f"run {_NAME}", f"run {name}"),
        ("PATH", str(folder)),
        ("FOLDER", str(folder.parent)),
    ):
        text = text.replace(there, here)
    return text
