"""The Task Base: parameters declared once, from which the form, the checks, `--set` and the docs are made."""

import difflib
from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeVar

import msgspec
from msgspec import inspect

from sar_tui.framework.declaration import Field, ParameterError, declared_field, meta, read

P = TypeVar("P", bound="TaskParameters")


class TaskParameters(msgspec.Struct, frozen=True, kw_only=True):
    """What every task can be set to. A task adds its own in a subclass.

    Build them with ``build``, which checks; the constructor does not.
    """

    attempts: Annotated[
        int, meta("Attempts", help="How many attempts a session has.", ge=1, le=200, group="Session")
    ] = 20
    practice_attempts: Annotated[
        int,
        meta("Practice attempts", help="Attempts before the first that counts; they never change the level.",
             ge=0, le=20, group="Session"),
    ] = 0  # fmt: skip
    threshold: Annotated[
        float,
        meta(
            "Goal",
            help="The result of an attempt has to be better than this; equal is not enough.",
            ge=0,
            le=1e6,
            group="Difficulty",
        ),
    ] = 1000.0
    neutral_band: Annotated[
        float,
        meta(
            "Neutral band",
            help="This near the goal, on either side, feedback is neutral.",
            ge=0,
            le=1e6,
            group="Difficulty",
        ),
    ] = 10.0
    min_accuracy: Annotated[
        float,
        meta(
            "Minimum accuracy",
            help="The share of right responses an attempt needs to succeed, 0 to 1.",
            ge=0,
            le=1,
            group="Difficulty",
        ),
    ] = 0.8
    consecutive_successes: Annotated[
        int,
        meta(
            "Successes before harder",
            help="So many successes in a row raise the level by one.",
            ge=1,
            le=20,
            group="Difficulty",
        ),
    ] = 1
    consecutive_failures: Annotated[
        int,
        meta(
            "Failures before easier",
            help="So many failures in a row lower the level by one.",
            ge=1,
            le=20,
            group="Difficulty",
        ),
    ] = 1
    start_level: Annotated[
        int, meta("Start level", help="The level of the first attempt.", ge=1, le=100, group="Difficulty")
    ] = 1
    min_level: Annotated[
        int, meta("Lowest level", help="The level never falls below this.", ge=1, le=100, group="Difficulty")
    ] = 1
    max_level: Annotated[
        int,
        meta(
            "Highest level",
            help="The level never rises above this, nor above the last level there is.",
            ge=1,
            le=100,
            group="Difficulty",
        ),
    ] = 10
    difficulty_policy: Annotated[
        Literal["consecutive", "fixed"],
        meta(
            "Difficulty",
            help="consecutive: one level up or down after successes or failures in a row. fixed: stays.",
            group="Difficulty",
            renamed={"thesis": "consecutive"},
        ),
    ] = "consecutive"
    feedback_schedule: Annotated[
        Literal["every", "faded", "bandwidth", "summary", "request", "none"],
        meta(
            "Feedback",
            help="every: each time, or each so many attempts. faded: less often with success. bandwidth: only away "
            "from the goal. summary: of the last attempts. request: when the participant asks (Tab). none.",
            group="Feedback",
        ),
    ] = "every"
    feedback_every: Annotated[
        int,
        meta("Feedback every", "attempts", "For every and summary: the agent answers every so many attempts.",
             ge=1, le=100, group="Feedback"),
    ] = 1  # fmt: skip
    feedback_fade: Annotated[
        int,
        meta("Fading", "successes",
             "For faded: so many more successes than failures make feedback rarer by one attempt.", ge=1, le=50,
             group="Feedback"),
    ] = 2  # fmt: skip
    feedback_tolerance: Annotated[
        float,
        meta("Bandwidth", "% of the goal", "For bandwidth: a result no farther from the goal is not answered.",
             ge=0, le=100, group="Feedback"),
    ] = 10.0  # fmt: skip
    feedback_form: Annotated[
        Literal["qualitative", "quantitative", "both"],
        meta("Feedback form", help="In words only, with figures, or both.", group="Feedback"),
    ] = "both"
    feedback_compared_with: Annotated[
        Literal["last attempt", "best attempt", "session's mean", "goal"],
        meta(
            "Compared with",
            help="What figures are held against: results at the same level, or the goal.",
            group="Feedback",
        ),
    ] = "last attempt"
    feedback_delay_ms: Annotated[
        int,
        meta("Feedback delay", "ms", "From the end of an attempt to its answer.", ge=0, le=60_000, group="Feedback"),
    ] = 0
    encouragement: Annotated[
        bool,
        meta("Encouragement", help="A kind word before an attempt that is harder than those before.", group="Agent"),
    ] = True
    rest_every: Annotated[
        int,
        meta("Rest reminder every", "attempts", "The agent reminds of rest; 0: never.", ge=0, le=200, group="Session"),
    ] = 10
    language: Annotated[
        str,
        meta("Language", help="Of all the participant sees and hears: en, es, or another the theme has.",
             takes="a code of small letters, such as en, es or es-mx",
             pattern="^[a-z]{2,3}(-[a-z]{2,4})?$", group="Session"),
    ] = "en"  # fmt: skip
    outputs: Annotated[
        tuple[str, ...],
        meta("Outputs", help="What the agent speaks and moves with: screen, speech, tones, servo, ros://HOST.",
             max_length=8, group="Agent"),
    ] = ("screen",)  # fmt: skip
    speech: Annotated[
        str,
        meta(
            "Speech goes to",
            help="sound: the loudspeaker. file:FOLDER: a WAV for each utterance.",
            max_length=500,
            group="Agent",
        ),
    ] = "sound"
    operator_feedback: Annotated[
        Literal["autonomous", "veto", "approve", "manual"],
        meta("Feedback mode", help="With an operator: autonomous, the agent gives it; veto, unless it is stopped in "
             "time; approve, on a key; manual, the operator alone.", group="Operator"),
    ] = "autonomous"  # fmt: skip
    operator_encouragement: Annotated[
        Literal["autonomous", "veto", "approve", "manual"],
        meta("Encouragement mode", help="As for feedback; also reminders of rest.", group="Operator"),
    ] = "autonomous"
    operator_instruction: Annotated[
        Literal["autonomous", "veto", "approve", "manual"],
        meta("Instruction mode", help="As for feedback; also greeting and goodbye.", group="Operator"),
    ] = "autonomous"
    operator_gesture: Annotated[
        Literal["autonomous", "veto", "approve", "manual"],
        meta("Gesture mode", help="As for feedback; autonomous: they go with their words.", group="Operator"),
    ] = "autonomous"
    operator_difficulty: Annotated[
        Literal["autonomous", "veto", "approve", "manual"],
        meta("Level mode", help="As for feedback.", group="Operator"),
    ] = "autonomous"
    operator_time_ms: Annotated[
        int,
        meta("Time to decide", "ms", "How long veto and approve wait. With a feedback delay, feedback waits for that.",
             group="Operator", ge=200, le=120_000),
    ] = 4000  # fmt: skip
    operator_timeout: Annotated[
        Literal["act", "drop"],
        meta("Timeout of approve", help="When nobody decides in time. act: the agent goes on as if it were alone. "
             "drop: nothing is said.", group="Operator"),
    ] = "act"  # fmt: skip
    operator_lost: Annotated[
        Literal["autonomous", "silent"],
        meta("Agent without operator", help="If none is there, or none is heard any more. silent: what would need one "
             "is left out.", group="Operator"),
    ] = "autonomous"  # fmt: skip
    operator_lost_ms: Annotated[
        int,
        meta("Time until lost", "ms", "An operator is lost whose program gave no sign of life for so long.",
             group="Operator", ge=500, le=60_000),
    ] = 2000  # fmt: skip
    filler: Annotated[
        Literal["operator", "always", "never"],
        meta("Filler", help="A word after a second without an answer that is due. operator: while one decides; always: "
             "also while a feedback delay passes, so that it does not tell the two apart.", group="Operator"),
    ] = "operator"  # fmt: skip
    response_timeout_ms: Annotated[
        int,
        meta(
            "Response time-out",
            "ms",
            "After this long without a response the prompt is missed.",
            ge=100,
            le=600_000,
            group="Timing",
        ),
    ] = 5000
    min_rt_ms: Annotated[
        int,
        meta("Fastest real response", "ms",
             "A faster response is kept, marked as an anticipation, and left out of the result.", ge=0, le=1000,
             group="Timing"),
    ] = 100  # fmt: skip
    quiet_ms: Annotated[
        int,
        meta(
            "Quiet before a prompt",
            "ms",
            "No key may be pressed for this long before the wait begins.",
            ge=0,
            le=5000,
            group="Timing",
        ),
    ] = 500
    foreperiod_min_ms: Annotated[
        int,
        meta("Shortest wait", "ms", "The wait before a prompt is at least this long.", ge=0, le=60_000, group="Timing"),
    ] = 500
    foreperiod_max_ms: Annotated[
        int,
        meta(
            "Longest wait",
            "ms",
            "The wait before a prompt is random, at most this long.",
            ge=0,
            le=60_000,
            group="Timing",
        ),
    ] = 1500
    repeat_interval_ms: Annotated[
        int,
        meta(
            "Key repeat interval",
            "ms",
            "The same key again within this time is a held key, not a press.",
            ge=0,
            le=1000,
            group="Timing",
        ),
    ] = 50

    def problems(self) -> dict[str, str]:
        """Settings that do not go together: parameter name to one clear sentence. Extend it in a subclass."""
        problems = {}
        if self.min_level > self.max_level:
            problems["min_level"] = f"Lowest level ({self.min_level}) is above the highest ({self.max_level})."
        elif not self.min_level <= self.start_level <= self.max_level:
            problems["start_level"] = (
                f"Start level ({self.start_level}) has to lie between {self.min_level} and {self.max_level}."
            )
        if self.foreperiod_min_ms > self.foreperiod_max_ms:
            problems["foreperiod_min_ms"] = (
                f"Shortest wait ({self.foreperiod_min_ms} ms) is above the longest ({self.foreperiod_max_ms} ms)."
            )
        return problems


def fields(parameters: type[TaskParameters]) -> tuple[Field, ...]:
    """The declared parameters of a task, the task's own first, then those common to all."""
    common = _declared(TaskParameters)
    found = [
        msgspec.structs.replace(
            field, group=field.group or common[name].group, renamed=field.renamed or common[name].renamed
        )
        if name in common
        else field
        for name, field in _declared(parameters).items()
    ]
    return tuple(sorted(found, key=lambda field: field.name in common))


def _declared(parameters: type[TaskParameters]) -> dict[str, Field]:
    info = inspect.type_info(parameters)
    assert isinstance(info, inspect.StructType)
    return {field.name: declared_field(field) for field in info.fields}


def current_values(parameters: type[TaskParameters], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values with former spellings of choices replaced by the present ones (``renamed`` of ``meta``).

    Call it on values from a database or a file before showing or comparing them; ``build`` does it itself.
    """
    renamed = {field.name: field.renamed for field in fields(parameters) if field.renamed}
    return {
        name: renamed[name].get(value, value) if name in renamed and isinstance(value, str) else value
        for name, value in values.items()
    }


def build(parameters: type[P], values: Mapping[str, object]) -> P:
    """Make checked parameters from values, typed or as text.

    Raises:
        ParameterError: naming every parameter that is unknown, out of bounds, or at odds with another.
    """
    declared = {field.name: field for field in fields(parameters)}
    types = {field.name: field.type for field in msgspec.structs.fields(parameters)}
    problems: dict[str, str] = {}
    good: dict[str, Any] = {}
    for name, value in current_values(parameters, values).items():
        if name not in declared:
            near = difflib.get_close_matches(name, declared, 1)
            problems[name] = f"There is no parameter {name}." + (f" Did you mean {near[0]}?" if near else "")
            continue
        given = read(declared[name], value) if isinstance(value, str) else value
        try:
            good[name] = msgspec.convert(given, types[name], strict=not isinstance(value, str))
        except msgspec.ValidationError:
            problems[name] = declared[name].problem(value)
    built = parameters(**good)
    if problems or (problems := built.problems()):
        raise ParameterError(problems)
    return built


def changed(parameters: TaskParameters) -> dict[str, Any]:
    """Only what differs from the defaults, as plain values."""
    return {
        field.name: msgspec.to_builtins(getattr(parameters, field.name))
        for field in fields(type(parameters))
        if getattr(parameters, field.name) != field.default
    }
