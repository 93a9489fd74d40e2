"""Visits to a session at home: when one may be, and the link that they come by."""

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sar_tui.link.errors import LinkError
from sar_tui.link.invitation import home_file

if TYPE_CHECKING:
    from sar_tui.link.broker_process import BrokerProcess
    from sar_tui.store.database import StoreConnection

_MODES = (
    "operator_feedback",
    "operator_encouragement",
    "operator_instruction",
    "operator_gesture",
    "operator_difficulty",
)


@contextlib.contextmanager
def open_visits(
    folder: Path,
    database: "StoreConnection",
    settings: Mapping[str, Any],
    participants: Sequence[str],
    study: str,
    lost_ms: int,
    warn: Callable[[str], object],
) -> "Iterator[BrokerProcess | None]":
    """Let a session dial out for the duration of the block, if this is a home; else give None. What
    hinders it never hinders the session: ``warn`` is told.

    Args:
        folder, database: of the session.
        settings, participants: of the session.
        study: name of the session's study; empty if it is of none.
        lost_ms: silence after which a visitor is lost (ms).
    """
    with contextlib.ExitStack() as stack:
        link = None
        if home_file(folder).is_file() and may_be_visited(database, settings, participants, study):
            from sar_tui.link import visits

            try:
                link = stack.enter_context(visits.open_visits(folder, lost_ms))
            except LinkError as error:
                warn(str(error))
        yield link


def may_be_visited(
    database: "StoreConnection",
    settings: Mapping[str, Any],
    participants: Sequence[str],
    study: str,
) -> bool:
    """Return False for a session in which nothing may tell that somebody watches: one with a
    wizard, or of a study that is blind or has a condition with a wizard. Also for one of two
    people, of whom one would decide for the other.
    """
    if len(participants) > 1 or has_wizard(settings):
        return False
    return not study or _is_open_study(database, study)


def has_wizard(settings: Mapping[str, Any]) -> bool:
    """Return True if an operator decides on what the agent says, by these settings, or may join."""
    modes = (settings.get(name, "autonomous") for name in _MODES)
    return bool(settings.get("operator_joins")) or any(mode != "autonomous" for mode in modes)


def _is_open_study(database: "StoreConnection", study: str) -> bool:
    """Return True if the plan of a study is known, not blind, and without a wizard."""
    from sar_tui.study import ledger

    frozen = ledger.newest(database, study)
    if frozen is None or frozen.plan.allocation.blind:
        return False
    return not any(has_wizard(each.settings) for each in frozen.plan.conditions.values())
