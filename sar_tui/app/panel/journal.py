"""The journal: what happened that an operator should know of, a short line each."""

from typing import Any, Literal, NamedTuple

from sar_tui.framework.messages import (
    ActMissed,
    ActRefused,
    Dropped,
    LevelChanged,
    LevelRuled,
    OperatorChanged,
    SensorChanged,
    StorageChanged,
)
from sar_tui.framework.topics import (
    DECISION,
    DROPPED,
    LEVEL,
    LEVEL_RULED,
    MISSED,
    MODE,
    NOTED,
    OPERATOR,
    PRESENCE,
    REFUSED,
    REMARK,
    SEEN,
    SENSOR,
    STORAGE,
)
from sar_tui.link.peer import Frame, Welcome

KEPT = 40
Tone = Literal["plain", "good", "bad"]

_DROPPED = {
    "late": "A proposal came too late: the session had gone on.",
    "stopped": "What waited was stopped.",
    "amended": "A proposal fell away: the attempt was scored anew.",
    "expired": "A proposal expired: nobody decided in time.",
    "no operator": "A proposal fell away: there was no operator.",
}
_SENSOR = {
    "attached": ("The motion sensor is there.", "good"),
    "detached": ("The motion sensor is gone.", "bad"),
    "stalled": ("Nothing comes from the motion sensor.", "bad"),
    "flowing": ("The motion sensor sends again.", "good"),
    "ended": ("The recording that stands for the sensor has ended.", "plain"),
}
_ACTS = {
    OPERATOR.name: "an act",
    DECISION.name: "a decision",
    REMARK.name: "words or a gesture",
    MODE.name: "another mode",
    NOTED.name: "a note",
    SEEN.name: "a sign of having seen",
}
_WHY_LEVEL = {"success": "goal reached", "failure": "goal missed", "operator": "an operator", "mark": "a mark"}


class Line(NamedTuple):
    """One line: when (ns, on the session's clock), what, and whether it is good news."""

    at: int
    text: str
    tone: Tone = "plain"


def short(name: str) -> str:
    """A peer's name without its role: ``anna`` of ``operator.anna``."""
    return name.partition(".")[2] or name


def line(frame: Frame, me: Welcome | None) -> Line | None:
    """What a message is worth in the journal, if anything. ``me``: the reader is told "you"."""
    told = _words(frame.topic.name, frame.message, me.name if me else "")
    return Line(frame.at, *told) if told else None


def _words(topic: str, message: Any, me: str) -> tuple[str, Tone] | None:
    told: tuple[str, Tone] | None = None
    if topic == REFUSED.name:
        told = _refused(message, me), "bad"
    elif topic == MISSED.name:
        told = _missed(message, me), "bad"
    elif topic == PRESENCE.name:
        told = _presence(message, me)
    elif topic == DROPPED.name:
        told = _dropped(message)
    elif topic == LEVEL_RULED.name:
        told = _level_ruled(message, me), "plain"
    elif topic == LEVEL.name:
        told = _level(message)
    elif topic == SENSOR.name:
        told = _sensor(message)
    elif topic == STORAGE.name:
        told = _storage(message)
    return told


def _who(actor: str, me: str) -> str:
    return "you" if actor == me else short(actor)


def _refused(refused: ActRefused, me: str) -> str:
    times = f" ({refused.count} times)" if refused.count > 1 else ""
    whose = "" if refused.actor == me else f" of {short(refused.actor)}"
    return f"Refused{whose}: {_ACTS.get(refused.what, refused.what)}{times}. {refused.why}"


def _missed(missed: ActMissed, me: str) -> str:
    whose = "" if missed.actor == me else f" of {short(missed.actor)}"
    return f"Too late{whose}: {missed.what}. {missed.why}"


def _presence(changed: OperatorChanged, me: str) -> tuple[str, Tone]:
    who = _who(changed.actor, me).capitalize() if changed.actor == me else short(changed.actor)
    you = changed.actor == me
    match changed.state:
        case "baton":
            return (f"{who} {'hold' if you else 'holds'} the baton.", "good" if you else "plain")
        case "joined":
            return f"{who} came{' to watch' if changed.role == 'observer' else ''}.", "plain"
        case "left":
            return f"{who} left.", "plain"
    return f"{who} {'were' if you else 'is'} no longer heard{f': {changed.detail}' if changed.detail else ''}.", "bad"


def _dropped(dropped: Dropped) -> tuple[str, Tone] | None:
    words = _DROPPED.get(dropped.reason)  # a veto, and what only the operator does, are nobody's news
    return (words, "bad" if dropped.reason in ("late", "expired") else "plain") if words else None


def _level_ruled(ruled: LevelRuled, me: str) -> str:
    if ruled.decision == "rejected":
        return f"The level stays {ruled.level} ({_ground(ruled, me)})."
    return f"The next level is {ruled.level} ({_ground(ruled, me)})."


def _ground(ruled: LevelRuled, me: str) -> str:
    if ruled.ground == "operator":
        return _who(ruled.actor, me)
    return {"deadline": "nobody decided in time", "no operator": "no operator"}.get(ruled.ground, "the task's rule")


def _level(changed: LevelChanged) -> tuple[str, Tone] | None:
    if changed.previous == changed.level:
        return None
    return f"Level {changed.previous} → {changed.level} ({_WHY_LEVEL.get(changed.reason, changed.reason)}).", "plain"


def _sensor(changed: SensorChanged) -> tuple[str, Tone] | None:
    words, tone = _SENSOR.get(changed.state, ("", "plain"))
    return (words, tone) if words else None  # type: ignore[return-value]


def _storage(changed: StorageChanged) -> tuple[str, Tone]:
    if changed.working:
        return "The disk works again.", "good"
    return f"The disk refuses to write: {changed.reason}", "bad"
