"""Timing passports: the figures of ``sar-tui timing`` that sessions were recorded with."""

import hashlib
from collections.abc import Iterable, Mapping
from typing import Any

import msgspec

FILE = "timing.json"
_TEXTS = ("verdict", "measured_at")


class Passport(msgspec.Struct, frozen=True):
    """The measured timing of the machine of some sessions.

    Attributes:
        sha256: of ``timing`` as JSON in UTF-8, with sorted keys and without spaces.
        timing: figures in ms, the verdict, and when it was measured.
        sessions: the ids of the sessions that began after this measurement and before the next.
    """

    sha256: str
    timing: dict[str, Any]
    sessions: list[str]


def passports(sessions: Iterable[Mapping[str, Any]], *, with_dates: bool) -> list[Passport]:
    """Return the passports of sessions, as `store.sessions.listing` returns them; those not
    measured have none.
    """
    found: dict[str, Passport] = {}
    for row in sessions:
        timing = (row["machine"] or {}).get("timing")
        if not isinstance(timing, dict):
            continue
        kept = {name: value for name, value in timing.items() if _is_kept(name, value, with_dates)}
        digest = hashlib.sha256(msgspec.json.encode(kept, order="sorted")).hexdigest()
        found.setdefault(digest, Passport(digest, kept, [])).sessions.append(row["id"])
    return list(found.values())


def _is_kept(name: str, value: object, with_dates: bool) -> bool:
    return isinstance(value, int | float) or (
        name in _TEXTS and (with_dates or name != "measured_at")
    )
