"""``sar-tui export`` as a person calls it."""

import csv
import json
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.export.target import sha256
from sar_tui.store import locks
from sar_tui.store.database import connect
from tests.export.exported import read_csv
from tests.program import Call


@pytest.fixture
def live(call: Call, simulated: str, data: Path) -> str:
    """A session that counts as live, beside a simulated one; its id."""
    call("simulate keyboard --user average --attempts 1 -p P02")
    with closing(connect(data)) as database:
        database.execute("UPDATE sessions SET mode='live' WHERE id=?", (simulated,))
    return simulated


def ids(folder: Path) -> set[str]:
    return {row["session"] for row in read_csv(folder, "sessions")}


def test_chosen_and_live_sessions_leave_and_simulated_ones_only_if_asked_for(
    call: Call, live: str, tmp_path: Path
) -> None:
    call("export --all --to", tmp_path / "live").shows(f"1 session in {tmp_path / 'live'}\n")
    assert ids(tmp_path / "live") == {live}
    call("export --all --simulated --to", tmp_path / "simulated")
    call("export --all --mixed --to", tmp_path / "mixed")
    assert ids(tmp_path / "mixed") - ids(tmp_path / "simulated") == {live}
    assert {row["mode"] for row in read_csv(tmp_path / "simulated", "trials")} == {"simulated"}
    call("export last --to", tmp_path / "x").refused("is simulated: add --simulated")
    assert not (tmp_path / "x").exists()
    one = call("export", live[:6], live, "--to", tmp_path / "one", "--json").json
    assert (one["sessions"], one["problems"]) == ([live], [])
    assert call("export -p p01 --to", tmp_path / "two").code == 0
    assert ids(tmp_path / "two") == {live}
    manifest = json.loads((tmp_path / "two" / "sar-tui-export.json").read_text())
    assert (manifest["format"], manifest["sessions"]) == ("csv", [live])


def test_a_session_that_runs_is_named_and_the_rest_leaves(
    call: Call, live: str, data: Path, tmp_path: Path
) -> None:
    with closing(connect(data)) as database:
        database.execute("UPDATE sessions SET status='running' WHERE id<>?", (live,))
        (running,) = database.execute("SELECT id FROM sessions WHERE id<>?", (live,)).fetchone()
    one = ("export", running, "--simulated", "--to", tmp_path / "alone")
    lock = locks.hold(data, "session", running)
    try:
        called, alone = call("export --all --mixed --to", tmp_path / "out"), call(*one)
    finally:
        lock.release()
    assert called.code == 1
    assert called.err == f"! Session {running} is running. It is left out until it has ended.\n"
    assert ids(tmp_path / "out") == {live}
    assert (alone.code, (tmp_path / "alone").exists()) == (1, False)
    assert call(*one).code == 0, "it was interrupted"


def test_the_ledger_tells_what_left_when_and_for_whom(
    call: Call, live: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    call("export --ledger").shows("Nothing was exported yet.\n")
    board = ("--for", "the ethics board", "--json")
    first = call("export", live, "--to", tmp_path / "one", *board).json
    call("export zzz --to", tmp_path / "two")
    recode = f"--recode {tmp_path}/map.csv"
    call(f"export --all --mixed --with-notes {recode} --to", tmp_path / "three")
    with monkeypatch.context() as patch:
        # as if the database were read only
        patch.setattr("sar_tui.export.export.StoreConnection", sqlite3.Blob)
        called = call("export --all --to", tmp_path / "four")
    assert (called.code, ids(tmp_path / "four")) == (1, {live})
    assert "not in its ledger" in called.err
    last, entry = call("export --ledger --json").json["exports"]
    assert (entry["recipient"], entry["format"]) == ("the ethics board", "csv")
    assert entry["sessions"] == [live]
    manifest = sha256(tmp_path / "one" / "sar-tui-export.json")
    assert entry["manifest"] == first["manifest"] == manifest
    assert len(last["sessions"]) == 2
    assert last["options"] == {"with_notes": True, "with_events": False, "recoded": True}
    call("export --ledger").shows("the ethics board", "with notes, recoded")


def test_an_export_tells_the_sensor_on_the_hand_from_that_on_the_trunk(
    call: Call, tmp_path: Path
) -> None:
    settings = "--set imu_trunk=simulated --seed 5 --attempts 1"
    assert call(f"simulate reaching --user average {settings}").code == 0
    for kind in ("csv", "bids"):
        export = f"export --all --simulated --format {kind} --to"
        assert call(export, tmp_path / kind).code == 0
    with (tmp_path / "csv" / "imu_streams.csv").open() as file:
        streams = {row["part"]: row["stream"] for row in csv.DictReader(file)}
    assert sorted(streams) == ["hand", "trunk"]
    with (tmp_path / "csv" / "imu.csv").open() as file:
        assert {row["stream"] for row in csv.DictReader(file)} == set(streams.values())
    places = set()
    for channels in (tmp_path / "bids").rglob("*_channels.tsv"):
        for row in csv.DictReader(channels.read_text().splitlines(), delimiter="\t"):
            if row["type"] == "GYRO":
                places.add((row["tracked_point"], row["placement"]))
    assert places == {("hand", "back of the hand"), ("trunk", "sternum")}
