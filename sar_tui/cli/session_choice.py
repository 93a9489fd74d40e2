"""Choice of the session that a view joins: one on this machine, or the one of an invitation."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.common import named_path
from sar_tui.cli.errors import Refused

if TYPE_CHECKING:
    from sar_tui.link.discovery import JoinableSession
    from sar_tui.link.invitation import Invitation

Joined = Annotated[
    str | None,
    typer.Argument(
        metavar="SESSION", help="The session's id, or its beginning.", show_default=False
    ),
]
Link = Annotated[
    Path | None,
    typer.Option(
        "--link",
        parser=named_path,
        metavar="FILE",
        show_default=False,
        help="Invitation to a session on another machine.",
    ),
]


def session_to_join(
    session: str | None, link: Path | None, data: Path
) -> "JoinableSession | Invitation":
    """Return the session of a data folder given by its id or the start of it, the only one there,
    or an invitation's.

    Raises:
        Refused: there is no such session, or there are several.
        LinkError: the invitation cannot be used, or packages of the link are not installed.
    """
    from sar_tui.link.errors import need_packages
    from sar_tui.link.invitation import read

    need_packages()
    return _one(data, session) if link is None else read(link)


def _one(data: Path, session: str | None) -> "JoinableSession":
    from sar_tui.link.discovery import joinable_sessions, other_folders

    live = joinable_sessions(data)
    if session == "":
        raise Refused("The session's id is missing: it is empty.")
    meant = [each for each in live if each.session.startswith(session or "")]
    if not live and (others := other_folders(data)):
        raise Refused(
            f"No session of {data} can be joined. There is one of another data folder: to join "
            "it, add --data "
            f"{others[0]}."
        )
    if not live:
        raise Refused(
            "No session on this machine can be joined. Start one with --operator, as in "
            "`sar-tui run keyboard -p P01 --operator`. Sessions of other users, or with another "
            "XDG_RUNTIME_DIR, are "
            "not found."
        )
    there = "; ".join(f"{each.session} ({each.description})" for each in live)
    if not meant:
        raise Refused(f"No session that can be joined begins with {session}. These can: {there}.")
    if len(meant) > 1:
        raise Refused(f"Several sessions can be joined: {there}. Give the id of one.")
    return meant[0]
