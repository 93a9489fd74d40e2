"""With a map of codes, persons leave under random codes, and all dates of a person are shifted
alike.
"""

import csv
import errno
import os
import shutil
from collections import Counter
from contextlib import closing
from pathlib import Path
from typing import Any

import frictionless
import pytest
from filelock import FileLock

from sar_tui.export import recoding as recoding_module
from sar_tui.export.errors import ExportError
from sar_tui.export.export import _UNRECORDED
from sar_tui.export.recoding import shifted
from sar_tui.store import participants
from sar_tui.store.database import connect
from tests.export.exported import csv_of, export_as, export_csv, read_csv
from tests.played import simulated
from tests.program import Call
from tests.recorded import event, score
from tests.store.by_hand import insert, sql, value

CODES = {"ANNA", "BEA", "CARL"}


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Sessions of three persons, two of them together, and what was entered about one."""
    folder = tmp_path_factory.mktemp("stored") / "data"
    for code in ("CARL", "ANNA"):
        simulated(folder, "keyboard", code, user="poor", attempts=1)
    simulated(folder, "pairs", "ANNA", "BEA", user="poor", attempts=1, address="code")
    with closing(connect(folder)) as database:
        for code in sorted(CODES):
            participants.add(database, code)
        score(database, "ANNA", "ARAT", "2026-03-01", 7)
        event(database, "ANNA", "2026-03-01T14:30", what="Fell", severity="mild")
        made = {"participant": "ANNA", "created_at": "2026-03-01T10:00:00+00:00"}
        insert(database, "programmes", author="me", **made)
    return folder


@pytest.fixture
def data(stored: Path, tmp_path: Path) -> Path:
    """A copy of them."""
    return Path(shutil.copytree(stored, tmp_path / "data"))


@pytest.fixture
def map_path(tmp_path: Path) -> Path:
    """The path of a map of codes."""
    return tmp_path / "map.csv"


def read_map(path: Path) -> dict[str, tuple[str, int]]:
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {row["code"]: (row["recoded"], int(row["shift_days"])) for row in rows}


@pytest.mark.slow
def test_no_code_leaves_and_the_map_brings_them_back(data: Path, tmp_path: Path) -> None:
    map_path, out = tmp_path / "kept" / "map.csv", tmp_path / "out"
    export_csv(data, out, recode=map_path)
    codes = read_map(map_path)
    assert set(codes) == CODES
    for path in out.iterdir():
        assert [code for code in CODES if code in path.read_text("utf-8")] == [], path.name
    for table in ("participants", "trials", "sessions"):
        plain = Counter(codes[row["participant"]][0] for row in csv_of(data, table))
        assert plain == Counter(row["participant"] for row in read_csv(out, table))
    assert frictionless.validate(str(out / "datapackage.json")).valid
    assert os.name != "posix" or map_path.stat().st_mode & 0o777 == 0o600


_DATES = {
    "participants": "created_at",
    "sessions": "started_at",
    "programmes": "created_at",
    "records": "at",
}


def test_all_dates_of_a_person_are_shifted_by_the_same_days(
    data: Path, map_path: Path, tmp_path: Path
) -> None:
    export_csv(data, tmp_path / "out", recode=map_path)
    codes = read_map(map_path)
    assert all(-365 <= days <= -1 for _, days in codes.values())
    assert codes["ANNA"][1] == codes["BEA"][1], "they had a session together"
    for table, column in _DATES.items():
        plain = [(codes[row["participant"]], row[column]) for row in csv_of(data, table)]
        assert plain, table
        recoded = {(row["participant"], row[column]) for row in read_csv(tmp_path / "out", table)}
        assert recoded == {(code, shifted(stamp, days)) for (code, days), stamp in plain}
        for (_, days), stamp in plain:
            assert shifted(stamp, days)[10:] == stamp[10:], "the time of day stays"
    began = {row["session"]: row["started_at"] for row in read_csv(tmp_path / "out", "sessions")}
    for row in read_csv(tmp_path / "out", "runs"):
        assert row["clock_utc"][:10] == began[row["session"]][:10]


@pytest.mark.parametrize(
    ("written", "key"),
    [("code,recoded,shift_days,key\r\nBEA,XY,-3,ab12\r\n", "ab12"),
     ("code,recoded,shift_days\r\nBEA,XY,-3\r\n", None)],
    ids=["as now", "of an earlier version"],
)  # fmt: skip
def test_a_map_is_used_again(data: Path, map_path: Path, written: str, key: str | None) -> None:
    map_path.write_text(written)
    one = csv_of(data, "trials", recode=map_path)
    first = read_map(map_path)
    two = csv_of(data, "trials", recode=map_path)
    assert read_map(map_path) == first
    assert (first["BEA"], first["ANNA"][1]) == (("XY", -3), -3)
    (kept,) = {line.rpartition(",")[2] for line in map_path.read_text().splitlines()[1:]}
    assert kept == (key or kept)
    assert key or len(kept) == 32
    same = "the same ids of sessions, in another order"
    assert Counter(str(row) for row in one) == Counter(str(row) for row in two), same


def test_ids_and_seeds_leave_as_others_equal_where_they_were(data: Path, map_path: Path) -> None:
    sql(data, "UPDATE sessions SET seed=7 WHERE task='keyboard'")
    plain, recoded = csv_of(data, "sessions"), csv_of(data, "sessions", recode=map_path)
    for name in ("session", "seed"):
        assert {row[name] for row in plain} & {row[name] for row in recoded} == set()
    ids = {row["session"] for row in recoded}
    assert len(ids) == len(plain)
    assert len({row["seed"] for row in recoded if row["task"] == "keyboard"}) == 1
    assert {row["session"] for row in csv_of(data, "trials", recode=map_path)} <= ids


def test_versions_leave_only_if_all_sessions_have_the_same(
    data: Path, map_path: Path, tmp_path: Path
) -> None:
    same = csv_of(data, "sessions", recode=map_path)
    assert all(row["sar_tui"] and row["task_sha256"] for row in same)
    another = "software=json_set(software, '$.sar_tui', '0.0.1')"
    sql(data, f"UPDATE sessions SET {another} WHERE rowid=(SELECT min(rowid) FROM sessions)")
    left_out = export_csv(data, tmp_path / "out", recode=map_path).left_out
    assert {"sessions.sar_tui", "runs.sar_tui"} <= set(left_out)
    for row in read_csv(tmp_path / "out", "sessions"):
        assert "sar_tui" not in row
        assert row["python"]
    # which versions there are is told, but not whose sessions they recorded
    assert "0.0.1" in (tmp_path / "out" / "methods.md").read_text()


def test_problems_name_sessions_as_they_leave_in_files_and_as_they_are_here_on_the_terminal(
    data: Path, map_path: Path, tmp_path: Path
) -> None:
    some = value(data, "SELECT id FROM sessions LIMIT 1")
    sql(data, "UPDATE runs SET clock_anchor='{' WHERE session=?", some)
    problems = export_csv(data, tmp_path / "out", recode=map_path).problems
    (problem,) = set(problems) - {_UNRECORDED}
    assert problem.startswith(f"runs, session {some}, run 1: ")
    manifest = (tmp_path / "out" / "sar-tui-export.json").read_text()
    assert problem.partition(": ")[2] in manifest
    assert some not in manifest
    trials = [row for row in read_csv(tmp_path / "out", "trials") if row["onset_ns"] is not None]
    stands_for = "the first message stands for the start of its run"
    assert len({row["session"] for row in trials}) == 3, stands_for
    assert max(row["onset_ns"] for row in trials) < 3600 * 10**9


@pytest.mark.parametrize(
    "text",
    [
        "",
        "a,b\n1,2\n",
        "code,recoded,shift_days\nA,X,1\nB,X,2\n",
        "code,recoded,shift_days\nA,X,soon\n",
        "code,recoded,shift_days,key\nA,X,1\n",
        "code,recoded,shift_days,key\nA,X,1,k\nB,Y,2,l\n",
    ],
)
def test_a_file_that_is_no_map_is_not_touched(
    data: Path, map_path: Path, tmp_path: Path, text: str
) -> None:
    map_path.write_text(text)
    with pytest.raises(ExportError, match="not a map of codes"):
        export_csv(data, tmp_path / "out", recode=map_path)
    assert (map_path.read_text(), (tmp_path / "out").exists()) == (text, False)


def test_the_map_never_leaves_with_the_data(data: Path, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="must not be in a folder that leaves"):
        export_csv(data, tmp_path / "out", recode=tmp_path / "out" / "map.csv")
    assert not (tmp_path / "out").exists()
    export_csv(data, tmp_path / "earlier")
    with pytest.raises(ExportError, match="must not be in a folder that leaves"):
        export_csv(data, tmp_path / "out", recode=tmp_path / "earlier" / "map.csv")


def test_copies_of_the_map_a_killed_program_left_are_removed(
    data: Path, map_path: Path, tmp_path: Path
) -> None:
    export_csv(data, tmp_path / "out", recode=map_path)
    for name in (".map.csv.a1_b2c3d", "map.csv.a1_b2c3d", ".other.csv.a1_b2c3d"):
        (tmp_path / name).write_bytes(map_path.read_bytes())
    export_csv(data, tmp_path / "out", recode=map_path)
    kept = {path.name for path in tmp_path.iterdir() if path.is_file()} - {".map.csv.lock"}
    assert kept == {"map.csv", "map.csv.a1_b2c3d", ".other.csv.a1_b2c3d"}


def test_a_new_map_of_an_export_that_failed_is_named(
    call: Call, data: Path, map_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ("export --all --simulated --to", tmp_path / "out", "--recode", map_path)

    def fail(*_: Any) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patched:
        patched.setattr("sar_tui.export.export.write_manifest", fail)
        failed = call(*words)
        assert failed.code == 1
        assert f"! {map_path} was made, and nothing was exported with it" in failed.err
        assert "was made" not in call(*words).err, "it was there before"
    assert call(*words).code == 0


def test_a_map_that_another_export_writes_is_left_alone(
    data: Path, map_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Otherwise the codes of one could be replaced by those of the other."""
    monkeypatch.setattr(recoding_module, "_LOCK_TIMEOUT_S", 0)
    with (
        FileLock(tmp_path / ".map.csv.lock"),
        pytest.raises(ExportError, match=f"Another export is writing {map_path}"),
    ):
        export_csv(data, tmp_path / "out", recode=map_path)
    assert not map_path.exists()


def test_a_map_that_cannot_be_made_is_named(call: Call, data: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    map_path = tmp_path / "file" / "map.csv"
    refused = call("export --all --simulated --to", tmp_path / "out", "--recode", map_path)
    assert refused.code == 2
    assert refused.err == f"{map_path} cannot be made: {tmp_path / 'file'} is a file.\n"
    assert not (tmp_path / "out").exists()


def test_a_folder_of_many_sites_is_replaced_with_the_same_map_only(
    data: Path, map_path: Path, tmp_path: Path
) -> None:
    for _ in range(2):
        export_as("parquet", data, tmp_path / "lake", recode=map_path)
    with pytest.raises(ExportError, match="Give the same map of codes"):
        export_as("parquet", data, tmp_path / "lake", recode=tmp_path / "other.csv")
