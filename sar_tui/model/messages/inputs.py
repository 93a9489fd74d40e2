"""Inputs: messages that come from outside the nodes, except those of operators."""

from typing import Literal

from sar_tui.model.messages.base import ActionPart, Message, PartState, SensorState
from sar_tui.model.step import Step
from sar_tui.model.theme import Theme

__all__ = [
    "BodyPart",
    "FocusChanged",
    "ImuBlock",
    "InputDropped",
    "KeyPressed",
    "MarkersChanged",
    "OutputReport",
    "OutputStopped",
    "Pasted",
    "SensorChanged",
    "SessionStarted",
    "Shown",
    "StorageChanged",
    "Stored",
    "SwitchPressed",
    "SyncSignal",
    "ThemeApplied",
    "TimerFired",
    "ToneBegan",
    "TrialFeedbackShown",
]


class SessionStarted(Message, frozen=True, kw_only=True):
    """A run of the program begins on a session. ``run`` counts from 1; above 1 the session is
    resumed.

    ``best``: the participant's best results of earlier sessions, by level (as text; with a
    condition, ``2 cued``). ``others_best``: those of other participants, by seat. ``names``: what
    the agent calls each participant, by seat; without a name, the seat. ``rules``: version of the
    loop's rules (see `rules.version`). ``done_today``: what the participant
    did on this day in earlier runs (see `rules.limits.Dose`); empty if nothing limits a day.
    ``steps``: those between attempts that the session was begun with, beside the task's; only in
    the first run.
    """

    run: int
    task: str
    theme: str
    seed: int
    best: dict[str, float] = {}
    others_best: dict[str, dict[str, float]] = {}
    names: dict[str, str] = {}
    rules: int = 1
    done_today: dict[str, float] = {}
    steps: tuple[Step, ...] = ()


class ThemeApplied(Message, frozen=True, kw_only=True):
    """The theme from here on: published when a run begins and after each edit of the theme."""

    theme: Theme


class KeyPressed(Message, frozen=True, kw_only=True):
    """A key, stamped in the input thread. ``key`` is the character it types, or its name
    (``enter``, ``left``).

    ``loop_lag``: the largest delay of the event loop since the last prompt or key, in ns.
    ``stalled``: the program had just been suspended, so that the key was pressed at some unknown
    time before ``at``.
    """

    key: str
    at: int
    loop_lag: int = 0
    stalled: bool = False


class SwitchPressed(Message, frozen=True, kw_only=True):
    """A press of a person's switch between trials, where a mark moves through choices.

    ``key``: of the switch; the keys that it stands for are stored as `KeyPressed`. ``outcome``:
    ``taken``, ``asked`` (it leads to Yes and No), ``moved``, ``held`` (it repeats, or bounces: it
    does nothing), ``early`` (what is on the screen was not read yet: it does nothing). ``choice``:
    the words that were marked. ``interval_ms``: the scan interval in use; 0 with two switches.
    ``press_ms``: from the mark's move to the press; None if that tells nothing about the person.
    """

    key: str
    at: int
    outcome: Literal["taken", "asked", "moved", "held", "early"]
    choice: str
    interval_ms: int
    press_ms: float | None = None


class Pasted(Message, frozen=True, kw_only=True):
    """Text was pasted: never a response. Only its length is stored."""

    length: int
    at: int


class InputDropped(Message, frozen=True, kw_only=True):
    """The terminal sent something that cannot be read, such as a byte that is not UTF-8. ``what``:
    its end, escaped.
    """

    what: str
    at: int


class FocusChanged(Message, frozen=True, kw_only=True):
    """The terminal window gained or lost the keyboard focus."""

    focused: bool
    at: int


class Shown(Message, frozen=True, kw_only=True):
    """A prompt reached the terminal, or one of its frames: ``frame`` is its place, from 0.

    ``source``: ``flush`` (stamped as the frame was flushed), ``refresh`` (after Textual's refresh:
    less exact), ``virtual`` (simulated). ``picture``: how its picture was drawn; ``none`` if it
    could not be; empty if it has none.
    """

    attempt: int
    trial: int
    presentation: int
    at: int
    source: Literal["flush", "refresh", "virtual"]
    frame: int = 0
    picture: Literal["", "kitty", "sixel", "half blocks", "blocks", "none"] = ""


BodyPart = Literal["hand", "trunk"]
"""The place of a sensor on the body. Each part has topics of its own, so that nothing takes one
sensor for another.
"""


class TrialFeedbackShown(Message, frozen=True, kw_only=True):
    """The answer to a trial reached the terminal. ``source``: as of a prompt (see `Shown`)."""

    attempt: int
    trial: int
    at: int
    source: Literal["flush", "refresh", "virtual"]


class ToneBegan(Message, frozen=True, kw_only=True):
    """A tone of a prompt began to sound, or is about to, ``at`` (ns). ``frame``: that it belongs
    to.

    ``source``: ``device`` (by the clock of the sound card, with the time in its buffer), ``host``
    (when its samples were handed over: less exact), ``virtual`` (simulated), ``failed`` (it is not
    heard; ``detail`` says why).
    """

    attempt: int
    trial: int
    presentation: int
    frame: int
    at: int
    source: Literal["device", "host", "virtual", "failed"]
    detail: str = ""


class ImuBlock(Message, frozen=True, kw_only=True):
    """Samples of a motion sensor, in the order in which they were taken.

    ``samples``: as `motion.samples.pack` lays them out.
    """

    samples: bytes


class SensorChanged(Message, frozen=True, kw_only=True):
    """Something happened to the motion sensor at ``at`` (see `inputs.imu.Status`).

    ``count`` and ``duration_ms`` describe missing samples. ``model``, ``serial``, ``rate_hz`` and
    the ranges are given when it is ``attached``.
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
    """A node's timer fired. ``token`` distinguishes it from earlier timers of the same name."""

    node: str
    name: str
    token: int
    due: int


class OutputReport(Message, frozen=True, kw_only=True, rename={"part": "deed"}):
    """An output reports the state of one part of an action. ``detail`` says why it failed.

    ``queued``: accepted by the output; ``started``: audible or visible; then ``done``, ``aborted``
    (stopped before its end) or ``failed``.
    """

    action: str
    output: str
    part: ActionPart
    state: PartState
    at: int
    detail: str = ""


class OutputStopped(Message, frozen=True, kw_only=True):
    """An output that had to stop at ``asked`` was silent and still at ``at``. ``detail``: why it
    could not stop.
    """

    output: str
    asked: int
    at: int
    detail: str = ""


class MarkersChanged(Message, frozen=True, kw_only=True):
    """A destination of markers is ``open``, ``failing`` (``detail`` says why), ``working`` again,
    or ``closed``.

    When it is closed: ``sent``, ``lost`` (it failed, or could not keep up) and ``unheard`` (sent
    while nobody was known to receive them) count this run's markers; ``late_ms`` and ``latest_ms``
    are the median and the largest time from a prompt's onset until its marker was sent.
    """

    destination: str
    state: Literal["open", "failing", "working", "closed"]
    at: int
    detail: str = ""
    sent: int = 0
    lost: int = 0
    unheard: int = 0
    late_ms: float | None = None
    latest_ms: float | None = None


class SyncSignal(Message, frozen=True, kw_only=True):
    """A signal for cameras at the start of a run: the screen flashed, or a tone began to play,
    ``at``.

    ``source``: how this is known: ``flush`` (the white frame was flushed), ``refresh`` (after
    Textual's refresh: less exact), ``sound`` (the first samples were fed to the sound card; they
    are heard up to 40 ms later).
    """

    what: Literal["flash", "tone"]
    at: int
    source: Literal["flush", "refresh", "sound"]


class Stored(Message, frozen=True, kw_only=True):
    """The trial and everything before it are on disk; in a simulated session, with its group of
    messages.
    """

    attempt: int
    trial: int


class StorageChanged(Message, frozen=True, kw_only=True):
    """Writing to disk fails (``working`` False), or works again; with a reason, in another file
    than before.
    """

    working: bool
    reason: str = ""
