"""The parameters of a task: common settings and the task's own, built and checked in one place.

The settings form, `--set`, the checks and the documentation are made from these declarations. A
common setting is declared in ``TaskParameters``, by its heading on the form; a task's own in its
``Parameters``; a policy's beside the policy.
"""

import difflib
from collections.abc import Mapping
from functools import lru_cache
from typing import Annotated, Any, Literal, TypeVar

import msgspec
from msgspec import inspect

from sar_tui.model.language import Sentence
from sar_tui.model.messages import Mode
from sar_tui.model.trial_types import LONGEST_SHOW_MS
from sar_tui.plugin_calls import PLUGIN_ERRORS, calling, describe
from sar_tui.rules import policies
from sar_tui.rules.declaration import (
    Field,
    ParameterError,
    Settings,
    declared_field,
    in_group,
    read,
    show,
)
from sar_tui.rules.difficulty import BY_OUTCOME
from sar_tui.rules.questions import EARLIER, QUESTIONS
from sar_tui.rules.scanning import FASTEST_MS, SLOWEST_MS
from sar_tui.rules.wellbeing import HIGHEST, PainLimits

P = TypeVar("P", bound="TaskParameters")

_session = in_group("Session")
_limits = in_group("Limits")
_difficulty = in_group("Difficulty")
_feedback = in_group("Feedback")
_access = in_group("Access")
_agent = in_group("Agent")
_operator = in_group("Operator")
_timing = in_group("Timing")
_PAIN = PainLimits()


@policies.with_policies
class TaskParameters(Settings, frozen=True, kw_only=True):
    """Settings that every task has. A task adds its own in a subclass.

    Build them with ``build``, which checks; the constructor does not.
    """

    # Session

    attempts: Annotated[
        int, _session("Attempts", help="Number of attempts in a session.", ge=1, le=200)
    ] = 20
    practice_attempts: Annotated[
        int,
        _session(
            "Practice attempts",
            help="Attempts before the first that counts. They do not change the level.",
            ge=0,
            le=20,
        ),
    ] = 0
    rest_every: Annotated[
        int,
        _session(
            "Rest reminder every", "attempts", "The agent suggests a rest; 0: never.", ge=0, le=200
        ),
    ] = 10
    language: Annotated[
        str,
        _session(
            "Language",
            help="Language of all that the participant sees and hears: en, de, es, or another of "
            "the theme.",
            takes="a code in lower case, such as en, es or es-mx",
            pattern="^[a-z]{2,3}(-[a-z]{2,4})?$",
            personal=True,
        ),
    ] = "en"
    instructions: Annotated[
        Literal["first time", "always", "never"],
        _session(
            "Instructions",
            help="first time: participants who train alone, and have finished a session of this "
            "task before, begin without them: the first attempt follows their Enter. F1 shows "
            "them at any time.",
            personal=True,
        ),
    ] = "first time"
    ask_wellbeing: Annotated[
        bool,
        _session(
            "Ask about pain",
            help="Before and after a session, ask how much pain there is, where, and how tired "
            "the participant is.",
            personal=True,
        ),
    ] = False
    pain_limit: Annotated[
        int,
        _session(
            "Pain limit",
            ge=0,
            le=HIGHEST,
            help="With more pain than this, of 10, the participant is advised not to train, and "
            "you are told.",
            personal=True,
        ),
    ] = _PAIN.highest
    pain_rise: Annotated[
        int,
        _session(
            "Pain rise",
            ge=1,
            le=HIGHEST,
            help="So much more pain than before the session counts as too much, too.",
            personal=True,
        ),
    ] = _PAIN.rise
    questions: Annotated[
        tuple[str, ...],
        _session(
            "Questions",
            help=f"What to ask the participant: {', '.join(QUESTIONS)}. Empty: nothing.",
            max_length=len(QUESTIONS),
        ),
    ] = ()
    questions_every: Annotated[
        int,
        _session(
            "Ask every",
            "attempts",
            "The questions come after each so many attempts; 0: after the last.",
            ge=0,
            le=200,
        ),
    ] = 0

    # Limits

    # An attempt begun is always finished.

    session_minutes: Annotated[
        int,
        _limits(
            "Session length",
            "min",
            "After this time, rests and pauses included, the session ends with the attempt. 0: no "
            "limit.",
            ge=0,
            le=480,
            personal=True,
        ),
    ] = 0
    minutes_a_day: Annotated[
        int,
        _limits(
            "Minutes a day",
            "min",
            "Time in attempts of this task on a day, without the rests between them. 0: no limit.",
            ge=0,
            le=480,
            personal=True,
        ),
    ] = 0
    attempts_a_day: Annotated[
        int,
        _limits(
            "Attempts a day",
            help="Attempts of this task on a day, without practice. 0: no limit.",
            ge=0,
            le=1000,
            personal=True,
        ),
    ] = 0
    repetitions_a_day: Annotated[
        int,
        _limits(
            "Repetitions a day",
            help="Prompts or reaches of this task on a day, with practice. 0: no limit.",
            ge=0,
            le=10_000,
            personal=True,
        ),
    ] = 0
    planned_attempts_a_day: Annotated[
        int,
        _limits(
            "Planned a day",
            help="Attempts of this task planned for a day, in one session or several: progress "
            "compares what was done "
            "with it. 0: the attempts of the sessions begun.",
            ge=0,
            le=1000,
            personal=True,
        ),
    ] = 0
    days_between_visits: Annotated[
        int,
        _limits(
            "Days between visits",
            help="So many days after the last session of this task the participant is marked on "
            "the first screen: a "
            "visit is due. 0: never.",
            ge=0,
            le=365,
            personal=True,
        ),
    ] = 0
    rest_after_attempts: Annotated[
        int,
        _limits(
            "Must rest (attempts)",
            "attempts",
            "A rest that Enter cannot skip follows after so many attempts, practice included. 0: "
            "none.",
            ge=0,
            le=200,
            personal=True,
        ),
    ] = 0
    rest_after_minutes: Annotated[
        int,
        _limits(
            "Must rest (minutes)",
            "min",
            "The same rest follows the attempt in which so much time has passed since the last "
            "one. 0: none.",
            ge=0,
            le=480,
            personal=True,
        ),
    ] = 0
    rest_seconds: Annotated[
        int,
        _limits(
            "Length of that rest",
            "s",
            "The participant may rest longer; a therapist can end it from the pause menu.",
            ge=5,
            le=3600,
            personal=True,
        ),
    ] = 60

    # Difficulty

    threshold: Annotated[
        float,
        _difficulty(
            "Goal",
            help="The result of an attempt must be better than this; equal is not enough.",
            ge=0,
            le=1e6,
        ),
    ] = 1000.0
    neutral_band: Annotated[
        float,
        _difficulty(
            "Neutral band",
            help="A result this close to the goal, on either side, is called neither good nor bad.",
            ge=0,
            le=1e6,
        ),
    ] = 10.0
    min_accuracy: Annotated[
        float,
        _difficulty(
            "Minimum accuracy",
            help="The goal counts as reached only if at least this share of the responses is "
            "right.",
            ge=0,
            le=1,
        ),
    ] = 0.8
    start_level: Annotated[
        int,
        _difficulty(
            "Start level",
            help="The level of the first attempt. It is shown where no earlier result decides.",
            ge=1,
            le=100,
        ),
    ] = 1
    start_from: Annotated[
        Literal["estimate", "last level", "fixed"],
        _difficulty(
            "Start from",
            help="last results: the level at which the last session's times just reached the "
            "goal. last level: the one it ended at. fixed level: the same for each session, which "
            "you set.",
            labels={"estimate": "last results", "fixed": "fixed level"},
        ),
    ] = "estimate"
    min_level: Annotated[
        int, _difficulty("Lowest level", help="The level never falls below this.", ge=1, le=100)
    ] = 1
    max_level: Annotated[
        int,
        _difficulty(
            "Highest level",
            help="The level never rises above this or the last level of the task.",
            ge=1,
            le=100,
        ),
    ] = 10
    # the choices, their meaning and the settings of each are those of `policies.BY_CHOICE`
    difficulty_policy: Annotated[str, _difficulty("Difficulty")] = BY_OUTCOME

    # Feedback

    feedback_form: Annotated[
        Literal["qualitative", "quantitative", "both"],
        _feedback(
            "Feedback form",
            help="In words, in figures, or both.",
            labels={"qualitative": "in words", "quantitative": "in figures"},
        ),
    ] = "both"
    feedback_compared_with: Annotated[
        Literal["last attempt", "best attempt", "session's mean", "goal"],
        _feedback(
            "Compared with",
            help="Figures are compared with results at the same level, or with the goal.",
        ),
    ] = "last attempt"
    feedback_delay_ms: Annotated[
        int,
        _feedback(
            "Feedback delay",
            "ms",
            "Time from the end of an attempt to its feedback.",
            ge=0,
            le=60_000,
        ),
    ] = 0
    trial_feedback_ms: Annotated[
        int,
        _feedback(
            "Sign after each prompt",
            "ms",
            "A tick or a cross is shown this long after each prompt, unless the task shows "
            "something else; 0: never.",
            ge=0,
            le=LONGEST_SHOW_MS,
        ),
    ] = 0
    feedback_schedule: Annotated[str, _feedback("Feedback")] = "every"

    # Access

    switch: Annotated[
        Literal["none", "one", "two"],
        _access(
            "Switch",
            help="one: Space or Enter is the only key; a mark moves through the choices of each "
            "screen, and the switch takes the marked one. two: Space moves the mark, Enter takes. "
            "For tasks with one response key.",
            personal=True,
        ),
    ] = "none"
    scan_interval_ms: Annotated[
        int,
        _access(
            "Scan interval",
            "ms",
            "Time for which the mark stays on a choice, 500 ms or more. 0: it follows the person's "
            "presses.",
            ge=0,
            le=SLOWEST_MS,
            personal=True,
        ),
    ] = 0
    bounce_ms: Annotated[
        int,
        _access(
            "Bounce",
            "ms",
            "The same key again within this time is a tremor, not a press; it is recorded as a "
            "repeat. 0: only what the key repeat interval says.",
            ge=0,
            le=1000,
            personal=True,
        ),
    ] = 0
    system_keys: Annotated[
        Literal["not asked", "neither", "slow", "sticky", "both"],
        _access(
            "Slow or sticky keys",
            help="Ask, and look in the system's settings before the first session. GNOME: "
            "Accessibility, Typing. Windows: Accessibility, Keyboard, Filter keys. macOS: "
            "Accessibility, Keyboard. neither: you looked, and both are off.",
            personal=True,
        ),
    ] = "not asked"
    added_delay_ms: Annotated[
        int,
        _access(
            "Delay of the system",
            "ms",
            "What the system's slow keys add to each press, as its keyboard settings say. "
            "It is recorded and reported, and not subtracted from reaction times.",
            ge=0,
            le=5000,
            personal=True,
        ),
    ] = 0

    # Agent

    encouragement: Annotated[
        bool,
        _agent(
            "Encouragement",
            help="A kind word before an attempt that is harder than the earlier ones.",
        ),
    ] = True
    outputs: Annotated[
        tuple[str, ...],
        _agent(
            "Outputs",
            help="Where the agent appears, speaks and moves: screen, speech, tones, servo, or a robot "
            "(ros://HOST, furhat://HOST and others).",
            max_length=8,
            personal=True,
        ),
    ] = ("screen",)
    speech: Annotated[
        str,
        _agent(
            "Speech goes to",
            help="sound: the loudspeaker. file:FOLDER: a WAV file for each utterance.",
            max_length=500,
            personal=True,
        ),
    ] = "sound"
    read_aloud: Annotated[
        bool,
        _agent(
            "Read aloud",
            help="With speech: every sentence of the participant's screens is spoken. F9 repeats "
            "it, any other key ends it.",
            personal=True,
        ),
    ] = False

    # Operator

    # Adults read English non-fiction silently at 238 words a minute, 252 ms a word (Brysbaert 2019).

    operator_joins: Annotated[
        bool,
        _operator(
            "Operators can join",
            help="On this computer, with `sar-tui wizard`, from the beginning of a session to its "
            "end.",
            personal=True,
        ),
    ] = False
    operator_feedback: Annotated[
        Mode,
        _operator(
            "Feedback mode",
            help="With an operator: autonomous, the agent acts; veto, it acts unless stopped in time; "
            "approve, it acts when a key is pressed; manual, only the operator acts.",
        ),
    ] = "autonomous"
    operator_encouragement: Annotated[
        Mode, _operator("Encouragement mode", help="As for feedback; includes reminders of rest.")
    ] = "autonomous"
    operator_instruction: Annotated[
        Mode, _operator("Instruction mode", help="As for feedback; includes greeting and goodbye.")
    ] = "autonomous"
    operator_gesture: Annotated[
        Mode,
        _operator("Gesture mode", help="As for feedback; autonomous: gestures go with their text."),
    ] = "autonomous"
    operator_difficulty: Annotated[Mode, _operator("Level mode", help="As for feedback.")] = (
        "autonomous"
    )
    operator_time_ms: Annotated[
        int,
        _operator(
            "Time to decide",
            "ms",
            "Shortest waiting time of veto and approve; more if there is more to read. For "
            "feedback with a delay, that "
            "delay.",
            ge=200,
            le=120_000,
        ),
    ] = 4000
    operator_ms_per_word: Annotated[
        int,
        _operator(
            "Reading time per word",
            "ms",
            "The operator has this time for each word, and 2 s to choose. 0: always the time "
            "above.",
            ge=0,
            le=2000,
        ),
    ] = 250
    operator_timeout: Annotated[
        Literal["act", "drop"],
        _operator(
            "Timeout of approve",
            help="If nobody decides in time. act: the agent acts as if it were alone. drop: "
            "nothing is said.",
        ),
    ] = "act"
    operator_lost: Annotated[
        Literal["autonomous", "silent"],
        _operator(
            "Agent without operator",
            help="If no operator is connected, or the connection is lost. silent: what needs an "
            "operator is dropped.",
        ),
    ] = "autonomous"
    operator_lost_ms: Annotated[
        int,
        _operator(
            "Time until lost",
            "ms",
            "The operator counts as lost after this time without a sign of life from the panel or "
            "its terminal.",
            ge=500,
            le=60_000,
        ),
    ] = 2000
    filler: Annotated[
        Literal["operator", "always", "never"],
        _operator(
            "Filler",
            help="Said after one second of waiting for feedback. operator: while an operator "
            "decides. always: "
            "also during a feedback delay, so that the two cannot be told apart. never: nothing "
            "is said.",
        ),
    ] = "operator"

    # Timing

    response_timeout_ms: Annotated[
        int,
        _timing(
            "Response time-out",
            "ms",
            "A prompt without a response counts as missed after this time.",
            ge=100,
            le=600_000,
        ),
    ] = 5000
    min_rt_ms: Annotated[
        int,
        _timing(
            "Fastest real response",
            "ms",
            "A faster response is stored as an anticipation and left out of the result.",
            ge=0,
            le=1000,
        ),
    ] = 100
    quiet_ms: Annotated[
        int,
        _timing(
            "Quiet before a prompt",
            "ms",
            "The wait begins after this time without a key press.",
            ge=0,
            le=5000,
        ),
    ] = 500
    foreperiod_min_ms: Annotated[
        int,
        _timing(
            "Shortest wait",
            "ms",
            "The wait before a prompt is at least this long.",
            ge=0,
            le=60_000,
        ),
    ] = 500
    foreperiod_max_ms: Annotated[
        int,
        _timing(
            "Longest wait",
            "ms",
            "The wait before a prompt is random, at most this long.",
            ge=0,
            le=60_000,
        ),
    ] = 1500
    repeat_interval_ms: Annotated[
        int,
        _timing(
            "Key repeat interval",
            "ms",
            "The same key again within this time is a held key, not a press.",
            ge=0,
            le=1000,
        ),
    ] = 50

    def problems(self) -> dict[str, str]:
        """Return settings that do not fit together: parameter name to one clear sentence. Extend it
        in a subclass.
        """
        found = self._wrong_questions() | self._wrong_levels()
        for kind in policies.settings_types():
            found |= kind.problems(self)
        if self.foreperiod_min_ms > self.foreperiod_max_ms:
            found["foreperiod_min_ms"] = Sentence(
                "Shortest wait ({shortest} ms) is above the longest ({longest} ms).",
                shortest=self.foreperiod_min_ms,
                longest=self.foreperiod_max_ms,
            )
        if 0 < self.scan_interval_ms < FASTEST_MS:
            found["scan_interval_ms"] = Sentence(
                "Scan interval is 0, or {fastest} ms or more, not {chosen} ms.",
                fastest=FASTEST_MS,
                chosen=self.scan_interval_ms,
            )
        return found | self._wrong_system_keys()

    def _wrong_system_keys(self) -> dict[str, str]:
        has_slow, delay = self.system_keys in ("slow", "both"), self.added_delay_ms
        if has_slow and not delay:
            text = "With slow keys, the delay of the system is 1 ms or more."
            return {"system_keys": Sentence(text)}
        if delay and not has_slow:
            text = "A delay of {delay} ms is that of slow keys: choose slow."
            return {"added_delay_ms": Sentence(text, delay=delay)}
        return {}

    def _wrong_questions(self) -> dict[str, str]:
        for name in self.questions:
            if name not in QUESTIONS and name not in EARLIER:
                text = 'There is no question "{name}". Choose from: {known}.'
                return {"questions": Sentence(text, name=name, known=", ".join(QUESTIONS))}
        if len(set(self.questions)) < len(self.questions):
            return {"questions": Sentence("Each question can be asked once: name it once.")}
        return {}

    def _wrong_levels(self) -> dict[str, str]:
        lowest, highest, start = self.min_level, self.max_level, self.start_level
        if lowest > highest:
            text = "Lowest level ({lowest}) is above the highest ({highest})."
            return {"min_level": Sentence(text, lowest=lowest, highest=highest)}
        if not lowest <= start <= highest:
            text = "Start level ({start}) must be between {lowest} and {highest}."
            return {"start_level": Sentence(text, start=start, lowest=lowest, highest=highest)}
        return {}


def pain_limits(settings: TaskParameters) -> PainLimits:
    """Return the limits of pain that are set."""
    return PainLimits(settings.pain_limit, settings.pain_rise)


@lru_cache(maxsize=64)
def fields(parameters: type[TaskParameters]) -> tuple[Field, ...]:
    """Return the declared parameters of a task: its own first, then the common ones.

    Cached, because settings are built with every key typed into the form.
    """
    common = _declared(TaskParameters)
    found = [
        msgspec.structs.replace(field, group=field.group or common[name].group)
        if name in common
        else field
        for name, field in _declared(parameters).items()
    ]
    return tuple(sorted(found, key=lambda field: field.name in common))


def grouped(parameters: type[TaskParameters]) -> dict[str, tuple[Field, ...]]:
    """Return the declared parameters by heading, in the order of the settings form.

    The task's own under ``""`` come first, then headings that only this task has, then the common
    ones.
    """
    common = list(dict.fromkeys(field.group for field in fields(TaskParameters)))
    found: dict[str, list[Field]] = {}
    for field in fields(parameters):
        found.setdefault(field.group, []).append(field)
    ranks = {
        heading: common.index(heading) + 1 if heading in common else bool(heading) - 1
        for heading in found
    }
    return {heading: tuple(found[heading]) for heading in sorted(found, key=ranks.__getitem__)}


def _declared(parameters: type[TaskParameters]) -> dict[str, Field]:
    info = inspect.type_info(parameters)
    assert isinstance(info, inspect.StructType)
    return {field.name: _in_group(declared_field(field)) for field in info.fields}


def _in_group(field: Field) -> Field:
    """Return a setting of a policy under the heading of its policy, unless it has one."""
    if field.group:
        return field
    for kind, heading in policies.settings_types().items():
        if field.name in kind.__struct_fields__:
            return msgspec.structs.replace(field, group=heading)
    return field


def build(parameters: type[P], values: Mapping[str, object]) -> P:
    """Build checked parameters from values, typed or as text.

    Raises:
        ParameterError: names every parameter that is unknown, out of bounds, or in conflict with
            another.
    """
    declared = {field.name: field for field in fields(parameters)}
    types = {field.name: field.type for field in msgspec.structs.fields(parameters)}
    problems: dict[str, str] = {}
    good: dict[str, Any] = {}
    for name, value in values.items():
        if name not in declared:
            near = difflib.get_close_matches(name, declared, 1)
            problems[name] = (
                Sentence(
                    "There is no parameter {name}. Did you mean {near}?", name=name, near=near[0]
                )
                if near
                else Sentence("There is no parameter {name}.", name=name)
            )
            continue
        if not _is_text(value):
            problems[name] = Sentence(
                "{title} is a text with bytes that are not UTF-8: {shown}.",
                title=Sentence(declared[name].title),
                shown=show(value),
            )
            continue
        given = read(declared[name], value) if isinstance(value, str) else value
        try:
            good[name] = msgspec.convert(given, types[name], strict=not isinstance(value, str))
        except msgspec.ValidationError:
            problems[name] = declared[name].problem(value)
    if gone := policies.missing(values):  # their own settings are unknown, too
        raise ParameterError(gone)
    built = parameters(**good)
    if problems or (problems := _conflicts(built)):
        raise ParameterError(problems)
    return built


def usable(
    parameters: type[TaskParameters], values: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, str]]:
    """Return the values that can be used, and for each of the others why not, in one sentence.

    Values that were valid when they were saved may be out of bounds, in conflict, or unknown in
    another version of the task.

    Raises:
        ParameterError: no choice of the values can be used.
    """
    groups = {field.name: field.group for field in fields(parameters)}
    left_out: dict[str, str] = {
        name: Sentence("The setting {name} does not exist any more.", name=name)
        for name in values
        if name not in groups
    }
    kept = {name: value for name, value in values.items() if name in groups}
    while True:
        try:
            build(parameters, kept)
        except ParameterError as error:
            wrong = kept.keys() & error.problems
            # in conflict with the default of another parameter, under the same heading
            if not wrong:
                reported = {groups.get(name) for name in error.problems}
                wrong = {name for name in kept if groups[name] in reported}
            if not wrong:
                raise
            left_out.update({name: error.problems.get(name) or str(error) for name in wrong})
            kept = {name: value for name, value in kept.items() if name not in wrong}
        else:
            return kept, left_out


def _conflicts(parameters: TaskParameters) -> dict[str, str]:
    """Return the problems that a task finds in its parameters; if that fails, this under its first
    parameter.
    """
    try:
        with calling("task", type(parameters)):
            return {
                str(name): problem if isinstance(problem, Sentence) else str(problem)
                for name, problem in parameters.problems().items()
            }
    except PLUGIN_ERRORS as error:
        first, *_ = fields(type(parameters))
        return {
            first.name: f"The settings cannot be checked: problems() failed ({describe(error)})."
        }


def _is_text(value: object) -> bool:
    """Return False for a text, or a list with one, that cannot be stored: bytes of an argument that
    are not UTF-8.
    """
    try:
        show(value).encode()
    except UnicodeEncodeError:
        return False
    return True


def changed(parameters: TaskParameters) -> dict[str, Any]:
    """Return the parameters that differ from their defaults, as plain values."""
    return {
        field.name: msgspec.to_builtins(getattr(parameters, field.name))
        for field in fields(type(parameters))
        if getattr(parameters, field.name) != field.default
    }


class Change(msgspec.Struct, frozen=True, omit_defaults=True):
    """A parameter with two values. Its title is its name if it does not exist any more."""

    name: str
    title: str
    unit: str
    before: Any
    after: Any

    @property
    def text(self) -> str:
        """The change in words: "Goal 1000 → 900 ms"."""
        values = [show(value) or "none" for value in (self.before, self.after)]
        return " ".join(filter(None, (self.title, " → ".join(values), self.unit)))


def changes(
    parameters: type[TaskParameters],
    before: Mapping[str, Any],
    after: Mapping[str, Any],
) -> tuple[Change, ...]:
    """Return what differs between two sets of values, in the order of the declaration.

    A value that is missing is the default; of a parameter that does not exist any more it is None.
    """
    declared = {field.name: field for field in fields(parameters)}
    gone = [name for name in (*before, *after) if name not in declared]
    found = []
    for name in dict.fromkeys((*declared, *gone)):
        field = declared.get(name)
        default = field.default if field else None
        old, new = before.get(name, default), after.get(name, default)
        if show(old) != show(new):
            title, unit = (field.title, field.unit) if field else (name, "")
            found.append(Change(name, title, unit, old, new))
    return tuple(found)
