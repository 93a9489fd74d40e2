"""Drawn faces have one size and only characters that every terminal draws in one column."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len

from sar_tui.theme_folder.appearance import drawing_problems, fitted

_LARGE = "is larger than 11 columns and 4 lines."


_ODD = "is drawn with what does not fill one column:"


CAT = " /\\_/\\ \n( o o )\n( = = )\n \\___/ "


def test_a_face_that_fits_has_no_problems() -> None:
    assert drawing_problems("happy", CAT, 2) == []


@pytest.mark.parametrize(
    ("face", "problem"),
    [
        (f"{CAT}\nx", _LARGE),
        ("\n".join(["x" * 12] * 4), _LARGE),
        ("o o\n===", "has no line 2, counted from 0, for its mouth (mouth_line)."),
        ("o o\no o\n😀", rf"{_ODD} '\U0001f600'."),
        ("o o\no o\n中", rf"{_ODD} '\u4e2d'."),
        ("o o\no o\ne\u0301", rf"{_ODD} '\u0301'."),
        ("o o\no\to\n===", rf"{_ODD} '\t'."),
    ],
)
def test_a_face_that_does_not_fit_is_reported(face: str, problem: str) -> None:
    assert drawing_problems("happy", face, 2) == [f"The face happy {problem}"]


def test_faces_are_padded_to_one_size() -> None:
    assert fitted({"happy": "o o\n =", "sleeping": "- - z\n  -\n..."}) == {
        "happy": "o o  \n =   \n     ",
        "sleeping": "- - z\n  -  \n...  ",
    }
    assert fitted({}) == {}


@given(st.characters(exclude_characters="\n"))
def test_allowed_characters_fill_one_column(character: str) -> None:
    if not drawing_problems("happy", f".\n.\n.{character}", 2):
        assert cell_len(character) == 1
