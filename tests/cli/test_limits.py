"""Limits of a login: the size of a file (``ulimit -f``), and threads."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from threading import Thread

import pytest

import sar_tui
from tests.program import Call

resource = pytest.importorskip("resource")


def limited(
    data: Path, *words: object, bytes: int, program: Path | None = None
) -> subprocess.CompletedProcess[str]:
    """Run the program where no file may be larger than some bytes."""
    place = {"PYTHONPATH": str(program)} if program else {}
    return subprocess.run(
        [sys.executable, "-m", "sar_tui", *map(str, words)],
        env=os.environ | place | {"SAR_TUI_DATA": str(data)},
        cwd=program,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (bytes, bytes)),
        capture_output=True,
        text=True,
        check=False,
    )


def test_a_file_that_may_not_grow_is_one_sentence_with_the_limit(
    call: Call, simulated: str, tmp_path: Path
) -> None:
    done = limited(tmp_path / "data", "backup", bytes=8192)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.endswith(
        "This login may write no file larger than 8,192 bytes (ulimit -f).\n"
    )
    assert done.stderr.count("\n") == 1
    assert call("check").code == 0


def test_a_run_under_a_limit_leaves_no_module_that_is_cut_short(tmp_path: Path) -> None:
    ignored = shutil.ignore_patterns("__pycache__")
    for name in ("sar_tui", "tasks", "themes"):
        shutil.copytree(
            Path(sar_tui.__file__).parents[1] / name, tmp_path / "checkout" / name, ignore=ignored
        )
    limited(tmp_path / "data", "tasks", bytes=4096, program=tmp_path / "checkout")
    kept = [path.name for path in (tmp_path / "checkout").rglob("*.pyc")]
    assert "commands.cpython" not in " ".join(kept)
    assert all(path.stat().st_size < 4096 for path in (tmp_path / "checkout").rglob("*.pyc"))


def test_a_module_that_is_cut_short_is_one_sentence_that_says_what_to_do(
    call: Call, simulated: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise EOFError("marshal data too short")

    monkeypatch.setattr("sar_tui.store.sessions.listing", fail)
    called = call("sessions")
    assert (called.code, called.out) == (1, "")
    assert called.err.startswith(
        "A module that Python keeps compiled is cut short, as by a full disk."
    )
    assert "-m compileall -fq" in called.err


def test_a_thread_that_cannot_be_started_is_one_sentence(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_: Thread) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(Thread, "start", fail)
    called = call("doctor")
    assert (called.code, called.out) == (1, "")
    assert called.err.startswith("The system starts no more threads for this login: ")
    assert called.err.count("\n") == 1


def test_a_command_goes_on_if_its_progress_can_have_no_thread(
    call: Call, simulated: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_: Thread) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    monkeypatch.setattr(Thread, "start", fail)
    assert call("check").code == 0
