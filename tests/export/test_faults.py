"""Every format: a full disk, a kill, a wrong target or a hard session leave the target absent or
complete.
"""

import shutil
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from sar_tui.export.errors import ExportError
from sar_tui.export.registry import names
from sar_tui.export.target import LOCK
from sar_tui.store.database import FILE, connect
from tests.export.exported import export_as
from tests.export.hard_study import EMPTY, INTERRUPTED, store_study
from tests.program import Call
from tests.store.by_hand import sql
from tests.store.make_golden import RELEASES, unpack

FORMATS = names()
EVERYTHING = ("--all", "--mixed")


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data folder, closed, with all that is hard to export."""
    data = tmp_path_factory.mktemp("stored") / "data"
    store_study(data)
    return data


@pytest.fixture
def study(stored: Path, tmp_path: Path) -> Path:
    """A copy of it."""
    return Path(shutil.copytree(stored, tmp_path / "data"))


def content(data: Path) -> str:
    """Return all that a database holds but the ledger of exports."""
    with closing(sqlite3.connect(data / FILE)) as database:
        return "\n".join(line for line in database.iterdump() if 'INTO "exports"' not in line)


def others(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()} - {"data"}


def files(folder: Path) -> set[str]:
    """Return the files that have their final names, and not the lock of a folder that many sites
    share.
    """
    found = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    return {name for name in found if ".sar-tui-" not in name} - {LOCK}


def hidden(folder: Path) -> set[str]:
    """Return the hidden folders of exports that were not completed."""
    return {path.name for path in folder.rglob(".*.sar-tui-*")}


@contextmanager
def small_disk(largest: int) -> Iterator[None]:
    """Let no file grow beyond a number of bytes, as on a disk that is full."""
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    # would be cut off, too
    writes_bytecode, sys.dont_write_bytecode = (not sys.dont_write_bytecode, True)
    resource.setrlimit(resource.RLIMIT_FSIZE, (largest, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, before)
        sys.dont_write_bytecode = not writes_bytecode


@pytest.mark.skipif(sys.platform == "win32", reason="limits the size of files")
@pytest.mark.parametrize("format", FORMATS)
def test_a_full_disk_leaves_no_export_and_the_database_as_it_was(
    study: Path, tmp_path: Path, call: Call, format: str
) -> None:
    before = content(study)
    with small_disk(600):
        called = call("export", *EVERYTHING, "--format", format, "--to", tmp_path / "out")
    assert called.code == 1, called.out
    assert len(called.err.strip().splitlines()) == 1, called.err
    assert "Traceback" not in called.err
    assert (files(tmp_path / "out"), hidden(tmp_path)) == (set(), set())
    assert others(tmp_path) <= {"out"}
    assert content(study) == before


@pytest.mark.skipif(sys.platform == "win32", reason="symbolic links")
def test_a_link_is_no_way_to_replace_its_target(study: Path, tmp_path: Path, call: Call) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "thesis.tex").write_text("x")
    (tmp_path / "out").symlink_to(tmp_path / "elsewhere")
    called = call("export", *EVERYTHING, "--to", tmp_path / "out")
    assert called.code != 0
    assert (tmp_path / "elsewhere" / "thesis.tex").read_text() == "x"
    assert others(tmp_path) == {"elsewhere", "out"}


@pytest.mark.parametrize("format", FORMATS)
def test_hard_sessions_are_named_and_others_leave(study: Path, tmp_path: Path, format: str) -> None:
    with closing(connect(study)) as database:
        database.execute("UPDATE sessions SET task='forgotten' WHERE task='pairs'")
        stored = {id for (id,) in database.execute("SELECT id FROM sessions")}
    before = content(study)
    exported = export_as(format, study, tmp_path / "out")
    said = " ".join(exported.problems)
    assert {id for id in stored - set(exported.sessions) if id not in said} == set()
    assert stored - set(exported.sessions) <= {EMPTY, INTERRUPTED}
    assert content(study) == before


@pytest.mark.parametrize(
    ("format", "module", "extra"),
    [("mat", "scipy.io", "export"), ("elan", "pympi", "export"), ("parquet", "pyarrow", "lake")],
)
def test_a_format_whose_package_is_missing_says_how_to_install_it(
    study: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    format: str,
    module: str,
    extra: str,
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ExportError, match=rf"pip install -e '\.\[{extra}\]'"):
        export_as(format, study, tmp_path / "out")
    assert not files(tmp_path / "out")


@pytest.mark.parametrize("release", RELEASES)
@pytest.mark.parametrize("format", FORMATS)
def test_sessions_of_every_release_leave(tmp_path: Path, format: str, release: str) -> None:
    data = unpack(release, tmp_path / "data")
    stored = {id for (id,) in sql(data, "SELECT id FROM sessions")}
    assert set(export_as(format, data, tmp_path / "out").sessions) == stored


@pytest.mark.skipif(sys.platform == "win32", reason="ends a program with a signal")
@pytest.mark.slow
@pytest.mark.parametrize(
    "end", [signal.SIGTERM if sys.platform == "win32" else signal.SIGKILL, signal.SIGINT]
)
@pytest.mark.parametrize("format", FORMATS)
def test_an_export_that_is_ended_at_any_moment_is_absent_or_complete(
    study: Path, tmp_path: Path, format: str, end: signal.Signals
) -> None:
    """Ended when it opens its first, third and ninth file."""
    before = content(study)
    for moment in (1, 3, 9):
        ended = subprocess.run(
            [sys.executable, "-c", _ENDED, str(tmp_path), str(moment), str(int(end)), format],
            timeout=60, check=False, capture_output=True,
        )  # fmt: skip
        assert ended.returncode != 0 or (tmp_path / "out").is_dir()
        assert content(study) == before
        assert not files(tmp_path / "out") or [*(tmp_path / "out").rglob("sar-tui-export.json")]
    export_as(format, study, tmp_path / "out")
    assert (others(tmp_path), hidden(tmp_path)) == ({"out"}, set())


_ENDED = """
import itertools, os, sys
from pathlib import Path
place, moment, end, format = Path(sys.argv[1]), *map(int, sys.argv[2:4]), sys.argv[4]
count = itertools.count(1)
def watch(event, values):
    if event == "open" and ".sar-tui-" in str(values[0]) and next(count) == moment:
        os.kill(os.getpid(), end)
from tests.export.exported import export_as
sys.addaudithook(watch)
export_as(format, place / "data", place / "out")
"""
