"""``sar-tui simulate``: a whole session, its tables, its JSON, its refusals."""

import sqlite3
from pathlib import Path
from statistics import fmean
from types import SimpleNamespace
from typing import Any

import pytest

from sar_tui.cli.simulate import OperatorName, User
from sar_tui.outputs.output import Output
from sar_tui.simulation.operator import PROFILES
from sar_tui.simulation.participant_model import PEOPLE
from tests.edit import edit
from tests.plugged_in import offer
from tests.program import Call

AVERAGE = "simulate keyboard --user average"
PLAYED = "simulate pairs --user competent --user poor --attempts 2 --seed 2"
COLUMNS = {
    "session", "attempt", "seat", "run", "practice", "level", "metric", "metric_unit", "accuracy",
    "correct", "trials", "outcome", "feedback", "started_ns", "ended_ns", "goal", "qualities",
    "choice", "condition",
}  # fmt: skip


def test_json_is_the_session_and_the_rows_of_its_attempts(call: Call, tmp_path: Path) -> None:
    def simulated(seed: int) -> tuple[str, list[dict[str, Any]]]:
        printed = call(f"{AVERAGE} --set attempts=5 --attempts 3 --json --seed", seed).json
        assert set(printed) == {"session", "attempts", "outputs"}
        return printed["session"], [{**row, "session": ""} for row in printed["attempts"]]

    session, attempts = simulated(1)
    assert [row["attempt"] for row in attempts] == [1, 2, 3]
    assert all(set(row) == COLUMNS for row in attempts)
    with sqlite3.connect(tmp_path / "data" / "sar-tui.db") as connection:
        rows = connection.execute("SELECT metric FROM attempts WHERE session=?", (session,))
        assert [(row["metric"],) for row in attempts] == rows.fetchall()
    assert attempts == simulated(1)[1] != simulated(2)[1]


def test_show_lists_what_a_therapist_has_marked(call: Call, tmp_path: Path) -> None:
    session = call("simulate reaching --user average --attempts 2 --seed 1 --json").json["session"]
    assert "Marked" not in call("show", session).out
    with sqlite3.connect(tmp_path / "data" / "sar-tui.db") as connection:
        connection.execute(
            "UPDATE trials SET details=json_set(details, '$.mark', 'assisted') WHERE attempt=2"
        )
    assert "Marked by the therapist: attempt 2 assisted." in call("show", session).out


def test_people_read_a_table_and_a_sentence_with_the_seed_that_was_drawn(call: Call) -> None:
    called = call(f"{AVERAGE} --attempts 1")
    (row,) = call("sessions --json").json["sessions"]
    called.shows(f"Seed {row['seed']}.", "reaction time", "1 attempt, ", "sar-tui show")
    assert f"Seed {row['seed']}." not in call(f"{AVERAGE} --attempts 1").out
    given = call(f"{AVERAGE} --seed 1 --attempts 2 -p p07")
    given.shows("2 attempts, 2 reached the goal, levels 1 to 2")
    rows = call("sessions --json").json["sessions"]
    assert [row["participant"] for row in rows] == ["P07", "SIM", "SIM"]


def test_the_choices_are_the_simulated_people_and_operators() -> None:
    assert {user.value for user in User} == set(PEOPLE)
    assert {name.value for name in OperatorName} == set(PROFILES)


def test_settings_theme_and_people_can_be_changed(call: Call) -> None:
    settings = "--set prompts_per_attempt=3 --set practice_attempts=1 --theme high-contrast"
    printed = call(f"{AVERAGE} --attempts 2 {settings} --json").json
    rows = [(row["practice"], row["trials"]) for row in printed["attempts"]]
    assert rows == [(True, 3), (False, 3), (False, 3)]
    assert call("show", printed["session"], "--json").json["session"]["theme"] == "high-contrast"


def test_fatigue_slows_and_practice_speeds_up(call: Call) -> None:
    def last(option: str) -> float:
        fixed = "--seed 1 --attempts 8 --set difficulty_policy=fixed --json"
        return float(call(f"{AVERAGE} {fixed} {option}").json["attempts"][-1]["metric"])

    assert last("--practice-effect 0.5") < last("") < last("--fatigue 0.2")


def test_a_task_that_breaks_in_mid_session_is_a_failure_that_keeps_what_was_done(
    call: Call, tmp_path: Path
) -> None:
    call("tasks new brittle --to", tmp_path)
    task = tmp_path / "brittle" / "task.py"
    edit(task, "keys = KEYS[situation.level - 1]", "keys = KEYS[9 - situation.attempt * 9]")
    called = call("simulate brittle --user poor --tasks", tmp_path)
    assert called.code == 1
    assert called.err.startswith("The task brittle failed (IndexError:")
    assert "Traceback" not in called.err
    assert call("sessions --json").json["sessions"][0]["status"] == "interrupted"


class Voice(Output):
    name = "hoarse"
    can = frozenset({"say"})

    def say(self, action: str, text: str) -> None:
        raise OSError("the throat is dry")

    def stop(self, action: str = "") -> None:
        return None


def test_an_output_that_failed_is_reported_at_the_end(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    hoarse = {"name": "hoarse", "value": "hoarse:Hoarse", "load": lambda: lambda _: Voice()}
    offer(monkeypatch, "sar_tui.outputs", [SimpleNamespace(**hoarse)])
    few = f"{AVERAGE} --attempts 1 --set prompts_per_attempt=2 --seed 1 --outputs screen,hoarse"
    outputs = {each["output"]: each for each in call(few, "--json").json["outputs"]}
    told = outputs["hoarse"]
    assert (told["address"], told["done"]) == ("hoarse", 0)
    assert told["failed"] >= 3, "a greeting, an answer, a goodbye"
    assert "the throat is dry" in told["why"]
    warning = f"! hoarse: {told['failed']} of {told['failed']} failed ({told['why']})"
    assert call(few).out.rstrip().split("\n")[-1] == warning


# --- two participants


def test_two_users_sit_left_and_right(call: Call) -> None:
    rows = call(f"{PLAYED} --json").json["attempts"]
    order = [(row["attempt"], row["seat"]) for row in rows]
    assert order == [(n, seat) for n in (1, 2) for seat in "AB"]
    means = {seat: sum(row["metric"] for row in rows if row["seat"] == seat) for seat in "AB"}
    assert means["A"] < means["B"]
    (row,) = call("sessions -p sim-b --json").json["sessions"]
    assert (row["participant"], row["partner"]) == ("SIM", "SIM-B")
    shown = call("show last").out
    assert "Participant  SIM, SIM-B" in shown
    assert shown.count("reaction time (ms)") == 2


@pytest.mark.parametrize(
    ("policy", "quality", "says"),
    [("race", "won", "Ahead in {} of 24."), ("cooperative", "together", "Together in {} of 24.")],
)
def test_wins_and_joint_responses_of_two_are_counted(
    call: Call, policy: str, quality: str, says: str
) -> None:
    attempts = call(f"{PLAYED} --set policy={policy} --json").json["attempts"]
    for seat in "AB":
        counted = sum(row["qualities"][quality] for row in attempts if row["seat"] == seat)
        call("show last").shows(says.format(round(counted)))
    if policy == "cooperative":
        assert all(row["qualities"]["together"] == row["correct"] for row in attempts)


def test_the_congruency_effect_is_reported_for_each_seat(call: Call) -> None:
    given = ("--set", "policy=joint attention", "--set", "prompts_per_attempt=40")
    called = call("simulate pairs --user average -p p01 -p p02 --attempts 2 --seed 2", *given)
    called.shows("seat", "Seat A: 2 attempts", "Seat B: 2 attempts")
    attempts = call("show last --json").json["attempts"]
    for seat in "AB":
        rows = [row["qualities"] for row in attempts if row["seat"] == seat]
        effect = fmean(row["congruency_effect_ms"] for row in rows)
        call("show last").shows(f"Congruency effect {effect:.0f} ms", "mean of 2 attempts.")
