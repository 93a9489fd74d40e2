"""``sar-tui export`` as a person calls it."""

import errno
import json
import os
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from sar_tui.export.target import sha256
from sar_tui.store import locks
from sar_tui.store.database import connect
from tests.export.exported import read_csv
from tests.plugged_in import offer
from tests.program import Call


@pytest.fixture
def live(call: Call, simulated: str, tmp_path: Path) -> str:
    """A session that counts as live, beside a simulated one; its id."""
    call("simulate keyboard --user average --attempts 1 -p P02")
    with closing(connect(tmp_path / "data")) as database:
        database.execute("UPDATE sessions SET mode='live' WHERE id=?", (simulated,))
    return simulated


def ids(folder: Path) -> set[str]:
    return {row["session"] for row in read_csv(folder, "sessions")}


def test_live_sessions_leave_and_simulated_ones_only_if_asked_for(
    call: Call, live: str, tmp_path: Path
) -> None:
    assert call("export --all --to", tmp_path / "live") == (
        0,
        f"1 session in {tmp_path / 'live'}\n",
        "",
    )
    assert ids(tmp_path / "live") == {live}
    call("export --all --simulated --to", tmp_path / "simulated")
    call("export --all --mixed --to", tmp_path / "mixed")
    assert ids(tmp_path / "mixed") - ids(tmp_path / "simulated") == {live}
    assert {row["mode"] for row in read_csv(tmp_path / "simulated", "trials")} == {"simulated"}
    assert "is simulated: add --simulated" in call("export last --to", tmp_path / "x").err
    assert not (tmp_path / "x").exists()


def test_sessions_are_chosen_by_id_and_by_participant(
    call: Call, live: str, tmp_path: Path
) -> None:
    one = call("export", live[:6], live, "--to", tmp_path / "one", "--json").json
    assert (one["sessions"], one["problems"]) == ([live], [])
    assert call("export -p p01 --to", tmp_path / "two").code == 0
    assert ids(tmp_path / "two") == {live}
    manifest = json.loads((tmp_path / "two" / "sar-tui-export.json").read_text())
    assert (manifest["format"], manifest["sessions"]) == ("csv", [live])


def test_a_session_that_runs_is_named_and_the_rest_leaves(
    call: Call, live: str, tmp_path: Path
) -> None:
    with closing(connect(tmp_path / "data")) as database:
        database.execute("UPDATE sessions SET status='running' WHERE id<>?", (live,))
        (running,) = database.execute("SELECT id FROM sessions WHERE id<>?", (live,)).fetchone()
    lock = locks.hold(tmp_path / "data", "session", running)
    try:
        called = call("export --all --mixed --to", tmp_path / "out")
        alone = call("export", running, "--simulated", "--to", tmp_path / "alone")
    finally:
        lock.release()
    assert called.code == 1
    assert called.err == f"! Session {running} is running. It is left out until it has ended.\n"
    assert ids(tmp_path / "out") == {live}
    assert (alone.code, (tmp_path / "alone").exists()) == (1, False)
    assert call("export", running, "--simulated", "--to", tmp_path / "alone").code == 0, (
        "it was interrupted"
    )


@pytest.mark.parametrize(
    ("failure", "sentence"),
    [
        (errno.ENOSPC, "The disk is full: "),
        (errno.EIO, "The disk cannot be read or written: "),
        (errno.EROFS, "The disk can only be read. "),
    ],
)
def test_a_disk_that_fails_leaves_no_target_and_the_database_as_it_was(
    call: Call,
    live: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    failure: int,
    sentence: str,
) -> None:
    before = (tmp_path / "data" / "sar-tui.db").read_bytes()

    def fail(*_: Any) -> None:
        raise OSError(failure, os.strerror(failure))

    monkeypatch.setattr("os.fsync", fail)
    called = call("export --all --to", tmp_path / "out")
    assert called.code == 1
    assert called.err.startswith(sentence)
    assert [path.name for path in tmp_path.iterdir()] == ["data"]
    assert (tmp_path / "data" / "sar-tui.db").read_bytes() == before


def test_a_program_that_may_write_no_more_leaves_no_target(
    call: Call, live: str, tmp_path: Path
) -> None:
    resource = pytest.importorskip("resource")
    done = subprocess.run(
        [sys.executable, "-m", "sar_tui", "export", "--all", "--mixed", "--to", tmp_path / "out"],
        env={**os.environ, "SAR_TUI_DATA": str(tmp_path / "data")},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert done.stderr.startswith("A file would be larger than the disk or this login may have.")
    assert [path.name for path in tmp_path.iterdir()] == ["data"]


def test_an_installed_package_adds_a_format(
    call: Call, live: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Count:
        name = "count"
        title = "the number of rows"

        def write(self, contents: Any, folder: Path, progress: Any) -> None:
            counts = {
                t.name: sum(1 for o in contents.owners(t) for _ in contents.rows(t, o))
                for t in contents.tables
            }
            (folder / "count.json").write_text(json.dumps(counts))

    entry = SimpleNamespace(name="count", value="counts:Count", load=lambda: Count)
    offer(monkeypatch, "sar_tui.exports", [entry])
    assert call("export --all --format count --to", tmp_path / "out").code == 0
    assert json.loads((tmp_path / "out" / "count.json").read_text())["sessions"] == 1


def test_the_ledger_tells_what_left_when_and_for_whom(
    call: Call, live: str, tmp_path: Path
) -> None:
    assert call("export --ledger").out == "Nothing was exported yet.\n"
    first = call(
        "export", live, "--to", tmp_path / "one", "--for", "the ethics board", "--json"
    ).json
    call("export zzz --to", tmp_path / "two")
    call(
        "export --all --mixed --with-notes --to",
        tmp_path / "three",
        "--recode",
        tmp_path / "map.csv",
    )
    last, entry = call("export --ledger --json").json["exports"]
    assert (entry["recipient"], entry["format"], entry["sessions"]) == (
        "the ethics board",
        "csv",
        [live],
    )
    assert (
        entry["manifest"] == first["manifest"] == sha256(tmp_path / "one" / "sar-tui-export.json")
    )
    assert (len(last["sessions"]), last["options"]) == (
        2,
        {"with_notes": True, "with_events": False, "recoded": True},
    )
    shown = call("export --ledger").out
    assert "the ethics board" in shown
    assert "with notes, recoded" in shown


def test_an_export_that_cannot_be_recorded_says_so(
    call: Call, live: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # as if it were read only
    monkeypatch.setattr("sar_tui.export.export.StoreConnection", sqlite3.Blob)
    called = call("export --all --to", tmp_path / "out")
    assert (called.code, ids(tmp_path / "out")) == (1, {live})
    assert "not in its ledger" in called.err
