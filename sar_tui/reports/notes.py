"""Notes and event marks of a session. Pure."""

from collections.abc import Sequence

import msgspec

from sar_tui.model import messages as m
from sar_tui.reports.logged_messages import LoggedMessage, spans
from sar_tui.reports.presence import seconds


class Note(msgspec.Struct, frozen=True):
    """Note, or event mark with its ``label``. ``at_s``: of the key, from the start of its run."""

    run: int
    at_s: float
    actor: str
    text: str
    label: str


def notes(messages: Sequence[LoggedMessage]) -> list[Note]:
    """Return all notes and event marks of a session, in order."""
    known = spans(messages)
    return [
        Note(
            run,
            seconds((message.at or at) - known[run].began),
            message.actor,
            message.text,
            message.label,
        )
        for run, at, message in messages
        if isinstance(message, m.NoteAdded) and run in known
    ]
