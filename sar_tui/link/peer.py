"""What crosses the link, and what a panel needs of it: whoever watches or steers a session from another program."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol, TypeVar

import msgspec

from sar_tui.framework.bus import Topic
from sar_tui.framework.messages import Message, Role

if TYPE_CHECKING:
    from sar_tui.framework.task import Task

M = TypeVar("M", bound=Message)


class Frame(NamedTuple):
    """A message of the session's bus as it crosses the link: its number, the time of its cascade (ns), its topic."""

    seq: int
    at: int
    topic: Topic[Any]
    message: Message


class MarkKey(msgspec.Struct, frozen=True):
    """A therapist's mark: its name, and what it is called."""

    name: str
    title: str


class Welcome(msgspec.Struct, frozen=True):
    """What a session tells a peer that has just come: what it is, and how it stands.

    ``link``: the link's id; ``name`` and ``role``: who the peer is to the session. ``unit`` and ``decimals``: of the
    metric. ``spoken_names``: what the agent calls each of several participants, by seat. ``parameters``: of the task, as
    plain values. The frames of kept topics and of what happened last follow.
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
    marks: tuple[MarkKey, ...] = ()
    spoken_names: dict[str, str] = {}
    parameters: dict[str, Any] = {}


def session_welcome(task: "Task", session: str, link: str, participants: dict[str, str]) -> Welcome:
    """Return the welcome of a session, with ``name`` and ``role`` still to be filled in for each peer.

    Args:
        task: with its parameters.
        session: the session's id.
        link: the id of its link.
        participants: their codes, by seat.
    """
    parameters = task.parameters
    spoken = participants if task.address == "code" else {seat: task.seat_name(seat) for seat in participants}
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
        trials=task.trials_per_attempt,
        marks=tuple(MarkKey(mark.name, mark.title) for mark in task.marks),
        spoken_names=spoken if len(participants) > 1 else {},
        parameters=msgspec.to_builtins(parameters),
    )


class MotionTrace(msgspec.Struct, frozen=True):
    """How fast a hand turns, for an eye to follow: ``rates`` in rad/s, ``hz`` of them a second, up to ``at`` (ns)."""

    seat: str
    at: int
    hz: float
    rates: tuple[float, ...]


class Connection(NamedTuple):
    """How the link is: ``state``, and why. ``ended``: over, and it will not come back."""

    state: Literal["connecting", "connected", "lost", "ended"]
    why: str = ""


PeerEvent = Welcome | list[Frame] | MotionTrace | Connection
"""What a peer is told, in order, on the thread of the loop that it was made on."""


class Peer(Protocol):
    """A link to a session, from another program. Made with a function that hears what comes."""

    name: str
    role: Role

    def send(self, topic: Topic[M], message: M) -> None:
        """Send an act: one of the ``operator/`` topics. The session puts in who it was, and checks everything.

        ``at`` of the message is on the session's clock: see ``now``.
        """

    def take_control(self) -> None:
        """Hold the baton from here on, whoever has it."""

    def now(self) -> int:
        """The session's clock (ns), as well as it is known: read off the same host's, or estimated from pings."""

    def close(self) -> None:
        """Say goodbye, and let go."""


PeerListener = Callable[[PeerEvent], None]
