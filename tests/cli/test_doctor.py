"""``sar-tui doctor``: what works here, and what does not."""

import json
import sys
from collections import namedtuple
from pathlib import Path
from typing import Any

import pytest

from tests.cli.conftest import Call, Called


def finding(called: Called, name: str) -> dict[str, Any]:
    return next(row for row in called.json["checks"] if row["name"] == name)


@pytest.fixture(autouse=True)
def known_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setenv("LINES", "30")


def test_nothing_wrong_is_0(call: Call) -> None:
    called = call("doctor")
    assert (called.code, called.err) == (0, "")
    assert "✗" not in called.out
    for name in ("Python", "Terminal", "Clock", "Onset stamps", "Priority", "Data", "Disk space", "Tasks", "Themes"):
        assert name in called.out


def test_json_has_a_row_a_finding(call: Call) -> None:
    rows = call("doctor", "--json").json["checks"]
    assert all(set(row) == {"name", "state", "found", "mend"} for row in rows)
    assert {row["state"] for row in rows} <= {"ok", "care", "bad"}


def test_the_data_folder_is_made_and_named(call: Call, tmp_path: Path) -> None:
    data = finding(call("doctor", "--json"), "Data")
    assert data["state"] == "ok"
    assert str(tmp_path / "data") in data["found"]


def test_a_broken_database_is_1_and_says_how_to_mend_it(call: Call, tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "sar-tui.db").write_text("no database at all")
    called = call("doctor")
    assert called.code == 1
    assert "✗ Data" in called.out
    assert "→ Choose another folder" in called.out
    assert finding(call("doctor", "--json"), "Data")["state"] == "bad"


def test_a_task_that_does_not_load_is_1(call: Call, tmp_path: Path) -> None:
    (tmp_path / "mine" / "broken").mkdir(parents=True)
    (tmp_path / "mine" / "broken" / "task.py").write_text("this is no Python")
    called = call("doctor", "--tasks", tmp_path / "mine")
    assert called.code == 1
    assert "✗ Tasks" in called.out


def test_a_tasks_folder_that_is_not_there_is_a_finding(call: Call) -> None:
    called = call("doctor", "--tasks", "/no/such", "--json")
    assert called.code == 1
    assert finding(called, "Tasks")["state"] == "bad"
    assert finding(called, "Themes")["state"] == "ok"


def test_ssh_and_multiplexers_are_noticed(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SSH_CONNECTION", "10.0.0.1 22")
    monkeypatch.setenv("TMUX", "/tmp/tmux")
    found = finding(call("doctor", "--json"), "Connection")
    assert found["state"] == "care"
    assert "SSH and tmux" in found["found"]


def test_a_small_terminal_is_noticed(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    assert finding(call("doctor", "--json"), "Terminal size")["state"] == "care"


def test_a_dumb_terminal_is_1(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "dumb")
    assert call("doctor").code == 1


def test_redirected_output_is_no_fault(call: Call) -> None:
    called = call("doctor", "--json")
    assert finding(called, "Terminal")["state"] == "care"
    assert called.code == 0


def test_no_color_is_fine(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    assert finding(call("doctor", "--json"), "Colours")["state"] == "ok"


@pytest.mark.parametrize(("free", "state"), [(10, "bad"), (100, "care"), (10_000, "ok")])
def test_a_full_disk_is_noticed(call: Call, monkeypatch: pytest.MonkeyPatch, free: int, state: str) -> None:
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr("shutil.disk_usage", lambda _: usage(10**12, 0, free * 1_000_000))
    called = call("doctor", "--json")
    assert finding(called, "Disk space")["state"] == state
    assert called.code == (1 if state == "bad" else 0)


@pytest.mark.parametrize(
    ("text", "state", "says"),
    [
        (None, "care", "sar-tui timing"),
        ("{", "care", "sar-tui timing"),
        (json.dumps({"verdict": "fit"}), "care", "sar-tui timing"),
        ("fit", "ok", ""),
        ("not fit", "care", "says why"),
    ],
    ids=["none", "broken", "incomplete", "fit", "not fit"],
)
def test_measured_timing_is_told(call: Call, tmp_path: Path, text: str | None, state: str, says: str) -> None:
    if text is not None:
        (tmp_path / "data").mkdir()
        figures = {"measured_at": "2026-01-02T03:04", "median_ms": 0.3, "robust_sd_ms": 0.1, "p99_ms": 0.9}
        whole = json.dumps({**figures, "verdict": text}) if "fit" in text and "{" not in text else text
        (tmp_path / "data" / "timing.json").write_text(whole)
    found = finding(call("doctor", "--json"), "Measured timing")
    assert found["state"] == state
    assert says in found["mend"]


def test_a_look_that_fails_is_a_finding_too(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    def break_down(_: str) -> None:
        raise ZeroDivisionError("no clock")

    monkeypatch.setattr("time.get_clock_info", break_down)
    called = call("doctor", "--json")
    assert called.code == 1
    assert "ZeroDivisionError" in finding(called, "Clock")["found"]


@pytest.mark.skipif(sys.platform == "win32", reason="the driver of POSIX systems")
def test_a_textual_without_the_file_we_watch_is_noticed(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    from textual.drivers.linux_driver import LinuxDriver

    monkeypatch.setattr(LinuxDriver, "__init__", lambda self: None)
    assert finding(call("doctor", "--json"), "Onset stamps")["state"] == "care"
