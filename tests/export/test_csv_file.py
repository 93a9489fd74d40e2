"""Cells of CSV files: no spreadsheet computes a text, and no terminal obeys it."""

import csv
import io
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import sar_tui
from sar_tui.export.csv_file import CsvWriter, cell
from sar_tui.export.formats.bids import tsv
from tests.export.exported import read_csv
from tests.program import Call

ATTACK = '=HYPERLINK("http://127.0.0.1/?"&A1,"x")\x1b]0;title\x07'


@pytest.mark.parametrize(
    "text", ["=1+1", "+A1", "-1+1", "@SUM(A1)", "\t=1", "\r=1", '=cmd|" /C calc"!A0']
)
def test_a_text_that_a_spreadsheet_would_compute_begins_with_an_apostrophe(text: str) -> None:
    assert cell(text)[0] == "'"


@pytest.mark.parametrize(
    "value",
    [-1, -0.5, None, True, "P01", "a-b", "-", "-0.5", "+", "=", "", "two\nlines", "ñ", '{"a": 1}'],
)
def test_numbers_and_other_texts_stay_as_they_are(value: object) -> None:
    assert cell(value) == value


@given(st.text())
def test_every_text_is_one_cell_without_control_characters(text: str) -> None:
    file = io.StringIO(newline="")
    CsvWriter(file).row([text, "end"])
    file.seek(0)
    ((read, end),) = csv.reader(file)
    assert (read, end) == (cell(text), "end")
    assert not set(read.replace("\r\n", "")) & {
        chr(code) for code in (*range(0x09), *range(0x0B, 0x20), 0x7F, 0x9B)
    }
    assert len(read) == 1 or not read.startswith(tuple("=+-@\t\r")) or float(read)


def test_typed_formulas_leave_as_text_in_all_formats(
    call: Call, simulated: str, tmp_path: Path
) -> None:
    with closing(sqlite3.connect(tmp_path / "data" / "sar-tui.db")) as database, database:
        database.execute(
            "INSERT INTO notes (session, at_ns, author, text) VALUES (?, 1, 'x', ?)",
            (simulated, ATTACK),
        )
    for form in ("csv", "psych-ds", "bids"):
        words = ("--simulated", "--with-notes", "--format", form, "--to", tmp_path / form)
        assert call("export", simulated, *words).code == 0
    (note,) = [row for row in read_csv(tmp_path / "csv", "notes") if "HYPERLINK" in row["text"]]
    assert note["text"] == "'" + ATTACK.replace("\x1b", "␛").replace("\x07", "␇")
    for path in tmp_path.rglob("*.[ct]sv"):
        text = path.read_text(encoding="utf-8")
        assert "\x1b" not in text
        assert "\t=HYPER" not in text
        assert ',"=HYPER' not in text


def test_a_tsv_has_the_same_care() -> None:
    assert tsv.text("=1+1") == "'=1+1"
    assert tsv.text("a\tb") == "a\\tb"
    assert tsv.text("a\x1bb") == "a␛b"


def test_there_is_one_writer_of_csv() -> None:
    package = Path(sar_tui.__file__).parent
    users = [
        path.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        if "csv.writer" in path.read_text(encoding="utf-8")
        or "DictWriter" in path.read_text(encoding="utf-8")
    ]
    assert users == ["export/csv_file.py"]
