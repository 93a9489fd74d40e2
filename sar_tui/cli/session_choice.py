"""Which session a view joins: one of this machine, or the one that an invitation is to."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sar_tui.cli.errors import Refused

if TYPE_CHECKING:
    from sar_tui.link.discovery import JoinableSession
    from sar_tui.link.invitation import Invitation

Joined = Annotated[
    str | None, typer.Argument(metavar="SESSION", help="Its id, or the beginning of it.", show_default=False)
]
Link = Annotated[
    Path | None,
    typer.Option("--link", metavar="FILE", show_default=False, help="The invitation to another machine's session."),
]


def session_to_join(session: str | None, link: Path | None) -> "JoinableSession | Invitation":
    """The session meant by its id, or the beginning of it; by an invitation; or the only one there is.

    Raises:
        Refused: there is no such session, or it is not clear which.
        LinkError: the invitation cannot be used, or what the link needs is not installed.
    """
    from sar_tui.link.discovery import live_sessions
    from sar_tui.link.errors import need_packages
    from sar_tui.link.invitation import read

    need_packages()
    return _one(live_sessions(), session) if link is None else read(link)


def _one(live: "Sequence[JoinableSession]", session: str | None) -> "JoinableSession":
    meant = [each for each in live if each.session.startswith(session or "")]
    if not live:
        raise Refused(
            "No session on this machine can be joined; one that can is begun with --operator, as in "
            "`sar-tui run keyboard -p P01 --operator`. One of another user, or with another XDG_RUNTIME_DIR, is not "
            "seen here."
        )
    there = ", ".join(f"{each.session} ({each.task})" for each in live)
    if not meant:
        raise Refused(f"No session that can be joined begins with {session}; there is: {there}.")
    if len(meant) > 1:
        raise Refused(f"Several sessions can be joined: {there}. Say which.")
    return meant[0]
