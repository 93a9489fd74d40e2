"""With a map of codes, persons leave under random codes, and all dates of a person are shifted alike."""

import csv
import os
from contextlib import closing
from datetime import date
from pathlib import Path
from threading import Thread
from typing import Any

import frictionless
import pytest
from sqlite_utils import Database

from sar_tui.export import recoding as recoding_module
from sar_tui.export.errors import ExportError
from sar_tui.export.recoding import Recoded, shifted
from sar_tui.store import participants
from sar_tui.store.database import connect
from tests.export.exported import export_csv, read_csv
from tests.program import Call

CODES = {"ANNA", "BEA", "CARL"}


@pytest.fixture
def data(call: Call, tmp_path: Path) -> Path:
    """Sessions of three persons, two of them together, and what was entered about one."""
    for code in ("CARL", "ANNA"):
        call("simulate", "keyboard", "--user", "poor", "--attempts", 1, "-p", code)
    call("simulate", "pairs", "--user", "poor", "--attempts", 1, "-p", "ANNA", "-p", "BEA", "--set", "address=code")
    with closing(connect(tmp_path / "data")) as database:
        for code in sorted(CODES):
            participants.add(database, code)
        by, now = {"recorded_by": "me", "recorded_at": "2026-03-01T10:00:00+00:00"}, "2026-03-01T10:00:00+00:00"
        tables = Database(database)
        tables["instrument_scores"].insert(  # type: ignore[union-attr]
            {
                "participant": "ANNA",
                "instrument": "ARAT",
                "date": "2026-03-01",
                "score": 7,
                "note": "",
                "removed": 0,
                **by,
            }
        )
        tables["adverse_events"].insert(  # type: ignore[union-attr]
            {"event": "e1", "version": 1, "participant": "ANNA", "session": None, "onset": "2026-03-01 14:30",
             "what": "", "severity": "mild", "action": "", "outcome": "", **by}
        )  # fmt: skip
        tables["programmes"].insert(  # type: ignore[union-attr]
            {"participant": "ANNA", "task": "keyboard", "version": 1, "created_at": now, "author": "me", "reason": "",
             "parameters": "{}", "theme": "calm"}
        )  # fmt: skip
    return tmp_path / "data"


def read_map(path: Path) -> dict[str, tuple[str, int]]:
    with path.open(encoding="utf-8", newline="") as file:
        return {row["code"]: (row["recoded"], int(row["shift_days"])) for row in csv.DictReader(file)}


def test_no_code_leaves_and_the_map_brings_them_back(data: Path, tmp_path: Path) -> None:
    export_csv(data, tmp_path / "plain")
    export_csv(data, tmp_path / "out", recode=tmp_path / "kept" / "map.csv")
    codes = read_map(tmp_path / "kept" / "map.csv")
    assert set(codes) == CODES
    for path in (tmp_path / "out").iterdir():
        assert [code for code in CODES if code in path.read_text("utf-8")] == [], path.name
    for table in ("participants", "trials", "sessions"):
        plain, recoded = read_csv(tmp_path / "plain", table), read_csv(tmp_path / "out", table)
        assert [codes[row["participant"]][0] for row in plain] == [row["participant"] for row in recoded]
    assert frictionless.validate(str(tmp_path / "out" / "datapackage.json")).valid


def test_a_format_gets_no_code_but_the_random_ones(data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: set[str] = set()

    class Names:
        name = "csv"

        def write(self, contents: Any, folder: Path, progress: Any) -> None:
            for table in contents.tables:
                for owner in contents.owners(table):
                    seen.add(owner)
                    seen.update(str(value) for row in contents.rows(table, owner) for value in row)

    monkeypatch.setattr("tests.export.exported.load", lambda name: Names())
    export_csv(data, tmp_path / "out", recode=tmp_path / "map.csv")
    assert {code for code, _ in read_map(tmp_path / "map.csv").values()} <= seen
    assert seen & CODES == set()


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
def test_only_its_owner_can_read_the_map(data: Path, tmp_path: Path) -> None:
    export_csv(data, tmp_path / "out", recode=tmp_path / "map.csv")
    assert (tmp_path / "map.csv").stat().st_mode & 0o777 == 0o600


def test_all_dates_of_a_person_are_shifted_by_the_same_days(data: Path, tmp_path: Path) -> None:
    export_csv(data, tmp_path / "plain")
    export_csv(data, tmp_path / "out", recode=tmp_path / "map.csv")
    codes = read_map(tmp_path / "map.csv")
    assert all(-365 <= days <= -1 for _, days in codes.values())
    assert codes["ANNA"][1] == codes["BEA"][1], "they had a session together"
    stamps = {
        "participants": "created_at", "sessions": "started_at", "programmes": "created_at", "adverse_events": "onset",
        "instrument_scores": "date",
    }  # fmt: skip
    for table, column in stamps.items():
        pairs = list(zip(read_csv(tmp_path / "plain", table), read_csv(tmp_path / "out", table), strict=True))
        assert pairs, table
        for plain, recoded in pairs:
            assert recoded[column] == shifted(plain[column], codes[plain["participant"]][1])
            assert recoded[column][10:] == plain[column][10:], "the time of day stays"
    anchors = [[row["clock_utc"][:10] for row in read_csv(tmp_path / name, "runs")] for name in ("plain", "out")]
    days = [(date.fromisoformat(b) - date.fromisoformat(a)).days for a, b in zip(*anchors, strict=True)]
    assert days == [codes[name][1] for name in ("CARL", "ANNA", "ANNA")]


def test_a_map_is_used_again(data: Path, tmp_path: Path) -> None:
    (tmp_path / "map.csv").write_text("code,recoded,shift_days\r\nBEA,XY,-3\r\n")
    export_csv(data, tmp_path / "one", recode=tmp_path / "map.csv")
    first = read_map(tmp_path / "map.csv")
    export_csv(data, tmp_path / "two", recode=tmp_path / "map.csv")
    assert read_map(tmp_path / "map.csv") == first
    assert (first["BEA"], first["ANNA"][1]) == (("XY", -3), -3)
    assert read_csv(tmp_path / "one", "trials") == read_csv(tmp_path / "two", "trials")


@pytest.mark.parametrize(
    "text", ["", "a,b\n1,2\n", "code,recoded,shift_days\nA,X,1\nB,X,2\n", "code,recoded,shift_days\nA,X,soon\n"]
)
def test_a_file_that_is_no_map_is_not_touched(data: Path, tmp_path: Path, text: str) -> None:
    (tmp_path / "map.csv").write_text(text)
    with pytest.raises(ExportError, match="not a map of codes"):
        export_csv(data, tmp_path / "out", recode=tmp_path / "map.csv")
    assert ((tmp_path / "map.csv").read_text(), (tmp_path / "out").exists()) == (text, False)


def test_the_map_never_leaves_with_the_data(data: Path, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="must not be in the folder that leaves"):
        export_csv(data, tmp_path / "out", recode=tmp_path / "out" / "map.csv")
    assert not (tmp_path / "out").exists()


def test_two_exports_at_once_agree_on_the_codes(data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The second one must not read the map before the codes of the first are in it, and then replace them."""
    told: list[str] = []
    write = recoding_module._write

    def write_while_another_begins(path: Path, known: dict[str, Recoded]) -> None:
        other = Thread(target=another)
        other.start()
        other.join()
        write(path, known)

    def another() -> None:
        with closing(connect(data)) as database, pytest.raises(ExportError) as refused:
            recoding_module.recoding(database, tmp_path / "map.csv", CODES)
        told.append(str(refused.value))

    monkeypatch.setattr(recoding_module, "_LOCK_TIMEOUT_S", 0)
    monkeypatch.setattr(recoding_module, "_write", write_while_another_begins)
    with closing(connect(data)) as database:
        given = recoding_module.recoding(database, tmp_path / "map.csv", CODES)
    assert told == [f"Another export is writing {tmp_path / 'map.csv'}. Try again when it has ended."]
    assert read_map(tmp_path / "map.csv") == {code: (each.code, each.shift_days) for code, each in given.items()}


def test_a_map_that_cannot_be_made_is_named(call: Call, data: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    refused = call(
        "export", "--all", "--simulated", "--to", tmp_path / "out", "--recode", tmp_path / "file" / "map.csv"
    )
    assert refused.code == 2
    assert refused.err == f"{tmp_path / 'file' / 'map.csv'} cannot be made: {tmp_path / 'file'} is a file.\n"
    assert not (tmp_path / "out").exists()
