"""The folder of an export is absent or complete, whatever happens, and other files are never
touched.
"""

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from sar_tui.export.errors import ExportError
from sar_tui.export.target import sync, target, write_manifest


def made(folder: Path, text: str = "1", name: str = "a.csv") -> None:
    """Make an export that holds one file."""
    with target(folder, "csv") as hidden:
        (hidden / name).write_text(text)
        write_manifest(hidden, format="csv")
        sync(hidden)


def fail(folder: Path, error: BaseException) -> None:
    """Fail when a file was written."""
    with target(folder, "csv") as hidden:
        (hidden / "a.csv").write_text("2")
        raise error


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_the_folder_appears_when_it_is_complete_is_its_owners_and_is_replaced_as_a_whole(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "deep" / "out"
    with target(folder, "csv") as hidden:
        (hidden / "a.csv").write_text("1")
        assert not folder.exists()
        write_manifest(hidden, format="csv")
        sync(hidden)
    assert names(folder) == ["a.csv", "sar-tui-export.json"]
    if os.name == "posix":
        assert {path.stat().st_mode & 0o777 for path in folder.iterdir()} == {0o600}
        assert folder.stat().st_mode & 0o777 == 0o700
    made(folder, "2", "b.csv")
    assert names(folder) == ["b.csv", "sar-tui-export.json"]
    assert names(folder.parent) == ["out"]


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_failure_leaves_an_earlier_export_whole(tmp_path: Path, error: BaseException) -> None:
    made(tmp_path / "old")
    for name in ("old", "new"):
        with pytest.raises(type(error)):
            fail(tmp_path / name, error)
    assert names(tmp_path) == ["old"]
    assert (tmp_path / "old" / "a.csv").read_text() == "1"


def test_other_files_are_never_touched(tmp_path: Path) -> None:
    foreign, mixed, file = tmp_path / "foreign", tmp_path / "mixed", tmp_path / "file"
    made(mixed)
    made(tmp_path / "out")
    for other in (foreign / "thesis.tex", mixed / "plots" / "mine.R", file):
        other.parent.mkdir(exist_ok=True)
        other.write_text("x")
    for folder, form, said in (
        (foreign, "csv", "holds other files"),
        (mixed, "csv", "plots/mine.R"),
        (file, "csv", "is a file"),
        (tmp_path / "out", "mat", "in the format csv"),
    ):
        with pytest.raises(ExportError, match=said), target(folder, form):
            pytest.fail("nothing may be written")


def test_files_that_somebody_puts_there_meanwhile_are_not_touched(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()

    def disturbed() -> None:
        with target(tmp_path / "out", "csv") as hidden:
            write_manifest(hidden, format="csv")
            (tmp_path / "out" / "thesis.tex").write_text("x")

    with pytest.raises(ExportError, match="other files"):
        disturbed()
    assert names(tmp_path / "out") == ["thesis.tex"]
    assert names(tmp_path) == ["out"]


WRITES_ON = """
import sys
from pathlib import Path
from sar_tui.export.target import target
with target(Path(sys.argv[1]), "csv") as hidden:
    (hidden / "a.csv").write_text("half")
    print("there", flush=True)
    sys.stdin.read()
"""


@pytest.mark.skipif(os.name != "posix", reason="kills a process")
def test_the_next_removes_what_a_killed_export_left_and_not_a_running_one(tmp_path: Path) -> None:
    made(tmp_path / "out")
    command, pipe = [sys.executable, "-c", WRITES_ON, tmp_path / "out"], subprocess.PIPE
    programs = [subprocess.Popen(command, stdin=pipe, stdout=pipe) for _ in range(2)]
    try:
        for program in programs:
            assert program.stdout
            assert program.stdout.readline()
        programs[0].send_signal(signal.SIGKILL)
        programs[0].wait()
        assert (tmp_path / "out" / "a.csv").read_text() == "1"
        assert len(names(tmp_path)) == 3
        made(tmp_path / "out", "2")
        assert len(names(tmp_path)) == 2, "that of the running program is still there"
    finally:
        for program in programs:
            program.kill()
            program.communicate()
    made(tmp_path / "out", "3")
    assert names(tmp_path) == ["out"]


def test_an_export_is_put_back_if_a_program_was_killed_replacing_it(tmp_path: Path) -> None:
    made(tmp_path / "out")
    shutil.move(tmp_path / "out", tmp_path / ".out.sar-tui-abc-before")
    with pytest.raises(OSError, match="full"), target(tmp_path / "out", "csv"):
        raise OSError("full")
    assert names(tmp_path) == ["out"]
    assert (tmp_path / "out" / "a.csv").read_text() == "1"


def test_a_folder_that_cannot_be_made_is_named_and_no_hidden_one(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    under, long = tmp_path / "file" / "deep" / "out", tmp_path / ("a" * 250)
    with pytest.raises(ExportError, match=r"/proc/nowhere.* cannot be made: "):
        made(Path("/proc/nowhere/out"))
    for folder, said in (
        (under, f"{under} cannot be made: {tmp_path / 'file'} is a file."),
        (long, f"{long} is too long for the name of a file or folder."),
    ):
        with pytest.raises(ExportError) as refused:
            made(folder)
        assert str(refused.value) == said
        assert refused.value.bad_input
