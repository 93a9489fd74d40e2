"""``sar-tui demo``: the app with invented people, in a folder that is removed afterwards."""

import os
import shlex
import shutil
import signal
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Annotated

import typer

from sar_tui.cli.common import Home, named_path, need_screen
from sar_tui.cli.errors import Refused
from sar_tui.cli.progress_line import progress_line
from sar_tui.tui.exit_codes import after_signal

_PREFIX = "sar-tui-demo-"
"""Beginning of the name of a folder that is removed."""
_LOCK = ("demo", "folder")
"""Lock in such a folder, held as long as it is in use."""


def demo(
    context: typer.Context,
    keep: Annotated[
        Path | None,
        typer.Option(
            "--keep",
            parser=named_path,
            metavar="FOLDER",
            show_default=False,
            help="Make the data folder here and keep it, and do not open the app.",
        ),
    ] = None,
) -> None:
    """Look around with six invented people.

    The app opens on eight weeks of their sessions. Try everything: nothing is kept.
    """
    home = context.find_object(Home) or Home()
    if home.data is not None:
        raise Refused(
            "A demonstration has a folder of its own: leave out --data. "
            "To keep it: sar-tui demo --keep FOLDER"
        )
    if keep is not None:
        _keep(keep)
        look = shlex.join(("sar-tui", "--data", str(keep)))
        print(f"The demonstration is in {keep}. Look at it: {look}")
        return
    need_screen()
    catalogue = home.catalogue()
    with _until_closed() as folder:
        _make(folder)
        from sar_tui.app.app import run_app

        ended = run_app(folder, catalogue, is_kept=False)
    raise typer.Exit(ended)


def _keep(folder: Path) -> None:
    """Make a data folder, or nothing of it if a signal or an error ends that."""
    from sar_tui.runs.demonstration import check_free

    check_free(folder)
    with _ended_by_signals():
        try:
            _make(folder)
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise


def _make(folder: Path) -> None:
    """Make the data folder; show on the terminal how far that is."""
    from sar_tui.runs.demonstration import make_demonstration

    what = "Inventing six people and their sessions"
    with progress_line(what) as show:
        make_demonstration(folder, progress=lambda done, of: show(what, done, of))


# --- a folder that is removed


@contextmanager
def _until_closed() -> Iterator[Path]:
    """Yield the name of a data folder in a private one, which is removed with all that is in it,
    also if a signal ends the program; first remove those of programs that were killed.
    """
    from sar_tui.store.locks import hold

    _remove_leftovers()
    with _ended_by_signals():
        folder = Path(tempfile.mkdtemp(prefix=_PREFIX))
        try:
            lock = hold(folder, *_LOCK)
            try:
                yield folder / "data"
            finally:
                lock.release()
        finally:
            shutil.rmtree(folder, ignore_errors=True)


def _remove_leftovers() -> None:
    """Remove the folders of this user's programs that have ended without removing theirs."""
    from sar_tui.store.database import StoreError
    from sar_tui.store.locks import hold

    for folder in Path(tempfile.gettempdir()).glob(f"{_PREFIX}*"):
        if _is_own(folder) and (folder / "locks").is_dir():
            try:
                hold(folder, *_LOCK).release()
            except StoreError:  # its program runs
                continue
            shutil.rmtree(folder, ignore_errors=True)


def _is_own(folder: Path) -> bool:
    """Return True for a folder, not a link to one, of this user."""
    try:
        if folder.is_symlink() or not folder.is_dir():
            return False
        return os.name != "posix" or folder.lstat().st_uid == os.getuid()
    except OSError:
        return False


class _Signalled(BaseException):
    """A signal came that ends the program. No part of a session takes it for an error of its own."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


@contextmanager
def _ended_by_signals() -> Iterator[None]:
    """Let signals that end the program raise, so that it ends in order. The app has its own way."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise _Signalled(number)

    names = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")
    numbers = [getattr(signal, name) for name in names if hasattr(signal, name)]
    before = {number: signal.signal(number, stop) for number in numbers}
    try:
        yield
    except _Signalled as signalled:
        print("Stopped.", file=sys.stderr)
        raise typer.Exit(after_signal(signalled.number)) from None
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
