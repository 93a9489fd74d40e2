"""Files that SQLite refuses though it could read most of them: cut short, or with a damaged
header.
"""

import contextlib
import shutil
import sqlite3
import struct
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from sar_tui.store.database import create_file, damaged, sidecars

_MAGIC = b"SQLite format 3\0"
_HEADER = 100
"""Bytes of the header, which is the beginning of the first page
(https://www.sqlite.org/fileformat.html).
"""
_PAGE_SIZES = (4096, 1024, 2048, 8192, 16384, 32768, 65536, 512)
"""The sizes that a page may have, the usual one first."""
_SMALLEST = 512


def is_refused(path: Path) -> bool:
    """Return True if SQLite refuses a file that it could read in part: by its header, or because it
    was cut short.
    """
    size = path.stat().st_size
    if size < _SMALLEST:
        return False
    if _has_damaged_header(path):
        return True
    log, _ = sidecars(path)
    if log.exists() and log.stat().st_size:  # it may hold the pages that are missing
        return False
    with path.open("rb") as file:
        header = file.read(_HEADER)
    page_size = int.from_bytes(header[16:18], "big")
    page_size = 65536 if page_size == 1 else page_size
    return size < page_size * int.from_bytes(header[28:32], "big")


def _has_damaged_header(path: Path) -> bool:
    """Return True if the header of a file is not one that SQLite writes."""
    with path.open("rb") as file:
        header = file.read(_HEADER)
    page_size = int.from_bytes(header[16:18], "big")
    return not (
        header.startswith(_MAGIC)
        and (page_size == 1 or page_size in _PAGE_SIZES)
        and header[18] in (1, 2)
        and header[19] in (1, 2)
        and header[21:24] == b"\x40\x20\x20"
        and int.from_bytes(header[56:60], "big") in (1, 2, 3)
    )


@contextmanager
def readable_copy(path: Path) -> Iterator[Path]:
    """Yield a copy of a file, with its log, that has a header as SQLite writes it; the copy is
    removed afterwards.

    Raises:
        StoreError: no page size makes tables of what is in the file.
        OSError: the copy cannot be written.
    """
    copy = path.with_name(f".{path.stem}-readable.part")
    log, _ = sidecars(path)
    copied_log, memory = sidecars(copy)
    is_new = _has_damaged_header(path)
    try:
        for page_size in _PAGE_SIZES if is_new else (0,):
            for each in (copy, copied_log, memory):
                each.unlink(missing_ok=True)
            create_file(copy)
            shutil.copyfile(path, copy)
            has_log = log.exists() and log.stat().st_size > 0
            if has_log:
                create_file(copied_log)
                shutil.copyfile(log, copied_log)
            if is_new:
                _write_header(copy, page_size, has_log=has_log)
            if _has_tables(copy):
                yield copy
                return
        raise damaged(path)
    finally:
        for each in (copy, copied_log, memory):
            with contextlib.suppress(OSError):
                each.unlink()


def _write_header(path: Path, page_size: int, *, has_log: bool) -> None:
    pages = -(-path.stat().st_size // page_size)
    form = 2 if has_log else 1
    fixed = struct.pack(
        ">16sHBBBBBB", _MAGIC, page_size if page_size < 65536 else 1, form, form, 0, 64, 32, 32
    )
    # Change counter, pages, no free pages, schema cookie and format, cache, no vacuum, UTF-8,
    # version unknown, no id.
    numbers = struct.pack(">11I", 1, pages, 0, 0, 1, 4, 0, 0, 1, 0, 0)
    header = (
        fixed
        + numbers
        + struct.pack(">I", 0)
        + bytes(20)
        + struct.pack(">II", 1, sqlite3.sqlite_version_info[1])
    )
    with path.open("rb+") as file:
        file.write(header)
        file.truncate(pages * page_size)


def _has_tables(path: Path) -> bool:
    try:
        with closing(open_wary(path)) as database:
            return bool(
                database.execute("SELECT 1 FROM sqlite_master WHERE name='sessions'").fetchone()
            )
    except sqlite3.Error:
        return False


def open_wary(path: Path, timeout: float = 0) -> sqlite3.Connection:
    """Open a damaged database so that SQLite reads what it can, and runs nothing that is in its
    schema.
    """
    database = sqlite3.connect(path, timeout=timeout, isolation_level=None)
    # tolerates pages that are missing, and a schema that is read in part
    database.execute("PRAGMA writable_schema=ON")
    database.execute("PRAGMA trusted_schema=OFF")
    return database
