"""Whatever the text is and wherever it comes from: a terminal gets no command from it."""

import io
import json
import os
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest
from rich.table import Table
from rich.text import Text

from sar_tui.cli.scaffold import new_theme
from sar_tui.cli.tables import VisibleConsole
from sar_tui.cli.visible_output import VisibleStream
from sar_tui.plugins import Catalogue
from tests.edit import edit
from tests.hostile import HOSTILE, SHOWN, leaks
from tests.program import Call
from tests.store.by_hand import add_message

ARGUMENTS = [
    [HOSTILE],
    [f"--{HOSTILE}"],
    ["tasks", HOSTILE],
    ["tasks", "show", HOSTILE],
    ["tasks", "check", HOSTILE],
    ["tasks", "new", HOSTILE],
    ["tasks", "--tasks", f"/no/{HOSTILE}"],
    ["themes", "check", HOSTILE],
    ["themes", "new", "evening", "--from", HOSTILE],
    ["show", HOSTILE],
    ["resume", HOSTILE],
    ["graph", HOSTILE],
    ["detect", HOSTILE],
    ["detect", "--detector", HOSTILE, "file.csv"],
    ["report", HOSTILE],
    ["report", "wizard", HOSTILE],
    ["reanalyse", HOSTILE],
    ["validate", HOSTILE],
    ["serve", HOSTILE],
    ["serve", "operator", "--link", HOSTILE],
    ["serve", "operator", "--name", HOSTILE],
    ["wizard", "--link", HOSTILE],
    ["link", "check", HOSTILE],
    ["link", "revoke", HOSTILE],
    ["link", "invite", HOSTILE, "--name", "anna", "--host", "here"],
    ["link", "invite", "operator", "--name", HOSTILE, "--host", "here"],
    ["link", "invite", "operator", "--name", "anna", "--host", HOSTILE],
    ["run", HOSTILE, "-p", "P01"],
    ["run", "keyboard", "-p", "P01", "--imu", HOSTILE],
    ["run", "reaching", "-p", "P01", "--imu", HOSTILE],
    ["run", "reaching", "-p", "P01", "--imu", f"ros://{HOSTILE}"],
    ["run", "reaching", "-p", "P01", "--imu", f"recorded:{HOSTILE}"],
    ["run", "keyboard", "-p", "P01", "--theme", HOSTILE],
    ["run", "keyboard", "-p", "P01", "--language", HOSTILE],
    ["run", "keyboard", "-p", "P01", "--outputs", f"ros://{HOSTILE}"],
    ["run", "keyboard", "-p", "P01", "--outputs", f"servo:{HOSTILE}"],
    ["run", "keyboard", "-p", "P01", "--listen", HOSTILE],
    ["simulate", "keyboard", "--user", HOSTILE],
    ["simulate", "keyboard", "--user", "poor", "--set", HOSTILE],
    ["simulate", "keyboard", "--user", "poor", "--set", f"{HOSTILE}=1"],
    ["simulate", "keyboard", "--user", "poor", "--set", f"attempts={HOSTILE}"],
    ["simulate", "keyboard", "--user", "poor", "--seed", HOSTILE],
]


@pytest.mark.parametrize(
    "arguments", ARGUMENTS, ids=lambda arguments: " ".join(map(ascii, arguments))[:60]
)
def test_a_refused_argument_is_quoted_visibly(call: Call, arguments: list[str]) -> None:
    called = call(*arguments)
    assert called.code == 2
    assert leaks(called.out + called.err) == []


def test_a_cell_of_a_recording_is_quoted_visibly(call: Call, tmp_path: Path) -> None:
    file = tmp_path / "recording.csv"
    file.write_text(
        f"t,wx,wy,wz,ax,ay,az\n0,0,0,0,0,0,0\n0.01,{HOSTILE.replace(chr(10), '')},0,0,0,0,0\n"
    )
    called = call("detect", file)
    assert called.code == 2
    assert leaks(called.err) == []
    assert "␛]0;owned␇" in called.err


def test_texts_of_a_theme_are_printed_visibly(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    themes = tmp_path / "config" / "sar-tui" / "themes"
    monkeypatch.setattr("sar_tui.plugin_loader.user_folder", lambda: themes.parent)
    evening = new_theme("evening", themes, "calm", Catalogue())
    title = json.dumps(HOSTILE)
    edit(evening / "theme.toml", 'title = "Evening"', f"title = {title}")
    listed = call("themes")
    assert leaks(listed.out) == []
    assert SHOWN in listed.out
    as_json = call("themes --json")
    assert leaks(as_json.out) == []
    assert HOSTILE in [row["title"] for row in as_json.json["themes"]]
    checked = call("themes check", evening)
    assert checked.code == 1
    assert leaks(checked.out) == []
    assert (
        "title in theme.toml has control characters: U+0007, U+001B, U+009B, U+2028, U+202E, "
        "U+2066." in checked.out
    )


def test_stored_notes_are_printed_visibly(call: Call, data: Path) -> None:
    played = call(
        "simulate keyboard --user average --attempts 2 --set prompts_per_attempt=3",
        *"--operator careful --seed 1 --json".split(),
    )
    session = played.json["session"]
    with closing(sqlite3.connect(data / "sar-tui.db")) as database, database:
        seq, at = database.execute("SELECT max(seq) + 1, max(at_ns) FROM events").fetchone()
        note = {"text": HOSTILE, "actor": "operator.simulated", "at": at}
        add_message(database, session, seq, at, "operator/note", note)
    called = call("report wizard", session)
    assert leaks(called.out) == []
    assert SHOWN in called.out


def test_a_name_of_a_file_that_is_not_text_is_quoted(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable.encode(), b"-m", b"sar_tui", b"detect", b"\xff\x1b[2J.csv"],
        env={**os.environ, "PYTHONIOENCODING": "utf-8"},
        capture_output=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, b"")
    assert "�␛[2J.csv".encode() in done.stderr


def test_a_traceback_is_printed_visibly(tmp_path: Path) -> None:
    script = (
        "import sys; from sar_tui.cli import main; sys.argv = ['sar-tui', 'show', "
        f"{HOSTILE!r}]; main()"
    )
    broken = (
        "import sar_tui.store.sessions as s\ndef find(*_): raise RuntimeError(_[-1])\ns.find "
        "= find\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", broken + script],
        env={**os.environ, "SAR_TUI_DEBUG": "1", "SAR_TUI_DATA": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert f"RuntimeError: {SHOWN}" in done.stderr
    assert leaks(done.stderr) == []


# --- the parts


def test_a_stream_keeps_lines_and_columns() -> None:
    file = io.StringIO()
    stream = VisibleStream(file)
    print("one\ttwo\n", "\x1b[31m", file=stream)
    stream.writelines(["\x07", "\n"])
    assert file.getvalue() == "one\ttwo\n ␛[31m\n␇\n"
    assert not stream.isatty()


def test_a_console_sends_its_own_commands_and_nobody_elses() -> None:
    console = VisibleConsole(
        file=io.StringIO(), force_terminal=True, color_system="standard", width=60, highlight=False
    )
    table = Table("name")
    table.add_row(Text("\x1b[2J", style="bold"))
    console.print(table)
    console.print("a\x07b\x1b[31m", Text("c\u202ed", style="red"))
    shown = console.file.getvalue()
    assert "\x1b[1m␛[2J\x1b[0m" in shown
    assert "a␇b␛[31m" in shown
    assert "\x1b[31mc�d\x1b[0m" in shown


def test_output_shows_names_in_brackets_and_colons_as_they_are(call: Call) -> None:
    called = call("simulate keyboard --user poor --theme [red]:warning:[/x]")
    assert "There is no theme [red]:warning:[/x]." in called.err
