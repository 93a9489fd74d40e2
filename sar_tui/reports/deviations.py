"""Deviations from the plan: operators' commands, lost operators, refused requests and late
decisions. Pure.
"""

from collections.abc import Collection, Iterator, Sequence

import msgspec

from sar_tui.model import messages as m
from sar_tui.reports.logged_messages import LoggedMessage, peers, spans
from sar_tui.reports.presence import seconds

_COMMANDS = ("level", "skip", "repeat", "pause", "end", "stop", "mark", "undo")
"""Commands that count as deviations. `resume` does not: it only ends a pause."""


class Deviation(msgspec.Struct, frozen=True):
    """Deviation from the plan.

    Attributes:
        at_s: from the start of its run.
        what: ``mode``, ``level``, ``skip``, ``repeat``, ``pause``, ``end``, ``stop``, ``mark``,
            ``undo``; ``theme`` (that of the first run was not there any more); ``baton`` (stored spelling:
            another operator took control); ``lost``, ``left``, ``unproven`` (an operator, whose
            terminal nothing proves to be there); ``refused`` (a request), ``missed`` (a late
            decision).
        actor: who caused it.
        count: number of refused requests that one message reports.
        duration_s: of a pause.
    """

    run: int
    at_s: float
    what: str
    actor: str
    detail: str = ""
    count: int = 1
    duration_s: float | None = None


def deviations(messages: Sequence[LoggedMessage], operators: Collection[str]) -> list[Deviation]:
    """Return all deviations of a session, in order. ``operators``: those whose commands count.

    An observer's stop counts, too.
    """
    operators = {*operators, *peers(messages, "observer")}
    known = spans(messages)
    holder = ""
    found = []
    themes = [message.theme for _, _, message in messages if isinstance(message, m.SessionStarted)]
    for index, (run, at, message) in enumerate(messages):
        if run not in known:
            continue
        if isinstance(message, m.OperatorChanged) and message.state == "baton":
            holder, before = message.actor, holder
            if before in ("", holder):
                continue
        for what, detail in _deviation(message, operators, themes[0]):
            count = message.count if isinstance(message, m.PeerRequestRefused) else 1
            duration = _pause_s(messages, index) if what == "pause" else None
            at_s = seconds(at - known[run].began)
            found.append(
                Deviation(run, at_s, what, getattr(message, "actor", ""), detail, count, duration)
            )
    return found


def _deviation(
    message: m.Message, operators: Collection[str], theme: str
) -> Iterator[tuple[str, str]]:
    match message:
        case m.SessionStarted() if message.theme != theme:
            yield "theme", f"{message.theme} instead of {theme}"
        case m.ModeChanged():
            yield "mode", f"{message.kind}: {message.mode}"
        case m.SessionCommand(command="skip", reason="step") if message.actor in operators:
            yield "skip", f"step {message.value}"
        case m.SessionCommand(command=what) if message.actor in operators and what in _COMMANDS:
            yield (
                what,
                ""
                if message.value is None and what == "level"
                else str(message.value or message.reason),
            )
        case m.OperatorChanged(state="baton"):
            yield "baton", ""
        case m.OperatorChanged(role="operator", state="lost" | "left" | "unproven" as what):
            yield what, message.detail
        case m.PeerRequestRefused():
            yield "refused", f"{message.what}: {message.why}"
        case m.LateDecision():
            yield "missed", f"{message.what}: {message.why}"


def _pause_s(messages: Sequence[LoggedMessage], index: int) -> float:
    """Return the duration of a pause, in s: until the session continues or its run ends; 0 if it
    did not pause.
    """
    run, at, _ = messages[index]
    until = at
    for later in messages[index + 1 :]:
        if later.run != run:
            break
        until = later.at
        if isinstance(later.message, m.Waiting) and later.message.stage != "paused":
            break
    return seconds(until - at)


# --- pauses


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
