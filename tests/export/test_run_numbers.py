"""Actions and notes name the run of the program whose clock stamped them."""

from pathlib import Path

from tests.export.exported import export_csv, read_csv
from tests.export.resumed import resumed


def test_actions_and_notes_of_a_resumed_session_name_their_runs(tmp_path: Path) -> None:
    resumed(tmp_path / "data")
    export_csv(tmp_path / "data", tmp_path / "out", with_notes=True)
    notes = [(row["text"], row["run"]) for row in read_csv(tmp_path / "out", "notes")]
    assert notes == [("in run 1", 1), ("in run 2", 2)]
    actions = read_csv(tmp_path / "out", "actions")
    begun = {row["run"]: row["clock_ns"] for row in read_csv(tmp_path / "out", "runs")}
    assert {row["run"] for row in actions} == {1, 2}
    assert begun[2] < begun[1], "the second run's clock began anew"
    for row in actions:
        assert row["run"] == (1 if row["decided_ns"] >= begun[1] else 2)


def test_an_attempt_that_was_interrupted_names_the_run_in_which_it_began(tmp_path: Path) -> None:
    resumed(tmp_path / "data")
    export_csv(tmp_path / "data", tmp_path / "out")
    begun = {row["run"]: row["clock_ns"] for row in read_csv(tmp_path / "out", "runs")}
    first, second = read_csv(tmp_path / "out", "attempts")
    assert [(row["started_run"], row["run"]) for row in (first, second)] == [(1, 1), (1, 2)]
    assert second["started_ns"] >= begun[1] > second["ended_ns"] >= begun[2]
