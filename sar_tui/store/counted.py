"""Sessions that count: the one rule for dose, limits, progress, start levels, earlier results,
visits and reports.

A session that was discarded, as it was begun by mistake, or refused, as a question that must be
agreed to was not, is kept and listed, and counts nowhere. Every query for live sessions takes its
condition from here.
"""

from collections.abc import Mapping
from typing import Any

from sar_tui.model.session_mode import PERSONAL, is_personal

SET_ASIDE = ("discarded", "refused")
"""Statuses of sessions that do not count."""
KEPT = f"sessions.status NOT IN ({', '.join(map(repr, SET_ASIDE))})"
"""Condition: the session counts, if sessions of its mode are looked at."""
LIVE = f"sessions.mode IN ({', '.join(map(repr, PERSONAL))})"
"""Condition: a person sat there, or one invented for a demonstration, whatever became of the
session. For pain, adverse events, locks and checks.
"""
COUNTS = f"{LIVE} AND {KEPT}"
"""Condition: the session is one of a person, and counts."""


def is_set_aside(session: Mapping[str, Any]) -> bool:
    """Return True if a listed session does not count."""
    return session["status"] in SET_ASIDE


def counts(session: Mapping[str, Any]) -> bool:
    """Return True if a listed session is one of a person, and counts."""
    return is_personal(session["mode"]) and not is_set_aside(session)
