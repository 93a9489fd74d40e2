"""Whatever the text is and wherever it comes from: a terminal gets no command from it."""

import io
import json
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

ARGUMENTS = """
?
--?
tasks show ?
tasks new ?
tasks --tasks /no/?
show ?
detect --detector ? file.csv
serve operator --name ?
link invite operator --name anna --host ?
run reaching -p P01 --imu ros://?
run keyboard -p P01 --outputs servo:?
simulate keyboard --user poor --set ?=1
simulate keyboard --user poor --set attempts=?
"""


def test_a_refused_argument_is_quoted_visibly(call: Call) -> None:
    for arguments in ARGUMENTS.strip().splitlines():
        called = call("", *(word.replace("?", HOSTILE) for word in arguments.split()))
        assert called.code == 2, arguments
        assert leaks(called.out + called.err) == [], arguments


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


# --- the parts


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


def test_a_stream_keeps_lines_and_columns() -> None:
    file = io.StringIO()
    stream = VisibleStream(file)
    print("one\ttwo\n", "\x1b[31m", file=stream)
    stream.writelines(["\x07", "\n"])
    assert file.getvalue() == "one\ttwo\n ␛[31m\n␇\n"
    assert not stream.isatty()
