"""Pauses of the participant, with their reasons. Pure."""

from collections.abc import Collection, Sequence

import msgspec

from sar_tui.model import messages as m
from sar_tui.reports.logged_messages import LoggedMessage, spans
from sar_tui.reports.presence import seconds


class Pause(msgspec.Struct, frozen=True):
    """Pause of the participant.

    Attributes:
        at_s: from the start of its run.
        reason: ``tired``, ``pain``, ``finished`` or empty.
        ended_by: the person who resumed; empty if the run ended.
    """

    run: int
    at_s: float
    duration_s: float
    reason: str
    ended_by: str


def pauses(messages: Sequence[LoggedMessage], operators: Collection[str]) -> list[Pause]:
    """Return all pauses of the participant, in order. ``operators``: those whose pauses do not
    count.
    """
    known = spans(messages)
    found: list[Pause] = []
    is_open = is_paused = False

    for run, at, message in messages:
        if run not in known:
            continue
        if is_open and found[-1].run == run:
            lasted = seconds(at - known[run].began) - found[-1].at_s
            found[-1] = msgspec.structs.replace(found[-1], duration_s=round(lasted, 3))
        match message:
            case m.SessionStarted():
                is_open = is_paused = False
            case m.SessionCommand(command="pause") if message.actor not in operators:
                if not is_open:
                    found.append(Pause(run, seconds(at - known[run].began), 0.0, "", ""))
                    is_open = True
                if message.reason:  # given after the pause has begun
                    found[-1] = msgspec.structs.replace(found[-1], reason=message.reason)
            case m.SessionCommand(command="resume") if is_open:
                found[-1] = msgspec.structs.replace(found[-1], ended_by=message.actor)
            case m.Waiting():
                if message.stage != "paused" and is_open:
                    is_open = False
                    if not is_paused:
                        found.pop()  # the command had no effect: the session could not pause
                is_paused = message.stage == "paused"
    return found
