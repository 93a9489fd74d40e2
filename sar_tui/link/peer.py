"""Interface between a panel and a session in another program: what a peer receives, and what it can
send.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol, TypeVar

import msgspec

from sar_tui.loop.bus import Topic
from sar_tui.loop.marks import TrialMark
from sar_tui.model.messages import Message, Role
from sar_tui.model.trial_types import Metric

if TYPE_CHECKING:
    from sar_tui.loop.task import Task

M = TypeVar("M", bound=Message)


class Frame(NamedTuple):
    """Message of the session's bus, with its sequence number and the time of its cascade (ns)."""

    seq: int
    at: int
    topic: Topic[Any]
    message: Message


class MarkKey(msgspec.Struct, frozen=True):
    """Mark that a therapist can set: its name and its title."""

    name: str
    title: str


class Welcome(msgspec.Struct, frozen=True):
    """Description of a session, sent to a peer that has just joined; the frames of its snapshot
    follow.

    ``link``: the link's id. ``run``: random text, of one run of the program; the session knows
    nothing of acts in another. ``name``, ``role``: the peer's, as the session knows it. ``unit``,
    ``decimals``: of the metric; ``metric`` is not known of a session of an earlier version.
    ``spoken_names``: how the agent addresses each of several participants, by seat. ``parameters``:
    of the task, as plain values. ``trial_mark``: the mark that a key would remove or replace now,
    which may be of an earlier run.
    """

    link: str
    session: str
    task: str
    title: str
    participants: dict[str, str]
    name: str
    role: Role
    unit: str
    decimals: int
    levels: int
    attempts: int
    trials: int
    metric: Metric | None = None
    marks: tuple[MarkKey, ...] = ()
    spoken_names: dict[str, str] = {}
    parameters: dict[str, Any] = {}
    trial_mark: TrialMark = TrialMark()
    run: str = ""


def session_welcome(task: "Task", session: str, link: str, participants: dict[str, str]) -> Welcome:
    """Return the welcome of a session, with ``name`` and ``role`` still to be filled in for each
    peer.

    Args:
        task: the task, with its parameters.
        session: the session's id.
        link: the id of its link.
        participants: their codes, by seat.
    """
    parameters = task.parameters
    spoken = (
        participants
        if task.address == "code"
        else {seat: task.seat_name(seat) for seat in participants}
    )
    return Welcome(
        link=link,
        session=session,
        task=task.name,
        title=task.title,
        participants=participants,
        name="",
        role="observer",
        unit=task.metric.unit,
        decimals=task.metric.decimals,
        levels=task.levels,
        attempts=parameters.practice_attempts + parameters.attempts,
        trials=task.trials_at(parameters.start_level),
        metric=task.metric,
        marks=tuple(MarkKey(mark.name, mark.title) for mark in task.marks),
        spoken_names=spoken if len(participants) > 1 else {},
        parameters=msgspec.to_builtins(parameters),
    )


class MotionTrace(msgspec.Struct, frozen=True):
    """Downsampled angular rate of a hand: ``rates`` in rad/s at ``hz`` Hz, the last of them at
    ``at`` (ns).
    """

    seat: str
    at: int
    hz: float
    rates: tuple[float, ...]


class Connection(NamedTuple):
    """State of the link, and the reason for it. ``ended``: the session is over."""

    state: Literal["connecting", "connected", "lost", "ended"]
    why: str = ""


class TerminalState(NamedTuple):
    """Evidence that a person's terminal is at a peer's end of the link.

    ``silence``: time since the terminal last answered (ns); None if it never has. ``is_relayed``:
    another program, such as tmux, answers in its place.
    """

    silence: int | None = None
    is_relayed: bool = False


PeerEvent = Welcome | list[Frame] | MotionTrace | Connection
"""Received by a peer, in order, on the thread of the loop that it was made on."""


class Peer(Protocol):
    """Link to a session in another program. It is made with a listener that receives each
    ``PeerEvent``.
    """

    name: str
    role: Role

    def send(self, topic: Topic[M], message: M) -> None:
        """Send an operator's act: a message of one of the ``operator/`` topics.

        The session checks it and fills in who sent it. The message's ``at`` is on the session's
        clock, see ``now``. An act with an ``id`` of hexadecimal digits is answered by a frame of
        ``ANSWERED``, and asked for again if that does not come; without a connection, or after the
        program of the session was started again, none comes.
        """

    def watch_terminal(self, state: Callable[[], TerminalState]) -> None:
        """Send the state of the operator's terminal with every heartbeat, so that its loss is
        noticed.
        """

    def take_control(self) -> None:
        """Take control of the session from whichever operator has it."""

    def now(self) -> int:
        """Return the session's time (ns): exact on the same machine, else estimated from pings."""

    def close(self, *, says_goodbye: bool = True) -> None:
        """Leave the session and close the connection; without a goodbye, the session counts this
        peer as lost.
        """


PeerListener = Callable[[PeerEvent], None]
