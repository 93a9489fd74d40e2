"""Commands that run a task whose code does not return."""

from functools import partial
from pathlib import Path

import pytest

from sar_tui.cli import common
from sar_tui.runs import plugin_watchdog
from tests.edit import edit
from tests.program import Call


@pytest.fixture
def looping(call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a task that loops for ever when it is asked for a prompt."""
    quick = partial(plugin_watchdog.PluginWatchdog, limit_s=0.3, period_s=0.1)
    monkeypatch.setattr(plugin_watchdog, "PluginWatchdog", quick)
    call("tasks new looping --to", tmp_path)
    task = tmp_path / "looping" / "task.py"
    edit(task, "keys = KEYS[situation.level - 1]", "while True:\n            pass")
    return task.parent


def test_a_simulation_ends_with_a_sentence(call: Call, looping: Path) -> None:
    called = call("simulate looping --user average --tasks", looping.parent)
    assert (called.code, called.out) == (1, "")
    assert "The task looping failed (NotResponding: it took longer than 10 s, line " in called.err
    assert [row["status"] for row in call("sessions --json").json["sessions"]] == ["interrupted"]


def test_the_check_names_what_does_not_return(call: Call, looping: Path) -> None:
    said = "✗ makes the same one-line prompts when asked twice. task.py:"
    called = call("tasks check", looping)
    called.shows(said, "NotResponding: it took longer than 10 s.", code=1)


def test_a_task_that_ignores_the_error_ends_the_command(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    codes: list[int] = []
    monkeypatch.setattr(common.os, "_exit", codes.append)
    common.give_up("task stubborn")
    assert codes == [1]
    assert "The task stubborn does not return" in capsys.readouterr().err
