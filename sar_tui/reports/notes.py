"""What was written down while a session ran: remarks, and event marks. Pure."""

from collections.abc import Sequence

import msgspec

from sar_tui.framework import messages as m
from sar_tui.reports.presence import seconds
from sar_tui.reports.record import Told, spans


class Written(msgspec.Struct, frozen=True):
    """A remark, or an event mark with its ``label``: ``at_s`` since its run's beginning, when its key was pressed."""

    run: int
    at_s: float
    actor: str
    text: str
    label: str


def written(told: Sequence[Told]) -> list[Written]:
    """All of a session, in order."""
    known = spans(told)
    return [
        Written(run, seconds((message.at or at) - known[run].began), message.actor, message.text, message.label)
        for run, at, message in told
        if isinstance(message, m.NoteAdded) and run in known
    ]
