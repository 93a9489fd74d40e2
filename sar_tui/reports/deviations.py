"""What an operator did beside the session's plan, and what did not come through. Pure."""

from collections.abc import Collection, Iterator, Sequence

import msgspec

from sar_tui.framework import messages as m
from sar_tui.reports.presence import seconds
from sar_tui.reports.record import Told, spans

_STEERING = ("level", "skip", "repeat", "pause", "end", "stop", "mark")
"""Of the commands, those that make a session another than it would have been; a pause ends by itself."""


class Deviation(msgspec.Struct, frozen=True):
    """One of them: ``what``, ``at_s`` since the beginning of its run, and by whom.

    ``what``: ``mode``, ``level``, ``skip``, ``repeat``, ``pause``, ``end``, ``stop``, ``mark``; ``baton`` (another
    operator holds it); ``lost``, ``left`` (an operator); ``refused`` (an act was not let in), ``missed`` (it came to
    nothing). ``count``: for refused acts, of how many this tells. ``duration_s``: of a pause.
    """

    run: int
    at_s: float
    what: str
    actor: str
    detail: str = ""
    count: int = 1
    duration_s: float | None = None


def deviations(told: Sequence[Told], operators: Collection[str]) -> list[Deviation]:
    """All of a session, in order. ``operators``: whose steering counts; a participant's own pause is none."""
    known = spans(told)
    holder = ""
    found = []
    for index, (run, at, message) in enumerate(told):
        if run not in known:
            continue
        if isinstance(message, m.OperatorChanged) and message.state == "baton":
            holder, before = message.actor, holder
            if before in ("", holder):
                continue
        for what, detail in _deviation(message, operators):
            count = message.count if isinstance(message, m.ActRefused) else 1
            duration = _pause_s(told, index) if what == "pause" else None
            at_s = seconds(at - known[run].began)
            found.append(Deviation(run, at_s, what, getattr(message, "actor", ""), detail, count, duration))
    return found


def _deviation(message: m.Message, operators: Collection[str]) -> Iterator[tuple[str, str]]:
    match message:
        case m.ModeChanged():
            yield "mode", f"{message.kind}: {message.mode}"
        case m.Operator(command=what) if message.actor in operators and what in _STEERING:
            yield what, "" if message.value is None and what == "level" else str(message.value or message.reason)
        case m.OperatorChanged(state="baton"):
            yield "baton", ""
        case m.OperatorChanged(role="operator", state="lost" | "left" as what):
            yield what, message.detail
        case m.ActRefused():
            yield "refused", f"{message.what}: {message.why}"
        case m.ActMissed():
            yield "missed", f"{message.what}: {message.why}"


def _pause_s(told: Sequence[Told], index: int) -> float:
    """How long a pause lasted: until the session waits for something else, or its run ends; 0 if it was none."""
    run, at, _ = told[index]
    until = at
    for later in told[index + 1 :]:
        if later.run != run:
            break
        until = later.at
        if isinstance(later.message, m.Waiting) and later.message.stage != "paused":
            break
    return seconds(until - at)
