"""``sar-tui sessions`` and ``show``: what was recorded, for people and programs."""

import json
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.model.trial_types import Metric
from tests.program import Call
from tests.store.by_hand import add_message


def change(folder: Path, statement: str, *values: object) -> None:
    with sqlite3.connect(folder / "data" / "sar-tui.db") as connection:
        connection.execute(statement, values)


def test_sessions_json_has_the_columns_of_the_table(call: Call, simulated: str) -> None:
    printed = call("sessions --json").json
    assert set(printed) == {"sessions"}
    (row,) = printed["sessions"]
    assert {
        "id",
        "task",
        "status",
        "started_at",
        "ended_at",
        "seed",
        "parameters",
        "software",
        "machine",
        "mode",
    } <= set(row)
    assert (row["id"], row["participant"], row["status"], row["mode"]) == (
        simulated,
        "P01",
        "completed",
        "simulated",
    )
    assert row["parameters"]["attempts"] == 4


def test_sessions_can_be_one_participants(call: Call, simulated: str) -> None:
    assert [row["id"] for row in call("sessions -p p01 --json").json["sessions"]] == [simulated]
    assert call("sessions -p P99") == (2, "", "There is no participant P99.\n")


def test_sessions_are_listed_newest_first(call: Call, simulated: str) -> None:
    newer = call("simulate keyboard --user poor --attempts 1 --json").json["session"]
    printed = call("sessions").out
    assert printed.index(newer) < printed.index(simulated)
    assert "completed, simulated" in printed


def test_no_sessions_says_how_to_make_one(call: Call) -> None:
    assert "There are no sessions yet. `sar-tui simulate" in call("sessions").out


def test_show_json_has_session_attempts_and_trials(call: Call, simulated: str) -> None:
    printed = call("show", simulated, "--json").json
    more = {"outputs", "markers", "records"}
    assert set(printed) == {"session", "attempts", "trials"} | more
    assert printed["session"]["id"] == simulated
    assert len(printed["attempts"]) == 4
    assert len(printed["trials"]) == 80
    (screen,) = printed["outputs"]
    assert (screen["output"], screen["failed"], screen["why"]) == ("screen", 0, "")
    assert {
        "attempt",
        "trial",
        "stimulus",
        "response",
        "correct",
        "reaction_time_ms",
        "timing",
        "details",
    } <= set(printed["trials"][0])


@pytest.mark.parametrize("name", ["last", "whole", "beginning"])
def test_a_session_is_found_by_its_id_its_beginning_or_last(
    call: Call, simulated: str, name: str
) -> None:
    named = {"last": "last", "whole": simulated, "beginning": simulated[:5]}[name]
    assert call("show", named, "--json").json["session"]["id"] == simulated


def test_show_prints_facts_attempts_plot_and_timing(call: Call, simulated: str) -> None:
    called = call("show last")
    assert (called.code, called.err) == (0, "")
    for part in (
        simulated,
        "P01",
        "keyboard",
        "positive",
        "╌ goal 1000",
        "level   ",
        "of 80 trials have a flag",
    ):
        assert part in called.out
    assert "\x1b" not in called.out


def test_show_says_what_became_of_each_attempt_as_its_plot_does(
    call: Call, tmp_path: Path, simulated: str
) -> None:
    change(tmp_path, "UPDATE attempts SET outcome='failure'")
    change(tmp_path, "UPDATE attempts SET metric=NULL WHERE attempt=1")
    change(tmp_path, "UPDATE attempts SET metric=goal + 100 WHERE attempt=2")
    change(tmp_path, "UPDATE attempts SET metric=goal - 100 WHERE attempt=3")
    printed = call("show last").out
    table = {line.split()[0]: line for line in printed.splitlines() if line.strip()[:1].isdigit()}
    assert "× no result" in table["1"]
    assert "○ missed" in table["2"]
    assert "◇ inaccurate" in table["3"]
    legend = next(line for line in printed.splitlines() if "× no result  ╌ goal" in line)
    assert all(marker in legend for marker in ("○ missed", "◇ inaccurate", "× no result"))


def test_show_reports_causes_of_inexact_timing(call: Call, tmp_path: Path, simulated: str) -> None:
    change(tmp_path, "UPDATE sessions SET machine=?", json.dumps({"flags": ["ssh", "tmux"]}))
    timing = {"onset_source": "flush", "handler_delay_ms": 0.25, "flags": ["focus_lost"]}
    change(tmp_path, "UPDATE trials SET timing=? WHERE attempt=1", json.dumps(timing))
    printed = call("show last").out
    assert "less exact: the keys came through ssh and tmux" in printed
    assert "20 of 80 trials have a flag (focus_lost 20)" in printed
    assert "flush 20" in printed


def test_show_works_when_the_task_is_gone(call: Call, tmp_path: Path, simulated: str) -> None:
    change(tmp_path, "UPDATE sessions SET task='gone'")
    called = call("show", simulated)
    assert called.code == 0
    assert "reaction time (ms)" in called.out, "what the task declared is kept with the session"


def test_infinite_results_of_earlier_versions_are_no_results(
    call: Call, tmp_path: Path, simulated: str
) -> None:
    change(tmp_path, "UPDATE attempts SET metric=9e999 WHERE attempt=2")
    change(tmp_path, "UPDATE attempts SET metric=-9e999 WHERE attempt=3")
    called = call("show", simulated)
    assert (called.code, called.err) == (0, "")
    assert called.out.count("× no result") == 3, "two rows of the table, and the plot's legend"
    assert [row["metric"] is None for row in call("show", simulated, "--json").json["attempts"]] == [
        False, True, True, False
    ]  # fmt: skip
    assert call("progress P01").code == 0


def test_show_a_session_without_attempts(call: Call, tmp_path: Path, simulated: str) -> None:
    change(tmp_path, "DELETE FROM attempts")
    change(tmp_path, "DELETE FROM trials")
    called = call("show", simulated)
    assert called.code == 0
    assert "No attempt was finished." in called.out


@pytest.mark.parametrize(("unit", "label"), [("ms", "reaction time (ms)"), ("", "reaction time")])
def test_a_metric_is_labelled_with_its_unit_if_it_has_one(unit: str, label: str) -> None:
    assert Metric("reaction_time", unit, "lower").label == label


# --- outputs


def record(folder: Path, session: str, topic: str, **message: object) -> None:
    """Append a message to a session."""
    with closing(sqlite3.connect(folder / "data" / "sar-tui.db")) as database, database:
        (seq,) = database.execute(
            "SELECT max(seq) + 1 FROM events WHERE session=?", (session,)
        ).fetchone()
        add_message(database, session, seq, 0, topic, message)


def test_show_ends_with_a_line_for_each_output_that_failed(
    call: Call, tmp_path: Path, simulated: str
) -> None:
    card, busy = "There is no sound card [yet].", "It is busy."
    for output in ("speech", "tones"):
        record(tmp_path, simulated, "output/opened", output=output, address=output, can=["say"])
    for action, state, detail in (
        ("a1", "failed", card),
        ("a2", "failed", busy),
        ("a3", "failed", card),
    ):
        record(
            tmp_path,
            simulated,
            "output/report",
            output="speech",
            action=action,
            deed="say",
            state="queued",
            at=1,
        )
        record(
            tmp_path, simulated, "output/report", output="speech", action=action, deed="say",
            state=state, at=2, detail=detail,
        )  # fmt: skip
    for action, state in (("a4", "done"), ("a5", "aborted"), ("a6", "queued")):
        record(
            tmp_path,
            simulated,
            "output/report",
            output="speech",
            action=action,
            deed="say",
            state=state,
            at=3,
        )
    record(
        tmp_path,
        simulated,
        "output/report",
        output="tones",
        action="a1",
        deed="tone",
        state="done",
        at=3,
    )

    assert (
        call("show", simulated).out.rstrip().split("\n")[-1] == f"! speech: 3 of 5 failed ({card})"
    )
    outputs = {each["output"]: each for each in call("show", simulated, "--json").json["outputs"]}
    assert outputs["speech"] == {
        "output": "speech", "address": "speech", "done": 1, "aborted": 1, "failed": 3, "why": card,
        "not_closed": "",
    }  # fmt: skip
    assert (outputs["tones"]["done"], outputs["tones"]["failed"], outputs["tones"]["why"]) == (
        1,
        0,
        "",
    )


def test_show_omits_outputs_that_worked(call: Call, simulated: str) -> None:
    assert "failed" not in call("show", simulated).out


@pytest.mark.parametrize(
    ("policy", "line"),
    [
        (
            "target",
            "After attempt 1: level 1 → 3. 5 of 5 prompts reached the goal; the target is 70 %.",
        ),
        ("percentile", " ms. The goal is the last result at this level."),
    ],
)
def test_the_reasons_of_changes_are_shown_under_policies_that_need_them(
    call: Call, policy: str, line: str
) -> None:
    settings = ["--set", f"difficulty_policy={policy}", "--set", "prompts_per_attempt=5"]
    call("simulate keyboard --user competent --attempts 2 --seed 1", *settings)
    assert line in call("show last").out


def test_by_default_no_reasons_are_listed(call: Call) -> None:
    call("simulate keyboard --user competent --attempts 2 --seed 1")
    assert "After attempt" not in call("show last").out


def test_rests_that_had_to_be_taken_are_listed(call: Call) -> None:
    settings = [
        "--set",
        "prompts_per_attempt=1",
        "--set",
        "rest_after_attempts=2",
        "--set",
        "rest_seconds=30",
    ]
    call("simulate keyboard --user competent --attempts 5 --seed 1", *settings)
    rests = [line for line in call("show last").out.splitlines() if "a rest of" in line]
    assert rests == ["After attempt 2: a rest of 30 s.", "After attempt 4: a rest of 30 s."]


@pytest.mark.parametrize(
    "damage", ["substr(parameters, 1, 100)", "CAST(parameters || x'ff' AS TEXT)", "''"]
)
@pytest.mark.parametrize("command", [["sessions"], ["show", "last"], ["report", "wizard", "last"]])
def test_a_damaged_text_in_the_database_is_reported_as_damage(
    call: Call, tmp_path: Path, simulated: str, command: list[str], damage: str
) -> None:
    change(tmp_path, f"UPDATE sessions SET parameters={damage} WHERE id=?", simulated)
    called = call(*command)
    assert (called.code, called.out) == (2, "")
    assert (
        "sar-tui.db is damaged. Restore a backup, save what can be read (`sar-tui check --repair`)"
        in called.err
    )


def test_reported_changes_stand_beside_their_mdc95(call: Call) -> None:
    settings = {"difficulty_policy": "fixed", "attempts": 20, "prompts_per_attempt": 5}
    sets = [word for name, value in settings.items() for word in ("--set", f"{name}={value}")]
    call("simulate keyboard --user competent --seed 6", *sets)
    (said,) = (line for line in call("show last").out.splitlines() if "feedback reported" in line)
    assert said == "After attempt 13, feedback reported: reaction time -0.231 s (MDC95 0.226 s)."
