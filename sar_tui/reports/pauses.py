"""When the participant paused, and how they said they were. Pure."""

from collections.abc import Collection, Sequence

import msgspec

from sar_tui.framework import messages as m
from sar_tui.reports.presence import seconds
from sar_tui.reports.record import Told, spans


class Pause(msgspec.Struct, frozen=True):
    """A pause that the participant asked for: from ``at_s`` (since its run's beginning) on, for ``duration_s``.

    ``reason``: as they gave it, ``tired``, ``pain``, ``finished``, or empty; ``ended_by``: who went on, empty where the
    run ended with it.
    """

    run: int
    at_s: float
    duration_s: float
    reason: str
    ended_by: str


def pauses(told: Sequence[Told], operators: Collection[str]) -> list[Pause]:
    """All of a session, in order. ``operators``: whose pauses are none of the participant's."""
    known = spans(told)
    found: list[Pause] = []
    is_open = is_paused = False

    for run, at, message in told:
        if run not in known:
            continue
        if is_open and found[-1].run == run:
            lasted = seconds(at - known[run].began) - found[-1].at_s
            found[-1] = msgspec.structs.replace(found[-1], duration_s=round(lasted, 3))
        match message:
            case m.SessionStarted():
                is_open = is_paused = False
            case m.Operator(command="pause") if message.actor not in operators:
                if not is_open:
                    found.append(Pause(run, seconds(at - known[run].began), 0.0, "", ""))
                    is_open = True
                if message.reason:  # they pause first, and may say then how they are
                    found[-1] = msgspec.structs.replace(found[-1], reason=message.reason)
            case m.Operator(command="resume") if is_open:
                found[-1] = msgspec.structs.replace(found[-1], ended_by=message.actor)
            case m.Waiting():
                if message.stage != "paused" and is_open:
                    is_open = False
                    if not is_paused:
                        found.pop()  # it could not be just then
                is_paused = message.stage == "paused"
    return found
