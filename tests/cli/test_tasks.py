"""``sar-tui tasks``: list, show, create, check."""

import runpy
import shutil
from functools import partial
from pathlib import Path

import pytest

from sar_tui.checks.task import check
from sar_tui.cli import common
from sar_tui.cli.common import Home
from sar_tui.cli.doctor.finding import Machine
from sar_tui.cli.doctor.machine import tasks
from sar_tui.outputs.sound.protocol import Examined
from sar_tui.plugins import Catalogue, task_folder
from sar_tui.runs import plugin_watchdog
from tests.edit import edit
from tests.examples import first
from tests.program import Call

BUNDLED = sorted(set(Catalogue().task_names()) - {"flanker"})


@pytest.fixture
def mine(call: Call, tmp_path: Path) -> Path:
    """The folder of a new task, a choice reaction."""
    assert call("tasks new mine --to", tmp_path / "own").code == 0
    return tmp_path / "own" / "mine"


# --- listed and shown


def test_tasks_are_listed_with_title_summary_and_metric(call: Call) -> None:
    metric = "reaction time (ms, lower is better)"
    call("tasks").shows("keyboard", "Keyboard reaction", "Press the key that appears", metric)
    tasks = {task["name"]: task for task in call("tasks --json").json["tasks"]}
    assert list(tasks) == sorted(tasks)
    assert tasks["keyboard"]["trains"] == "Reaction"
    assert tasks["keyboard"]["metric"]["better"] == "lower"
    assert tasks["reaching"]["metric"]["name"] == "reach_time"


def test_a_task_that_replaces_a_built_in_one_is_named_and_its_sessions_say_so(
    call: Call, tmp_path: Path
) -> None:
    own = tmp_path / "own" / "keyboard"
    shutil.copytree(task_folder(Catalogue().task("keyboard")), own)
    says = f"keyboard: your own in {own} replaces the built-in one."
    assert f"! {says}" in call("tasks --tasks", own.parent).out
    assert says not in call("tasks").out
    found = tasks(Machine(Home(tmp_path, (own.parent,)), Examined))
    assert (found.state, found.found) == ("care", says)
    call("simulate keyboard --user average --attempts 1 --tasks", own.parent)
    session = call("sessions --json").json["sessions"][0]
    assert session["software"]["task"]["source"] == "own"


def test_a_task_that_fails_to_load_is_listed_with_its_reason(call: Call, mine: Path) -> None:
    edit(mine / "task.py", "import msgspec", "import no_such_library")
    reason = "The task mine cannot be loaded: task.py:5: ModuleNotFoundError"
    call("tasks --tasks", mine.parent).shows(f"✗ mine: {reason}", "keyboard")
    listed = call("tasks --tasks", mine.parent, "--json").json["tasks"]
    assert set(listed[-1]) == {"name", "error"}
    assert call("simulate mine --user poor --tasks", mine.parent).code == 2
    checked = call("tasks check", mine)
    checked.shows(f"✗ can be loaded. {reason}", code=1)
    assert checked.out.count("✗") == 1


def test_a_task_shows_its_parameters_and_details(call: Call) -> None:
    called = call("tasks show keyboard")
    called.shows("prompts_per_attempt", "1 to 200", "100 to 60000 ms", "key_gap_ms")
    assert "Measures of an attempt" not in called.out
    words = called.out.split()
    own, heading, common = map(words.index, ("sequence_length", "Session", "attempts"))
    assert own < heading < common
    printed = call("tasks show keyboard --json").json
    assert printed["task"]["name"] == "keyboard"
    (prompts,) = (row for row in printed["parameters"] if row["name"] == "prompts_per_attempt")
    assert (prompts["default"], prompts["ge"], prompts["le"]) == (20, 1, 200)
    described = "Number of keys that the prompt was drawn from."
    choices = {"name": "choices", "type": "integer", "description": described}
    assert printed["details"][0] == choices
    annotated_plainly = call("tasks show tapping --json").json["details"][0]
    assert (annotated_plainly["name"], annotated_plainly["description"]) == (
        "taps",
        "Number of taps.",
    )


# --- created


def test_a_new_task_passes_its_check_and_runs(call: Call, mine: Path, tmp_path: Path) -> None:
    printed = call("tasks check", mine, "--json").json
    assert (printed["task"], printed["passed"]) == ("mine", True)
    assert {tuple(row) for row in printed["checks"]} == {("check", "ok", "problem", "warning")}
    assert all(row["ok"] for row in printed["checks"])
    assert not (tmp_path / "data").exists(), "checks leave no data behind"
    simulate = "simulate mine --user competent --seed 1 --json --tasks"
    rows = call(simulate, mine.parent).json["attempts"]
    assert {row["metric_unit"] for row in rows} == {"ms"}
    assert len({row["level"] for row in rows}) > 1
    readme = (mine / "README.md").read_text()
    assert f"tasks check {mine}" in readme
    assert f"run mine -p P01 --tasks {mine.parent}" in readme


@pytest.mark.parametrize("model", first(2, [None, "flanker", *BUNDLED]))
def test_a_new_task_works_and_has_a_test_beside_it(
    call: Call, tmp_path: Path, model: str | None
) -> None:
    chosen = ["--from", model] if model else []
    assert call("tasks new mine", *chosen, "--to", tmp_path).code == 0
    assert "xample" not in (tmp_path / "mine" / "task.py").read_text()
    test = runpy.run_path(str(tmp_path / "mine" / "test_task.py"))
    test["test_it_keeps_the_contract_of_tasks_and_simulated_people_can_do_it"]()


# --- checked


def test_a_session_of_a_task_that_is_not_found_says_what_is_missing(call: Call, mine: Path) -> None:
    done = call("simulate mine --user poor --attempts 1 --seed 1 --tasks", mine.parent)
    assert f"--tasks {mine.parent}` shows more" in done.out
    call("show last").shows("! There is no task mine.")
    assert "There is no task" not in call("show last --tasks", mine.parent).out


def test_a_declared_measure_that_no_attempt_has_is_named(mine: Path) -> None:
    task = mine / "task.py"
    imports = "import msgspec\n\nfrom sar_tui.api.task import Measure\n"
    edit(task, "import msgspec\n", imports)
    declared = 'measured = (Measure("pace_ms", "pace", unit="ms"),)'
    edit(task, "    Details =", f"    {declared}\n    Details =")
    measures = '\n    def measures(self, results):\n        return {"pace": 1.0}\n'
    task.write_text(task.read_text() + measures)
    (told,) = (done for done in check(mine) if done.check == "has the measures that it declares")
    assert told.ok
    assert "No attempt had pace_ms" in told.warning
    assert "Attempts had pace, which are not declared" in told.warning


def test_a_task_that_does_not_return_ends_the_command_with_a_sentence(
    call: Call, mine: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    quick = partial(plugin_watchdog.PluginWatchdog, limit_s=0.3, period_s=0.1)
    monkeypatch.setattr(plugin_watchdog, "PluginWatchdog", quick)
    edit(mine / "task.py", "keys = KEYS[situation.level - 1]", "while True:\n            pass")
    called = call("simulate mine --user average --tasks", mine.parent)
    called.refused("The task mine failed (NotResponding: it took longer than 10 s, line ", code=1)
    assert [row["status"] for row in call("sessions --json").json["sessions"]] == ["interrupted"]
    said = "✗ makes the same one-line prompts when asked twice. task.py:"
    checked = call("tasks check", mine)
    checked.shows(said, "NotResponding: it took longer than 10 s.", code=1)


def test_a_task_that_ignores_the_error_ends_the_command(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    codes: list[int] = []
    monkeypatch.setattr(common.os, "_exit", codes.append)
    common.give_up("task stubborn")
    assert codes == [1]
    assert "The task stubborn does not return" in capsys.readouterr().err
