"""``sar-tui sessions`` and ``show``: what was recorded, for people and programs; ``sar-tui markers``."""

import json
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import msgspec
import pytest

from sar_tui.loop.topics import MARKERS
from sar_tui.model.messages import MarkersChanged
from sar_tui.reports.output_summary import marker_summaries
from sar_tui.store.database import connect_to_read
from tests.outputs.markers.receivers import udp_receiver
from tests.program import Call
from tests.store.by_hand import add_message


def change(folder: Path, statement: str, *values: object) -> None:
    with sqlite3.connect(folder / "data" / "sar-tui.db") as connection:
        connection.execute(statement, values)


def test_sessions_are_listed_newest_first(call: Call) -> None:
    assert "There are no sessions yet. `sar-tui simulate" in call("sessions").out
    session = "simulate keyboard --user average --seed 1 --attempts 4 -p p01 --json"
    simulated = call(session).json["session"]
    (row,) = call("sessions -p p01 --json").json["sessions"]
    columns = "task started_at ended_at seed software machine operators partner site"
    assert set(columns.split()) <= set(row)
    assert [row[name] for name in ("id", "participant", "status", "mode")] == [
        simulated, "P01", "completed", "simulated",
    ]  # fmt: skip
    assert row["parameters"]["attempts"] == 4
    newer = call("simulate keyboard --user poor --attempts 1 --json").json["session"]
    assert [row["id"] for row in call("sessions -p p01 --json").json["sessions"]] == [simulated]
    printed = call("sessions").out
    assert printed.index(newer) < printed.index(simulated)
    assert "completed, simulated" in printed


def test_show_json_has_session_attempts_and_trials(call: Call, simulated: str) -> None:
    for name in ("last", simulated[:5]):
        assert call("show", name, "--json").json["session"]["id"] == simulated
    printed = call("show", simulated, "--json").json
    parts = {"session", "attempts", "trials", "outputs", "markers", "records"}
    assert (set(printed), printed["session"]["id"]) == (parts, simulated)
    assert (len(printed["attempts"]), len(printed["trials"])) == (4, 80)
    (screen,) = printed["outputs"]
    assert (screen["output"], screen["failed"], screen["why"]) == ("screen", 0, "")
    columns = "attempt trial stimulus response correct reaction_time_ms timing details"
    assert set(columns.split()) <= set(printed["trials"][0])


def test_show_prints_facts_attempts_plot_and_causes_of_inexact_timing(
    call: Call, tmp_path: Path, simulated: str
) -> None:
    called = call("show last")
    called.shows(
        simulated, "P01", "keyboard", "╌ goal 1000", "level   ", "of 80 trials have a flag"
    )
    assert not [text for text in ("\x1b", "failed", "After attempt") if text in called.out]
    change(tmp_path, "UPDATE sessions SET machine=?", json.dumps({"flags": ["ssh", "tmux"]}))
    timing = {"onset_source": "flush", "handler_delay_ms": 0.25, "flags": ["focus_lost"]}
    change(tmp_path, "UPDATE trials SET timing=? WHERE attempt=1", json.dumps(timing))
    called = call("show last")
    called.shows("less exact: the keys came through ssh and tmux", "flush 20")
    called.shows("20 of 80 trials have a flag (focus_lost 20)")
    change(tmp_path, "UPDATE sessions SET task='gone'")
    call("show", simulated).shows("reaction time (ms)")  # as the task declared it
    for table in ("attempts", "trials"):
        change(tmp_path, f"DELETE FROM {table}")
    call("show", simulated).shows("No attempt was finished.")


def test_show_says_what_became_of_each_attempt_as_its_plot_does(
    call: Call, tmp_path: Path, simulated: str
) -> None:
    change(tmp_path, "UPDATE attempts SET outcome='failure'")
    for attempt, metric in ((1, "NULL"), (2, "goal + 100"), (3, "goal - 100")):
        change(tmp_path, f"UPDATE attempts SET metric={metric} WHERE attempt={attempt}")
    lines = call("show last").out.splitlines()
    table = {line.split()[0]: line for line in lines if line.strip()[:1].isdigit()}
    (legend,) = (line for line in lines if "× no result  ╌ goal" in line)
    for attempt, marker in (("1", "× no result"), ("2", "○ missed"), ("3", "◇ inaccurate")):
        assert marker in table[attempt]
        assert marker in legend


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
    card = "There is no sound card [yet]."
    for output in ("speech", "tones"):
        record(tmp_path, simulated, "output/opened", output=output, address=output, can=["say"])
    for output, action, state, detail in (
        ("speech", "a1", "queued", ""),
        ("speech", "a1", "failed", card),
        ("speech", "a2", "failed", "It is busy."),
        ("speech", "a3", "failed", card),
        ("speech", "a4", "done", ""),
        ("speech", "a5", "aborted", ""),
        ("speech", "a6", "queued", ""),
        ("tones", "a1", "done", ""),
    ):
        report = {"output": output, "action": action, "deed": "say", "state": state, "at": 2}
        record(tmp_path, simulated, "output/report", **report, detail=detail)
    printed = call("show", simulated).out.rstrip().split("\n")
    assert printed[-1] == f"! speech: 3 of 5 failed ({card})"
    outputs = {each["output"]: each for each in call("show", simulated, "--json").json["outputs"]}
    speech = {"done": 1, "aborted": 1, "failed": 3, "why": card, "not_closed": ""}
    assert outputs["speech"] == {"output": "speech", "address": "speech", **speech}
    assert [outputs["tones"][name] for name in ("done", "failed", "why")] == [1, 0, ""]


@pytest.mark.parametrize(
    ("policy", "line"),
    [
        ("target", "After attempt 1: level 1 → 3. 5 of 5 prompts reached the goal; the target"),
        ("percentile", " ms. The goal is the last result at this level."),
    ],
)
def test_the_reasons_of_changes_are_shown_under_policies_that_need_them_and_rests(
    call: Call, policy: str, line: str
) -> None:
    settings = f"--set difficulty_policy={policy} --set prompts_per_attempt=5"
    rests = "--set rest_after_attempts=2 --set rest_seconds=30"
    call(f"simulate keyboard --user competent --attempts 5 --seed 1 {settings} {rests}")
    called = call("show last")
    called.shows(line)
    rests = [shown for shown in called.out.splitlines() if "a rest of" in shown]
    assert rests == ["After attempt 2: a rest of 30 s.", "After attempt 4: a rest of 30 s."]


@pytest.mark.usefixtures("simulated")
def test_a_damaged_text_in_the_database_is_reported_as_damage(call: Call, tmp_path: Path) -> None:
    change(tmp_path, "UPDATE sessions SET parameters=CAST(parameters || x'ff' AS TEXT)")
    for command in ("sessions", "show last", "report wizard last"):
        call(command).refused("sar-tui.db is damaged. Restore a backup", "check --repair")


def test_reported_changes_stand_beside_their_mdc95(call: Call) -> None:
    settings = "--set difficulty_policy=fixed --set attempts=20 --set prompts_per_attempt=5"
    call(f"simulate keyboard --user competent --seed 6 {settings}")
    (said,) = (line for line in call("show last").out.splitlines() if "feedback reported" in line)
    assert said == "After attempt 13, feedback reported: reaction time -0.231 s (MDC95 0.226 s)."


def test_test_markers_are_sent(call: Call) -> None:
    with udp_receiver() as receiver:
        called = call("markers", receiver.address, "--count", 3, "--every", 0)
        received = [receiver.next() for _ in range(3)]
    called.shows(f"{receiver.address}: 3 sent, 0 lost.\n")
    sent = [(marker["event"], marker["number"]) for marker in received]
    assert sent == [("test", n) for n in (1, 2, 3)]


def test_show_says_where_markers_went_and_how_many_arrived(
    call: Call, simulated: str, tmp_path: Path
) -> None:
    def record_change(destination: str, **change: Any) -> None:
        message = MarkersChanged(destination=destination, at=1, **change)
        record(tmp_path, simulated, MARKERS.name, **msgspec.structs.asdict(message))

    record_change("lsl", state="open", detail="LSL's clock minus the session's: 5 ns")
    record_change("lsl", state="failing", detail="It broke.")
    counts = {"sent": 7, "lost": 2, "unheard": 1, "late_ms": 0.25, "latest_ms": 1.5}
    record_change("lsl", state="closed", **counts)
    record_change("udp://h:1", state="open")
    shown = " ".join(call("show", simulated).out.split())
    for said in (
        "Markers to lsl: 7 sent, 2 lost; 1 sent while nobody listened; prompts sent 0.2 ms after",
        "at most 1.5 ms. It broke. LSL's clock minus the session's: 5 ns.",
        "Markers to udp://h:1: 0 sent, 0 lost; not counted in a run that was killed",
    ):
        assert said in shown
    summary, _ = call("show", simulated, "--json").json["markers"]
    assert (summary["sent"], summary["lost"], summary["unfinished"]) == (7, 2, 0)
    with connect_to_read(tmp_path / "data") as database:
        assert marker_summaries(database, "another") == []
