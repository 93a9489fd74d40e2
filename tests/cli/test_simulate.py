"""``sar-tui simulate``: a whole session, its tables, its JSON, its refusals."""

import sqlite3
from pathlib import Path

import pytest

from sar_tui.cli.simulate import User
from sar_tui.outputs.output import Output
from sar_tui.simulation.participant_model import PEOPLE
from tests.plugged_in import offer
from tests.program import Call

AVERAGE = "simulate keyboard --user average".split()
COLUMNS = {
    "session", "attempt", "seat", "run", "practice", "level", "metric", "metric_unit", "accuracy",
    "correct", "trials", "outcome", "feedback", "started_ns", "ended_ns", "goal", "qualities",
    "choice", "condition",
}  # fmt: skip


def test_json_is_the_session_and_the_rows_of_its_attempts(call: Call, tmp_path: Path) -> None:
    printed = call(*AVERAGE, "--seed", 1, "--attempts", 3, "--json").json
    assert set(printed) == {"session", "attempts", "outputs"}
    assert [row["attempt"] for row in printed["attempts"]] == [1, 2, 3]
    assert all(set(row) == COLUMNS for row in printed["attempts"])
    with sqlite3.connect(tmp_path / "data" / "sar-tui.db") as connection:
        rows = connection.execute(
            "SELECT metric FROM attempts WHERE session=?", (printed["session"],)
        ).fetchall()
    assert [row["metric"] for row in printed["attempts"]] == [metric for (metric,) in rows]


def test_show_lists_what_a_therapist_has_marked(call: Call, tmp_path: Path) -> None:
    session = call("simulate reaching --user average --attempts 2 --seed 1 --json").json["session"]
    assert "Marked" not in call("show", session).out
    with sqlite3.connect(tmp_path / "data" / "sar-tui.db") as connection:
        connection.execute(
            "UPDATE trials SET details=json_set(details, '$.mark', 'assisted') WHERE attempt=2"
        )
    assert "Marked by the therapist: attempt 2 assisted." in call("show", session).out


def test_the_same_seed_gives_the_same_attempts(call: Call) -> None:
    first, second, other = (
        [
            {name: value for name, value in row.items() if name != "session"}
            for row in call(*AVERAGE, "--seed", seed, "--attempts", 3, "--json").json["attempts"]
        ]
        for seed in (7, 7, 8)
    )
    assert first == second != other


def test_a_seed_is_drawn_and_reported(call: Call, tmp_path: Path) -> None:
    called = call(*AVERAGE, "--attempts", 1)
    with sqlite3.connect(tmp_path / "data" / "sar-tui.db") as connection:
        (seed,) = connection.execute("SELECT seed FROM sessions").fetchone()
    assert f"Seed {seed}." in called.out


def test_people_read_a_table_and_a_sentence(call: Call) -> None:
    called = call(*AVERAGE, "--seed", 1, "--attempts", 2)
    assert (called.code, called.err) == (0, "")
    assert "reaction time" in called.out
    assert "2 attempts, 2 reached the goal, levels 1 to 2, mean reaction time" in called.out
    assert "sar-tui show" in called.out


def test_user_choices_are_the_simulated_people() -> None:
    assert {user.value for user in User} == set(PEOPLE)


def test_the_code_defaults_to_sim_and_is_stored_in_capitals(call: Call) -> None:
    call(*AVERAGE, "--attempts", 1)
    call(*AVERAGE, "--attempts", 1, "-p", "p07")
    assert {row["participant"] for row in call("sessions --json").json["sessions"]} == {
        "SIM",
        "P07",
    }


def test_settings_theme_and_people_can_be_changed(call: Call) -> None:
    options = (
        "--set",
        "prompts_per_attempt=3",
        "--set",
        "practice_attempts=1",
        "--theme",
        "high-contrast",
    )
    printed = call(*AVERAGE, "--attempts", 2, *options, "--json").json
    assert [(row["practice"], row["trials"]) for row in printed["attempts"]] == [
        (True, 3),
        (False, 3),
        (False, 3),
    ]
    assert call("show", printed["session"], "--json").json["session"]["theme"] == "high-contrast"


def test_attempts_beats_set(call: Call) -> None:
    assert (
        len(call(*AVERAGE, "--attempts", 1, "--set", "attempts=5", "--json").json["attempts"]) == 1
    )


def test_fatigue_slows_and_practice_speeds_up(call: Call) -> None:
    def last(*options: object) -> float:
        fixed = ("--seed", 1, "--attempts", 8, "--set", "difficulty_policy=fixed", "--json")
        return float(call(*AVERAGE, *fixed, *options).json["attempts"][-1]["metric"])

    assert last("--practice-effect", 0.5) < last() < last("--fatigue", 0.2)


def test_a_task_that_breaks_in_mid_session_is_a_failure_that_keeps_what_was_done(
    call: Call, tmp_path: Path
) -> None:
    call("tasks new brittle --to", tmp_path)
    path = tmp_path / "brittle" / "task.py"
    text = path.read_text()
    assert "keys = KEYS[situation.level - 1]" in text
    path.write_text(
        text.replace("keys = KEYS[situation.level - 1]", "keys = KEYS[9 - situation.attempt * 9]")
    )
    called = call("simulate brittle --user poor --tasks", tmp_path)
    assert called.code == 1
    assert called.err.startswith("The task brittle failed (IndexError:")
    assert "Traceback" not in called.err
    assert call("sessions --json").json["sessions"][0]["status"] == "interrupted"


class Hoarse:
    """Entry point of an output that can only speak, and always fails."""

    name = "hoarse"
    value = "hoarse:Hoarse"

    def load(self) -> type[Output]:
        class Voice(Output):
            name = "hoarse"
            can = frozenset({"say"})

            def say(self, action: str, text: str) -> None:
                raise OSError("the throat is dry")

            def stop(self, action: str = "") -> None:
                return None

        return lambda _: Voice()  # type: ignore[return-value]


def test_an_output_that_failed_is_reported_at_the_end(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    offer(monkeypatch, "sar_tui.outputs", [Hoarse()])
    options = (
        "--attempts",
        1,
        "--set",
        "prompts_per_attempt=2",
        "--outputs",
        "screen,hoarse",
        "--seed",
        1,
    )
    hoarse = next(
        each
        for each in call(*AVERAGE, *options, "--json").json["outputs"]
        if each["output"] == "hoarse"
    )
    assert (hoarse["address"], hoarse["done"]) == ("hoarse", 0)
    assert hoarse["failed"] >= 3, "a greeting, an answer, a goodbye"
    assert "the throat is dry" in hoarse["why"]
    warning = f"! hoarse: {hoarse['failed']} of {hoarse['failed']} failed ({hoarse['why']})"
    assert call(*AVERAGE, *options).out.rstrip().split("\n")[-1] == warning


# --- two participants


def test_two_users_sit_left_and_right(call: Call) -> None:
    called = call("simulate pairs --user competent --user poor --attempts 3 --seed 2 --json")
    attempts = called.json["attempts"]
    assert [(row["attempt"], row["seat"]) for row in attempts] == [
        (n, seat) for n in (1, 2, 3) for seat in "AB"
    ]
    means = {seat: sum(row["metric"] for row in attempts if row["seat"] == seat) for seat in "AB"}
    assert means["A"] < means["B"]
    (row,) = call("sessions -p sim-b --json").json["sessions"]
    assert (row["participant"], row["partner"]) == ("SIM", "SIM-B")


def test_a_session_of_two_is_reported_seat_by_seat(call: Call) -> None:
    called = call("simulate pairs --user average -p p01 -p p02 --attempts 2 --seed 2")
    assert called.code == 0
    assert "seat" in called.out.splitlines()[0]
    assert "Seat A: 2 attempts" in called.out
    assert "Seat B: 2 attempts" in called.out
    shown = call("show last").out
    assert "Participant  P01, P02" in shown
    assert shown.count("reaction time (ms)") == 2


PLAYED = "simulate pairs --user competent --user poor --attempts 2 --seed 2".split()


@pytest.mark.parametrize(
    ("policy", "quality", "says"),
    [("race", "won", "Ahead in {} of 24."), ("cooperative", "together", "Together in {} of 24.")],
)
def test_wins_and_joint_responses_of_two_are_counted(
    call: Call, policy: str, quality: str, says: str
) -> None:
    attempts = call(*PLAYED, "--set", f"policy={policy}", "--json").json["attempts"]
    shown = call("show last").out
    for seat in "AB":
        counted = sum(row["qualities"][quality] for row in attempts if row["seat"] == seat)
        assert says.format(round(counted)) in shown
    if policy == "cooperative":
        assert [row["qualities"]["together"] for row in attempts] == [
            row["correct"] for row in attempts
        ]


def test_the_congruency_effect_is_reported_for_each_seat(call: Call) -> None:
    given = ("--set", "policy=joint attention", "--set", "prompts_per_attempt=40", "--json")
    attempts = call(*PLAYED, *given).json["attempts"]
    shown = call("show last").out
    for seat in "AB":
        one, other = (
            row["qualities"]["congruency_effect_ms"] for row in attempts if row["seat"] == seat
        )
        effect = f"{(one + other) / 2:.0f} ms"
        assert (
            f"Congruency effect {effect}: incongruent minus congruent, mean of 2 attempts." in shown
        )


def test_the_plots_of_two_have_the_same_axis(call: Call) -> None:
    call("simulate pairs --user competent --user poor --attempts 3 --seed 2")
    ticks = [
        line.split("┤")[0].strip() for line in call("show last").out.splitlines() if "┤" in line
    ]
    half = len(ticks) // 2
    assert half > 2
    assert ticks[:half] == ticks[half:]
