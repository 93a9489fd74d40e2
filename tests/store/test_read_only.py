"""Data can be read where nothing can be written, such as on an archive."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from sar_tui.store import sessions
from sar_tui.store.database import FILE, StoreError, connect, connect_to_read
from tests.store.test_sessions import enter

REFUSED = "cannot be written to|is read-only|may you write to it"
"""Pattern of the messages: the system refuses the owner of the files and anybody else at different
calls.
"""
NOBODY = 65534
"""User id of ``nobody``, who owns no files: the superuser can write anywhere."""
pytestmark = pytest.mark.skipif(os.name != "posix", reason="permissions are those of POSIX")


@contextmanager
def as_owner() -> Iterator[None]:
    """Act as the user who runs the tests again, for a moment."""
    user = os.geteuid()
    os.seteuid(os.getuid())
    try:
        yield
    finally:
        os.seteuid(user)


@pytest.fixture
def archive() -> Iterator[Path]:
    """A data folder with a session that nobody may write to, as this user or, for the superuser, as
    another.
    """
    user = os.geteuid()
    with tempfile.TemporaryDirectory() as name:
        top, folder = Path(name), Path(name) / "data"
        with closing(connect(folder)) as database:
            enter(database)
        (folder / "locks").mkdir(mode=0o700)
        for path in (top, folder, folder / "locks"):
            path.chmod(0o555)
        (folder / FILE).chmod(0o444)
        if user == 0:
            os.seteuid(NOBODY)
        try:
            yield folder
        finally:
            os.seteuid(user)
            for path in (top, folder, folder / "locks"):
                path.chmod(0o700)


def test_the_sessions_of_a_folder_that_is_read_only_are_listed(archive: Path) -> None:
    with closing(connect_to_read(archive)) as database:
        (row,) = sessions.listing(database, archive)
        assert (row["task"], row["status"]) == ("keyboard", "interrupted")
    with pytest.raises(StoreError, match=REFUSED):
        connect(archive)


def test_a_read_only_folder_whose_log_was_not_merged_is_reported(archive: Path) -> None:
    with as_owner():
        archive.chmod(0o700)
        (archive / f"{FILE}-wal").write_bytes(b"not merged")
        archive.chmod(0o555)
    with pytest.raises(StoreError, match=REFUSED):
        connect_to_read(archive)


def test_a_folder_that_may_not_even_be_looked_into_is_reported(archive: Path) -> None:
    with as_owner():
        archive.chmod(0o000)
    with pytest.raises(StoreError, match="Permission denied"):
        connect_to_read(archive)
