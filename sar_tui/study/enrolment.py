"""Enrolment: the plan is frozen with the first person, and each person comes to a group and to an
order of conditions.
"""

import sqlite3
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from sar_tui.model.language import Sentence
from sar_tui.plugins import Catalogue
from sar_tui.store import participants, sites
from sar_tui.store.database import StoreError, transaction
from sar_tui.study import conditions, ledger, secret
from sar_tui.study.allocation import (
    AllocationError,
    Assigned,
    Draws,
    ListedGroup,
    assign,
    neutral_codes,
    row_of_order,
)
from sar_tui.study.ledger import Enrolment, Frozen, Mode
from sar_tui.study.plan import Allocation, Study, orders


class Names(NamedTuple):
    """Names of groups and conditions as people may see them, by their own.

    Attributes:
        groups, conditions: neutral codes in a blind study, else the names themselves.
        codes: neutral codes of groups, which people of a study that was blind still have.
    """

    groups: Mapping[str, str]
    conditions: Mapping[str, str]
    codes: Mapping[str, str] = {}

    def group(self, shown: str) -> str:
        """Return the name of a group that is stored so."""
        return {code: name for name, code in self.codes.items()}.get(shown, shown)


def names_of(plan: Study, draws: Draws | None) -> Names:
    """Return the names as people may see them.

    Args:
        plan: the study.
        draws: from its key; None if nobody is allocated.
    """
    groups = {name: name for name in plan.groups}
    conditions = {name: name for name in plan.conditions}
    if draws is None:
        return Names(groups, conditions)
    codes = neutral_codes(draws, list(plan.groups), "G")
    if plan.allocation.blind:
        return Names(codes, neutral_codes(draws, list(plan.conditions), "C"), codes)
    return Names(groups, conditions, codes)


def needs_key(plan: Study) -> bool:
    """Return True if something about people of the study is drawn."""
    return bool(plan.groups or plan.squares)


def freeze(
    db: sqlite3.Connection,
    catalogue: Catalogue,
    text: str,
    plan: Study,
    key: Path,
    *,
    mode: Mode,
    author: str,
    reason: str = "",
    now: datetime | None = None,
) -> None:
    """Freeze a version of a plan, with a key for what is drawn: a new one if there is none yet.

    Raises:
        StoreError: as `ledger.freeze`; the key is not that of the version before; or people are
            enrolled, and their groups or orders would be lost.
        AllocationError: the key cannot be read or written.
    """
    last = ledger.newest(db, plan.name)
    commitment = ""
    if needs_key(plan):
        draws = secret.read(key) if key.exists() or last else secret.create(key)
        commitment = draws.commitment
        if last and last.commitment not in ("", commitment):
            raise StoreError(Sentence(_OTHER_KEY, key=str(key), study=plan.name), bad_input=True)
    if last and plan.version > last.plan.version:
        earlier = [each.plan for each in ledger.versions(db, plan.name)]
        if (wrong := _lost(earlier, plan)) and ledger.enrolments(db, plan.name):
            raise StoreError(
                f"People are enrolled already: version {plan.version} must {wrong}.", bad_input=True
            )
    ledger.freeze(
        db,
        text,
        plan,
        conditions.resolved(plan, catalogue),
        commitment=commitment,
        mode=mode,
        author=author,
        reason=reason,
        now=now,
    )


def _lost(versions: Sequence[Study], plan: Study) -> str:
    """Return the part of the versions before that a later one must keep, and does not; empty if it
    keeps all: groups, orders and neutral codes of people follow from it.
    """
    before = versions[-1]
    if missing := [name for name in before.groups if name not in plan.groups]:
        return f"keep the group {missing[0]}"
    if list(before.squares.items()) != list(plan.squares.items()):
        return "have the same orders of conditions"
    is_coded = any(each.allocation.blind for each in (*versions, plan))
    if is_coded and before.groups.keys() != plan.groups.keys():
        return "have the same groups, as their neutral codes follow from their names"
    if is_coded and before.conditions.keys() != plan.conditions.keys():
        return "have the same conditions, as their neutral codes follow from their names"
    return ""


_OTHER_KEY = "{key} is not the key with which the study {study} was frozen."


def draws_of(frozen: Frozen, key: Path) -> Draws | None:
    """Return what is drawn with the key of a frozen study; None if it needs none.

    Raises:
        AllocationError: the key is not here, or is another one.
    """
    if not needs_key(frozen.plan):
        return None
    draws = secret.read(key)
    if draws.commitment != frozen.commitment:
        raise AllocationError(Sentence(_OTHER_KEY, key=str(key), study=frozen.plan.name))
    return draws


def enrol(
    db: sqlite3.Connection,
    frozen: Frozen,
    participant: str,
    key: Path,
    *,
    factors: Mapping[str, str] = {},
    replaces: str = "",
    listed: Path | None = None,
    author: str = "",
    now: datetime | None = None,
) -> Enrolment:
    """Enrol a person, and draw their group and orders in the same transaction.

    Args:
        db: the database.
        frozen: the study.
        participant: a code, which is known or new.
        key: file of the study's key.
        factors: values of the strata, by name.
        replaces: code of a person who has left, whose group and orders this one gets.
        listed: a list of groups made elsewhere.
        author: who enrols.
        now: when; None for the present.

    Raises:
        StoreError: the person is enrolled already, a factor is missing, or the disk cannot write.
        AllocationError: the key or the list cannot be used.
    """
    plan = frozen.plan
    draws = draws_of(frozen, key)
    names = names_of(plan, draws)
    with transaction(db) as connection:
        code = participants.store(connection, participant, now)
        people, given, rows = check(
            connection, plan, code, factors=factors, replaces=replaces, listed=listed
        )
        stratum = "|".join(filter(None, (sites.own(connection), *given.values())))
        group, numbers = "", tuple[int, ...]()
        if replaces:
            left = _replaced(plan, people, replaces)
            group, numbers = names.group(left.group), left.orders
        elif draws:
            group = _drawn(plan, draws, people, stratum, given, rows, names)
            numbers = _orders(plan, draws, people, stratum, group, names)
        enrolled = Enrolment(
            participant=code,
            study=plan.name,
            version=plan.version,
            number=len(people) + 1,
            group=names.groups.get(group, group),
            stratum=stratum,
            orders=numbers,
            replaces=replaces,
        )
        ledger.enrol(connection, enrolled, author=author, now=now)
    return enrolled


class _Checked(NamedTuple):
    """The people of this site in a study, and what is given for one more: values of the factors,
    and the list of groups.
    """

    people: list[Enrolment]
    factors: dict[str, str]
    rows: tuple[ListedGroup, ...]


def check(
    db: sqlite3.Connection,
    plan: Study,
    participant: str,
    *,
    factors: Mapping[str, str] = {},
    replaces: str = "",
    listed: Path | None = None,
) -> _Checked:
    """Check that a person can be enrolled, also before the plan is frozen.

    Args:
        db: the database.
        plan: the study.
        participant, factors, replaces, listed: as for `enrol`.

    Raises:
        StoreError, AllocationError: as `enrol`.
    """
    given = _checked_factors(plan.allocation, factors)
    rows = secret.read_list(listed, tuple(plan.groups)) if listed else ()
    people = [one for one in ledger.enrolments(db, plan.name) if ledger.is_own(one.participant)]
    if earlier := next((one for one in people if one.participant == participant), None):
        raise StoreError(
            f"{participant} is in the study {plan.name} already, as number {earlier.number}.",
            bad_input=True,
        )
    if replaces:
        _replaced(plan, people, replaces)
    elif plan.groups and plan.allocation.method == "list" and not rows:
        raise AllocationError(
            Sentence("The groups of this study are listed elsewhere: add --list FILE.")
        )
    return _Checked(people, given, rows)


def _checked_factors(given: Allocation, factors: Mapping[str, str]) -> dict[str, str]:
    for name, value in factors.items():
        if name not in given.strata:
            known = f"There are: {', '.join(given.strata)}." if given.strata else "There are none."
            raise StoreError(f"The plan has no factor {name}. {known}", bad_input=True)
        if value not in given.strata[name]:
            raise StoreError(
                f"{name} is {' or '.join(given.strata[name])}, not {value!r:.40}.", bad_input=True
            )
    for name, values in given.strata.items():
        if name not in factors:
            example = f"--factor {name}={values[0]}"
            raise StoreError(f"The factor {name} is missing: add {example}.", bad_input=True)
    return {name: factors[name] for name in given.strata}


def _replaced(plan: Study, people: list[Enrolment], replaces: str) -> Enrolment:
    """Return who is replaced. Raises StoreError."""
    for one in people:
        if one.participant == replaces:
            if not one.ended or one.by_consent:
                raise StoreError(
                    f"{replaces} still takes part: end it first, sar-tui study exit {replaces}",
                    bad_input=True,
                )
            if after := next((each for each in people if each.replaces == replaces), None):
                raise StoreError(
                    f"{replaces} was replaced by {after.participant} already.", bad_input=True
                )
            return one
    raise StoreError(f"{replaces} is not in the study {plan.name}.", bad_input=True)


def _drawn(
    plan: Study,
    draws: Draws,
    people: list[Enrolment],
    stratum: str,
    factors: Mapping[str, str],
    rows: tuple[ListedGroup, ...],
    names: Names,
) -> str:
    """Return the group of the next person, by its name."""
    if not plan.groups:
        return ""
    before = [
        Assigned(
            group=names.group(one.group),
            stratum=one.stratum,
            factors=dict(
                zip(plan.allocation.strata, one.stratum.split("|")[-len(factors) :], strict=False)
            ),
        )
        for one in people
        if not one.replaces
    ]
    weights = {name: group.weight for name, group in plan.groups.items()}
    return assign(plan.allocation, weights, draws, before, stratum, factors, rows)


def _orders(
    plan: Study, draws: Draws, people: list[Enrolment], stratum: str, group: str, names: Names
) -> tuple[int, ...]:
    """Return the rows of the orders of the next person, balanced within group and stratum."""
    alike = sum(
        names.group(one.group) == group and one.stratum == stratum and not one.replaces
        for one in people
    )
    return tuple(
        row_of_order(draws, len(orders(plan, each)), alike, "|".join(each), group, stratum)
        for each in plan.squares
    )
