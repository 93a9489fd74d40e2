"""Parquet files of many sites are one data set, and hold what the databases hold, as DuckDB reads
them.
"""

import re
from contextlib import closing
from datetime import datetime
from pathlib import Path
from typing import Any

import duckdb
import pytest
from pyarrow import parquet

from sar_tui.export.errors import ExportError
from sar_tui.export.export import Exported
from sar_tui.export.formats.parquet import ROWS
from sar_tui.store import sites
from sar_tui.store.database import connect
from tests.export.exported import export_as, export_csv, read_csv
from tests.export.hard_study import store_study
from tests.played import simulated
from tests.store.by_hand import sql, value

PAGE = (Path(__file__).parents[2] / "docs" / "many-sites.md").read_text(encoding="utf-8")


def leave(data: Path, lake: Path, **options: Any) -> Exported:
    """Export the sessions of a data folder as Parquet."""
    return export_as("parquet", data, lake, **options)


def query(lake: Path, table: str, what: str = "*", rest: str = "") -> list[tuple[Any, ...]]:
    return duckdb.sql(f"SELECT {what} FROM '{lake}/{table}/**/*.parquet' {rest}").fetchall()


@pytest.fixture
def clinic(tmp_path: Path) -> Any:
    """Make the data of a site: sessions of some tasks, each of the participant P01."""

    def make(site: str, *tasks: str) -> Path:
        for task in tasks:
            codes = ("P01", "P02") if task == "pairs" else ("P01",)
            simulated(tmp_path / site, task, *codes, user="poor", attempts=1)
        with closing(connect(tmp_path / site)) as database:
            sites.set_own(database, site)
        return tmp_path / site

    return make


def test_exports_of_many_sites_in_a_folder_are_one_data_set(clinic: Any, tmp_path: Path) -> None:
    lake = tmp_path / "lake"
    for site, tasks in {
        "BERN": ("keyboard", "reaching"),
        "ULM": ("pairs",),
        "JENA": ("keyboard",),
    }.items():
        leave(clinic(site, *tasks), lake)
    assert query(lake, "trials", "DISTINCT site, task", "ORDER BY ALL") == [
        ("BERN", "keyboard"), ("BERN", "reaching"), ("JENA", "keyboard"), ("ULM", "pairs"),
    ]  # fmt: skip
    people = query(lake, "trials", "DISTINCT site", "WHERE participant='P01' ORDER BY ALL")
    assert people == [("BERN",), ("JENA",), ("ULM",)]
    times = query(lake, "trials", "(details->>'reach_time_ms')::double", "WHERE task='reaching'")
    assert all(time > 0 for (time,) in times)
    for table in lake.iterdir():
        assert len({str(parquet.read_schema(path)) for path in table.rglob("*.parquet")}) <= 1
    (path,) = lake.glob("trials/site=JENA/*/trials-JENA-*.parquet")
    field = parquet.read_schema(path).field("reaction_time_ms")
    assert field.metadata[b"unit"] == b"ms"
    assert b"Missing for a miss" in field.metadata[b"meaning"]
    assert re.fullmatch(r"month=\d{4}-\d{2}", path.parent.name)


def test_rows_beyond_one_block_are_all_there(
    clinic: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.export.formats.parquet.ROWS", 7)
    data = clinic("BERN", "reaching")
    leave(data, tmp_path / "lake")
    samples = value(data, "SELECT sum(n) FROM imu_chunks")
    assert query(tmp_path / "lake", "imu", "count(*)") == [(samples,)]
    assert ROWS > 7


def test_a_database_without_a_code_is_local_until_it_has_one(tmp_path: Path) -> None:
    data, lake = tmp_path / "data", tmp_path / "lake"
    simulated(data, user="poor", attempts=1)
    for site in ("local", "BERN"):
        leave(data, lake)
        assert query(lake, "trials", "DISTINCT site, participant") == [(site, "P01")]
        with closing(connect(data)) as database:
            sites.set_own(database, "BERN")
    assert not list(lake.glob("*/site=local"))


def test_another_database_of_a_site_does_not_replace_its_data(clinic: Any, tmp_path: Path) -> None:
    lake, data = tmp_path / "lake", clinic("BERN", "keyboard")
    leave(data, lake)
    data.rename(tmp_path / "first")
    with pytest.raises(
        ExportError, match="1 session of the site BERN that this database does not have"
    ):
        leave(clinic("BERN", "keyboard"), lake)
    assert query(lake, "sessions", "count(*)") == [(1,)]


@pytest.mark.slow
def test_every_table_holds_what_csv_files_hold(tmp_path: Path) -> None:
    data, lake = tmp_path / "data", tmp_path / "lake"
    store_study(data)
    leave(data, lake, with_notes=True)
    export_csv(data, tmp_path / "csv", with_notes=True)
    for path in sorted((tmp_path / "csv").glob("*.csv")):
        table, rows = path.stem, read_csv(tmp_path / "csv", path.stem)
        described = duckdb.sql(f"DESCRIBE SELECT * FROM '{lake}/{table}/**/*.parquet'").fetchall()
        has_zone = {name: "ZONE" in kind for name, kind, *_ in described}
        if not rows:
            assert query(lake, table, "count(*)") == [(0,)]
            continue
        names = [name for name in has_zone if name in rows[0] and name != "site"]
        quoted = (
            f"timezone('UTC', \"{name}\")" if has_zone[name] else f'"{name}"' for name in names
        )
        found = query(lake, table, ", ".join(quoted))
        expected = [tuple(_time(row[n]) if has_zone[n] else row[n] for n in names) for row in rows]
        plain = [tuple(map(_plain, row)) for row in found]
        assert sorted(map(repr, plain)) == sorted(map(repr, expected))


def _plain(value: object) -> object:
    """Return a value as an export as CSV has it, where an empty text is missing."""
    return None if value == "" else value


def _time(text: str | None) -> datetime | None:
    return datetime.fromisoformat(text).replace(tzinfo=None) if text else None


def test_a_value_of_another_type_is_named_and_the_rest_leaves(clinic: Any, tmp_path: Path) -> None:
    data = clinic("BERN", "keyboard")
    odd = "onset_ns='later', timing=json_set(timing, '$.loop_lag_ms', 'x')"
    sql(data, f"UPDATE trials SET {odd} WHERE trial=2")
    problems = leave(data, tmp_path / "lake").problems
    assert [sentence.split(": ")[-1] for sentence in problems] == [
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
    for month, began in query(lake, "sessions", "month, timezone('UTC', started_at)"):
        assert month == f"{began:%Y-%m}"
    ((code,),) = query(lake, "participants", "participant")
    assert code != "P01"


def test_the_query_of_the_page_gives_what_the_databases_hold(
    clinic: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = []
    for site, tasks in (("BERN", ("keyboard", "reaching")), ("ULM", ("keyboard", "pairs"))):
        data = clinic(site, *tasks)
        leave(data, tmp_path / "lake")
        rows = sql(
            data,
            "SELECT participant, count(*), avg(reaction_time_ms) FROM trials JOIN sessions ON id=session"
            " JOIN seats USING (session, seat) LEFT JOIN attempts USING (session, attempt, seat)"
            " WHERE task='keyboard' AND trials.correct AND NOT practice GROUP BY 1",
        )
        expected += [(site, *row) for row in rows]
    monkeypatch.chdir(tmp_path)
    found = duckdb.sql(PAGE.partition("```sql\n")[2].partition("```")[0]).fetchall()
    assert [row[:3] for row in found] == [row[:3] for row in expected]
    assert [row[3] for row in found] == [pytest.approx(row[3]) for row in expected]
    for script in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL):
        exec(script, {})
