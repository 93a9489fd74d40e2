"""The program as a whole: help, version, exit codes, and errors."""

import os
import shutil
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest

import sar_tui
from sar_tui.plugins import Catalogue
from tests.program import Call

HEAVY = ("textual", "aiohttp", "numpy", "sqlite3", "sqlite_utils", "plotext", "msgspec")
COMMANDS = """
run resume simulate sessions show wizard agent serve tasks themes graph timing passphrase doctor
detect reanalyse replay validate progress export backup check rescue merge site
tasks/show tasks/new tasks/check link/invite link/list link/revoke link/check report/wizard
report/intervention programme/show programme/history programme/export programme/import
programme/presets
""".split()


def program(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "sar_tui", *arguments],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        check=False,
    )


def test_version_is_the_packages(call: Call) -> None:
    assert call("--version") == (0, f"sar-tui {sar_tui.__version__}\n", "")


def test_help_and_version_import_nothing_heavy() -> None:
    script = (
        "import sys; from sar_tui.cli import main\n"
        "for arguments in (['--version'], ['-h'], ['--help'], ['simulate', '--help'], ['tasks', "
        "'--help']):\n"
        "    sys.argv = ['sar-tui', *arguments]\n"
        "    try: main()\n"
        f"    except SystemExit as end: print(end.code, [name for name in {HEAVY!r} if name in "
        "sys.modules], "
        "file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "0 []\n" * 5)


def loaded_by(*arguments: str) -> set[str]:
    """Return the modules that a call of the program has loaded when it ends."""
    script = (
        "import sys; from sar_tui.__main__ import main\n"
        f"sys.argv = ['sar-tui', *{arguments!r}]\n"
        "try: main()\n"
        "except SystemExit as end: print(end.code, *sys.modules, file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    code, *modules = done.stderr.split()
    assert code == "0", done.stderr
    return set(modules)


def test_the_version_is_printed_without_the_parser_of_the_command_line() -> None:
    assert not loaded_by("--version") & {"typer", "typing", "re", "pathlib"}


def test_a_command_loads_no_other_command() -> None:
    modules = loaded_by("tasks")
    assert "sar_tui.cli.tasks" in modules
    assert not modules & {
        "sar_tui.cli.detect",
        "sar_tui.cli.live",
        "sar_tui.cli.link",
        "sar_tui.cli.validate",
    }
    assert not modules & {"sqlite3", "sqlite_utils", "filelock", "numpy", "textual"}


def test_the_sessions_of_a_current_database_are_listed_without_the_modules_that_migrate_one(
    simulated: str, tmp_path: Path
) -> None:
    modules = loaded_by("sessions", "--data", str(tmp_path / "data"))
    assert "sar_tui.store.sessions" in modules
    assert not modules & {"sqlite_utils", "filelock", "numpy", "textual"}


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_takes_the_data_and_tasks_folders_and_has_help(
    call: Call, command: str
) -> None:
    called = call(command.replace("/", " "), "--help")
    assert called.code == 0
    assert "--data DIR" in called.out
    assert "--tasks DIR" in called.out


@pytest.mark.parametrize("before", [True, False], ids=["before the command", "after it"])
def test_the_data_folder_may_be_named_before_or_after_the_command(
    call: Call, tmp_path: Path, before: bool
) -> None:
    option = ("--data", tmp_path / "elsewhere")
    simulate = ("simulate", "keyboard", "--user", "poor", "--attempts", 1)
    assert call(*(option + simulate if before else simulate + option)).code == 0
    assert (tmp_path / "elsewhere" / "sar-tui.db").exists()
    assert not (tmp_path / "data").exists()


def test_the_folder_named_last_counts(call: Call, tmp_path: Path) -> None:
    call("--data", tmp_path / "one", "sessions", "--data", tmp_path / "two")
    assert not (tmp_path / "one").exists()
    assert (tmp_path / "two").exists()


@pytest.mark.parametrize("option", ["--data", "--tasks"])
@pytest.mark.parametrize("before", [True, False], ids=["before the command", "after it"])
def test_a_folder_without_a_name_is_bad_usage_and_not_the_present_folder(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, option: str, before: bool
) -> None:
    monkeypatch.chdir(tmp_path)
    called = call(option, "", "sessions") if before else call("sessions", option, "")
    assert called.code == 2
    assert "a name is missing: it is empty." in called.err
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_no_database_is_bad_input(call: Call, tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "sar-tui.db").write_text("Dear diary, today I was a text file.")
    called = call("sessions")
    assert called.code == 2
    assert "is not a SQLite database" in called.err


def test_a_newer_database_is_bad_input(call: Call, tmp_path: Path, simulated: str) -> None:
    with sqlite3.connect(tmp_path / "data" / "sar-tui.db") as connection:
        connection.execute("PRAGMA user_version=999")
    called = call("show", simulated)
    assert called.code == 2
    assert "newer sar-tui" in called.err


def test_a_folder_that_cannot_be_made_is_a_failure(call: Call, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    called = call("sessions --data", tmp_path / "file" / "data")
    assert called.code == 1
    assert "cannot be written to" in called.err
    assert called.err.count("\n") == 1


def test_a_database_error_is_explained(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    def break_down(*_: object, **__: object) -> None:
        raise sqlite3.OperationalError("no such table: sessions")

    monkeypatch.setattr("sar_tui.store.sessions.listing", break_down)
    assert call("sessions") == (1, "", "sar-tui.db: no such table: sessions.\n")


def test_a_module_that_cannot_be_loaded_is_reported_in_a_sentence(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    def break_down(*_: object, **__: object) -> None:
        raise ZeroDivisionError("a plain mistake")

    monkeypatch.setattr("sar_tui.store.sessions.listing", break_down)
    monkeypatch.setitem(sys.modules, "sar_tui.plugins", None)
    called = call("sessions")
    assert (called.code, called.err.count("\n")) == (1, 1)
    assert called.err.startswith("An unexpected error occurred (ModuleNotFoundError: ")


def test_an_unforeseen_error_is_a_sentence(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    def break_down(*_: object, **__: object) -> None:
        raise ZeroDivisionError("a plain mistake")

    monkeypatch.setattr("sar_tui.store.sessions.listing", break_down)
    called = call("sessions")
    assert called.code == 1
    assert "ZeroDivisionError: a plain mistake" in called.err
    assert "SAR_TUI_DEBUG=1" in called.err
    assert "Traceback" not in called.err

    monkeypatch.setenv("SAR_TUI_DEBUG", "1")
    monkeypatch.setattr(sys, "argv", ["sar-tui", "sessions"])
    from sar_tui.cli import main

    with pytest.raises(ZeroDivisionError):
        main()


def test_ctrl_c_is_130_and_a_word(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("sar_tui.store.sessions.listing", interrupted)
    assert call("sessions") == (130, "", "Stopped.\n")


def test_ctrl_c_while_the_program_is_loaded_is_130_and_a_word() -> None:
    script = (
        "import sys\n"
        "class CtrlC:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name == 'sar_tui.cli': raise KeyboardInterrupt\n"
        "sys.meta_path.insert(0, CtrlC())\n"
        "from sar_tui.__main__ import main\n"
        "main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "Stopped.\n")


@pytest.mark.skipif(os.name != "posix", reason="pipes of POSIX systems")
@pytest.mark.parametrize("how", ["--json", "table"])
def test_a_reader_that_goes_away_is_no_error(call: Call, tmp_path: Path, how: str) -> None:
    assert call("simulate keyboard --user poor --attempts 4 --data", tmp_path).code == 0
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "sar_tui",
            "show",
            "last",
            "--data",
            str(tmp_path),
            *(["--json"] * (how == "--json")),
        ],
        stdout=writing,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    os.close(writing)
    assert done.stderr == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="/dev/full is Linux's")
@pytest.mark.parametrize(
    "arguments", [["--version"], ["--help"], ["sessions", "--help"], ["tasks"]]
)
def test_output_that_does_not_fit_on_the_disk_is_a_failure_in_a_sentence(
    tmp_path: Path, arguments: list[str]
) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "sar_tui", *arguments],
            env={**os.environ, "SAR_TUI_DATA": str(tmp_path)},
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    said = (
        "The disk is full: what was to be written is not complete. Free some space, and try "
        "again.\n"
    )
    assert (done.returncode, done.stderr) == (1, said)


@pytest.mark.skipif(os.name != "posix", reason="the shell of POSIX systems")
@pytest.mark.parametrize("arguments", ["--version", "tasks"])
def test_a_command_whose_standard_output_is_closed_is_done_all_the_same(arguments: str) -> None:
    done = subprocess.run(
        ["sh", "-c", f'"{sys.executable}" -m sar_tui {arguments} >&-'],
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(
    "arguments", [[], ["run", "keyboard", "-p", "P01"]], ids=["the app", "run"]
)
@pytest.mark.parametrize("term", ["xterm", "dumb"])
def test_without_a_terminal_the_app_is_refused(
    call: Call, monkeypatch: pytest.MonkeyPatch, arguments: list[str], term: str
) -> None:
    monkeypatch.setenv("TERM", term)
    called = call(*arguments)
    assert (called.code, called.out) == (2, "")
    assert "terminal" in called.err
    assert "sar-tui simulate" in called.err


LONG = "x" * 300
NOT_TEXT = "\udcff"
"""An argument of one byte that is not UTF-8, as Python passes it."""


@pytest.mark.parametrize(
    "arguments",
    [
        ["sessions", "--data", LONG],
        ["tasks", "--tasks", LONG],
        ["tasks", "new", LONG],
        ["tasks", "check", LONG],
        ["tasks", "show", LONG],
        ["themes", "new", LONG],
        ["themes", "new", "evening", "--to", LONG],
        ["themes", "check", LONG],
        ["show", LONG],
        ["graph", LONG],
        ["detect", LONG],
        ["wizard", "--link", LONG],
        ["serve", "operator", "--link", LONG],
        ["serve", "operator", "--token-file", LONG],
        ["link", "check", LONG],
        ["link", "invite", "operator", "--name", LONG, "--host", "here"],
        ["link", "invite", "operator", "--name", "anna", "--host", "here", "--to", LONG],
        ["run", "reaching", "-p", "P01", "--imu", f"recorded:{LONG}"],
        ["run", "keyboard", "-p", "P01", "--speech", f"file:{LONG}"],
        ["simulate", "keyboard", "--user", "poor", "-p", LONG],
        ["simulate", "keyboard", "--user", "poor", "--set", f"{LONG}=1"],
    ],
    ids=lambda arguments: " ".join(arguments).replace(LONG, "…"),
)
def test_a_name_that_is_too_long_is_bad_input(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str]
) -> None:
    monkeypatch.setattr("sar_tui.plugin_loader.user_folder", lambda: tmp_path)
    called = call(*arguments)
    assert (called.code, called.err.count("\n")) == (2, 1)
    assert "unexpected" not in called.err
    assert LONG not in called.err


@pytest.mark.parametrize(
    "arguments",
    [
        ["--set", f"layout={NOT_TEXT}"],
        ["--set", f"layout=qwerty{NOT_TEXT}"],
        ["--set", f"speech=file:{NOT_TEXT}"],
        ["--set", f"levels={NOT_TEXT}"],
        ["--set", f"attempts={NOT_TEXT}"],
        ["--set", NOT_TEXT],
        ["--set", f"{NOT_TEXT}=1"],
        ["--outputs", f"screen,{NOT_TEXT}"],
        ["--speech", f"file:{NOT_TEXT}"],
        ["--language", NOT_TEXT],
        ["--theme", NOT_TEXT],
        ["-p", NOT_TEXT],
    ],
    ids=lambda arguments: " ".join(arguments).replace(NOT_TEXT, "?"),
)
def test_an_argument_that_is_not_text_is_bad_input(
    call: Call, tmp_path: Path, arguments: list[str]
) -> None:
    called = call("simulate keyboard --user poor", *arguments)
    assert called.code == 2
    assert "unexpected" not in called.err
    assert NOT_TEXT not in called.err


@pytest.mark.skipif(sys.platform != "linux", reason="names of files that are not text")
def test_a_theme_whose_name_is_not_text_is_bad_input(
    call: Call, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("sar_tui.plugin_loader.user_folder", lambda: tmp_path)
    shutil.copytree(Catalogue().theme_folder("calm"), tmp_path / "themes" / NOT_TEXT)
    called = call("simulate keyboard --user poor --theme", NOT_TEXT)
    assert called.code == 2
    assert called.err == "The theme � cannot be read: the name of its folder is not UTF-8.\n"
    assert call("themes --json").json["themes"][-1]["name"] == NOT_TEXT


def test_with_redirected_streams_the_app_is_refused(tmp_path: Path) -> None:
    done = program(TERM="xterm", SAR_TUI_DATA=str(tmp_path))
    assert (done.returncode, done.stdout) == (2, "")
    assert "sar-tui simulate" in done.stderr


def test_a_dumb_terminal_is_refused(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    for stream in ("stdin", "stdout", "stderr"):
        monkeypatch.setattr(getattr(sys, stream), "isatty", lambda: True, raising=False)
    monkeypatch.setenv("TERM", "dumb")
    called = call()
    assert called.code == 2
    assert "TERM=dumb" in called.err


@pytest.mark.skipif(os.name != "posix", reason="kinds of terminals")
@pytest.mark.parametrize("term", ["", None])
@pytest.mark.parametrize(
    "arguments", [[], ["run", "keyboard", "-p", "P01"], ["wizard", "--wait"]], ids=" ".join
)
def test_a_terminal_of_no_kind_is_refused(
    call: Call, monkeypatch: pytest.MonkeyPatch, term: str | None, arguments: list[str]
) -> None:
    for stream in ("stdin", "stdout", "stderr"):
        monkeypatch.setattr(getattr(sys, stream), "isatty", lambda: True, raising=False)
    monkeypatch.setattr("sar_tui.link.discovery.live_sessions", list)
    for opens in ("sar_tui.app.app.run_app", "sar_tui.operator.app.run_wizard"):
        monkeypatch.setattr(opens, lambda *_, **__: 7)
    if term is None:
        monkeypatch.delenv("TERM")
    else:
        monkeypatch.setenv("TERM", term)
    called = call(*arguments)
    assert (called.code, called.err.count("\n")) == (2, 1)
    assert "TERM, which names the kind of this one, is empty" in called.err
