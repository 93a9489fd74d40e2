"""Policies of difficulty and feedback by name: included ones, the user's own, and those of packages.

A policy of others is named ``POLICY`` in a module of the user's folder ``policies``, with the name
of its file (hyphens for underscores), or is an entry point of the group ``sar_tui.policies``. Its
settings become settings of every task (`parameters.TaskParameters`, which has them found).
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, get_type_hints

import msgspec
from msgspec import Meta

from sar_tui.model.language import Sentence
from sar_tui.plugin_calls import check_api, is_own, marked_as
from sar_tui.plugin_loader import Group, PluginError, import_from, user_folder
from sar_tui.rules import difficulty, feedback
from sar_tui.rules.declaration import Settings
from sar_tui.rules.difficulty import Difficulty, DifficultyPolicy, Goal
from sar_tui.rules.feedback import Decision, FeedbackPolicy

S = TypeVar("S", bound=Settings)
F = TypeVar("F", bound=Callable[..., Any])
Policy = DifficultyPolicy | FeedbackPolicy

_GROUP = Group("sar_tui.policies", "policy")
DIFFICULTY: dict[str, DifficultyPolicy] = dict(difficulty.INCLUDED)
"""The choices of the setting ``difficulty_policy``."""
FEEDBACK: dict[str, FeedbackPolicy] = dict(feedback.INCLUDED)
"""The choices of the setting ``feedback_schedule``."""
BY_CHOICE: Mapping[str, Mapping[str, Policy]] = {
    "difficulty_policy": DIFFICULTY,
    "feedback_schedule": FEEDBACK,
}
"""The policies among which a setting chooses."""
HEADINGS = {"difficulty_policy": "Difficulty", "feedback_schedule": "Feedback"}
"""The heading of the settings of those policies."""
_NO_POLICY = {
    "difficulty_policy": "There is no difficulty policy {name} here: install the package that has "
    "it, or choose one of {known}.",
    "feedback_schedule": "There is no feedback policy {name} here: install the package that has "
    "it, or choose one of {known}.",
}
FAILED: dict[str, str] = {}
"""Why a policy cannot be used, in one sentence, by its name."""


def with_policies(common: type[S]) -> type[S]:
    """Return the class of common settings with all policies: as choices, and with the settings that
    they read by `own_settings`.
    """
    _find_others(common.__struct_fields__)
    hints = get_type_hints(common, include_extras=True)
    own: list[tuple[str, Any, Any]] = []
    for choice, found in BY_CHOICE.items():
        help = Meta(description=_summaries(found))
        names: Any = Literal[tuple(found)]
        default = next(f.default for f in msgspec.structs.fields(common) if f.name == choice)
        own.append((choice, Annotated[names, *hints[choice].__metadata__, help], default))
    for kind in settings_types():
        hints = get_type_hints(kind, include_extras=True)
        own += [(f.name, hints[f.name], f.default) for f in msgspec.structs.fields(kind)]
    extended: Any = msgspec.defstruct(
        common.__name__,
        own,
        bases=(common,),
        module=common.__module__,
        namespace={"__doc__": common.__doc__},
        frozen=True,
        kw_only=True,
    )
    return extended  # type: ignore[no-any-return]


def own_settings(kind: type[S], parameters: Settings) -> S:
    """Return a policy's own settings out of all parameters of a session."""
    return kind(**{name: getattr(parameters, name) for name in kind.__struct_fields__})


def settings_types() -> dict[type[Settings], str]:
    """Return each type of settings that policies read, in order of the policies' names, with its
    heading.
    """
    return {
        policy.settings: HEADINGS[choice]
        for choice, policies in BY_CHOICE.items()
        for policy in policies.values()
        if policy.settings.__struct_fields__
    }


def without_effect(values: Mapping[str, object]) -> dict[str, str]:
    """Return the settings that have no effect beside others, each with the policies that use it:
    "target".

    Args:
        values: of the settings, by name. Those of a choice that is not known leave everything in
            effect.
    """
    found: dict[str, str] = {}
    for choice, policies in BY_CHOICE.items():
        users: dict[str, list[str]] = {}
        common = {field for policy in policies.values() for field in _ignored(policy)}
        for name, policy in policies.items():
            read = [*policy.settings.__struct_fields__, *(common - {*_ignored(policy)})]
            for field in read:
                users.setdefault(field, []).append(name)
        if (chosen := values.get(choice)) in policies:
            found |= {name: " or ".join(of) for name, of in users.items() if chosen not in of}
    return found


def _ignored(policy: Policy) -> tuple[str, ...]:
    """Return the settings of every task that have no effect under a policy."""
    return policy.ignores if isinstance(policy, DifficultyPolicy) else ()


def missing(values: Mapping[str, object]) -> dict[str, str]:
    """Return the choices of policies that do not exist here, each with a sentence."""
    found = {}
    for choice, policies in BY_CHOICE.items():
        name = values.get(choice)
        if not isinstance(name, str) or name in policies:
            continue
        found[choice] = FAILED.get(name) or Sentence(
            _NO_POLICY[choice], name=name or Sentence("with an empty name"), known=tuple(policies)
        )
    return found


def _summaries(found: Mapping[str, Policy]) -> str:
    """Return the names of policies with their summaries; those of others on a line of their own,
    as they have no translation.
    """
    included = {*difficulty.INCLUDED, *feedback.INCLUDED}
    lines = (
        " ".join(
            f"{name}: {policy.summary}"
            for name, policy in found.items()
            if (name in included) is is_included
        )
        for is_included in (True, False)
    )
    return "\n".join(filter(None, lines))


def _find_others(common: Iterable[str]) -> None:
    """Add the user's own policies and those of packages, or why they cannot be used.

    Args:
        common: names of the settings that every task has.
    """
    taken = set(common)
    for kind in settings_types():
        taken |= {*kind.__struct_fields__}
    folder = user_folder() / "policies"
    own = {path.stem.replace("_", "-"): path.stem for path in folder.glob("*.py")}
    for name in sorted(own.keys() | _GROUP.names()):
        try:
            policy = _own_policy(folder, own[name]) if name in own else _GROUP.load(name)
            taken |= _add(name, policy, taken)
        except PluginError as error:
            FAILED[name] = str(error)


def _own_policy(folder: Path, stem: str) -> object:
    """Return the policy of a file. Raises PluginError."""

    def load() -> object:
        module = import_from(folder, "sar_tui_policies", stem)
        check_api("policy", stem, module)
        return module.POLICY

    return _GROUP.guarded(stem, stem, load)


def _add(name: str, policy: object, taken: Collection[str]) -> set[str]:
    """Add a policy of others, and return the names of its settings. Raises PluginError.

    Args:
        name: of the policy.
        policy: as its author declared it.
        taken: names of settings that it cannot have.
    """
    if not isinstance(policy, DifficultyPolicy | FeedbackPolicy):
        raise PluginError(f"The policy {name} is neither a DifficultyPolicy nor a FeedbackPolicy.")
    if name in DIFFICULTY or name in FEEDBACK:
        raise PluginError(f"The policy {name} has the name of an included one: rename it.")
    _GROUP.guarded(name, name, lambda: _check_settings(name, policy.settings, taken))
    if isinstance(policy, DifficultyPolicy):
        DIFFICULTY[name] = policy._replace(
            step=_checked(name, policy.step, Difficulty),
            goal=policy.goal and _checked(name, policy.goal, Goal, type(None)),
            start=_checked(name, policy.start, int),
            aim=policy.aim and _checked(name, policy.aim, float, int),
        )
    else:
        FEEDBACK[name] = policy._replace(
            decide=_checked(name, policy.decide, Decision),
            recent=_checked(name, policy.recent, int),
        )
    return {*policy.settings.__struct_fields__}


def _checked(name: str, function: F, *kinds: type) -> F:
    """Return a function of a policy with its mark as a plug-in's, and with its result checked. One
    of the program stays as it is.
    """
    if is_own(getattr(function, "__module__", None) or ""):
        return function
    marked = marked_as("policy", name, function)

    def call(*given: Any) -> Any:
        found = marked(*given)
        if not isinstance(found, kinds):
            raise TypeError(f"the policy {name} returned {found!r}, not a {kinds[0].__name__}")
        if isinstance(found, Difficulty):  # the bounds are the last argument of its step
            return msgspec.structs.replace(found, level=given[-1].nearest(found.level))
        return found

    return call  # type: ignore[return-value]


def _check_settings(name: str, kind: type[Settings], taken: Collection[str]) -> None:
    """Raise an error unless the settings of a policy can be settings of every task."""
    check_api("policy", name, kind)
    msgspec.convert(msgspec.to_builtins(kind()), kind)
    if shared := [field for field in kind.__struct_fields__ if field in taken]:
        raise PluginError(
            f"The policy {name} declares {', '.join(shared)}, which is a setting of every task: "
            "rename it."
        )
