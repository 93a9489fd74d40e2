"""Presence of operators, and the time for which each mode was set. Pure."""

from collections.abc import Iterable, Sequence

import msgspec

from sar_tui.model import messages as m
from sar_tui.model.messages import ControlledKind, Mode
from sar_tui.reports.logged_messages import LoggedMessage, spans
from sar_tui.rules import arbitration
from sar_tui.rules.parameters import TaskParameters

_NS = 1e9


class Absence(msgspec.Struct, frozen=True):
    """Time without an operator after there had been one.

    Attributes:
        at_s: from the start of its run.
        actor: the last operator.
        state: ``left`` or ``lost``.
        detail: reason for the loss.
        came_back: True if there was an operator again before the run ended.
    """

    run: int
    at_s: float
    duration_s: float
    actor: str
    state: str
    detail: str
    came_back: bool


class Presence(msgspec.Struct, frozen=True):
    """Duration of all runs, and of the time with an operator (s)."""

    duration_s: float
    operated_s: float
    absences: tuple[Absence, ...]


def presence(messages: Sequence[LoggedMessage]) -> Presence:
    """Return the presence of operators. The time before the first one joins is not an absence."""
    known = spans(messages)
    operated, absences = 0, []
    since: dict[int, int] = {}
    gone: dict[int, tuple[int, m.OperatorChanged]] = {}

    def absent(run: int, until: int, *, came_back: bool) -> None:
        at, changed = gone.pop(run)
        absences.append(
            Absence(
                run=run,
                at_s=seconds(at - known[run].began),
                duration_s=seconds(until - at),
                actor=changed.actor,
                state=changed.state,
                detail=changed.detail,
                came_back=came_back,
            )
        )

    for run, at, message in messages:
        if isinstance(message, m.SessionStarted):
            since.pop(run, None)  # the arbiter forgets operators when a run begins
        if not isinstance(message, m.OperatorChanged) or run not in known:
            continue
        if message.operated and run not in since:
            since[run] = at
            if run in gone:
                absent(run, at, came_back=True)
        elif not message.operated and run in since:
            operated += at - since.pop(run)
            gone[run] = at, message
    operated += sum(known[run].ended - began for run, began in since.items())
    for run in list(gone):
        absent(run, known[run].ended, came_back=False)
    absences.sort(key=lambda absence: (absence.run, absence.at_s))
    duration = sum(span.ended - span.began for span in known.values())
    return Presence(seconds(duration), seconds(operated), tuple(absences))


class ModeTime(msgspec.Struct, frozen=True):
    """Time for which a mode was set for a kind of action. ``unattended_s``: of that, without an
    operator.
    """

    kind: ControlledKind
    mode: Mode
    time_s: float
    unattended_s: float


def mode_times(messages: Iterable[LoggedMessage], parameters: TaskParameters) -> list[ModeTime]:
    """Return the time of each kind and mode over all runs, without modes that were never set."""
    messages = list(messages)
    known = spans(messages)
    state = arbitration.start(parameters)
    times: dict[tuple[ControlledKind, Mode], list[int]] = {}
    last: dict[int, int] = {}

    def pass_until(run: int, at: int) -> None:
        lasted = at - last[run]
        for each in state.modes.items():
            spent = times.setdefault(each, [0, 0])
            spent[0] += lasted
            spent[1] += 0 if state.operated else lasted
        last[run] = at

    for run, at, message in messages:
        if run in last:
            pass_until(run, max(at, last[run]))
        match message:
            case m.SessionStarted():
                last[run] = known[run].began
                state = msgspec.structs.replace(state, operated=False)
            case m.OperatorChanged():
                state = msgspec.structs.replace(state, operated=message.operated)
            case m.ModeChanged():
                state = arbitration.set_mode(state, message.kind, message.mode)
    return [
        ModeTime(kind, mode, seconds(time), seconds(unattended))
        for (kind, mode), (time, unattended) in sorted(times.items(), key=_in_order)
    ]


def _in_order(item: tuple[tuple[ControlledKind, Mode], object]) -> tuple[int, int]:
    (kind, mode), _ = item
    return KINDS.index(kind), MODES.index(mode)


KINDS: tuple[ControlledKind, ...] = (
    "feedback",
    "encouragement",
    "instruction",
    "gesture",
    "difficulty",
)
MODES: tuple[Mode, ...] = ("autonomous", "veto", "approve", "manual")


def seconds(ns: int) -> float:
    """Return seconds, to the millisecond."""
    return round(ns / _NS, 3)
