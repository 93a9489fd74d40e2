"""Settings that have no effect, because they belong to policies of difficulty or feedback that are
not chosen.
"""

from collections.abc import Mapping
from typing import Any

import msgspec

from sar_tui.rules import difficulty, feedback

_CHOICES: Mapping[str, Mapping[str, Any]] = {
    "difficulty_policy": difficulty.POLICIES,
    "feedback_schedule": feedback.POLICIES,
}


def without_effect(values: Mapping[str, object]) -> dict[str, str]:
    """Return the settings that have no effect beside others, each with the policies that use it:
    "target".

    Args:
        values: of the settings, by name. Those of a choice that is not known leave everything in
            effect.
    """
    found: dict[str, str] = {}
    for choice, policies in _CHOICES.items():
        users: dict[str, list[str]] = {}
        for name, policy in policies.items():
            for field in msgspec.structs.fields(policy.settings):
                users.setdefault(field.name, []).append(name)
        if (chosen := values.get(choice)) in policies:
            found |= {name: " or ".join(of) for name, of in users.items() if chosen not in of}
    return found
