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


def test_a_run_under_a_limit_leaves_no_module_that_is_cut_short(tmp_path: Path) -> None:
    root, checkout = Path(sar_tui.__file__).parents[1], tmp_path / "checkout"
    ignored = shutil.ignore_patterns("__pycache__")
    for name in ("sar_tui", "tasks", "themes"):
        shutil.copytree(root / name, checkout / name, ignore=ignored)
    limited(tmp_path / "data", "tasks", bytes=4096, program=checkout)
    kept = list(checkout.rglob("*.pyc"))
    assert not [path for path in kept if path.name.startswith("commands.cpython")]
    assert all(path.stat().st_size < 4096 for path in kept)


@pytest.mark.usefixtures("simulated")
def test_a_file_that_may_not_grow_is_one_sentence_with_the_limit(call: Call, data: Path) -> None:
    done = limited(data, "backup", bytes=8192)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (1, "", 1)
    assert "may write no file larger than 8,192 bytes (ulimit -f)." in done.stderr
    assert call("check").code == 0


@pytest.fixture
def no_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: Thread) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(Thread, "start", fail)


@pytest.mark.usefixtures("no_threads")
def test_a_thread_that_cannot_be_started_is_one_sentence(call: Call) -> None:
    called = call("doctor")
    called.refused("The system starts no more threads for this login: ", code=1)
    assert called.err.count("\n") == 1


@pytest.mark.usefixtures("simulated", "no_threads")
def test_a_command_goes_on_if_its_progress_can_have_no_thread(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    assert call("check").code == 0
