"""``sar-tui progress``: for people, as a note, and as JSON."""

import os
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.program import Call


@pytest.fixture
def trained(call: Call) -> list[str]:
    """The ids of two short simulated sessions of P01."""
    return [
        call("simulate keyboard --user average --seed", seed, "-p", "P01", "--json",
             "--set", "prompts_per_attempt=5", "--attempts", 12).json["session"]
        for seed in (1, 2)
    ]  # fmt: skip


def test_progress_shows_the_sessions_and_what_can_be_said(call: Call, trained: list[str]) -> None:
    called = call("progress p01")
    assert called.code == 0
    assert all(session[:6] in called.out for session in trained)
    assert "P01 · Keyboard reaction · goal 1.0 s · simulated · Prompts per attempt 5" in called.out
    assert "Level at goal in the last session: level " in called.out
    assert "not yet known" in called.out
    assert "● " in called.out


def test_json_has_every_line_and_session(call: Call, trained: list[str]) -> None:
    found = call("progress P01 --json").json
    assert found["participant"] == "P01"
    (line,) = found["lines"]
    assert [each["session"] for each in line["sessions"]] == trained
    assert line["axis"] == {"name": "choice", "unit": "keys", "decimals": 1, "is_log2": True}
    at_goal = line["sessions"][0]["at_goal"]
    assert at_goal["low"] < at_goal["difficulty"] < at_goal["high"]
    assert found["days"] == []


@pytest.mark.usefixtures("trained")
def test_a_note_is_one_paragraph_in_either_language(call: Call) -> None:
    english = call("progress P01 --note").out.strip()
    spanish = call("progress P01 --note --language es").out.strip()
    assert english.startswith("P01, Keyboard reaction · goal 1.0 s")
    assert spanish.startswith("P01, Reacción con el teclado · meta 1,0 s")
    assert "\n" not in english + spanish
    assert "no diagnosis" in english
    assert "MCID" in spanish


def test_two_sessions_are_compared(call: Call, trained: list[str]) -> None:
    named = f"{trained[0][:6]},last"
    assert "How much is noise is not yet known" in call("progress P01 --compare", named).out
    compared = call("progress P01 --compare", named, "--json").json
    assert (compared["earlier"]["session"], compared["later"]["session"]) == tuple(trained)
    assert compared["verdict"] == "not yet known"


def test_a_participant_without_sessions_has_no_lines_in_json(call: Call) -> None:
    call("record", "add", "BBT", "P09", "score=30", "--on", "2026-03-01", "--new")
    found = call("progress", "P09", "--json").json
    assert (found["participant"], found["lines"], found["days"], len(found["instruments"])) == (
        "P09",
        [],
        [],
        1,
    )
    assert (found["recent"]["days"], found["recent"]["done"]) == (0, 0)


@pytest.mark.usefixtures("trained")
def test_a_page_is_written_for_its_owner_alone_and_never_overwritten(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(
        sys.modules, "vl_convert", SimpleNamespace(vegalite_to_svg=lambda spec: "<svg ></svg>")
    )
    file = tmp_path / "p01.html"
    assert call("progress P01 --html", file).code == 0
    assert "<h1>P01 · Progress</h1>" in file.read_text(encoding="utf-8")
    if os.name == "posix":
        assert file.stat().st_mode & 0o777 == 0o600
    again = call("progress P01 --html", file)
    assert (again.code, "is not overwritten" in again.err) == (2, True)


@pytest.mark.usefixtures("trained")
def test_without_the_package_no_page_is_left(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "vl_convert", None)
    called = call("progress P01 --html", tmp_path / "p01.html")
    assert called.code == 2
    assert ".[report]" in called.err
    assert not (tmp_path / "p01.html").exists()
