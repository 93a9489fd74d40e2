"""``sar-tui reanalyse``: the reaches of a session, found again in its stored samples."""

import json
import shutil
import sqlite3
from pathlib import Path
from typing import Any

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from tests.program import Call

SIMULATE = "simulate reaching --user average --seed 5 --attempts 2"


def change(folder: Path, statement: str, *values: object) -> None:
    with sqlite3.connect(folder / "data" / "sar-tui.db") as connection:
        connection.execute(statement, values)


def recorded(call: Call, session: str) -> list[dict[str, Any]]:
    trials: list[dict[str, Any]] = call("show", session, "--json").json["trials"]
    return trials


@pytest.fixture(scope="module")
def reaches(tmp_path_factory: pytest.TempPathFactory, catalogue: Catalogue) -> tuple[Path, str]:
    """The data folder of a short simulated session of the reaching task, and the session's id."""
    folder = tmp_path_factory.mktemp("reaches")
    plan = make_plan(catalogue, "reaching", ["SIM"], {"attempts": 3}, seed=3, mode="simulated")
    return folder, simulate(plan, PEOPLE["poor"], folder, catalogue)


@pytest.fixture
def reached(reaches: tuple[Path, str], tmp_path: Path) -> str:
    """The id of that session, in a copy of its own."""
    folder, session = reaches
    shutil.copytree(folder, tmp_path / "data")
    return session


def test_the_same_detector_gives_exactly_what_was_recorded_and_changes_nothing(
    call: Call, data: Path, reached: str
) -> None:
    def stored() -> list[str]:
        with sqlite3.connect(data / "sar-tui.db") as connection:
            return list(connection.iterdump())

    before = stored()
    printed = call("reanalyse", reached, "--json").json
    assert set(printed) == {"session", "detector", "trials"}
    assert (printed["session"], printed["detector"]) == (reached, "orientation")
    trials = recorded(call, reached)
    assert [(row["attempt"], row["trial"]) for row in printed["trials"]] == [(1, 1), (2, 1), (3, 1)]
    for row, trial in zip(printed["trials"], trials, strict=True):
        assert row["recorded_ms"] == row["reach_time_ms"] == trial["details"]["reach_time_ms"]
        assert (row["difference_ms"], row["equal"], row["missing_samples"]) == (0.0, True, 0)
        assert row["details"].items() <= trial["details"].items()
        assert set(row["flags"]) <= set(trial["timing"]["flags"])
    called = call("reanalyse last")
    called.shows("3 of 3 trials are exactly as recorded.")
    detector = "orientation (version 3) detector."
    assert called.out.endswith(f"Recorded: {detector} Now: {detector}\n")
    assert stored() == before


@pytest.mark.parametrize(
    "settings",
    [
        "--set detector=fixed-threshold --set thesis_threshold_rad_s=0.3",
        "--set go_signal=yes --set reaches_per_attempt=2 --set response_timeout_ms=1500",
        "--set hand=left",
    ],
)
def test_the_results_are_the_same_for_any_settings(call: Call, settings: str) -> None:
    call(f"{SIMULATE} {settings}")
    trials = call("reanalyse last --json").json["trials"]
    assert all(row["equal"] for row in trials)
    assert any(row["reach_time_ms"] for row in trials)


def test_a_reach_that_was_not_sure_is_not_sure_again(call: Call) -> None:
    call(f"{SIMULATE} --set least_confidence=1")
    then = ["unsure" in trial["timing"]["flags"] for trial in recorded(call, "last")]
    now = ["unsure" in row["flags"] for row in call("reanalyse last --json").json["trials"]]
    assert then == now
    assert any(now)


def test_another_detector_can_be_asked_for(call: Call) -> None:
    call(SIMULATE)
    printed = call("reanalyse last --detector fixed-threshold --json").json
    assert printed["detector"] == "fixed-threshold"
    times = [trial["details"]["fixed_threshold_reach_time_ms"] for trial in recorded(call, "last")]
    assert [row["reach_time_ms"] for row in printed["trials"]] == times
    first, _ = printed["trials"]
    differs = first["reach_time_ms"] - first["recorded_ms"]
    assert first["difference_ms"] == pytest.approx(differs, abs=1e-3)
    assert (first["details"]["detector"], first["equal"]) == ("fixed-threshold", False)


def test_samples_that_were_never_stored_are_reported(
    call: Call, tmp_path: Path, reached: str
) -> None:
    change(tmp_path, "DELETE FROM imu_chunks")
    called = call("reanalyse", reached)
    called.shows("Attempt 1, trial 1: 1941 of its samples were never stored.")
    called.shows("0 of 3 trials are exactly as recorded, and in 3 there is no reach now.")
    first, *_ = call("reanalyse", reached, "--json").json["trials"]
    assert (first["reach_time_ms"], first["difference_ms"]) == (None, None)
    assert "samples" in first["flags"]


def test_samples_from_before_a_reattachment_are_not_used(
    call: Call, tmp_path: Path, reached: str
) -> None:
    change(
        tmp_path,
        """UPDATE messages SET topic=(SELECT id FROM topics WHERE name='input/sensor'), message='["attached", 0]'
        WHERE seq=(SELECT min(seq) FROM events WHERE topic='event_handler/prompt')""",
    )
    first, second, _ = call("reanalyse", reached, "--json").json["trials"]
    assert first["missing_samples"] > 500
    assert second["equal"]


def test_damaged_samples_are_a_failure_in_words(call: Call, tmp_path: Path, reached: str) -> None:
    change(tmp_path, "UPDATE imu_chunks SET crc32=crc32+1 WHERE seq=3")
    said = f"Block 3 of sensor stream 1 of session {reached} is damaged."
    call("reanalyse", reached).refused(said, code=1)


def test_sessions_of_two_and_those_without_reaches_are_refused_with_a_reason(
    call: Call, simulated: str
) -> None:
    few = "--attempts 1 --set prompts_per_attempt=2 --set respond_with=reaches --seed 1 --json"
    session = call(f"simulate pairs --user average --user average {few}").json["session"]
    said = f"The session {session} (pairs) has two participants."
    call("reanalyse", session).refused(said, "not which sensor each reach came from.")
    said = f"The session {simulated} (keyboard) has no reach that can be found again"
    call("reanalyse", simulated).refused(said)


def test_a_detector_that_no_longer_exists_is_bad_input(
    call: Call, tmp_path: Path, reached: str
) -> None:
    details = recorded(call, reached)[0]["details"] | {"detector": "clairvoyant"}
    change(tmp_path, "UPDATE trials SET details=? WHERE attempt=1", json.dumps(details))
    said = "Attempt 1, trial 1 was found by the detector clairvoyant"
    call("reanalyse", reached).refused(said)
    assert call("reanalyse", reached, "--detector", "single-axis").code == 0
