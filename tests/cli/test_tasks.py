"""``sar-tui tasks``: list, show, create, check."""

import re
import runpy
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from sar_tui.checks.task import check
from sar_tui.cli.common import Home
from sar_tui.cli.doctor.finding import Machine
from sar_tui.cli.doctor.machine import tasks
from sar_tui.outputs.sound.protocol import Examined
from sar_tui.plugins import Catalogue, task_folder
from tests.edit import edit
from tests.examples import first
from tests.program import Call

Change = Callable[[str, str], Path]
TESTS = Path(__file__).parents[1]
BUNDLED = sorted(set(Catalogue().task_names()) - {"flanker"})


@pytest.fixture
def tapping(call: Call, tmp_path: Path) -> Path:
    """The folder of a new task, in which people tap."""
    assert call("tasks new drumming --to", tmp_path / "mine").code == 0
    folder = tmp_path / "mine" / "drumming"
    shutil.copyfile(TESTS / "drumming_task.py", folder / "task.py")
    return folder


@pytest.fixture
def change(tapping: Path) -> Change:
    """Return a function ``change(old, new)`` that edits the new task and returns its folder."""

    def changed(old: str, new: str) -> Path:
        edit(tapping / "task.py", old, new)
        return tapping

    return changed


# --- listed and shown


def test_tasks_are_listed_with_title_summary_and_metric(call: Call) -> None:
    called = call("tasks")
    assert called.code == 0
    for part in (
        "keyboard",
        "Keyboard reaction",
        "Press the key that appears",
        "reaction time (ms, lower is better)",
    ):
        assert part in called.out


def test_tasks_json(call: Call) -> None:
    tasks = {task["name"]: task for task in call("tasks --json").json["tasks"]}
    assert list(tasks) == sorted(tasks)
    assert (tasks["keyboard"]["title"], tasks["keyboard"]["trains"]) == (
        "Keyboard reaction",
        "Reaction",
    )
    assert tasks["keyboard"]["metric"]["better"] == "lower"
    assert tasks["pairs"]["metric"]["name"] == "reaction_time"
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


def test_a_task_that_fails_to_load_is_listed_with_its_reason(call: Call, change: Change) -> None:
    folder = change("import msgspec", "import no_such_library").parent
    called = call("tasks --tasks", folder)
    assert called.code == 0
    assert (
        "✗ drumming: The task drumming cannot be loaded: task.py:6: ModuleNotFoundError"
        in called.out
    )
    assert "keyboard" in called.out
    broken = call("tasks --tasks", folder, "--json").json["tasks"][-1]
    assert set(broken) == {"name", "error"}
    assert call("simulate drumming --user poor --tasks", folder).code == 2


def test_a_task_shows_its_parameters(call: Call) -> None:
    called = call("tasks show keyboard")
    assert called.code == 0
    for part in (
        "prompts_per_attempt",
        "1 to 200",
        "Number of keys in an attempt.",
        "100 to 60000 ms",
    ):
        assert part in called.out
    words = called.out.split()
    own, heading, common = (
        words.index("sequence_length"),
        words.index("Session"),
        words.index("attempts"),
    )
    assert own < heading < common


def test_parameters_as_json(call: Call) -> None:
    printed = call("tasks show keyboard --json").json
    assert printed["task"]["name"] == "keyboard"
    prompts = next(row for row in printed["parameters"] if row["name"] == "prompts_per_attempt")
    assert (prompts["default"], prompts["ge"], prompts["le"]) == (20, 1, 200)


def test_showing_an_unknown_task_is_bad_input(call: Call) -> None:
    assert call("tasks show juggling").code == 2


# --- created


def test_a_new_task_passes_its_check_and_runs(call: Call, tapping: Path) -> None:
    called = call("tasks check", tapping)
    assert called.code == 0
    assert "✗" not in called.out
    rows = call(
        "simulate drumming --user competent --seed 1 --tasks", tapping.parent, "--json"
    ).json
    assert {row["metric_unit"] for row in rows["attempts"]} == {"taps/s"}
    assert len({row["level"] for row in rows["attempts"]}) > 1


def test_without_a_model_a_new_task_has_one_prompt_and_one_key(call: Call, tmp_path: Path) -> None:
    assert call("tasks new pressing --to", tmp_path).code == 0
    assert "Choice reaction" in (tmp_path / "pressing" / "README.md").read_text()
    called = call("simulate pressing --user average --attempts 2 --tasks", tmp_path, "--json")
    assert {row["metric_unit"] for row in called.json["attempts"]} == {"ms"}


@pytest.mark.parametrize("model", first(2, [None, "flanker", *BUNDLED]))
def test_a_new_task_works_and_has_a_test_beside_it(
    call: Call, tmp_path: Path, model: str | None
) -> None:
    chosen = ["--from", model] if model else []
    assert call("tasks new mine", *chosen, "--to", tmp_path).code == 0
    assert "xample" not in (tmp_path / "mine" / "task.py").read_text()
    test = runpy.run_path(str(tmp_path / "mine" / "test_task.py"))
    test["test_it_keeps_the_contract_of_tasks_and_simulated_people_can_do_it"]()


def test_an_unknown_model_is_bad_input(call: Call, tmp_path: Path) -> None:
    called = call("tasks new mine --from chess --to", tmp_path)
    assert called.code == 2
    assert "chess" in called.err
    assert not (tmp_path / "mine").exists()


def test_creating_a_task_prints_how_to_try_it(call: Call, tapping: Path) -> None:
    readme = (tapping / "README.md").read_text()
    assert f"sar-tui tasks check {tapping}" in readme
    assert f"sar-tui run drumming -p P01 --tasks {tapping.parent}" in readme
    assert "view.py" in readme
    assert "xample" not in (tapping / "task.py").read_text()


def test_people_tap_at_their_own_rate(call: Call, tapping: Path) -> None:
    def rate(user: str) -> float:
        fixed = (
            "--set",
            "difficulty_policy=fixed",
            "--attempts",
            3,
            "--seed",
            1,
            "--tasks",
            tapping.parent,
        )
        rows = call("simulate drumming --user", user, *fixed, "--json").json["attempts"]
        return float(sum(row["metric"] for row in rows))

    assert rate("poor") < rate("average") < rate("competent")


@pytest.mark.parametrize("name", ["Two words", "1st", "Tapping", "../up"])
def test_an_invalid_name_is_bad_input(call: Call, tmp_path: Path, name: str) -> None:
    called = call("tasks new", name, "--to", tmp_path / "mine")
    assert called.code == 2
    assert "small letters" in called.err
    assert not (tmp_path / "mine").exists()


def test_an_existing_folder_is_never_overwritten(call: Call, tapping: Path) -> None:
    (tapping / "task.py").write_text("mine")
    called = call("tasks new drumming --to", tapping.parent)
    assert called.code == 2
    assert "exists already" in called.err
    assert (tapping / "task.py").read_text() == "mine"


# --- checked


def test_the_bundled_task_passes_its_check(call: Call) -> None:
    from sar_tui.plugins import Catalogue, task_folder

    called = call("tasks check", task_folder(Catalogue().task("keyboard")))
    assert called.code == 0
    assert "keyboard passes all checks." in called.out


def test_checks_as_json_leave_no_data_behind(call: Call, tapping: Path, tmp_path: Path) -> None:
    printed = call("tasks check", tapping, "--json").json
    assert (printed["task"], printed["passed"]) == ("drumming", True)
    assert all(
        set(row) == {"check", "ok", "problem", "warning"} and row["ok"] for row in printed["checks"]
    )
    assert not (tmp_path / "data").exists()


def test_a_task_in_a_folder_of_another_name_is_named(call: Call, tapping: Path) -> None:
    folder = Path(shutil.copytree(tapping, tapping.parent / "other"))
    called = call("tasks check", folder)
    assert called.code == 1
    assert "has the name drumming" in called.out


def test_checking_a_missing_folder_is_bad_input(call: Call, tmp_path: Path) -> None:
    assert call("tasks check", tmp_path / "nowhere").code == 2


def test_a_session_of_a_task_that_is_not_found_says_what_is_missing(
    call: Call, tapping: Path
) -> None:
    done = call("simulate drumming --user poor --attempts 1 --seed 1 --tasks", tapping.parent)
    assert f"--tasks {tapping.parent}` shows more" in done.out
    shown = call("show last")
    assert shown.code == 0
    assert "! There is no task drumming." in shown.out
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
    source = task.read_text().replace(
        "import msgspec\n", "import msgspec\n\nfrom sar_tui.api.task import Measure\n"
    )
    source = source.replace(
        "    Details =", '    measured = (Measure("pace_ms", "pace", unit="ms"),)\n    Details ='
    )
    task.write_text(source + '\n    def measures(self, results):\n        return {"pace": 1.0}\n')
    (told,) = (done for done in check(tapping) if done.check == "has the measures that it declares")
    said = (
        "No attempt had pace_ms: so no column shows it. Attempts had pace, which are not declared."
    )
    assert (told.ok, told.warning) == (True, said)
