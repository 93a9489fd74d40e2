"""What the app leaves in the terminal when it has closed: what became of the session, and how to get back to it."""

import contextlib
import shlex
import sys
from typing import TYPE_CHECKING

from sar_tui.store.database import default_folder

if TYPE_CHECKING:
    from sar_tui.app.app import SarTui

INTERRUPTED = 130
"""Exit code after Ctrl-C."""
UNSAVED = "The disk would not take the session's last messages; the trials acknowledged before are safe."


def say_last_words(app: "SarTui", code: int) -> None:
    """Print them."""
    for line in last_words(app, code):
        with contextlib.suppress(OSError):  # the terminal may be gone: then there is nobody to tell
            print(line, file=sys.stderr)


def last_words(app: "SarTui", code: int) -> list[str]:
    """What there is to say, a line each."""
    words = [app.failure] if app.failure else []
    if code == INTERRUPTED:
        words.append("Stopped with Ctrl-C.")
    live = app.live
    if live and not live.run.session.ended and not live.run.session.broken:
        words.append(f"The session is kept. Go on with it: {_command(app, 'resume', live.run.id)}")
    elif live and app.begins_at_once:
        words.append(f"The session is kept. Look at it: {_command(app, 'show', live.run.id)}")
        if live.can_be_joined:
            words.append(f"What operators did: {_command(app, 'report wizard', live.run.id)}")
    if live and live.unsaved:
        words.append(UNSAVED)
    return words


def _command(app: "SarTui", name: str, session: str) -> str:
    """A command for a session, as it has to be typed from here."""
    words = ["sar-tui", *name.split(), session]
    if app.folder.resolve() != default_folder().resolve():
        words += ["--data", str(app.folder)]
    for folder in app.catalogue.extra_tasks:
        words += ["--tasks", str(folder)]
    return shlex.join(words)
