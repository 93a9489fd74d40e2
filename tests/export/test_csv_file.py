"""Cells of CSV files: no spreadsheet computes a text, and no terminal obeys it."""

import csv
import io
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import sar_tui
from sar_tui.export.csv_file import CsvWriter, cell
from sar_tui.export.formats.bids import tsv
from tests.export.exported import read_csv
from tests.program import Call
from tests.store.by_hand import insert

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
    insert(tmp_path / "data", "notes", session=simulated, at_ns=1, author="x", text=ATTACK)
    for form in ("csv", "psych-ds", "bids"):
        words = f"export --all --simulated --with-notes --format {form} --to"
        assert call(words, tmp_path / form).code == 0
    (note,) = [row for row in read_csv(tmp_path / "csv", "notes") if "HYPERLINK" in row["text"]]
    assert note["text"] == "'" + ATTACK.replace("\x1b", "␛").replace("\x07", "␇")
    for path in tmp_path.rglob("*.[ct]sv"):
        text = path.read_text(encoding="utf-8")
        assert [sign for sign in ("\x1b", "\t=HYPER", ',"=HYPER') if sign in text] == []


def test_a_tsv_has_the_same_care() -> None:
    assert tsv.text("=1+1") == "'=1+1"
    assert tsv.text("a\tb") == "a\\tb"
    assert tsv.text("a\x1bb") == "a␛b"


def test_there_is_one_writer_of_csv() -> None:
    package = Path(sar_tui.__file__).parent
    writes = re.compile("csv.writer|DictWriter")
    users = [path for path in package.rglob("*.py") if writes.search(path.read_text("utf-8"))]
    assert users == [package / "export" / "csv_file.py"]
