"""Nobody's true date follows from a recoded export, for somebody who knows the machine's clock or
the order of enrolment.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from random import Random
from types import SimpleNamespace

import pytest

from sar_tui.export import recoding
from sar_tui.export.registry import BUNDLED
from tests.examples import first
from tests.export.date_attacks import clock_readings, identified_by_order, written
from tests.export.exported import export_as, read_csv
from tests.export.test_recoding import read_map
from tests.export.thirty_people import BOOT, MANY, Study, store_people
from tests.store.by_hand import sql

_FEW = 6
_BY_CHANCE = 5
"""So many of thirty, and more, are guessed right in one of 270 random orders."""


@pytest.fixture(scope="module")
def patch() -> Iterator[pytest.MonkeyPatch]:
    with pytest.MonkeyPatch.context() as patched:
        yield patched


@pytest.fixture(scope="module", params=first(1, [_FEW, MANY]))
def study(
    request: pytest.FixtureRequest,
    tmp_path_factory: pytest.TempPathFactory,
    patch: pytest.MonkeyPatch,
) -> Study:
    return store_people(tmp_path_factory.mktemp("study") / "data", patch, request.param)


@pytest.fixture(autouse=True)
def _seeded(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let codes, shifts, keys and orders be the same in each run of the tests."""
    random = Random(9)
    same = {
        "choice": random.choice,
        "randbelow": random.randrange,
        "token_hex": lambda n: random.randbytes(n).hex(),
    }
    monkeypatch.setattr(recoding, "secrets", SimpleNamespace(**same, SystemRandom=lambda: random))


_ORDERS = ("order of rows in sessions", "order of rows in participants", "order of rows in trials",
           "sessions of the manifest", "sessions of timing.json")  # fmt: skip
_VERSIONS = ("sessions.sar_tui", "sessions.python", "sessions.numpy", "sessions.loop_rules", "sessions.task_sha256",
             "sessions.theme_sha256", "sessions.terminal", "runs.python", "runs.utc_offset_s")  # fmt: skip


def test_the_order_of_enrolment_identifies_everybody_in_an_export_as_it_is_and_nobody_in_a_recoded_one(
    study: Study, tmp_path: Path
) -> None:
    export_as("csv", study.data, tmp_path / "plain", with_events=True)
    found = identified_by_order(tmp_path / "plain", study.began)
    assert {found[name] for name in _ORDERS} == {len(study.began)}
    by_version = [found.get(f"order of {name}", 0) for name in _VERSIONS]
    assert len(study.began) < MANY or min(by_version) > _BY_CHANCE
    export_as("csv", study.data, tmp_path / "out", with_events=True, recode=tmp_path / "map.csv")
    codes = {code: random for code, (random, _) in read_map(tmp_path / "map.csv").items()}
    true = {codes[code]: moment for code, moment in study.began.items()}
    found = identified_by_order(tmp_path / "out", true)
    assert len(codes) < MANY or not {f"order of {name}" for name in _VERSIONS} & found.keys()
    chance = min(_BY_CHANCE, len(codes) - 1)
    assert {name: number for name, number in found.items() if number > chance} == {}


def test_stamps_in_a_recoded_export_count_from_the_start_of_each_session(
    study: Study, tmp_path: Path
) -> None:
    """One that counted from another person's would tell the days between the two."""
    export_as("csv", study.data, tmp_path / "out", with_events=True, recode=tmp_path / "map.csv")
    units = {"_ns": 10**9, "_ms": 10**3, "details_seen_at": 10**9}
    for path in (tmp_path / "out").glob("*.csv"):
        for row in read_csv(tmp_path / "out", path.stem):
            for column, number in row.items():
                unit = next((unit for end, unit in units.items() if column.endswith(end)), None)
                if unit and isinstance(number, int | float):
                    assert abs(number) < 3600 * unit, (path.stem, column, number)


@pytest.mark.parametrize("format", first(2, BUNDLED))
def test_no_file_of_a_recoded_export_holds_a_reading_of_the_clock_a_true_date_or_a_name(
    study: Study, tmp_path: Path, format: str
) -> None:
    export_as(format, study.data, tmp_path / "out", with_events=True, recode=tmp_path / "map.csv")
    query = "SELECT id FROM sessions UNION SELECT seed FROM sessions UNION SELECT id FROM records"
    ids = {str(id) for (id,) in sql(study.data, query)}
    true = [moment.isoformat()[:19] for moment in study.began.values()]
    true += [str(int(moment.timestamp() + 0.25)) for moment in study.began.values()]
    for name, text in written(tmp_path / "out"):
        assert clock_readings(text) == [], name
        names = set(re.findall(r"[\w.:+-]+", f"{name} {text}".replace("_", " ")))
        assert names & {*ids, *study.began, BOOT} == set(), name
        assert [each for each in true if each in text] == [], name
    times = {path.stat().st_mtime_ns for path in [tmp_path / "out", *(tmp_path / "out").rglob("*")]}
    assert len(times) == 1 or format == "parquet"


def test_a_plain_export_holds_readings_of_the_clock(study: Study, tmp_path: Path) -> None:
    """Otherwise nothing could be found in a recoded one."""
    export_as("csv", study.data, tmp_path / "out", with_events=True)
    held = {name for name, text in written(tmp_path / "out") if clock_readings(text)}
    assert {f"{table}.csv" for table in "actions events imu runs trials".split()} <= held
    seen = [str(int(moment.timestamp() + 0.25)) for moment in study.began.values()]
    trials = (tmp_path / "out" / "trials.csv").read_text("utf-8")
    assert [each for each in seen if each not in trials] == []
