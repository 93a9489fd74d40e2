"""Parquet files of many sites are one data set, and hold what the databases hold, as DuckDB reads
them.
"""

import json
import math
import re
import sys
from contextlib import closing
from datetime import datetime
from pathlib import Path
from typing import Any

import duckdb
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyarrow import parquet

from sar_tui.export.errors import ExportError
from sar_tui.export.export import Exported, Options, export
from sar_tui.export.formats.parquet import ROWS, ParquetFormat
from sar_tui.plugins import Catalogue
from sar_tui.store import sessions, sites
from sar_tui.store.database import connect
from sar_tui.store.selection import Request
from tests.examples import examples
from tests.export.exported import ALL, export_csv, no_bar, read_csv
from tests.export.hard_study import store_study
from tests.export.test_round_trip import TRIAL
from tests.program import Call

PAGE = (Path(__file__).parents[2] / "docs" / "many-sites.md").read_text(encoding="utf-8")


def leave(data: Path, lake: Path, request: Request = ALL, **options: Any) -> Exported:
    """Export the sessions of a data folder as Parquet."""
    with closing(connect(data)) as database:
        return export(
            database, data, Catalogue(), request, ParquetFormat(), lake, no_bar, Options(**options)
        )


def query(lake: Path, table: str, what: str = "*", rest: str = "") -> list[tuple[Any, ...]]:
    return duckdb.sql(f"SELECT {what} FROM '{lake}/{table}/**/*.parquet' {rest}").fetchall()


@pytest.fixture
def clinic(call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Make the data of a site: sessions of some tasks, each of the participant P01."""

    def make(site: str, *tasks: str) -> Path:
        data = tmp_path / site
        for task in tasks:
            codes = ("P01", "P02") if task == "pairs" else ("P01",)
            who = [part for code in codes for part in ("-p", code, "--user", "poor")]
            assert (
                call("simulate", task, *who, "--attempts", 1, "--seed", 3, "--data", data).code == 0
            )
        with closing(connect(data)) as database:
            sites.set_own(database, site)
        return data

    return make


def test_exports_of_several_sites_in_one_folder_are_one_data_set(
    clinic: Any, tmp_path: Path
) -> None:
    lake = tmp_path / "lake"
    for site, tasks in (
        ("BERN", ("keyboard", "reaching")),
        ("ULM", ("pairs",)),
        ("JENA", ("keyboard",)),
    ):
        leave(clinic(site, *tasks), lake)
    found = query(lake, "trials", "site, task, count(*)", "GROUP BY ALL ORDER BY ALL")
    assert [(site, task) for site, task, _ in found] == [
        ("BERN", "keyboard"), ("BERN", "reaching"), ("JENA", "keyboard"), ("ULM", "pairs"),
    ]  # fmt: skip
    people = query(
        lake, "trials", "DISTINCT site, participant", "WHERE participant='P01' ORDER BY ALL"
    )
    assert people == [("BERN", "P01"), ("JENA", "P01"), ("ULM", "P01")]
    times = query(lake, "trials", "(details->>'reach_time_ms')::double", "WHERE task='reaching'")
    assert all(time > 0 for (time,) in times)
    schemas = {}
    for path in lake.rglob("*.parquet"):
        schemas.setdefault(path.relative_to(lake).parts[0], set()).add(
            str(parquet.read_schema(path))
        )
    assert {name for name, different in schemas.items() if len(different) > 1} == set()


def test_a_file_describes_its_columns(clinic: Any, tmp_path: Path) -> None:
    leave(clinic("BERN", "keyboard"), tmp_path / "lake")
    (path,) = (tmp_path / "lake").glob("trials/site=BERN/*/trials-BERN-*.parquet")
    field = parquet.read_schema(path).field("reaction_time_ms")
    assert field.metadata[b"unit"] == b"ms"
    assert b"Missing for a miss" in field.metadata[b"meaning"]
    assert re.fullmatch(r"month=\d{4}-\d{2}", path.parent.name)


@given(rows=st.lists(TRIAL, max_size=5))
@examples(100)
def test_odd_texts_and_numbers_are_read_back_as_they_are_stored(
    tmp_path_factory: Any, rows: list[dict[str, Any]]
) -> None:
    place = tmp_path_factory.mktemp("odd")
    with closing(connect(place)) as database:
        sites.set_own(database, "BERN")
        sessions.create(
            database, "s1", task="keyboard", theme="calm", participant="P01", seed=1,
            parameters={}, software={"sar_tui": "0"}, machine={}, mode="live",
        )  # fmt: skip
        for number, row in enumerate(rows, 1):
            values = {
                "session": "s1",
                "attempt": 1,
                "trial": number,
                "seat": "A",
                "run": 1,
                "timing": "{}",
                **row,
            }
            database.execute(
                f"INSERT INTO trials ({', '.join(values)}) VALUES ({', '.join('?' * len(values))})",
                tuple(values.values()),
            )
    leave(place, place / "lake")
    names = (
        "stimulus",
        "response",
        "correct",
        "onset_ns",
        "response_ns",
        "reaction_time_ms",
        "details",
    )
    read = query(place / "lake", "trials", ", ".join(names), "ORDER BY trial")
    for got, row in zip(read, rows, strict=True):
        time = row["reaction_time_ms"]
        row["reaction_time_ms"] = time if time is not None and math.isfinite(time) else None
        known = json.loads(row["details"] or "null") or {}
        details = {name: value for name, value in known.items() if value is not None}
        assert got[:-1] == tuple(row[name] for name in names[:-1])
        assert json.loads(got[-1]) == details


def test_rows_beyond_one_block_are_all_there(
    call: Call, clinic: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.export.formats.parquet.ROWS", 7)
    data = clinic("BERN", "reaching")
    leave(data, tmp_path / "lake")
    with closing(connect(data)) as database:
        (samples,) = database.execute("SELECT sum(n) FROM imu_chunks").fetchone()
    assert query(tmp_path / "lake", "imu", "count(*)") == [(samples,)]
    assert ROWS > 7


def test_an_export_replaces_the_data_of_its_own_site_only(clinic: Any, tmp_path: Path) -> None:
    lake = tmp_path / "lake"
    leave(clinic("BERN", "keyboard"), lake)
    leave(clinic("ULM", "keyboard"), lake)
    before = {path: path.read_bytes() for path in lake.glob("*/site=BERN/**/*") if path.is_file()}
    leave(clinic("ULM", "keyboard"), lake)
    assert {
        path: path.read_bytes() for path in lake.glob("*/site=BERN/**/*") if path.is_file()
    } == before
    assert query(lake, "sessions", "site, count(*)", "GROUP BY ALL ORDER BY ALL") == [
        ("BERN", 1),
        ("ULM", 2),
    ]


def test_a_database_without_a_code_is_the_site_local_until_it_has_one(
    call: Call, tmp_path: Path
) -> None:
    data, lake = tmp_path / "data", tmp_path / "lake"
    call("simulate", "keyboard", "-p", "P01", "--user", "poor", "--attempts", 1)
    leave(data, lake)
    assert query(lake, "trials", "DISTINCT site, participant") == [("local", "P01")]
    with closing(connect(data)) as database:
        sites.set_own(database, "BERN")
    leave(data, lake)
    assert query(lake, "trials", "DISTINCT site, participant") == [("BERN", "P01")]
    assert not list(lake.glob("*/site=local"))


def test_an_export_that_was_stopped_while_its_files_were_moved_is_finished_by_the_next_of_the_site(
    clinic: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data, lake = clinic("BERN", "keyboard"), tmp_path / "lake"
    moves, rename = iter(range(5)), Path.rename

    def move(path: Path, to: Path) -> Path:
        if next(moves, None) is None:
            raise KeyboardInterrupt
        return rename(path, to)

    with monkeypatch.context() as stopping:
        stopping.setattr(Path, "rename", move)
        with pytest.raises(KeyboardInterrupt):
            leave(data, lake)
    assert not list(lake.glob("sessions/*/*/*.parquet")), "only some tables were moved"
    assert leave(data, lake).problems == []
    assert query(lake, "sessions", "count(*)") == [(1,)]
    assert not list(lake.glob(".site=*"))


def test_another_database_of_the_same_site_does_not_replace_its_data(
    clinic: Any, tmp_path: Path
) -> None:
    lake, data = tmp_path / "lake", clinic("BERN", "keyboard")
    leave(data, lake)
    data.rename(tmp_path / "first")
    with pytest.raises(
        ExportError, match="1 session of the site BERN that this database does not have"
    ):
        leave(clinic("BERN", "keyboard"), lake)
    assert query(lake, "sessions", "count(*)") == [(1,)]


def test_every_table_holds_what_the_export_as_csv_holds(
    catalogue: Catalogue, tmp_path: Path
) -> None:
    data = tmp_path / "data"
    store_study(data, catalogue)
    leave(data, tmp_path / "lake", with_notes=True)
    export_csv(data, tmp_path / "csv", with_notes=True)
    for path in sorted((tmp_path / "csv").glob("*.csv")):
        table, rows = (
            f"'{tmp_path}/lake/{path.stem}/**/*.parquet'",
            read_csv(tmp_path / "csv", path.stem),
        )
        types = dict(
            duckdb.sql(
                f"SELECT column_name, column_type FROM (DESCRIBE SELECT * FROM {table})"
            ).fetchall()
        )
        names = [name for name in types if rows and name in rows[0] and name != "site"]
        if not rows:
            assert duckdb.sql(f"SELECT count(*) FROM {table}").fetchall() == [(0,)]
            continue
        read = ", ".join(
            f"timezone('UTC', \"{name}\")" if "ZONE" in types[name] else f'"{name}"'
            for name in names
        )
        found = duckdb.sql(f"SELECT {read} FROM {table}").fetchall()
        assert sorted(repr(tuple(map(_plain, row))) for row in found) == sorted(
            repr(tuple(_time(row[name]) if "ZONE" in types[name] else row[name] for name in names))
            for row in rows
        )


def _plain(value: object) -> object:
    """Return a value as an export as CSV has it, where an empty text is missing."""
    return None if value == "" else value


def _time(text: str | None) -> datetime | None:
    return datetime.fromisoformat(text).replace(tzinfo=None) if text else None


def test_a_value_of_another_type_is_named_and_the_rest_leaves(clinic: Any, tmp_path: Path) -> None:
    data = clinic("BERN", "keyboard")
    with closing(connect(data)) as database:
        database.execute(
            "UPDATE trials SET onset_ns='later', timing=json_set(timing, '$.loop_lag_ms', 'x') "
            "WHERE trial=2"
        )
    exported = leave(data, tmp_path / "lake")
    assert [sentence.split(": ")[-1] for sentence in exported.problems] == [
        f"what is stored in {name} is damaged, and left out."
        for name in ("onset_ns", "loop_lag_ms")
    ]
    rows = query(tmp_path / "lake", "trials", "onset_ns, loop_lag_ms, stimulus", "WHERE trial=2")
    assert rows[0][:2] == (None, None)
    assert rows[0][2]
    assert query(tmp_path / "lake", "trials", "count(onset_ns), count(*)")[0] == (19, 20)


def test_months_follow_shifted_dates(clinic: Any, tmp_path: Path) -> None:
    lake = tmp_path / "lake"
    leave(clinic("BERN", "keyboard"), lake, recode=tmp_path / "map.csv")
    rows = query(
        lake, "sessions", "month, strftime(started_at, '%Y-%m'), timezone('UTC', started_at)"
    )
    assert all(month == f"{began:%Y-%m}" for month, _, began in rows)
    ((code,),) = duckdb.sql(
        f"SELECT participant FROM '{lake}/participants/**/*.parquet'"
    ).fetchall()
    assert code != "P01"


def test_without_the_package_one_sentence_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(ExportError, match=r"pip install -e '\.\[lake\]'"):
        ParquetFormat()


def test_the_query_of_the_page_gives_what_the_databases_hold(
    clinic: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = []
    for site, tasks in (("BERN", ("keyboard", "reaching")), ("ULM", ("keyboard", "pairs"))):
        data = clinic(site, *tasks)
        leave(data, tmp_path / "lake")
        with closing(connect(data)) as database:
            expected += [
                (site, *row)
                for row in database.execute(
                    "SELECT participant, count(*), avg(reaction_time_ms) FROM trials JOIN "
                    "sessions ON id=session"
                    " JOIN seats USING (session, seat) LEFT JOIN attempts USING (session, "
                    "attempt, seat)"
                    " WHERE task='keyboard' AND trials.correct AND NOT practice GROUP BY 1"
                )
            ]
    monkeypatch.chdir(tmp_path)
    found = duckdb.sql(PAGE.partition("```sql\n")[2].partition("```")[0]).fetchall()
    assert [row[:3] for row in found] == [row[:3] for row in expected]
    assert [row[3] for row in found] == [pytest.approx(row[3]) for row in expected]
    for script in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL):
        exec(script, {})
