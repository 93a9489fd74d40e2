"""A robot with ROS4HRI skills, which are actions of ROS 2: it is reached through the rosbridge
protocol.

The skills are those of `communication_skills`, `motions_skills` and `interaction_skills`
(github.com/ros4hri). A goal ends with a ``std_skills/Result``.
"""

from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any, NamedTuple

import msgspec
from msgspec import Meta

from sar_tui.drivers.address import Address
from sar_tui.drivers.rosbridge import PORT, Bridge
from sar_tui.loop.clock import Clock
from sar_tui.model.messages import ActionPart, PartState
from sar_tui.model.units import MS
from sar_tui.outputs.output import OutputError
from sar_tui.outputs.robot import (
    LONGEST,
    Answer,
    Changed,
    Heard,
    Link,
    OwnNames,
    Request,
    Robot,
    Skipped,
    plain,
    read_address,
)


class Skill(NamedTuple):
    """An action: its name and its type."""

    name: str
    type: str


SKILLS: Mapping[ActionPart, Skill] = {
    "say": Skill("/skill/say", "communication_skills/action/Say"),
    "gesture": Skill("/skill/replay_motion", "motions_skills/action/ReplayMotion"),
    "gaze": Skill("/skill/look_at", "interaction_skills/action/LookAt"),
}
PRIORITY = 128
"""Normal priority of ``std_skills/Meta``."""
_SUCCEEDED, _CANCELED = 4, 5
"""Statuses of ``action_msgs/GoalStatus``."""
_INTERRUPTED, _CANCELLED = 4, 125
"""Error codes of ``std_skills/Result``: by another skill, by the one who asked for it."""
LEARN = 300 * MS
"""Pause after connecting, in which it is learned which skills there are."""
LOOK = 400 * MS
"""Time after which a look is done; its goal may go on, to follow the point."""
CANCEL_AGAIN = (20 * MS, 60 * MS, 250 * MS)
"""Times after a stop at which an open goal is cancelled again: rosbridge drops what comes before
the robot has accepted the goal.
"""
_AWAY = {"left": (-0.5, 0.0), "right": (0.5, 0.0), "up": (0.0, 0.4), "down": (0.0, -0.4)}
"""Distance of what the robot looks at, 1 m away, to the participant's right and up (m)."""
_EXAMPLE = (
    "ros4hri://HOST or ros4hri://HOST:PORT; after a question mark, joined by &, there may be the "
    "robot's motion for a gesture, such as wave=hello, and frame= and eyes=, the frame of its body "
    "and the height of its eyes in it (m)"
)


class Options(OwnNames, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Options after the question mark of an address. A gesture without a motion here is the motion
    of its name.
    """

    frame: str = "base_link"
    eyes: Annotated[float, Meta(gt=0, le=3)] = 1.2


class _Goal(NamedTuple):
    """A goal that is not over."""

    request: Request
    id: str


class Skills:
    """The connection: one for the goals, and one to cancel them.

    A rosbridge that does not send each goal in a thread of its own (the default up to 2.1.0) takes
    up a message when the goal before it on the same connection has ended (rosbridge_suite, issue
    909). It knows the goals of all connections, so that another one can cancel them.
    """

    def __init__(
        self, address: Address, options: Options, clock: Clock, changed: Changed, heard: Heard
    ) -> None:
        self._options, self._clock, self._heard = options, clock, heard
        self._changed = changed
        self._goals = Bridge(address, {}, {}, self._connection_changed)
        self._cancels = Bridge(address, {}, {}, self._connection_changed)
        self._open: dict[str, _Goal] = {}
        self._motions: list[str] = []
        self._servers: list[str] = []
        self._number = 0

    @property
    def problem(self) -> str:
        return self._goals.problem

    @property
    def is_connected(self) -> bool:
        return self._goals.is_connected and self._cancels.is_connected

    def open(self) -> None:
        self._goals.open()
        self._cancels.open()

    def send(self, request: Request) -> bool:
        skill = SKILLS[request.part]
        if self._servers:
            if skill.name not in self._servers:
                raise OutputError(f"This robot does not have the skill {skill.name}.")
            request.answer = request.lasts + LONGEST  # many skills report nothing but their end
        args = self._args(request) | {"meta": {"caller": "sar-tui", "priority": PRIORITY}}
        self._number += 1
        goal = _Goal(request, f"{request.id}-{self._number}")
        if request.part == "gaze":
            self._cancel(
                [each for each in list(self._open.values()) if each.request.part == "gaze"]
            )
        self._open[goal.id] = goal
        is_sent = self.is_connected and self._goals.send_goal(
            goal.id, *skill, args, partial(self._begun, goal), partial(self._ended, goal)
        )
        if not is_sent:
            del self._open[goal.id]
        elif request.part == "gaze":
            self._clock.call_at(self._clock.now() + LOOK, partial(self._looked, goal))
        return is_sent

    def stop(self, id: str) -> bool:
        """Cancel the goals of this id; of every id if it is empty, also those of a connection that
        was lost.
        """
        goals = [goal for goal in list(self._open.values()) if id in ("", goal.request.id)]
        is_sent = self.is_connected and self._cancel(goals)
        for pause in CANCEL_AGAIN if is_sent and goals else ():
            self._clock.call_at(self._clock.now() + pause, lambda: self._cancel(goals))
        return is_sent

    def close(self) -> None:
        self._goals.close()
        self._cancels.close()

    def _args(self, request: Request) -> dict[str, Any]:
        match request.part:
            case "say":
                return {"input": _without_markup(request.what)}
            case "gesture":
                motion = getattr(self._options, request.what, "") or request.what
                if self._motions and motion not in self._motions:
                    raise Skipped(_no_motion(motion, self._motions))
                return {"name": motion, "unsafe": False}
        if request.what not in _AWAY:
            return {"policy": "reset"}
        right, up = _AWAY[request.what]  # the robot faces the participant: y is to its left
        point = {"x": 1.0, "y": right, "z": self._options.eyes + up}
        return {"target": {"header": {"frame_id": self._options.frame}, "point": point}}

    # --- on the connection's thread

    def _connection_changed(self) -> None:
        if self.is_connected:
            self._number += 1
            id = f"skills-{self._number}"
            self._cancels.call_service(id, "/rosapi/action_servers", self._learned)
        else:
            self._servers = []
        self._changed()

    def _learned(self, answer: Mapping[str, Any]) -> None:
        self._servers = list(answer.get("action_servers", ()))

    def _begun(self, goal: _Goal) -> None:
        if goal.request.started is None:
            self._heard(Answer("started", goal.request.id, goal.request.part))

    def _ended(self, goal: _Goal, status: int, values: Any) -> None:
        self._open.pop(goal.id, None)
        request = goal.request
        result = read_result(values)
        if isinstance(result, str):
            self._heard(Answer("failed", request.id, request.part, result))
            return
        code = result.result.error_code
        if result.available_motions and code:
            self._motions = result.available_motions
            why = _no_motion(request.what, self._motions)
            answer = Answer("done", request.id, request.part, why)
        elif status == _CANCELED or code == _CANCELLED:
            answer = Answer("aborted", request.id, request.part)
        elif code or status != _SUCCEEDED:
            state: PartState = "aborted" if code == _INTERRUPTED else "failed"
            why = result.result.error_msg or f"Its skill ended with the error {code}."
            answer = Answer(state, request.id, request.part, why)
        else:
            answer = Answer("done", request.id, request.part)
        self._heard(answer)

    # --- on the clock's thread

    def _looked(self, goal: _Goal) -> None:
        if goal.id in self._open:
            self._heard(Answer("done", goal.request.id, "gaze"))

    def _cancel(self, goals: list[_Goal]) -> bool:
        """Cancel those that are still open. Returns False without a connection."""
        is_sent = True
        for goal in goals:
            if goal.id in self._open:
                for bridge in (self._cancels, self._goals):
                    is_sent &= bridge.cancel_goal(goal.id, SKILLS[goal.request.part].name)
        return is_sent


class _SkillResult(msgspec.Struct, frozen=True):
    error_code: int = 0
    error_msg: str = ""


class _Values(msgspec.Struct, frozen=True):
    """The fields of an action's result that are used."""

    result: _SkillResult = _SkillResult()
    available_motions: list[str] = []


def read_result(values: Any) -> _Values | str:
    """Return the result of a skill, or why there is none: rosbridge gives a text instead, if the
    goal was refused or its type is not known.
    """
    if isinstance(values, str):
        return plain(values)
    try:
        return msgspec.convert(values, _Values)
    except msgspec.ValidationError as error:
        return f"Its result could not be understood ({plain(error)})."


def _no_motion(name: str, motions: list[str]) -> str:
    return f"This robot has no motion {plain(name)}. It has: {plain(', '.join(motions))}."


def _without_markup(text: str) -> str:
    """Return a text without the characters that begin markup in the skill's input."""
    return text.translate(str.maketrans("<>", "  "))


class Ros4Hri(Robot):
    """A robot with ROS4HRI skills.

    ``started`` is the skill's first feedback; many give none, and are reported when they end.

    Args:
        address: ``ros4hri://HOST[:PORT]``, and after a question mark `Options`. Raises OutputError
            if it is invalid.
    """

    name = "ros4hri"
    settle = LEARN

    def __init__(self, address: str) -> None:
        self._address, self._options = read_address(address, "ros4hri", PORT, Options, _EXAMPLE)
        self.place = str(self._address)
        self.missing = f"there is no ROS bridge at {self.place}. Start rosbridge there."

    def connect(self, changed: Changed, heard: Heard) -> Link:
        return Skills(self._address, self._options, self.clock, changed, heard)
