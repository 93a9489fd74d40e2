"""Nobody's true date follows from a recoded export, for somebody who knows true dates or the order
of enrolment.
"""

import re
from collections.abc import Iterator, Mapping
from itertools import chain
from pathlib import Path
from random import Random
from types import SimpleNamespace
from typing import NamedTuple

import pytest

from sar_tui.export import recoding
from sar_tui.export.registry import BUNDLED
from tests.examples import first
from tests.export.date_attacks import (
    KNOWN,
    by_clocks,
    by_files,
    by_order,
    by_times_of_day,
    clock_readings,
    identified,
    written,
)
from tests.export.exported import csv_of, export_as
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


class Found(NamedTuple):
    """Numbers of people that attacks identify, by what they use."""

    by_clocks: dict[str, int]
    by_order: dict[str, int]


def attacked(study: Study, folder: Path, codes: Mapping[str, str]) -> Found:
    """Return what each attack on an export finds.

    Args:
        codes: as they leave, by those of the study.
    """
    true = {codes[code]: moment for code, moment in study.began.items()}
    known = dict(list(true.items())[:KNOWN])
    clocks = chain(by_clocks(folder, known), by_times_of_day(folder, known))
    orders = by_order(folder, list(true.values()))
    return Found(
        {what: identified(guesses, true, known) for what, guesses in clocks},
        {what: identified(guesses, true) for what, guesses in orders},
    )


def recoded(path: Path) -> dict[str, str]:
    return {code: random for code, (random, _) in read_map(path).items()}


def test_attacks_identify_everybody_in_an_export_as_it_is(study: Study, tmp_path: Path) -> None:
    export_as("csv", study.data, tmp_path / "out", with_events=True)
    found, many = (
        attacked(study, tmp_path / "out", {code: code for code in study.began}),
        len(study.began),
    )
    assert {found.by_clocks[name] for name in _CLOCKS} == {many - KNOWN}
    assert {found.by_order[name] for name in _ORDERS} == {many}
    by_version = {name: found.by_order.get(f"order of {name}", 0) for name in _VERSIONS}
    assert many < MANY or min(by_version.values()) > _BY_CHANCE


_CLOCKS = ("runs.clock_ns beside a known date", "runs.clock_ns in ns", "trials.onset_ns in ns", "events.at_ns in ns",
           "trials.frame_onsets_ns in ns", "trials.details_seen_at in ns", "trials.details_seen_s in s",
           "trials.data_made_ns in ns", "actions.proposed_ns in ns")  # fmt: skip
_ORDERS = ("order of rows in sessions", "order of rows in participants", "order of rows in trials",
           "sessions of the manifest", "sessions of timing.json")  # fmt: skip


_VERSIONS = ("sessions.sar_tui", "sessions.python", "sessions.numpy", "sessions.loop_rules", "sessions.task_sha256",
             "sessions.theme_sha256", "sessions.terminal", "runs.python", "runs.utc_offset_s")  # fmt: skip


def test_no_attack_identifies_anybody_in_a_recoded_export(study: Study, tmp_path: Path) -> None:
    export_as("csv", study.data, tmp_path / "out", with_events=True, recode=tmp_path / "map.csv")
    codes = recoded(tmp_path / "map.csv")
    found = attacked(study, tmp_path / "out", codes)
    assert {name: number for name, number in found.by_clocks.items() if number} == {}
    versions = {f"order of {name}" for name in _VERSIONS} & found.by_order.keys()
    assert len(codes) < MANY or not versions
    chance = min(_BY_CHANCE, len(codes) - 1)
    assert {name: number for name, number in found.by_order.items() if number > chance} == {}


@pytest.mark.parametrize("format", BUNDLED)
def test_no_file_of_a_recoded_export_holds_a_reading_of_the_clock_or_a_name(
    study: Study, tmp_path: Path, format: str
) -> None:
    export_as(format, study.data, tmp_path / "out", with_events=True, recode=tmp_path / "map.csv")
    query = "SELECT id FROM sessions UNION SELECT seed FROM sessions UNION SELECT id FROM records"
    ids = {str(id) for (id,) in sql(study.data, query)}
    true = [moment.isoformat()[:19] for moment in study.began.values()]
    for name, text in written(tmp_path / "out"):
        assert clock_readings(text) == [], name
        names = set(re.findall(r"[\w.:+-]+", f"{name} {text}".replace("_", " ")))
        assert names & {*ids, *study.began, BOOT} == set(), name
        assert [each for each in true if each in text] == [], name


@pytest.mark.parametrize("format", ["mat", "elan", "bids"])
def test_names_and_times_of_files_tell_no_order(study: Study, tmp_path: Path, format: str) -> None:
    for recode in (None, tmp_path / "map.csv"):
        folder = tmp_path / f"{format} {recode is None}"
        export_as(format, study.data, folder, recode=recode)
        rows = csv_of(study.data, "sessions", recode=recode)
        people = {row["session"]: row["participant"] for row in rows}
        codes = recoded(recode) if recode else {code: code for code in study.began}
        true = {codes[code]: moment for code, moment in study.began.items()}
        guesses = by_files(folder, people, list(true.values()))
        found = {what: identified(each, true) for what, each in guesses}
        if recode:
            assert max(found.values()) <= min(_BY_CHANCE, len(codes) - 1)
            assert len({path.stat().st_mtime_ns for path in [folder, *folder.rglob("*")]}) == 1
        else:
            assert found["times of files"] == len(codes)
