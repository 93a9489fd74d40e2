"""Inputs: what comes from outside the nodes, but for what operators do."""

from typing import Literal

from sar_tui.framework.messages.base import ActionPart, Message, PartState, SensorState
from sar_tui.framework.theme import Theme

__all__ = [
    "FocusChanged",
    "ImuBlock",
    "KeyPressed",
    "OutputReport",
    "OutputStopped",
    "Pasted",
    "SensorChanged",
    "SessionStarted",
    "Shown",
    "StorageChanged",
    "Stored",
    "ThemeApplied",
    "TimerFired",
]


class SessionStarted(Message, frozen=True, kw_only=True):
    """A run of the program begins on a session. ``run`` counts from 1; above 1 the session is resumed.

    ``best``: the participant's best results of earlier sessions, by level (as text); ``others_best``: those of who sits
    at the other seats, by seat. ``names``: what the agent calls who sits where, by seat, if that is not the seat.
    """

    run: int
    task: str
    theme: str
    seed: int
    best: dict[str, float] = {}
    others_best: dict[str, dict[str, float]] = {}
    names: dict[str, str] = {}


class ThemeApplied(Message, frozen=True, kw_only=True):
    """What the agent looks like and how it speaks, from here on: at the beginning of a run, and after each edit."""

    theme: Theme


class KeyPressed(Message, frozen=True, kw_only=True):
    """A key, stamped in the input thread. ``key`` is the character it types, or its name (``enter``, ``left``).

    ``loop_lag``: how late (ns) the event loop was at its worst since the last prompt or key.
    """

    key: str
    at: int
    loop_lag: int = 0


class Pasted(Message, frozen=True, kw_only=True):
    """Text was pasted: never a response. Only its length is kept."""

    length: int
    at: int


class FocusChanged(Message, frozen=True, kw_only=True):
    """The terminal's window gained or lost the keyboard focus."""

    focused: bool
    at: int


class Shown(Message, frozen=True, kw_only=True):
    """A prompt reached the terminal.

    ``source``: ``flush`` (stamped as the frame was flushed), ``refresh`` (after Textual's refresh: less sure),
    ``virtual`` (simulated).
    """

    attempt: int
    trial: int
    presentation: int
    at: int
    source: Literal["flush", "refresh", "virtual"]


class ImuBlock(Message, frozen=True, kw_only=True):
    """Samples of a motion sensor, in the order in which they were taken; many a second, so they are a stream.

    ``samples``: as `motion.samples.pack` lays them out.
    """

    samples: bytes


class SensorChanged(Message, frozen=True, kw_only=True):
    """Something happened to the motion sensor at ``at`` (see `inputs.imu.Status`).

    ``count`` and ``duration_ms`` tell of missing samples. What the sensor is (``model``, ``serial``, ``rate_hz``,
    the largest it can measure) is told when it is ``attached``.
    """

    state: SensorState
    at: int
    detail: str = ""
    count: int = 0
    duration_ms: float = 0.0
    source: str = ""
    model: str = ""
    serial: str = ""
    rate_hz: float = 0.0
    rate_range_rad_s: float = 0.0
    acceleration_range_m_s2: float = 0.0


class TimerFired(Message, frozen=True, kw_only=True):
    """A node's timer fired. ``token`` tells it from an earlier timer of the same name."""

    node: str
    name: str
    token: int
    due: int


class OutputReport(Message, frozen=True, kw_only=True, rename={"part": "deed"}):
    """An output tells what became of a part of an action. ``detail`` says why it failed.

    ``queued``: the output has taken it on; ``started``: it can be heard or seen; then ``done``, ``aborted`` (stopped
    before its end) or ``failed``.
    """

    action: str
    output: str
    part: ActionPart
    state: PartState
    at: int
    detail: str = ""


class OutputStopped(Message, frozen=True, kw_only=True):
    """An output that was told to stop at ``asked`` is still since ``at``. ``detail`` says why, where it is not."""

    output: str
    asked: int
    at: int
    detail: str = ""


class Stored(Message, frozen=True, kw_only=True):
    """The trial, and everything before it, is on disk."""

    attempt: int
    trial: int


class StorageChanged(Message, frozen=True, kw_only=True):
    """The disk refuses to write (``working`` False), or writes again."""

    working: bool
    reason: str = ""
