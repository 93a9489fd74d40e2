"""People's rights in a merge: what was erased or de-identified stays so, whatever the order.

What each database knows of it is done to the other one before they are merged.
"""

import sqlite3
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path

import msgspec

from sar_tui.store import people_events, sites
from sar_tui.store.database import StoreError, transaction
from sar_tui.store.merge.people import Pair, local_code, site_of, stored_pairs
from sar_tui.store.people_events import PersonEvent
from sar_tui.store.personal_rows import FINAL, apply, with_full_codes

_ERASED = "{code} was erased on {date} by {home}: what the other database has of them is left out."
_DEIDENTIFIED = (
    "{code} was de-identified on {date} by {home}: what the other database has of them is taken "
    "without texts, and under that code."
)
_CLAIMED = (
    "{site} says that {code} was {event} here. If so, say it here: sar-tui participant {command} "
    "{local}"
)


class Rights(msgspec.Struct, frozen=True):
    """Events to be applied to this database, and sentences on what was done to the other one.

    ``events``: erasures and de-identifications, with codes in full.
    """

    events: tuple[PersonEvent, ...]
    refused: tuple[str, ...]


def keep_rights(
    db: sqlite3.Connection, other: Path, own: str, given: str, same: Iterable[Pair]
) -> Rights:
    """Do to the copy of another database what is known of people's rights in both.

    Args:
        db: this database, only read.
        other: the copy.
        own: the code of this site. ``given``: that of the other one, if its database has none.
        same: codes of the same persons that are said now.

    Raises:
        StoreError: a row of the other database is damaged.
    """
    here = [with_full_codes(event, own) for event in people_events.events(db)]
    with closing(sqlite3.connect(other, isolation_level=None)) as copy:
        site = sites.own(copy) or given
        if not site:
            return Rights((), ())
        try:
            there = [with_full_codes(event, site) for event in people_events.events(copy)]
        except StoreError as error:
            raise StoreError(
                "The other database cannot be merged: people_events.details is somewhere what this "
                "program does not store.",
                bad_input=True,
            ) from error
        known = {event.id for event in here}
        accepted = [event for event in there if _is_author(event, own, site) or event.id in known]
        refused = [_claimed(event, site) for event in there if _is_claim(event, own, site, known)]
        with transaction(copy):
            copy.execute("INSERT OR IGNORE INTO site (number, code) VALUES (1, ?)", (site,))
            pairs = stored_pairs(db) | set(same)
            for event in _final(here, accepted):
                is_new = event.id not in {one.id for one in there}
                if apply(copy, event, same=pairs, at=own) and is_new:
                    refused.append(_in_words(event, own))
    return Rights(_final(accepted, here), tuple(refused))


def _final(others: Iterable[PersonEvent], own: Iterable[PersonEvent]) -> tuple[PersonEvent, ...]:
    """Return the erasures and de-identifications that two databases know, in order; those of both
    as the second one has them: a later de-identification replaces the code in earlier ones.
    """
    known = {event.id: event for event in (*others, *own) if event.event in FINAL}
    return tuple(sorted(known.values(), key=lambda event: (event.at, event.id)))


def take_over(db: sqlite3.Connection, rights: Rights) -> list[str]:
    """Do to this database what was done elsewhere, in a transaction of the caller; return the codes
    of those of whom something was here.
    """
    return [event.participant for event in rights.events if apply(db, event)]


def _is_author(event: PersonEvent, own: str, site: str) -> bool:
    """Return True if the site of a person recorded an event; that of another one only its own
    database may say.
    """
    is_home = site_of(event.participant) == event.site
    return is_home and (event.site != own or site == own)


def _is_claim(event: PersonEvent, own: str, site: str, known: set[str]) -> bool:
    return event.event in FINAL and event.site == own and site != own and event.id not in known


def _claimed(event: PersonEvent, site: str) -> str:
    command = "erase" if event.event == "erased" else "de-identify"
    return _CLAIMED.format(
        site=site,
        code=event.participant,
        event=event.event,
        command=command,
        local=local_code(event.participant),
    )


def _in_words(event: PersonEvent, own: str) -> str:
    words = _ERASED if event.event == "erased" else _DEIDENTIFIED
    code = event.participant.removesuffix(f"@{own}")
    return words.format(code=code, date=event.at[:10], home=event.site)
