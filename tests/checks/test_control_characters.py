"""`tasks check` and `themes check` report texts that a terminal would obey."""

import json
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
    ],
    ids=["title", "metric", "help of a parameter", "instructions"],
)
def test_a_text_of_a_task_is_reported(tapping: Path, text: str, changed: str) -> None:
    edit(tapping / "task.py", text, changed)
    (problem,) = next(
        done.problems
        for done in check(tapping)
        if done.check == "has no control characters in its texts"
    )
    assert FOUND in problem


def test_a_translation_of_a_task_is_reported(call: Call, tapping: Path) -> None:
    (tapping / "words.es.toml").write_text(f'"Tapping" = "Toques{BAD}"', encoding="utf-8")
    called = call("tasks", "check", tapping)
    assert called.code == 1
    assert (
        f"✗ has no control characters in its texts. 'Toques\\x1b[31m\\u202e' {FOUND}"
        in " ".join(called.out.split())
    )


def test_a_prompt_is_reported(tapping: Path) -> None:
    edit(tapping / "task.py", 'hint="again', f'hint="{BAD}again')
    name = "makes the same one-line prompts when asked twice"
    (problem,) = next(done.problems for done in check(tapping) if done.check == name)
    assert (
        "What the prompt shows at level 1, trial 1 has control characters: U+001B, U+202E."
        in problem
    )


@pytest.mark.parametrize(
    ("file", "line", "problem"),
    [
        ("theme.toml", 'title = "Evening"', f"title in theme.toml {FOUND}"),
        ("phrases.en.toml", "greeting = [", f"A wording for greeting (en) {FOUND}"),
        ("phrases.en.toml", "[vocabulary]", f"last_attempt in vocabulary (en) {FOUND}"),
        ("phrases.en.toml", "[units]", f"ms in units (en) {FOUND}"),
    ],
)
def test_a_text_of_a_theme_is_reported(
    call: Call, evening: Path, file: str, line: str, problem: str
) -> None:
    changed = {
        'title = "Evening"': f'title = "Evening{BAD}"',
        "greeting = [": f'greeting = [ "Hello{BAD}", ',
    }.get(line)
    if changed:
        edit(evening / file, line, changed)
    else:
        name = problem.split(maxsplit=1)[0]
        text = (evening / file).read_text("utf-8").splitlines()
        (own,) = [
            each for each in text if each.startswith(f"{name} =") or each.startswith(f'"{name}" =')
        ]
        edit(evening / file, own, f'{own.split(" =")[0]} = "word{BAD}"')
    called = call("themes", "check", evening)
    assert called.code == 1
    assert problem in called.out


def test_a_text_of_a_theme_for_the_screens_is_reported(call: Call, evening: Path) -> None:
    (evening / "words.en.toml").write_text(f'"Stop voice" = "Hush{BAD}"', encoding="utf-8")
    called = call("themes", "check", evening)
    assert called.code == 1
    assert f"The wording of 'Stop voice' in words.en.toml {FOUND}" in called.out


def test_a_wording_with_control_characters_is_not_used(evening: Path) -> None:
    edit(evening / "phrases.en.toml", "greeting = [", f'greeting = [ "Hello{BAD}", ')
    theme = Catalogue(themes=(evening.parent,)).theme("evening")
    assert theme.phrases["greeting"]
    assert not any("\x1b" in wording for wording in theme.phrases["greeting"])
    assert json.dumps(theme.repairs).count("greeting") == 1
