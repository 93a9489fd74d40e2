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

ARGUMENTS = """
?
--?
tasks ?
tasks show ?
tasks check ?
tasks new ?
tasks --tasks /no/?
themes check ?
themes new evening --from ?
show ?
resume ?
graph ?
detect ?
detect --detector ? file.csv
report ?
report wizard ?
reanalyse ?
validate ?
serve ?
serve operator --link ?
serve operator --name ?
wizard --link ?
link check ?
link revoke ?
link invite ? --name anna --host here
link invite operator --name ? --host here
link invite operator --name anna --host ?
run ? -p P01
run keyboard -p P01 --imu ?
run reaching -p P01 --imu ?
run reaching -p P01 --imu ros://?
run reaching -p P01 --imu recorded:?
run keyboard -p P01 --theme ?
run keyboard -p P01 --language ?
run keyboard -p P01 --outputs ros://?
run keyboard -p P01 --outputs servo:?
run keyboard -p P01 --listen ?
simulate keyboard --user ?
simulate keyboard --user poor --set ?
simulate keyboard --user poor --set ?=1
simulate keyboard --user poor --set attempts=?
simulate keyboard --user poor --seed ?
"""


@pytest.mark.parametrize("arguments", ARGUMENTS.strip().splitlines())
def test_a_refused_argument_is_quoted_visibly(call: Call, arguments: str) -> None:
    called = call("", *(word.replace("?", HOSTILE) for word in arguments.split()))
    assert called.code == 2
    assert leaks(called.out + called.err) == []


def test_a_cell_of_a_recording_is_quoted_visibly(call: Call, tmp_path: Path) -> None:
    file = tmp_path / "recording.csv"
    cell = HOSTILE.replace("\n", "")
    file.write_text(f"t,wx,wy,wz,ax,ay,az\n0,0,0,0,0,0,0\n0.01,{cell},0,0,0,0,0\n")
    called = call("detect", file)
    called.refused("␛]0;owned␇")
    assert leaks(called.err) == []


def test_texts_of_a_theme_are_printed_visibly(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.plugin_loader.user_folder", lambda: tmp_path)
    evening = new_theme("evening", tmp_path / "themes", "calm", Catalogue())
    edit(evening / "theme.toml", 'title = "Evening"', f"title = {json.dumps(HOSTILE)}")
    listed, as_json = call("themes"), call("themes --json")
    listed.shows(SHOWN)
    assert HOSTILE in [row["title"] for row in as_json.json["themes"]]
    checked = call("themes check", evening)
    characters = "U+0007, U+001B, U+009B, U+2028, U+202E, U+2066."
    checked.shows(f"title in theme.toml has control characters: {characters}", code=1)
    assert leaks(listed.out + as_json.out + checked.out) == []


def test_stored_notes_are_printed_visibly(call: Call, data: Path) -> None:
    few = "--attempts 2 --set prompts_per_attempt=3 --operator careful --seed 1 --json"
    session = call(f"simulate keyboard --user average {few}").json["session"]
    with closing(sqlite3.connect(data / "sar-tui.db")) as database, database:
        seq, at = database.execute("SELECT max(seq) + 1, max(at_ns) FROM events").fetchone()
        note = {"text": HOSTILE, "actor": "operator.simulated", "at": at}
        add_message(database, session, seq, at, "operator/note", note)
    called = call("report wizard", session)
    called.shows(SHOWN)
    assert leaks(called.out) == []


def test_a_name_of_a_file_that_is_not_text_is_quoted(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable.encode(), b"-m", b"sar_tui", b"detect", b"\xff\x1b[2J.csv"],
        env={**os.environ, "PYTHONIOENCODING": "utf-8"},
        capture_output=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, b"")
    assert "�␛[2J.csv".encode() in done.stderr


def test_a_traceback_is_printed_visibly(
    call: Call, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    script = (
        "import sys, sar_tui.store.sessions as s; from sar_tui.cli import main\n"
        "def find(*_): raise RuntimeError(_[-1])\n"
        f"s.find = find; sys.argv = ['sar-tui', 'show', {HOSTILE!r}]; main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
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
