"""`tasks check` and `themes check` report texts that a terminal would obey."""

import json
import re
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
def mine(tmp_path: Path) -> Path:
    """The folder of a new task."""
    return new_task("mine", tmp_path / "own", None, Catalogue())


@pytest.fixture
def evening(tmp_path: Path) -> Path:
    """The folder of a new theme."""
    return new_theme("evening", tmp_path / "mine", "calm", Catalogue())


@pytest.mark.parametrize(
    ("text", "changed"),
    [
        ('title = "Choice reaction"', f'title = "Choice reaction{BAD}"'),
        ('worsened="slower"', f'worsened="slower{BAD}"'),
        ("Number of keys in an attempt", f"{BAD}Number of keys in an attempt"),
        ('"press Escape."', f'"press Escape.{BAD}"'),
        ('text=f"Press: {key}"', f'hint="again{BAD}", text=f"Press: {{key}}"'),
    ],
    ids=["title", "metric", "help of a parameter", "instructions", "prompt"],
)
def test_a_text_of_a_task_is_reported(mine: Path, text: str, changed: str) -> None:
    edit(mine / "task.py", text, changed)
    problem = next(done.problems for done in check(mine) if not done.ok)
    assert FOUND in " ".join(problem)


def test_a_translation_of_a_task_is_reported(call: Call, mine: Path) -> None:
    (mine / "words.es.toml").write_text(f'"Choice reaction" = "Toques{BAD}"', encoding="utf-8")
    called = call("tasks check", mine)
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
