"""Trials that leave equal those of the database, to the last digit, whichever format they leave
in.
"""

import json
import math
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.export.csv_file import cell
from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.examples import examples
from tests.export import mat_files
from tests.export.exported import export_as, read_csv
from tests.export.varied import store_trials, varied
from tests.needs_statistics import needs_octave

Read = Callable[[Path], list[dict[str, Any]]]


def from_csv(folder: Path) -> list[dict[str, Any]]:
    return read_csv(folder, "trials")


def from_mat(folder: Path) -> list[dict[str, Any]]:
    return mat_files.rows(folder, "trials", mat_files.with_scipy)


def from_mat_by_octave(folder: Path) -> list[dict[str, Any]]:
    return mat_files.rows(folder, "trials", mat_files.with_octave)


WRITTEN: dict[Read, Callable[[Any], Any]] = {from_csv: cell}
"""Values as a format writes them, if not as they are."""
KEY = ("session", "attempt", "trial", "seat")
PLAIN = (*KEY, *"run stimulus response correct onset_ns response_ns reaction_time_ms".split())


def stored_trials(data: Path) -> list[dict[str, Any]]:
    """Return all trials as the program reads them, sorted by their key, an empty text as
    missing.
    """
    with closing(connect(data)) as database:
        ids = [id for (id,) in database.execute("SELECT id FROM sessions")]
        rows = [row for id in ids for row in sessions.rows(database, "trials", id)]
    return _sorted(rows)


def _sorted(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return sorted(rows, key=lambda row: [row[name] for name in KEY])


def assert_equal_to_the_database(data: Path, trials: list[dict[str, Any]], read: Read) -> None:
    def shown(value: Any) -> Any:
        return None if value == "" else WRITTEN.get(read, lambda same: same)(value)

    for row, stored in zip(_sorted(trials), stored_trials(data), strict=True):
        timing, details = stored["timing"] or {}, stored["details"] or {}
        expected = {name: shown(stored[name]) for name in PLAIN}
        expected |= {name: shown(value) for name, value in timing.items()}
        expected["flags"] = " ".join(timing.get("flags", ())) or None
        expected |= dict.fromkeys(name for name in row if name.startswith("details_"))
        expected |= {f"details_{name}": shown(value) for name, value in details.items()}
        assert {name: row[name] for name in expected} == expected


@needs_octave
def test_trials_of_played_sessions(tmp_path: Path) -> None:
    varied(tmp_path / "data")
    for format, read in {"csv": from_csv, "mat": from_mat_by_octave}.items():
        export_as(format, tmp_path / "data", tmp_path / format)
        assert_equal_to_the_database(tmp_path / "data", read(tmp_path / format), read)


TEXT = st.text(
    st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=8
) | st.sampled_from(
    ['"', 'a "b", c', "¿Qué\r\ntal?", "\r", "\n", ",", ";", "=1+1", " ", "'", "NA", "null", "ñ, á",
     "\u2028", "true", "🙂"]
)  # fmt: skip
REAL = (
    st.none()
    | st.floats(allow_nan=False, allow_infinity=True)
    | st.sampled_from([0.1 + 0.2, 5e-324, 1e22, -0.0])
)
WHOLE = st.integers(-(2**63) + 1, 2**63 - 1)
TRIAL = st.fixed_dictionaries(
    {
        "stimulus": TEXT,
        "response": st.none() | TEXT,
        "correct": st.sampled_from([0, 1]),
        "onset_ns": st.none() | WHOLE,
        "response_ns": st.none() | WHOLE,
        "reaction_time_ms": REAL,
        "details": st.none()
        | st.just("null")
        | st.fixed_dictionaries(
            {
                "choices": st.integers(1, 9),
                "key_gap_ms": st.none() | st.floats(allow_nan=False, allow_infinity=False),
            }
        ).map(json.dumps),
    }
)


@pytest.mark.parametrize(
    ("format", "read"), [("csv", from_csv), ("mat", from_mat)], ids=["csv", "mat"]
)
@given(rows=st.lists(TRIAL, max_size=5))
@examples(200)
def test_odd_texts_and_numbers(
    tmp_path_factory: Any, format: str, read: Read, rows: list[dict[str, Any]]
) -> None:
    place = tmp_path_factory.mktemp("odd")
    store_trials(place / "data", rows)
    export_as(format, place / "data", place / "out")
    for row in rows:
        if row["reaction_time_ms"] is not None and not math.isfinite(row["reaction_time_ms"]):
            row["reaction_time_ms"] = None  # of an earlier version, and read as no result
    found = read(place / "out")
    assert_equal_to_the_database(place / "data", found, read)
    written = WRITTEN.get(read, lambda same: same)
    assert [row["stimulus"] for row in found] == [written(row["stimulus"]) or None for row in rows]
