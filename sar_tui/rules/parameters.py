"""The parameters of a task: common settings and the task's own, built and checked in one place.

The settings form, `--set`, the checks and the documentation are made from these declarations.
"""

import difflib
from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeVar, get_type_hints

import msgspec
from msgspec import inspect

from sar_tui.plugin_calls import PLUGIN_ERRORS, calling, describe
from sar_tui.rules import difficulty, feedback, registry
from sar_tui.rules.declaration import Field, ParameterError, Settings, declared_field, read, show
from sar_tui.rules.settings.agent import AgentSettings
from sar_tui.rules.settings.difficulty import DifficultySettings
from sar_tui.rules.settings.feedback import FeedbackSettings, ScheduleSettings
from sar_tui.rules.settings.goal import GoalSettings
from sar_tui.rules.settings.limits import LimitSettings
from sar_tui.rules.settings.operator import OperatorSettings
from sar_tui.rules.settings.questions import QuestionSettings
from sar_tui.rules.settings.session import SessionSettings
from sar_tui.rules.settings.timing import TimingSettings
from sar_tui.rules.settings.wellbeing import WellbeingSettings

_COMMON: tuple[type[Settings], ...] = (
    SessionSettings,
    WellbeingSettings,
    QuestionSettings,
    LimitSettings,
    GoalSettings,
    *registry.settings_types(difficulty.POLICIES),
    DifficultySettings,
    ScheduleSettings,
    *registry.settings_types(feedback.POLICIES),
    FeedbackSettings,
    AgentSettings,
    OperatorSettings,
    TimingSettings,
)
"""Settings that every task has, in the order of the settings form."""


class _Checked(Settings, frozen=True, kw_only=True):
    def problems(self) -> dict[str, str]:
        """Return settings that do not fit together: parameter name to one clear sentence. Extend it
        in a subclass.
        """
        return {name: problem for kind in _COMMON for name, problem in kind.problems(self).items()}


if TYPE_CHECKING:
    from sar_tui.rules.difficulty.one_up_one_down import OneUpOneDownSettings
    from sar_tui.rules.difficulty.percentile import PercentileSettings
    from sar_tui.rules.difficulty.sequence import SequenceSettings
    from sar_tui.rules.difficulty.target import TargetSettings
    from sar_tui.rules.feedback.bandwidth import BandwidthSettings
    from sar_tui.rules.feedback.every import EverySettings
    from sar_tui.rules.feedback.faded import FadedSettings

    class TaskParameters(
        SessionSettings,
        WellbeingSettings,
        QuestionSettings,
        LimitSettings,
        GoalSettings,
        OneUpOneDownSettings,
        SequenceSettings,
        PercentileSettings,
        TargetSettings,
        DifficultySettings,
        ScheduleSettings,
        EverySettings,
        FadedSettings,
        BandwidthSettings,
        FeedbackSettings,
        AgentSettings,
        OperatorSettings,
        TimingSettings,
        frozen=True,
        kw_only=True,
    ):
        """Settings that every task has. A task adds its own in a subclass.

        Build them with ``build``, which checks; the constructor does not.
        """

else:  # a msgspec struct cannot have several bases with fields, so the fields are collected here
    TaskParameters = msgspec.defstruct(
        "TaskParameters",
        [
            (field.name, get_type_hints(kind, include_extras=True)[field.name], field.default)
            for kind in _COMMON
            for field in msgspec.structs.fields(kind)
        ],
        bases=(_Checked,),
        module=__name__,
        namespace={"__doc__": "Settings that every task has. A task adds its own in a subclass."},
        frozen=True,
        kw_only=True,
    )

P = TypeVar("P", bound=TaskParameters)


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
    return {field.name: declared_field(field) for field in info.fields}


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
            problems[name] = f"There is no parameter {name}." + (
                f" Did you mean {near[0]}?" if near else ""
            )
            continue
        if not _is_text(value):
            problems[name] = (
                f"{declared[name].title} is a text with bytes that are not UTF-8: {show(value)}."
            )
            continue
        given = read(declared[name], value) if isinstance(value, str) else value
        try:
            good[name] = msgspec.convert(given, types[name], strict=not isinstance(value, str))
        except msgspec.ValidationError:
            problems[name] = declared[name].problem(value)
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
    left_out = {
        name: f"The setting {name} does not exist any more."
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
            return {str(name): str(problem) for name, problem in parameters.problems().items()}
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
