"""Kinds of record are read from files, and hold values to what they declare."""

import math
from pathlib import Path

import pytest

from sar_tui.records import kind as kinds_room
from sar_tui.records.kind import (
    SHIPPED,
    Field,
    Kind,
    KindError,
    RecordError,
    find,
    kinds,
    read_kind,
    unusable_files,
)

GRIP = """
name = "grip"
title = "Grip strength"
once_a_day = true
source = "Our own clinic."

[[fields]]
name = "force"
title = "Force"
type = "number"
lowest = 0
highest = 90
unit = "kg"
better = "higher"
"""


def test_the_kinds_that_ship_say_who_enters_them_and_on_what_terms() -> None:
    shipped = [read_kind(path) for path in sorted(SHIPPED.glob("*.toml"))]
    assert {"adverse-event", "pain", "tiredness", "answer", "FMA-UE"} <= {
        each.name for each in shipped
    }
    assert [each.name for each in shipped if not each.licence] == []


def test_a_clinic_adds_a_kind_by_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kinds_room, "own_folder", lambda: tmp_path)
    assert "grip" not in kinds()
    kinds_room._read_folder.cache_clear()
    (tmp_path / "grip.toml").write_text(GRIP, encoding="utf-8")
    assert find("GRIP").score == find("grip").fields[0]
    assert "pain" in kinds()


def test_a_file_that_cannot_be_used_hides_no_other_kind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kinds_room, "own_folder", lambda: tmp_path)
    kinds_room._read_folder.cache_clear()
    (tmp_path / "grip.toml").write_text(GRIP, encoding="utf-8")
    (tmp_path / "Pain.toml").write_text('name = "pain', encoding="utf-8")
    assert {"grip", "tiredness"} <= kinds().keys()
    (problem,) = unusable_files()
    assert problem.startswith("Pain.toml, line 1: This is not valid TOML")
    assert find("grip").name == "grip"
    for name in ("pain", "nothing"):
        with pytest.raises(KindError, match=r"Pain\.toml, line 1"):
            find(name)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("name = 1", "line 1: This must be a text, in quotes."),
        (GRIP.replace('"number"', '"colour"'), "line 10: Invalid enum value 'colour'."),
        (GRIP + "\nfoo = 1", "line 16: There is nothing named foo here."),
        (GRIP.replace('"number"', '"choice"'), "needs two labels"),
        (GRIP.replace("lowest = 0", "lowest = 99"), "bounds that no number lies within"),
        (GRIP.replace('"Force"', '"Fo\\u001brce"'), "control characters: U+001B"),
        (GRIP + GRIP[GRIP.index("[[") :], "Two fields are named 'force'"),
        ('name = "x"\ntitle = "y"\nfields = []', "A kind has a name"),
    ],
)
def test_a_file_that_cannot_be_used_is_named_with_the_reason(
    tmp_path: Path, text: str, says: str
) -> None:
    (tmp_path / "own.toml").write_text(text, encoding="utf-8")
    with pytest.raises(KindError, match=r"own\.toml") as refused:
        read_kind(tmp_path / "own.toml")
    assert says in str(refused.value)


NUMBER = Field(name="n", title="Force", type="number", lowest=0, highest=90, unit="kg")
WHOLE = Field(name="n", title="Pain", type="integer", lowest=0, highest=10)
CHOICE = Field(name="n", title="Severity", type="choice", labels=("mild", "moderate", "severe"))
TEXT = Field(name="n", title="Remark", type="text")


@pytest.mark.parametrize(
    ("field", "given", "stored"),
    [
        (NUMBER, "4,5", 4.5),
        (NUMBER, 90, 90),
        (WHOLE, "3", 3),
        (CHOICE, " Mild ", "mild"),
        (TEXT, " seated\n", "seated"),
    ],
)
def test_values_are_stored_in_one_form(field: Field, given: str | float, stored: object) -> None:
    assert field.read(given) == stored


@pytest.mark.parametrize(
    ("field", "given", "says"),
    [
        (NUMBER, "much", "Force is a number, not 'much'."),
        (NUMBER, 91, "Force lies within 0 to 90 kg, not at 91."),
        (NUMBER, math.nan, "Force lies within 0 to 90 kg, not at nan."),
        (WHOLE, 2.5, "Pain is a whole number, not 2.5."),
        (CHOICE, "awful", "Severity is mild, moderate or severe, not 'awful'."),
        (TEXT, "x" * 2001, "Remark is too long: at most 2000 characters."),
        (TEXT, "a\x1b[2J", "Remark has control characters: U+001B."),
        (TEXT, "a\udc80b", "Remark has bytes that are not UTF-8."),
        (TEXT, "  ", "Remark is missing."),
    ],
)
def test_what_cannot_be_is_refused(field: Field, given: str | float, says: str) -> None:
    with pytest.raises(RecordError) as refused:
        field.read(given)
    assert (str(refused.value), refused.value.field) == (says, "n")


def test_a_record_has_the_fields_of_its_kind_and_no_others() -> None:
    kind = Kind(name="grip", title="Grip", fields=(NUMBER,))
    assert kind.read({"n": "3"}) == {"n": 3.0}
    with pytest.raises(RecordError, match=r"grip has no field m\. It has: n\."):
        kind.read({"m": 3})
