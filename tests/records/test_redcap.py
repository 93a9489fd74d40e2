"""Forms as REDCap's instruments, judged by its rules and by a schema of others, and read back."""

import contextlib
import csv
import io
import re
import zipfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from sar_tui.records import redcap
from sar_tui.records.kind import Kind, find, read_kind
from sar_tui.records.redcap import RedcapError, dictionary, instrument_zip, read
from tests.examples import examples

FORMS = ("SUS", "NASA-TLX", "effort", "fatigue", "pain-now")
HEAD = (
    "Variable / Field Name,Form Name,Section Header,Field Type,Field Label,"
    '"Choices, Calculations, OR Slider Labels",Field Note,'
    "Text Validation Type OR Show Slider Number,Text Validation Min,Text Validation Max,"
    "Identifier?,Branching Logic (Show field only if...),Required Field?,Custom Alignment,"
    "Question Number (surveys only),Matrix Group Name,Matrix Ranking?,Field Annotation"
)
"""The columns, as its help lists them."""
WORDS = st.text(
    st.characters(codec="utf-8", categories=("L", "N", "P", "Zs")), min_size=1, max_size=20
)


def table(content: bytes) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(content.decode("utf-8-sig"), newline="")))


def back(tmp_path: Path, content: bytes) -> Kind:
    """Return the only form of a file, as it is read here."""
    (tmp_path / "file").write_bytes(content)
    (found,) = read(tmp_path / "file")
    assert (found.refused, found.left_out) == ([], [])
    (tmp_path / "read.toml").write_text(found.declaration, encoding="utf-8")
    return read_kind(tmp_path / "read.toml")


def same(one: Kind, other: Kind, language: str = "en") -> bool:
    """Return True if two forms are the same but for the layout of their files, and words in other
    languages.
    """
    both = [each.in_language(language) for each in (one, other)]
    instructions = {each.instruction_in(language) for each in (one, other)}
    bare = [replace(each, words={}, form=None) for each in both]
    return bare[0] == bare[1] and len(instructions) == 1


# --- the rules of REDCap, as far as its documentation and its source say them


def broken_rules(rows: list[dict[str, str]]) -> list[str]:
    """Return what REDCap would refuse, a sentence each."""
    names = [row["Variable / Field Name"] for row in rows]
    said = [f"{name} twice" for name in set(names) if names.count(name) > 1]
    said += [
        f"{name} is no name" for name in names if not re.fullmatch("[a-z][a-z0-9_]{0,25}", name)
    ]
    for row in rows:
        type, choices = row["Field Type"], row["Choices, Calculations, OR Slider Labels"]
        name = row["Variable / Field Name"]
        if not re.fullmatch("[a-z][a-z0-9_]*", row["Form Name"]):
            said.append(f"{name}: form")
        if type not in ("text", "radio", "dropdown", "yesno", "truefalse", "slider", "calc"):
            said.append(f"{name}: type {type}")
        if type in ("radio", "dropdown"):
            codes = [choice.split(", ", 1)[0] for choice in choices.split(" | ")]
            if not all(re.fullmatch("-?[0-9]+", code) for code in codes) or len(set(codes)) < 2:
                said.append(f"{name}: choices {choices}")
        if type == "calc":
            known = set(re.findall(r"\[([a-z0-9_]+)\]", choices))
            if not known or not known <= set(names) or re.search('==|!=|&&|"', choices):
                said.append(f"{name}: calculation")
        if type in ("yesno", "truefalse") and choices:
            said.append(f"{name}: choices of its own")
        if not row["Field Label"].strip():
            said.append(f"{name}: no label")
    return said


@pytest.mark.parametrize("name", FORMS)
def test_an_instrument_keeps_the_rules_of_redcap(name: str) -> None:
    with zipfile.ZipFile(io.BytesIO(instrument_zip(find(name)))) as archive:
        assert sorted(archive.namelist()) == ["OriginID.txt", "instrument.csv"]
        content = archive.read("instrument.csv")
    assert content.decode("utf-8-sig").startswith(f"{HEAD}\r\n")
    rows = table(content)
    assert broken_rules(rows) == []
    assert len({row["Form Name"] for row in rows}) == 1
    assert "record_id" not in [row["Variable / Field Name"] for row in rows], "a zip has none"


@pytest.mark.parametrize("name", FORMS)
def test_an_instrument_fits_the_schema_of_others(name: str) -> None:
    """linkml-redcap describes the dictionary; its schema is read here without its own reader."""
    dictionaries = pytest.importorskip("linkml_redcap.data_dictionary")
    schema = dictionaries.schema_view()
    slots = schema.get_class("Field").attributes
    for row in table(dictionary(find(name))):
        assert len(row) == len(slots)
        for (column, value), (slot, rule) in zip(row.items(), slots.items(), strict=True):
            assert value or not rule.required, (column, slot)
            if value and rule.pattern:
                assert re.search(rule.pattern, value), (column, value)
            if value and (levels := schema.get_enum(rule.range) if rule.range else None):
                known = {*levels.permissible_values, "number"}
                assert value in known, (column, value)


# --- calculations


def calculated(expression: str, values: dict[str, int | str]) -> float | str:
    """Return what REDCap makes of a calculation, in which a blank makes all of it blank."""
    text = re.sub(r"\[([a-z0-9_]+)\]=''", lambda it: str(values[it[1]] == ""), expression)
    text = re.sub(r"\[([a-z0-9_]+)\]", lambda it: f"_[{it[1]!r}]", text)

    def mean(*given: Any) -> float:
        numbers = [each for each in given if each != ""]
        return sum(numbers) / len(numbers)

    text = re.sub(r"\bif\(", "choose(", text)
    names = {"_": {k: v if v != "" else Blank() for k, v in values.items()}, "mean": mean}
    result = eval(text, {"choose": lambda on, yes, no: yes if on else no, **names})
    return "" if isinstance(result, Blank) or result == "" else float(result)


class Blank(float):
    """An empty field: all that is computed with it is empty."""

    def _blank(self, *_: object) -> "Blank":
        return self

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __truediv__ = _blank  # type: ignore[assignment]


@given(st.lists(st.sampled_from([1, 2, 3, 4, 5, ""]), min_size=10, max_size=10))
def test_redcap_computes_the_same_usability(values: list[int | str]) -> None:
    sus = find("SUS")
    given = {f"sus_q{at}": value for at, value in enumerate(values, 1)}
    here = {f"q{at}": value for at, value in enumerate(values, 1) if value != ""}
    expected = sus.read(here).get("score", "") if here else ""
    assert calculated(table(dictionary(sus))[-1][redcap.CHOICES], given) == expected


def test_redcap_computes_the_same_mean_of_the_others(tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(OTHERS, encoding="utf-8")
    kind = read_kind(tmp_path / "own.toml")
    (score,) = (
        row[redcap.CHOICES] for row in table(dictionary(kind)) if row["Field Type"] == "calc"
    )
    for values in ((1, 2, 3), (7, "", 1), ("", "", 4), (7, 7, "")):
        given = {f"own_q{at}": value for at, value in enumerate(values, 1)}
        here = {f"q{at}": value for at, value in enumerate(values, 1) if value != ""}
        expected = kind.read(here).get("score", "")
        assert calculated(score, given) == (pytest.approx(expected) if expected else ""), values


OTHERS = """
name = "own"
title = "Own"
entered_by = "participant"
[form]
items = 3
lowest = 1
highest = 7
reversed = [2]
[[scores]]
rule = "sum"
missing = "others"
at_least = 2
subtract = 1
[words.en]
instruction = "Please answer."
items = ["a", "b", "c"]
"""


# --- there and back


@pytest.mark.parametrize("name", FORMS)
def test_a_form_comes_back_as_it_left(tmp_path: Path, name: str) -> None:
    kind = find(name)
    assert same(back(tmp_path, instrument_zip(kind)), kind)


def test_a_form_comes_back_in_its_language(tmp_path: Path) -> None:
    found = back(tmp_path, instrument_zip(find("effort"), "de"))
    assert found.title == "Anstrengung"
    assert found.items == find("effort").in_language("de").items


def _is_no_number(text: str) -> bool:
    return not text.lstrip("-").isdecimal()


def _item(number: int) -> st.SearchStrategy[dict[str, Any]]:
    label = WORDS.map(str.strip).filter(lambda text: text and "|" not in text)
    some = st.lists(label, min_size=2, max_size=9, unique_by=str.casefold)
    whole = st.integers(-5, 5)
    scale = st.builds(
        lambda low, count, step, ends: {
            "type": "integer", "lowest": low, "highest": low + (count - 1) * step, "step": step,
            **({"labels": ends} if ends else {}),
        },
        whole, st.integers(3, 11), st.integers(1, 5),
        st.one_of(st.just([]), st.lists(label.filter(_is_no_number), min_size=2, max_size=2)),
    )  # fmt: skip
    kinds = st.one_of(
        some.map(lambda labels: {"type": "choice", "labels": labels}),
        scale,
        st.just({"type": "text"}),
        st.just({"type": "number", "lowest": -2.5, "highest": 1000.0}),
        st.just({"type": "integer", "lowest": 0, "highest": 100, "labels": ["low", "high"]}),
        st.just({"type": "choice", "labels": ["Yes", "No"]}),
    )
    title = label.filter(lambda text: "[" not in text and "<" not in text and "&" not in text)
    return st.builds(
        lambda title, rest: {"name": f"i{number}", "title": title, **rest}, title, kinds
    )


@examples(60)
@given(st.tuples(*map(_item, range(4))))
def test_any_form_that_both_can_express_comes_back_as_it_left(
    tmp_path_factory: pytest.TempPathFactory, items: tuple[dict[str, Any], ...]
) -> None:
    folder = tmp_path_factory.mktemp("form")
    declared = {
        "name": "any", "title": "Any", "group": "form", "entered_by": "participant",
        "when": "When it was filled in", "has_time": True, "form": {}, "fields": list(items),
    }  # fmt: skip
    (folder / "any.toml").write_text(redcap.to_toml(declared), encoding="utf-8")
    kind = read_kind(folder / "any.toml")
    content = dictionary(kind)
    again = back(folder, instrument_zip(kind))
    assert same(again, kind)
    assert dictionary(again) == content


RECORD_ID = "Row 2: record_id is left out, as the record's id."
DICTIONARY = f"""{HEAD}
record_id,demo,,text,Record ID,,,,,,,,,,,,,
age,demo,Please answer,text,How old are you?,,years,integer,18,120,,,,,,,,
sex,demo,,dropdown,Sex,"1, female | 2, male | 3, other",,,,,,,,,,,,
ill,demo,,yesno,Are you ill?,,,,,,,,,,,,,
vas,demo,,slider,How are you?,bad |  | good,,number,,,,,,,,,,
mood,demo,,radio,Mood,"0, low | 1, 1 | 2, 2 | 3, high",,,,,,,,,,,,
"""


def test_a_foreign_dictionary_comes_back_with_its_names(tmp_path: Path) -> None:
    (tmp_path / "file.csv").write_text(DICTIONARY, encoding="utf-8")
    (found,) = read(tmp_path / "file.csv")
    assert (found.name, found.refused, found.left_out) == ("demo", [], [RECORD_ID])
    (tmp_path / "demo.toml").write_text(found.declaration, encoding="utf-8")
    kind = read_kind(tmp_path / "demo.toml")
    before = table(DICTIONARY.encode())[1:]
    after = table(dictionary(kind))
    after[0]["Field Annotation"] = ""
    assert after == before


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("3, other", "5, other", "Row 4: sex is a dropdown whose codes are not 1, 2, 3"),
        ("1, 1 | 2, 2", "1, 1", "Row 7: mood is a radio whose codes do not rise in equal steps"),
        ("1, 1 | 2, 2", "1, x | 2, 2", "Row 7: mood has words at some points of its scale only"),
        (",yesno,Are you ill?,", ',checkbox,Ill?,"1, a | 2, b"', "Row 5: ill asks for several options"),
        (",yesno,", ",file,", "Row 5: ill asks for a file"),
        (",yesno,", ",colour,", "Row 5: ill has the type 'colour'"),
        (",dropdown,Sex,\"1, female | 2, male | 3, other\"", ",dropdown,Sex,", "Row 4: sex has no list of choices"),
        ("3, high", f"{'9' * 5000}, high", "Row 7: mood is a radio whose codes are not whole numbers"),
        ("3, high", "999999999, high", "Row 7: mood is a radio whose codes do not rise in equal"),
        ("2, male", "2, female", "demo: The choice sex has two labels that are the same."),
        ("sex,demo", "age,demo", "Row 4: age is the name of row 3, too."),
        ("sex,demo", "Sex,demo", "Row 4: Sex is no name of a variable"),
        ("ill,demo", "ill,other", "Row 6: the rows of demo are not together."),
        ("How old are you?", "Are you [sex]?", "Row 3: age shows another answer"),
        (",integer,18", ",email,", "Row 3: age must be of the form 'email'"),
        ("18,120", "18,many", "Row 3: age has 'many' as a bound"),
        ("are you?,bad |  | good,,number,,,,", "are you?,bad |  | good,,number,,,y,", "Row 6: vas identifies"),
        ("bad |  | good", "bad | so | good", "Row 6: vas has words in the middle"),
        ("good,,number,,,,", "good,,number,,,,[ill]='1'", "Row 6: vas is shown only under a condition"),
        ("3, high\",,,,,,,,,,,,", "3, high\",,,,,,,,,,,,@HIDDEN", "Row 7: mood has the action tag @HIDDEN"),
        ("3, high\",,,,,,,,,,,,", "3, high\",,,,,,,,,,,,So. @NOW", "Row 7: mood has the action tag @NOW"),
    ],
)  # fmt: skip
def test_what_a_form_cannot_express_is_refused_with_its_row(
    tmp_path: Path, old: str, new: str, says: str
) -> None:
    assert old in DICTIONARY
    (tmp_path / "file.csv").write_text(DICTIONARY.replace(old, new, 1), encoding="utf-8")
    found = {each.name: each for each in read(tmp_path / "file.csv")}
    assert found["demo"].declaration == ""
    assert any(text.startswith(says) for text in found["demo"].refused), found["demo"].refused


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ("2, male", "2, <i>male</i>", "Row 4: sex: HTML of Choices"),
        ("bad |", "<b>bad</b> |", "Row 6: vas: HTML of Choices"),
    ],
)
def test_html_of_labels_is_left_out_with_a_sentence(
    tmp_path: Path, before: str, after: str, says: str
) -> None:
    (tmp_path / "file.csv").write_text(DICTIONARY.replace(before, after), encoding="utf-8")
    (found,) = read(tmp_path / "file.csv")
    assert any(text.startswith(says) for text in found.left_out), found
    assert "<" not in found.declaration


@pytest.mark.parametrize("piped", ["[age]", "[ill(1)]", "[sex:label]", "[event-name]"])
def test_a_label_that_shows_another_answer_is_refused(tmp_path: Path, piped: str) -> None:
    changed = DICTIONARY.replace("2, male", f"2, {piped}")
    (tmp_path / "file.csv").write_text(changed, encoding="utf-8")
    (found,) = read(tmp_path / "file.csv")
    assert found.refused == [
        "Row 4: sex shows another answer in its Choices, Calculations, OR Slider Labels."
    ]


@pytest.mark.parametrize(
    ("label", "read_as"),
    [
        ("Less than <5 and more than >3?", "Less than <5 and more than >3?"),
        ("How<br>are<br/>you?", "How are you?"),
        ('<p class="x">How are</p><p>you?</p>', "How are you?"),
        ("a &lt; b<!-- not > this -->", "a < b"),
    ],
)
def test_html_is_left_out_and_nothing_else(tmp_path: Path, label: str, read_as: str) -> None:
    quoted = '"' + label.replace('"', '""') + '"'
    (tmp_path / "file.csv").write_text(DICTIONARY.replace("Are you ill?", quoted), "utf-8")
    (found,) = read(tmp_path / "file.csv")
    assert f'title = "{read_as}"' in found.declaration


def test_an_instrument_without_its_zip_keeps_a_first_item_that_is_a_text(tmp_path: Path) -> None:
    (tmp_path / "own.toml").write_text(OTHERS.partition("[form]")[0] + TEXT_ITEM, "utf-8")
    kind = read_kind(tmp_path / "own.toml")
    assert same(back(tmp_path, dictionary(kind)), kind)


TEXT_ITEM = """
group = "form"
when = "When it was filled in"
has_time = true
[form]
[[fields]]
name = "remark"
title = "Anything else?"
type = "text"
"""


def test_what_is_layout_only_is_left_out_with_a_sentence(tmp_path: Path) -> None:
    changed = DICTIONARY.replace("Are you ill?,,,,,,,,,", "<b>Are you ill?</b>,,,,,,,,y,LH")
    changed += (
        "note1,demo,,descriptive,Hello,,,,,,,,,,,,,\nsum1,demo,,calc,Sum,[age]+1,,,,,,,,,,,,\n"
    )
    (tmp_path / "file.csv").write_text(changed, encoding="utf-8")
    (found,) = read(tmp_path / "file.csv")
    assert found.refused == []
    assert found.left_out == [
        RECORD_ID,
        "Row 5: ill: HTML of Field Label is left out.",
        "Row 5: ill is not required here, as anybody may rather not say.",
        "Row 5: ill: Custom Alignment is left out.",
        "Row 8: note1 is left out, as it asks nothing.",
        "Row 9: sum1 is left out: declare it as a score (docs/forms.md).",
    ]


def test_a_score_that_was_changed_in_redcap_is_refused(tmp_path: Path) -> None:
    changed = dictionary(find("SUS")).decode("utf-8-sig").replace("*2.5", "*25")
    (tmp_path / "file.csv").write_text(
        f"{HEAD}\nrecord_id,a,,text,Id{',' * 13}\n" + changed.split("\r\n", 1)[1]
    )
    found = [each for each in read(tmp_path / "file.csv") if each.name == "sus"]
    assert "is computed otherwise than the score" in found[0].refused[0]


def _damaged(content: bytes) -> bytes:
    """Return a zip whose compressed data are overwritten, but not its directory."""
    at = content.index(b"instrument.csv") + len("instrument.csv")
    return content[:at] + b"\xff" * 40 + content[at + 40 :]


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "is no data dictionary: it has no column"),
        (b"a,b\n1,2\n", "is no data dictionary: it has no column"),
        (HEAD.encode() + b"\n\xff\xfe", "is not UTF-8"),
        (f"{DICTIONARY.rstrip()},x".encode(), "row 7 has more cells"),
        (_damaged(instrument_zip(find("SUS"))), "is a damaged zip"),
        (b"PK\x05\x06" + bytes(18), "is no instrument of REDCap: it has no instrument.csv."),
    ],
)
def test_a_file_that_is_none_of_redcaps_is_refused(
    tmp_path: Path, content: bytes, says: str
) -> None:
    (tmp_path / "file").write_bytes(content)
    with pytest.raises(RedcapError, match=re.escape(says)):
        read(tmp_path / "file")


@examples(200)
@given(st.text(max_size=400))
def test_any_text_is_read_or_refused(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    path = tmp_path_factory.mktemp("any") / "file.csv"
    path.write_bytes(f"{HEAD}\n{text}".encode("utf-8", "replace"))
    with contextlib.suppress(RedcapError):
        read(path)
