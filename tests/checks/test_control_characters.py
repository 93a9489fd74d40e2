"""`tasks check` and `themes check` report texts that a terminal would obey."""

import json
import re
import shutil
from pathlib import Path

import pytest

from sar_tui.checks.task import check
from sar_tui.cli.scaffold import new_task, new_theme
from sar_tui.plugins import Catalogue
from tests.edit import edit
from tests.program import Call

FOUND = "has control characters: U+001B, U+202E."
BAD = r"\u001b[31m\u202e"


@pytest.fixture
def tapping(tmp_path: Path) -> Path:
    """The folder of a task in which people tap."""
    folder = new_task("drumming", tmp_path / "mine", None, Catalogue())
    shutil.copyfile(Path(__file__).parents[1] / "drumming_task.py", folder / "task.py")
    return folder


@pytest.fixture
def evening(tmp_path: Path) -> Path:
    """The folder of a new theme."""
    return new_theme("evening", tmp_path / "mine", "calm", Catalogue())


@pytest.mark.parametrize(
    ("text", "changed"),
    [
        ('title = "Finger tapping"', f'title = "Finger tapping{BAD}"'),
        ('worsened="slower"', f'worsened="slower{BAD}"'),
        ("Duration of a turn", f"{BAD}Duration of a turn"),
        ('"""Shown before the first attempt."""', f'return "Tap{BAD}"'),
        ('hint="again', f'hint="{BAD}again'),
    ],
    ids=["title", "metric", "help of a parameter", "instructions", "prompt"],
)
def test_a_text_of_a_task_is_reported(tapping: Path, text: str, changed: str) -> None:
    edit(tapping / "task.py", text, changed)
    problem = next(done.problems for done in check(tapping) if not done.ok)
    assert FOUND in " ".join(problem)


def test_a_translation_of_a_task_is_reported(call: Call, tapping: Path) -> None:
    (tapping / "words.es.toml").write_text(f'"Tapping" = "Toques{BAD}"', encoding="utf-8")
    called = call("tasks check", tapping)
    said = f"✗ has no control characters in its texts. 'Toques\\x1b[31m\\u202e' {FOUND}"
    assert (called.code, said in " ".join(called.out.split())) == (1, True)


@pytest.mark.parametrize(
    ("file", "line", "changed", "problem"),
    [
        ("theme.toml", "^title = .*", f'title = "Evening{BAD}"', "title in theme.toml"),
        ("phrases.en.toml", r"^greeting = \[", f'greeting = ["Hello{BAD}",', "A wording for greeting (en)"),
        ("phrases.en.toml", "^last_attempt = .*", f'last_attempt = "{BAD}"', "last_attempt in vocabulary (en)"),
        ("phrases.en.toml", '^"?ms"? = .*', f'ms = "{BAD}"', "ms in units (en)"),
        ("words.en.toml", "", f'"Stop voice" = "Hush{BAD}"', "The wording of 'Stop voice' in words.en.toml"),
    ],
)  # fmt: skip
def test_a_text_of_a_theme_is_reported(
    call: Call, evening: Path, file: str, line: str, changed: str, problem: str
) -> None:
    path = evening / file
    text = path.read_text("utf-8") if path.exists() else ""
    put = changed.replace("\\", "\\\\")
    path.write_text(re.sub(line, put, text, count=1, flags=re.MULTILINE), encoding="utf-8")
    call("themes check", evening).shows(f"{problem} {FOUND}", code=1)


def test_a_wording_with_control_characters_is_not_used(evening: Path) -> None:
    edit(evening / "phrases.en.toml", "greeting = [", f'greeting = [ "Hello{BAD}", ')
    theme = Catalogue(themes=(evening.parent,)).theme("evening")
    assert theme.phrases["greeting"]
    assert not any("\x1b" in wording for wording in theme.phrases["greeting"])
    assert json.dumps(theme.repairs).count("greeting") == 1
