"""Failures to make a file or folder, said of the name that the user gave and not of a hidden one
beside it.
"""

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sar_tui.drivers.private_folder import make_private
from sar_tui.export.errors import ExportError

_FULL = (errno.ENOSPC, errno.EDQUOT)


@contextmanager
def made_beside(path: Path) -> Iterator[None]:
    """Make the folder that a path is in, and run a block that makes hidden files there.

    Raises:
        ExportError: the folder cannot be made or written to.
        OSError: the disk is full.
    """
    above = next(folder for folder in path.absolute().parents if folder.exists())
    if not above.is_dir():
        raise ExportError(f"{path} cannot be made: {above} is a file.", bad_input=True)
    try:
        make_private(path.absolute().parent)
        yield
    except OSError as error:
        if error.errno in _FULL:
            raise
        if error.errno == errno.ENAMETOOLONG:
            raise ExportError(
                f"{path} is too long for the name of a file or folder.", bad_input=True
            ) from error
        raise ExportError(f"{path} cannot be made: {error.strerror or error}.") from error
