"""The program as a whole: help, version, exit codes, and errors."""

import errno
import os
import shutil
import sqlite3
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import sar_tui
from sar_tui.plugins import Catalogue
from tests.program import Call

HEAVY = {"textual", "aiohttp", "numpy", "sqlite3", "sqlite_utils", "plotext", "msgspec"}
COMMANDS = """
run resume simulate sessions show wizard agent serve tasks themes graph timing passphrase doctor
detect reanalyse replay validate progress export backup check rescue merge site
tasks/show tasks/new tasks/check link/invite link/list link/revoke link/check report/wizard
report/intervention programme/show programme/history programme/export programme/import
programme/presets participant/withdraw participant/withdrawals participant/move
participant/de-identify participant/erase participant/report
""".split()


OTHERS = {f"sar_tui.cli.{name}" for name in ("detect", "live", "link", "validate")}
OF_SESSIONS = {"sqlite_utils", "filelock", "numpy", "textual"}


def python(
    *arguments: str, stdout: Any = subprocess.PIPE, **environment: str
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments],
        env=os.environ | environment,
        stdin=subprocess.DEVNULL,
        stdout=stdout,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )


def fail_with(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    """Let ``sar-tui sessions`` fail."""

    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr("sar_tui.store.sessions.listing", fail)


def test_version_is_the_packages(call: Call) -> None:
    assert call("--version") == (0, f"sar-tui {sar_tui.__version__}\n", "")


@pytest.mark.parametrize(
    ("arguments", "loads", "lighter_by"),
    [
        ("--version", "sar_tui", {*HEAVY, "typer", "typing", "re", "pathlib"}),
        ("--help", "typer", HEAVY),
        ("simulate --help", "typer", HEAVY),
        ("tasks", "sar_tui.cli.tasks", {*OTHERS, *OF_SESSIONS, "sqlite3"}),
        ("sessions --data data", "sar_tui.store.sessions", OF_SESSIONS),
    ],
)
def test_a_command_loads_only_what_it_needs(
    simulated: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: str,
    loads: str,
    lighter_by: set[str],
) -> None:
    """The sessions of a current database need no module that migrates one."""
    monkeypatch.chdir(tmp_path)
    modules = loaded_by(*arguments.split())
    assert loads in modules
    assert not modules & lighter_by


def loaded_by(*arguments: str) -> set[str]:
    """Return the modules that a call of the program has loaded when it ends."""
    script = (
        "import sys; from sar_tui.__main__ import main\n"
        f"sys.argv = ['sar-tui', *{arguments!r}]\n"
        "try: main()\n"
        "except SystemExit as end: print(end.code, *sys.modules, file=sys.stderr)"
    )
    code, *modules = python("-c", script).stderr.split()
    assert code == "0", modules
    return set(modules)


def test_every_command_takes_the_data_and_tasks_folders_and_has_help(call: Call) -> None:
    for command in COMMANDS:
        call(command.replace("/", " "), "--help").shows("--data DIR", "--tasks DIR")


def test_the_data_folder_may_be_named_before_or_after_the_command_and_the_last_one_counts(
    call: Call, tmp_path: Path
) -> None:
    for command in (
        f"--data {tmp_path}/a sessions",
        f"sessions --data {tmp_path}/b",
        f"--data {tmp_path}/one sessions --data {tmp_path}/c",
    ):
        assert call(command).code == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b", "c"]


@pytest.mark.parametrize("option", ["--data", "--tasks"])
def test_a_folder_without_a_name_is_bad_usage_and_not_the_present_folder(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, option: str
) -> None:
    monkeypatch.chdir(tmp_path)
    for words in ((option, "", "sessions"), ("sessions", option, "")):
        call(*words).refused("a name is missing: it is empty.")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (ZeroDivisionError("a plain mistake"), 1, "(ZeroDivisionError: a plain mistake)"),
        (ZeroDivisionError(), 1, "SAR_TUI_DEBUG=1"),
        (sqlite3.OperationalError("no such table: t"), 1, "sar-tui.db: no such table: t."),
        (EOFError("marshal data too short"), 1, "Python keeps compiled is cut short"),
        (OSError(errno.EFBIG, "x"), 1, "A file would be larger than the disk or this login may "),
        (OSError(errno.EIO, "x"), 1, "The disk cannot be read or written: "),
        (OSError(errno.EROFS, "x"), 1, "The disk can only be read. "),
        (KeyboardInterrupt(), 130, "Stopped."),
    ],
)
def test_an_error_is_a_sentence(
    call: Call, monkeypatch: pytest.MonkeyPatch, error: BaseException, code: int, said: str
) -> None:
    fail_with(monkeypatch, error)
    called = call("sessions")
    called.refused(said, code=code)
    assert called.err.count("\n") == 1


def test_an_error_is_a_sentence_even_if_a_module_cannot_be_loaded_or_a_traceback_if_asked_for(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    fail_with(monkeypatch, ZeroDivisionError("a plain mistake"))
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "sar_tui.plugins", None)
        call("sessions").refused("An unexpected error occurred (ModuleNotFoundError: ", code=1)
    monkeypatch.setenv("SAR_TUI_DEBUG", "1")
    with pytest.raises(ZeroDivisionError):
        call("sessions")


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
    done = python("-c", script)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "Stopped.\n")


@pytest.mark.skipif(os.name != "posix", reason="pipes of POSIX systems")
def test_a_reader_that_goes_away_is_no_error(call: Call, tmp_path: Path) -> None:
    assert call("simulate keyboard --user poor --attempts 4 --data", tmp_path).code == 0
    reading, writing = os.pipe()
    os.close(reading)
    done = python(*PROGRAM, "show", "last", "--data", str(tmp_path), "--json", stdout=writing)
    os.close(writing)
    assert done.stderr == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="/dev/full is Linux's")
@pytest.mark.parametrize("arguments", ["--version", "sessions --help", "tasks"])
def test_output_that_does_not_fit_on_the_disk_is_a_failure_in_a_sentence(
    tmp_path: Path, arguments: str
) -> None:
    with Path("/dev/full").open("w") as full:
        done = python(*PROGRAM, *arguments.split(), stdout=full, SAR_TUI_DATA=str(tmp_path))
    assert (done.returncode, done.stderr.count("\n")) == (1, 1)
    assert done.stderr.startswith("The disk is full: what was to be written is not complete.")


@pytest.mark.skipif(os.name != "posix", reason="the shell of POSIX systems")
@pytest.mark.parametrize("arguments", ["--version", "tasks"])
def test_a_command_whose_standard_output_is_closed_is_done_all_the_same(arguments: str) -> None:
    words = ["sh", "-c", f'"{sys.executable}" -m sar_tui {arguments} >&-']
    done = subprocess.run(words, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


PROGRAM = ("-m", "sar_tui")
LONG = "x" * 300
TOO_LONG = """
sessions --data …
tasks --tasks …
tasks show …
themes new evening --to …
themes check …
show …
detect …
wizard --link …
serve operator --link …
link invite operator --name anna --host here --to …
run reaching -p P01 --imu recorded:…
run keyboard -p P01 --speech file:…
simulate keyboard --user poor -p …
simulate keyboard --user poor --set …=1
"""
IS_NOT_TEXT = """
simulate keyboard --user poor --set layout=qwerty…
simulate keyboard --user poor --set speech=file:…
simulate keyboard --user poor --set levels=…
simulate keyboard --user poor --set attempts=…
simulate keyboard --user poor --set …=1
simulate keyboard --user poor --outputs screen,…
simulate keyboard --user poor --language …
simulate keyboard --user poor --theme …
simulate keyboard --user poor -p …
"""
NOT_TEXT = "\udcff"
"""An argument of one byte that is not UTF-8, as Python passes it."""


def test_a_name_that_is_too_long_or_not_text_is_bad_input(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.plugin_loader.user_folder", lambda: tmp_path)
    for name, commands in ((LONG, TOO_LONG), (NOT_TEXT, IS_NOT_TEXT)):
        for arguments in commands.strip().splitlines():
            called = call(arguments.replace("…", name))
            assert (called.code, called.err.count("\n")) == (2, 1), arguments
            assert "unexpected" not in called.err, arguments
            assert name not in called.err, arguments


@pytest.mark.skipif(sys.platform != "linux", reason="names of files that are not text")
def test_a_theme_whose_name_is_not_text_is_bad_input(
    call: Call, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("sar_tui.plugin_loader.user_folder", lambda: tmp_path)
    shutil.copytree(Catalogue().theme_folder("calm"), tmp_path / "themes" / NOT_TEXT)
    called = call("simulate keyboard --user poor --theme", NOT_TEXT)
    called.refused("The theme � cannot be read: the name of its folder is not UTF-8.")
    assert call("themes --json").json["themes"][-1]["name"] == NOT_TEXT


@pytest.mark.skipif(os.name != "posix", reason="kinds of terminals")
@pytest.mark.parametrize("arguments", ["", "run keyboard -p P01", "wizard --wait"])
def test_without_a_terminal_and_in_a_dumb_one_or_one_of_no_kind_the_app_is_refused(
    call: Call, monkeypatch: pytest.MonkeyPatch, arguments: str
) -> None:
    monkeypatch.setattr("sar_tui.link.discovery.live_sessions", list)
    for opens in ("sar_tui.app.app.run_app", "sar_tui.operator.app.run_wizard"):
        monkeypatch.setattr(opens, lambda *_, **__: 7)
    for term in ("xterm", "dumb"):
        monkeypatch.setenv("TERM", term)
        call(arguments).refused("terminal")
    for stream in ("stdin", "stdout", "stderr"):
        monkeypatch.setattr(getattr(sys, stream), "isatty", lambda: True, raising=False)
    call(arguments).refused("TERM=dumb")
    monkeypatch.delenv("TERM")
    call(arguments).refused("TERM, which names the kind of this one, is empty")
