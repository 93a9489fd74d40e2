"""Attacks on shifted dates: what somebody finds out who has an export, and knows in which order all
people trained, or what their machine's clock read.
"""

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

import pyarrow.parquet
import scipy.io

from tests.export.exported import read_csv
from tests.export.thirty_people import UPTIME_NS

UNITS = {"ns": 1e9, "us": 1e6, "ms": 1e3, "s": 1.0}
_DATES = ("created_at", "started_at", "ended_at", "clock_utc", "at", "recorded_at", "onset")
_NUMBER = re.compile(r"(?<![\w.+-])-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?(?![\w.])")
Guesses = Mapping[str, datetime]
"""The guessed dates of people, by their codes in the export."""


def identified_by_order(folder: Path, true: Mapping[str, datetime]) -> dict[str, int]:
    """Return how many people's dates are guessed to the day, by what may be in the order of
    enrolment.

    Args:
        true: the dates in the order of enrolment, by the codes of people in the export.
    """
    return {
        what: sum(guess.date() == true[code].date() for code, guess in guesses.items())
        for what, guesses in _by_order(folder, list(true.values()))
    }


def _by_order(folder: Path, enrolled: Sequence[datetime]) -> Iterator[tuple[str, Guesses]]:
    """Yield guesses by what may be in the order of enrolment: rows, names, ids, seeds, versions."""

    def in_order(codes: Iterable[str]) -> Guesses:
        return dict(zip(dict.fromkeys(codes), enrolled, strict=False))

    for table, rows in _tables(folder):
        yield f"order of rows in {table}", in_order(row["participant"] for row in rows)
        for column in rows[0] if rows else ():
            given = [row for row in rows[::-1] if row[column] is not None]
            values = {row["participant"]: row[column] for row in given}
            if column not in ("participant", *_DATES) and len(set(values.values())) > 1:
                ranks = {code: (str(type(each)), each, code) for code, each in values.items()}
                yield f"order of {table}.{column}", in_order(sorted(values, key=ranks.__getitem__))
    people = _people(folder)
    manifest = json.loads((folder / "sar-tui-export.json").read_text("utf-8"))
    timing = json.loads((folder / "timing.json").read_text("utf-8"))
    measured = [session for each in timing["passports"] for session in each["sessions"]]
    for name, found in (("the manifest", manifest["sessions"]), ("timing.json", measured)):
        yield f"sessions of {name}", in_order(people[each] for each in found if each in people)


def _people(folder: Path) -> dict[str, str]:
    """Return the participants by their sessions."""
    return {row["session"]: row["participant"] for row in read_csv(folder, "sessions")}


def _tables(folder: Path) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    """Yield each table with the participant of each row."""
    people = _people(folder)
    for path in sorted(folder.glob("*.csv")):
        rows = read_csv(folder, path.stem)
        owners = [row.get("participant") or people[row["session"]] for row in rows]
        yield path.stem, [row | {"participant": who} for row, who in zip(rows, owners, strict=True)]


def written(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield the name of each file with all that is in it as text, whatever its format."""
    for path in sorted(folder.rglob("*")):
        if path.suffix == ".parquet":
            text = json.dumps(
                pyarrow.parquet.read_table(path).to_pylist(), default=lambda each: each.isoformat()
            )
        elif path.suffix == ".mat":
            text = f"{path.read_bytes()[:116]!r} {' '.join(_flat(scipy.io.loadmat(path)))}"
        else:
            text = path.read_text("utf-8") if path.is_file() else ""
        yield path.relative_to(folder).as_posix(), text


def _flat(value: Any) -> Iterator[str]:
    if isinstance(value, dict):
        for each in value.values():
            yield from _flat(each)
    elif hasattr(value, "dtype") and value.dtype.names:
        for name in value.dtype.names:
            yield from _flat(value[name])
    elif hasattr(value, "ravel"):
        for each in value.ravel():
            yield from _flat(each) if hasattr(each, "ravel") and each.shape else (str(each),)
    else:
        yield str(value)


def clock_readings(text: str) -> list[str]:
    """Return the numbers in a text that read as the machine's clock during the study, in any unit.

    In ms and s only fractions do: other numbers are as large.
    """

    def reads(number: str) -> bool:
        value = float(number)
        units = ("ns", "us") if value.is_integer() else UNITS
        return any(_is_reading(value, UNITS[unit]) for unit in units)

    return [number for number in _NUMBER.findall(text) if reads(number)]


def _is_reading(number: float, a_second: float) -> bool:
    return UPTIME_NS / 1e9 <= number / a_second < UPTIME_NS / 1e9 + 120 * 86_400
