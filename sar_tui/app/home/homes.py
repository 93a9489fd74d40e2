"""Words of the first screen on people who train at home, by the letters from their computers."""

import sqlite3
from collections.abc import Sequence
from datetime import UTC, date, datetime

import msgspec

from sar_tui.letterbox import status
from sar_tui.letterbox.status import Home
from sar_tui.model.language import Language
from sar_tui.rules.attention import AtHome


class Homes(msgspec.Struct, frozen=True):
    """The computers of a person that are invited, have joined or were revoked; at least one."""

    computers: Sequence[Home]

    @property
    def _joined(self) -> list[Home]:
        return [each for each in self.computers if each.state == "joined"]

    @property
    def can_be_written_to(self) -> bool:
        """True unless all of them were revoked."""
        return any(each.state != "revoked" for each in self.computers)

    @property
    def _heard(self) -> datetime | None:
        """When something was heard of any of them last, as the clock here shows it."""
        return max((_local(each.heard_at) for each in self._joined if each.heard_at), default=None)

    @property
    def _missing(self) -> int:
        return sum(len(each.missing) for each in self._joined)

    @property
    def facts(self) -> AtHome:
        """The facts in which a reason to look may be found."""
        refused = [_local(each.refused_at) for each in self._joined if each.refused_at]
        return AtHome(
            heard=self._heard.date() if self._heard else None,
            missing=self._missing,
            refused=max(refused).date() if refused else None,
        )

    def shortly(self, today: date, tr: Language) -> str:
        """Return what is said in the list: "At home: heard today 14:02"."""
        if not self._joined and self.computers[-1].state == "invited":
            return self._states(today, tr)[0]
        return tr("At home: {state}", state=self._states(today, tr)[0])

    def in_full(self, today: date, tr: Language) -> str:
        """Return what is said on the card: "At home: heard today 14:02 · 2 letters missing"."""
        return tr("At home: {state}", state=" · ".join(self._states(today, tr)))

    def _states(self, today: date, tr: Language) -> list[str]:
        if not self._joined:
            is_revoked = self.computers[-1].state == "revoked"
            return [tr("revoked") if is_revoked else tr("invited, not joined yet")]
        said = []
        if any(each.clock for each in self._joined):
            said.append(tr("the clock there is wrong"))
        said.append(_heard_words(self._heard, today, tr))
        if missing := self._missing:
            one, several = "1 letter missing", "{value} letters missing"
            said.append(tr(one if missing == 1 else several, value=missing))
        return said


def read_homes(database: sqlite3.Connection) -> dict[str, Homes]:
    """Return the people who train at home, or are invited to, by their codes."""
    found: dict[str, list[Home]] = {}
    for home in status.homes(database):
        if home.state in ("invited", "joined", "revoked"):
            found.setdefault(home.participant, []).append(home)
    return {code: Homes(computers) for code, computers in found.items()}


def _heard_words(heard: datetime | None, today: date, tr: Language) -> str:
    if heard is None:
        return tr("not heard yet")
    days = (today - heard.date()).days
    if days <= 0:
        return tr("heard today {clock}", clock=f"{heard:%H:%M}")
    if days == 1:
        return tr("heard yesterday")
    return tr("not heard for {days} days", days=days)


def _local(at: str) -> datetime:
    """Return a stored time as the clock here shows it."""
    stored = datetime.fromisoformat(at)
    return (stored if stored.tzinfo else stored.replace(tzinfo=UTC)).astimezone()
