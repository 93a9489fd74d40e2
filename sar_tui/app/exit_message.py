"""The lines that the app leaves in the terminal: what became of the session, and the command to get
back to it.
"""

import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from sar_tui.store.database import default_folder
from sar_tui.tui.exit_codes import INTERRUPTED

if TYPE_CHECKING:
    from sar_tui.app.live import LiveSession

UNSAVED = (
    "The session's last messages could not be written to the disk; all earlier trials are safe."
)


def exit_message(
    code: int,
    failure: str,
    live: "LiveSession | None",
    folder: Path,
    tasks: Sequence[Path],
    *,
    names_ended_session: bool,
) -> Iterator[str]:
    """Yield the lines to print.

    Args:
        code: the exit code.
        failure: why the app ended, if it failed.
        live: its last session, if there was one.
        folder: the data folder.
        tasks: folders that `--tasks` named.
        names_ended_session: True if the app was opened for this session only.
    """

    def command(name: str, *session: str) -> str:
        parts = ["sar-tui", *name.split(), *session]
        if folder.resolve() != default_folder().resolve():
            parts += ["--data", str(folder)]
        for each in tasks:
            parts += ["--tasks", str(each)]
        return shlex.join(parts)

    if failure:
        yield failure
    if code == INTERRUPTED:
        yield "Stopped with Ctrl-C."
    if live and live.rescued:
        yield f"{live.rescued} Bring it back into the database: {command('rescue')}"
    if live and live.trouble:
        yield live.trouble
    if live and live.is_mistake and not live.trouble:
        yield (
            "The session does not count, as it was started by mistake. It is kept: in sar-tui, "
            "F6 and Del restore it."
        )
    elif live and not live.run.session.ended and not live.run.session.broken:
        yield f"The session is kept. Resume it: {command('resume', live.run.id)}"
    elif live and names_ended_session:
        yield f"The session is kept. Look at it: {command('show', live.run.id)}"
        if live.can_be_joined:
            yield f"What operators did: {command('report wizard', live.run.id)}"
    if live and live.unsaved:
        yield UNSAVED
