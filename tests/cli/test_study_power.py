"""``sar-tui study power``: printed, as JSON, and refused."""

import sys
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner, Result

from sar_tui.cli.common import at_home
from sar_tui.cli.errors import Commands
from sar_tui.cli.study_power import power
from sar_tui.store.database import FILE
from tests.program import Call
from tests.study.plans import TWO_GROUPS

PLAN = """
[outcome]
measure = "metric"
block = "training"
visit = "second"
compared = "within"
[power]
effect_dz = 0.5
[conditions.praise]
task = "keyboard"
[[visits]]
name = "second"
[[visits.blocks]]
name = "training"
condition = "praise"
"""

SDS = "person_sd = 40\nsession_sd = 20\ntrial_sd = 60"

app = typer.Typer(cls=Commands, rich_markup_mode=None)
app.callback()(lambda: None)
app.command("power")(at_home(power))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    made = tmp_path / "study.toml"
    made.write_text(PLAN, encoding="utf-8")
    return made


def run(file: Path, *options: object) -> Result:
    """Run the command in one process."""
    given = map(str, options)
    return CliRunner().invoke(app, ["power", str(file), "--processes", "1", *given])


def changed(file: Path, before: str, after: str) -> Path:
    assert before in PLAN
    file.write_text(PLAN.replace(before, after), encoding="utf-8")
    return file


def test_assumptions_curve_and_one_sentence_are_printed(file: Path) -> None:
    done = run(file)
    assert done.exit_code == 0, done.output
    assert "metric (training, second): conditions of one person, paired t-test" in done.output
    assert "SD within a person" in done.output
    assert "√(20² + 69² / 40)" in done.output
    assert "power, %, over people; ╌ 80 %" in done.output
    assert (
        "With 34 people the study finds an effect of 16.11 ms (dz = 0.5, d = 0.357) in 80.5 % (79.7 "
        "to 81.2 %) of 10,000 simulated studies. It is the smallest number of people that reaches "
        "80 %." in done.output
    )
    assert max(map(len, done.output.splitlines()[:-1])) <= 80


def test_groups_are_printed_with_their_size(file: Path) -> None:
    before = 'compared = "within"\n[power]\neffect_dz'
    after = 'compared = "groups"\n[power]\nsizes = [25]\neffect_d'
    done = run(changed(file, before, after))
    assert "13 and 12" in done.output
    assert "(64 in each group) the study finds an effect of 22.58 ms (d = 0.5)" in done.output


def test_an_effect_that_no_size_finds_is_said(file: Path) -> None:
    done = run(changed(file, "effect_dz = 0.5", "effect_dz = 0.001"), "--draws", 1000)
    assert "Even 5,000 people find it in less than 80 %." in done.output


@pytest.mark.parametrize(
    ("measure", "power", "trials", "source"),
    [
        ("metric", "", 12, "the plan: 3 attempts of 4 prompts"),
        ("metric", "trials = 30", 30, "stated in the plan"),
        ("accuracy", SDS, 3, "the plan: 3 attempts"),
    ],
)
def test_trials_are_those_of_the_block_unless_they_are_stated(
    file: Path, measure: str, power: str, trials: int, source: str
) -> None:
    import json

    text = TWO_GROUPS.replace("[outcome]", f'[outcome]\nmeasure = "{measure}"')
    file.write_text(f"{text}[power]\neffect = 20\nsizes = [20]\n{power}\n", encoding="utf-8")
    found = json.loads(run(file, "--json", "--draws", 1000).output)
    assert found["numbers"]["trials"] == {"value": trials, "source": source}


def test_json_has_all_that_is_printed_and_repeats(file: Path) -> None:
    import json

    first, second = (json.loads(run(file, "--json", "--draws", 2000).output) for _ in range(2))
    assert first == second
    assert first["smallest"] in first["estimates"]
    assert set(first["smallest"]) == {"size", "found", "draws", "power", "low", "high"}
    assert first["numbers"]["person_sd"]["value"] == 39
    assert first["alpha"] == 0.05
    assert json.loads(run(file, "--json", "--draws", 2000, "--seed", 2).output) != first


def test_a_pilot_study_gives_the_numbers(call: Call, file: Path, tmp_path: Path) -> None:
    for number in range(5):
        for seed in (1, 2):
            call(
                "simulate keyboard --user average --attempts 2 --set practice_attempts=0 --seed",
                10 * number + seed,
                "-p",
                f"p{number}",
            )
    data = tmp_path / "data"
    before = (data / FILE).read_bytes()
    done = run(file, "--from-pilot", data, "--simulated", "--draws", 1000)
    assert "pilot: 5 people, 10 sessions" in done.output
    assert "The numbers rest on 5 people, 10 sessions" in " ".join(done.output.split())
    assert (data / FILE).read_bytes() == before
    done = run(file, "--from-pilot", data)
    assert (done.exit_code, "and this one has 0." in done.output) == (2, True)


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("effect_dz = 0.5", "effect_dz = 0", "[power] effect_dz must be other than 0"),
        ("[outcome]", "[outcomes]", "The plan has no [outcome]: add it (docs/power.md)."),
        ("[outcome]", "[outcome", "is not valid TOML"),
    ],
)
def test_a_wrong_plan_is_refused(file: Path, before: str, after: str, said: str) -> None:
    done = run(changed(file, before, after))
    assert (done.exit_code, said in done.output) == (2, True), done.output


def test_what_cannot_be_read_is_refused(file: Path, tmp_path: Path) -> None:
    assert "cannot be read: No such file" in run(tmp_path / "none.toml").output
    file.write_bytes(b"\xff")
    assert "is not a text in UTF-8." in run(file).output


def test_a_pilot_study_needs_a_task_of_the_plan(file: Path, tmp_path: Path) -> None:
    done = run(changed(file, 'condition = "praise"', ""), "--from-pilot", tmp_path)
    assert (done.exit_code, "names no task for the block training" in done.output) == (2, True)


def test_a_cluster_needs_its_extra(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    done = CliRunner().invoke(app, ["power", str(file), "--on", "tcp://127.0.0.1:1"])
    assert (done.exit_code, "Install it with" in done.output) == (2, True)
    done = run(file, "--on", "tcp://127.0.0.1:1")
    assert (done.exit_code, "not both" in done.output) == (2, True)
