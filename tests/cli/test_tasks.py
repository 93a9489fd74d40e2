"""``sar-tui tasks``: list, show, create, check."""

import re
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

TESTS = Path(__file__).parents[1]
BUNDLED = sorted(set(Catalogue().task_names()) - {"flanker"})


@pytest.fixture
def tapping(call: Call, tmp_path: Path) -> Path:
    """The folder of a new task, in which people tap."""
    assert call("tasks new drumming --to", tmp_path / "mine").code == 0
    folder = tmp_path / "mine" / "drumming"
    shutil.copyfile(TESTS / "drumming_task.py", folder / "task.py")
    return folder


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


def test_a_task_that_fails_to_load_is_listed_with_its_reason(call: Call, tapping: Path) -> None:
    edit(tapping / "task.py", "import msgspec", "import no_such_library")
    reason = "The task drumming cannot be loaded: task.py:6: ModuleNotFoundError"
    call("tasks --tasks", tapping.parent).shows(f"✗ drumming: {reason}", "keyboard")
    listed = call("tasks --tasks", tapping.parent, "--json").json["tasks"]
    assert set(listed[-1]) == {"name", "error"}
    assert call("simulate drumming --user poor --tasks", tapping.parent).code == 2


def test_a_task_shows_its_parameters(call: Call) -> None:
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
    assert printed["details"][0] == {
        "name": "choices",
        "type": "integer",
        "description": "Number of keys that the prompt was drawn from.",
    }


# --- created


def test_a_new_task_passes_its_check_and_runs(call: Call, tapping: Path, tmp_path: Path) -> None:
    printed = call("tasks check", tapping, "--json").json
    assert (printed["task"], printed["passed"]) == ("drumming", True)
    assert {tuple(row) for row in printed["checks"]} == {("check", "ok", "problem", "warning")}
    assert all(row["ok"] for row in printed["checks"])
    assert not (tmp_path / "data").exists(), "checks leave no data behind"
    simulate = "simulate drumming --user competent --seed 1 --json --tasks"
    rows = call(simulate, tapping.parent).json["attempts"]
    assert {row["metric_unit"] for row in rows} == {"taps/s"}
    assert len({row["level"] for row in rows}) > 1
    readme = (tapping / "README.md").read_text()
    assert f"tasks check {tapping}" in readme
    assert f"run drumming -p P01 --tasks {tapping.parent}" in readme


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


def test_a_session_of_a_task_that_is_not_found_says_what_is_missing(
    call: Call, tapping: Path
) -> None:
    done = call("simulate drumming --user poor --attempts 1 --seed 1 --tasks", tapping.parent)
    assert f"--tasks {tapping.parent}` shows more" in done.out
    call("show last").shows("! There is no task drumming.")
    assert "There is no task" not in call("show last --tasks", tapping.parent).out


def test_meanings_of_details_are_told_however_they_are_annotated(call: Call, tapping: Path) -> None:
    task = tapping / "task.py"
    old = re.search(r'msgspec\.Meta\(description=("[^"]+")\)', task.read_text())
    assert old
    task.write_text(task.read_text().replace(old[0], old[1]))
    told = call("tasks show drumming --json --tasks", tapping.parent).json["details"]
    assert all(detail["description"] for detail in told)


def test_a_declared_measure_that_no_attempt_has_is_named(tapping: Path) -> None:
    task = tapping / "task.py"
    imports = "import msgspec\n\nfrom sar_tui.api.task import Measure\n"
    edit(task, "import msgspec\n", imports)
    declared = 'measured = (Measure("pace_ms", "pace", unit="ms"),)'
    edit(task, "    Details =", f"    {declared}\n    Details =")
    measures = '\n    def measures(self, results):\n        return {"pace": 1.0}\n'
    task.write_text(task.read_text() + measures)
    (told,) = (done for done in check(tapping) if done.check == "has the measures that it declares")
    assert told.ok
    assert "No attempt had pace_ms" in told.warning
    assert "Attempts had pace, which are not declared" in told.warning


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
