"""Finds the policies of a package: one module each, named after the policy."""

import importlib
import pkgutil
from collections.abc import Iterable, Mapping
from typing import Protocol, TypeVar

from sar_tui.rules.declaration import Settings

P = TypeVar("P")
S = TypeVar("S", bound=Settings)


class HasSettings(Protocol):
    """A policy that declares its own parameters."""

    @property
    def settings(self) -> type[Settings]:
        """Type of the settings that the policy reads."""


def find(package: str, path: Iterable[str], kind: type[P]) -> dict[str, P]:
    """Return the policies of a package by name: the ``POLICY`` of each module that has one, in
    order of name.

    The name is that of the module, with hyphens.
    """
    modules = (
        importlib.import_module(f"{package}.{found.name}") for found in pkgutil.iter_modules(path)
    )
    policies = (
        (module.__name__.rpartition(".")[2].replace("_", "-"), getattr(module, "POLICY", None))
        for module in modules
    )
    return {name: policy for name, policy in sorted(policies) if isinstance(policy, kind)}


def settings_types(policies: Mapping[str, HasSettings]) -> tuple[type[Settings], ...]:
    """Return each type of settings that the policies read, once, in order of the name of its first
    parameter.
    """
    kinds = {policy.settings for policy in policies.values()}
    return tuple(
        sorted(
            (kind for kind in kinds if kind.__struct_fields__),
            key=lambda kind: kind.__struct_fields__[0],
        )
    )


def own_settings(kind: type[S], parameters: Settings) -> S:
    """Return a policy's own settings out of all parameters of a session."""
    return kind(**{name: getattr(parameters, name) for name in kind.__struct_fields__})
