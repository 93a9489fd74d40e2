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


def test_progress_is_shown_as_a_table_json_a_note_and_a_comparison(
    call: Call, trained: list[str]
) -> None:
    called = call("progress p01")
    called.shows("P01 · Keyboard reaction · goal 1.0 s · simulated · Prompts per attempt 5", "▄")
    called.shows(*(session[:6] for session in trained), "Level at goal in the last session: level ")
    found = call("progress P01 --json").json
    assert (found["participant"], found["days"]) == ("P01", [])
    (line,) = found["lines"]
    assert [each["session"] for each in line["sessions"]] == trained
    assert line["axis"] == {"name": "choice", "unit": "keys", "decimals": 1, "is_log2": True}
    at_goal = line["sessions"][0]["at_goal"]
    assert at_goal["low"] < at_goal["difficulty"] < at_goal["high"]
    english = call("progress P01 --note").out.strip()
    spanish = call("progress P01 --note --language es").out.strip()
    assert english.startswith("P01, Keyboard reaction · goal 1.0 s")
    assert spanish.startswith("P01, Reacción con el teclado · meta 1,0 s")
    assert "\n" not in english + spanish
    named = f"{trained[0][:6]},last"
    assert "How much is noise is not yet known" in call("progress P01 --compare", named).out
    compared = call("progress P01 --compare", named, "--json").json
    assert (compared["earlier"]["session"], compared["later"]["session"]) == tuple(trained)
    assert compared["verdict"] == "not yet known"


@pytest.mark.usefixtures("trained")
def test_a_page_is_written_for_its_owner_alone_and_never_overwritten(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "p01.html"
    monkeypatch.setitem(sys.modules, "vl_convert", None)
    call("progress P01 --html", file).refused(".[report]")
    assert not file.exists()
    converter = SimpleNamespace(vegalite_to_svg=lambda spec: "<svg ></svg>")
    monkeypatch.setitem(sys.modules, "vl_convert", converter)
    assert call("progress P01 --html", file).code == 0
    assert "<h1>P01 · Progress</h1>" in file.read_text(encoding="utf-8")
    if os.name == "posix":
        assert file.stat().st_mode & 0o777 == 0o600
    call("progress P01 --html", file).refused("is not overwritten")
