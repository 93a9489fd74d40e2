"""The ledger of studies in the database: frozen plans, who is enrolled, and what differed.

Nothing in it is ever changed. Plans are in the table ``studies``; enrolments, deviations, consent
and ends of participation are records of people (`store.records`), and so are exported, merged and
kept as these are.
"""

import hashlib
import sqlite3
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any, Literal, NamedTuple

import msgspec

from sar_tui.loop.topics import LEVEL
from sar_tui.model.language import Sentence
from sar_tui.model.messages import LevelChanged
from sar_tui.records.kind import Value
from sar_tui.rules.difficulty import stay
from sar_tui.rules.policies import DIFFICULTY
from sar_tui.store import people_events, records
from sar_tui.store.counted import COUNTS
from sar_tui.store.database import StoreError, store, transaction
from sar_tui.store.participants import check_own
from sar_tui.store.personal_rows import ENROLMENT
from sar_tui.store.records import Record
from sar_tui.store.sessions import status_now
from sar_tui.store.studies import names
from sar_tui.store.tables import STUDIES
from sar_tui.store.training_days import UTC_OFFSET, trained_at, utc
from sar_tui.study.plan import Study, parse_plan

Mode = Literal["live", "simulated"]
DEVIATION, CONSENT = "deviation", "consent"
EXIT, CODE_BREAK, FORM = "study-exit", "code-break", "form-filled"


ENDS = {
    "withdrawn": Sentence("withdrawn"),
    "excluded": Sentence("excluded"),
    "lost": Sentence("lost"),
    "not eligible": Sentence("not eligible"),
    "no consent": Sentence("no consent"),
}
"""Ends of a participation, for people."""
_WITHOUT_CONSENT = {
    "no": ("no consent", "did not agree"),
    "withdrawn": ("withdrawn", "withdrew the consent"),
}
"""End of a participation by an answer to the consent, and its reason."""
_LEVELS = tuple(
    f"(SELECT {what} FROM attempts WHERE attempts.session=sessions.id AND seat='A')"
    for what in ("total(NOT practice)", "min(level)", "max(level)")
)
_SETTINGS = tuple(
    f"json_extract(parameters, '$.{name}')"
    for name in ("attempts", "difficulty_policy", "operator_difficulty", "start_level")
)


class Frozen(msgspec.Struct, frozen=True, kw_only=True):
    """A version of a plan as it was frozen.

    Attributes:
        plan: the study; ``text``: as TOML. ``sha256``: of the text.
        commitment: of the key from which assignments follow; empty if nobody is allocated.
        mode: with people, or a rehearsal.
        site: that froze it; empty for this one.
    """

    plan: Study
    text: str
    sha256: str
    commitment: str
    mode: Mode
    frozen_at: str
    frozen_by: str
    reason: str
    site: str


class Enrolment(msgspec.Struct, frozen=True, kw_only=True):
    """A person in a study.

    Attributes:
        number: of the person at the site, from 1.
        group: that they came to, in a blind study a neutral code; empty without groups.
        orders: numbers of the rows of orders, in the order of the plan's ``squares``.
        at: when, UTC.
        consent: the last answer to it; empty without one.
        ended: how the participation ended; empty if it goes on.
        ended_at: when, UTC.
        by_consent: True if it ended by the answer to the consent, which may change.
    """

    participant: str
    study: str
    version: int
    number: int
    group: str = ""
    stratum: str = ""
    orders: tuple[int, ...] = ()
    replaces: str = ""
    at: str = ""
    consent: str = ""
    ended: str = ""
    why_ended: str = ""
    ended_at: str = ""
    by_consent: bool = False


class Played(msgspec.Struct, frozen=True, kw_only=True):
    """A session of a study, or a form that was filled in.

    Attributes:
        id: of the session, or of the record of the answers.
        status: of the session, ``running`` while a program plays it; ``completed`` for a form.
        day: local date on which it began.
        began, ended: when, UTC.
        attempts: number of those that count; None of a form. ``planned``: of the session.
        level_by_hand: True if somebody set a level that the settings fix.
    """

    id: str
    participant: str
    visit: str
    block: str
    condition: str = ""
    position: int = 1
    version: int = 1
    status: str = "completed"
    day: str = ""
    began: str = ""
    ended: str = ""
    attempts: int | None = None
    planned: int = 0
    level_by_hand: bool = False

    @property
    def key(self) -> tuple[str, str, int]:
        """The key of the item of a schedule that it belongs to."""
        return self.visit, self.block, self.position

    @property
    def is_running(self) -> bool:
        """True if the person is in this session at the moment."""
        return self.status == "running"


class Differed(msgspec.Struct, frozen=True, kw_only=True):
    """A deviation from the plan: recorded, or a session that was ended early, or whose level was
    changed by hand.
    """

    participant: str
    visit: str
    block: str
    what: str
    reason: str
    at: str


class Participation(NamedTuple):
    """A person in a study, with what was done and what differed from the plan, each by time."""

    enrolled: Enrolment
    played: list[Played]
    deviations: list[Differed]


# --- plans


def sha256_of(text: str) -> str:
    """Return the hash of a plan."""
    return hashlib.sha256(text.encode()).hexdigest()


def freeze(
    db: sqlite3.Connection,
    text: str,
    plan: Study,
    conditions: Mapping[str, Any],
    *,
    commitment: str,
    mode: Mode,
    author: str,
    reason: str = "",
    now: datetime | None = None,
) -> None:
    """Store a version of a plan that is not there yet.

    Raises:
        StoreError: another plan of this name and version is there, the version does not follow the
            last one, or the disk cannot write.
    """
    with transaction(db) as connection:
        last = newest(connection, plan.name)
        if last and last.plan.version == plan.version and last.sha256 == sha256_of(text):
            return
        if problem := frozen_otherwise(connection, plan, text):
            raise StoreError(problem, bad_input=True)
        if last and not reason:
            raise StoreError(
                f"The study {plan.name} is frozen in version {last.plan.version}. A later version "
                "needs a reason: sar-tui study amend FILE --reason …",
                bad_input=True,
            )
        store(
            connection,
            STUDIES,
            name=plan.name,
            version=plan.version,
            frozen_at=utc(now),
            frozen_by=author,
            reason=reason,
            mode=mode,
            blind=plan.allocation.blind,
            sha256=sha256_of(text),
            commitment=commitment,
            plan=text,
            conditions=conditions,
        )


_SELECT = (
    "SELECT plan, sha256, commitment, mode, frozen_at, frozen_by, reason, site, name FROM studies"
    " WHERE name=?"
)


def versions(db: sqlite3.Connection, name: str) -> list[Frozen]:
    """Return the frozen versions of a study, the oldest first; of a version that several sites
    froze, this site's.
    """
    rows = db.execute(f"{_SELECT} ORDER BY version, site DESC", (name,))
    found = {frozen.plan.version: frozen for frozen in map(_frozen, rows)}
    return list(found.values())


def newest(db: sqlite3.Connection, name: str) -> Frozen | None:
    """Return the newest frozen version of a study; None if there is none."""
    row = db.execute(f"{_SELECT} ORDER BY version DESC, site LIMIT 1", (name,)).fetchone()
    return _frozen(row) if row else None


def is_frozen(db: sqlite3.Connection, name: str, text: str) -> bool:
    """Return True if the newest frozen version of a study is this text."""
    last = newest(db, name)
    return last is not None and last.sha256 == sha256_of(text)


def frozen_otherwise(db: sqlite3.Connection, plan: Study, text: str) -> str:
    """Return what to do about a plan whose version, or a later one, is frozen as another text; empty
    if none is.
    """
    last = newest(db, plan.name)
    if last is None or plan.version > last.plan.version or last.sha256 == sha256_of(text):
        return ""
    return (
        f"Version {last.plan.version} of the study {plan.name} was frozen as another text. Write "
        f"version = {last.plan.version + 1} for a changed plan, and give the reason: sar-tui study "
        "amend FILE --reason …"
    )


def _frozen(row: Sequence[Any]) -> Frozen:
    text, sha256, commitment, mode, at, by, reason, site, name = row
    return Frozen(
        plan=parse_plan(text, f"study {name}"),
        text=text,
        sha256=sha256,
        commitment=commitment,
        mode=mode,
        frozen_at=at,
        frozen_by=by,
        reason=reason,
        site=site,
    )


def find(db: sqlite3.Connection, name: str = "") -> Frozen:
    """Return the newest version of a study; without a name, of the only one.

    Raises:
        StoreError: there is no such study, none at all, or more than one.
    """
    known = names(db)
    wanted = name or (known[0] if len(known) == 1 else "")
    if found := newest(db, wanted):
        return found
    if not known:
        raise StoreError(
            "No study is frozen here. Enrol the first person with its plan: sar-tui study enrol "
            "P01 --plan study.toml",
            bad_input=True,
        )
    listed = ", ".join(known)
    said = f"There is no study {name}. There are: {listed}." if name else (
        f"There are several studies: {listed}. Name one: --study {known[0]}"
    )  # fmt: skip
    raise StoreError(said, bad_input=True)


# --- people


def enrol(
    connection: sqlite3.Connection, enrolled: Enrolment, *, author: str, now: datetime | None
) -> None:
    """Store an enrolment, in a transaction of the caller.

    Its id follows from the study and the number of the person, so that no number is used twice.
    """
    content: dict[str, Value] = {
        "study": enrolled.study,
        "version": enrolled.version,
        "number": enrolled.number,
    }
    orders = ", ".join(map(str, enrolled.orders))
    texts = {
        "group": enrolled.group,
        "stratum": enrolled.stratum,
        "order": orders,
        "replaces": enrolled.replaces,
    }
    content |= {name: text for name, text in texts.items() if text}
    records.store(
        connection,
        Record(
            id=f"{enrolled.study}-{enrolled.number}",
            kind=ENROLMENT,
            participant=enrolled.participant,
            at=utc(now),
            content=content,
            recorded_at=utc(now),
            recorded_by=author,
        ),
    )


def people(db: sqlite3.Connection, frozen: Frozen, participant: str = "") -> list[Participation]:
    """Return the people of a study, in the order of their enrolment; or one person only."""
    study = frozen.plan.name
    done: dict[str, list[Played]] = {}
    differed: dict[str, list[Differed]] = {}
    for one in played(db, study, frozen.mode, participant):
        done.setdefault(one.participant, []).append(one)
    for each in of_study(db, DEVIATION, study, participant):
        differed.setdefault(each.participant, []).append(_recorded(each))
    is_left = frozen.plan.interrupted.then == "leave"
    found = []
    for enrolled in enrolments(db, study, participant):
        who = enrolled.participant
        own = done.get(who, [])
        deviations = differed.get(who, []) + [
            _ended_early(one)
            for one in own
            if one.status == "aborted" or (one.status == "interrupted" and is_left)
        ]
        deviations += [_in_session(one, _BY_HAND) for one in own if one.level_by_hand]
        found.append(Participation(enrolled, own, sorted(deviations, key=lambda each: each.at)))
    return found


def _recorded(deviation: Record) -> Differed:
    content = deviation.content
    return Differed(
        participant=deviation.participant,
        visit=str(content.get("visit", "")),
        block=str(content.get("block", "")),
        what=str(content["what"]),
        reason=str(content.get("reason", "")),
        at=deviation.at,
    )


def _ended_early(one: Played) -> Differed:
    """Return the deviation of a session that was ended, or cut off for good, before all attempts
    were done.
    """
    return _in_session(one, "ended early", "" if one.status == "aborted" else "cut off")


_BY_HAND = "level changed by hand"


def _in_session(one: Played, what: str, reason: str = "") -> Differed:
    """Return the deviation of a session that follows from its log."""
    return Differed(
        participant=one.participant,
        visit=one.visit,
        block=one.block,
        what=what,
        reason=reason,
        at=one.ended,
    )


def enrolments(db: sqlite3.Connection, study: str, participant: str = "") -> list[Enrolment]:
    """Return who is in a study, in the order of their enrolment; or one person only."""
    ends = {record.participant: record for record in of_study(db, EXIT, study, participant)}
    agreed = sorted(
        of_study(db, CONSENT, study, participant), key=lambda each: (each.day, each.recorded_at)
    )
    consents = {record.participant: record for record in agreed}
    left = _left(db)
    found = []
    for record in of_study(db, ENROLMENT, study, participant):
        content = record.content
        consent = consents.get(record.participant)
        ended = _ended(ends.get(record.participant), left.get(record.participant), consent)
        orders = str(content.get("order", ""))
        found.append(
            Enrolment(
                participant=record.participant,
                study=study,
                version=int(content["version"]),
                number=int(content["number"]),
                group=str(content.get("group", "")),
                stratum=str(content.get("stratum", "")),
                orders=tuple(map(int, filter(None, orders.split(",")))),
                replaces=str(content.get("replaces", "")),
                at=record.at,
                consent=str(consent.content["answer"]) if consent else "",
                ended=ended.what,
                why_ended=ended.why,
                ended_at=ended.at,
                by_consent=ended.by_consent,
            )
        )
    return sorted(found, key=lambda one: (one.participant.partition("@")[2], one.number))


class _End(NamedTuple):
    """End of a participation: how, why, when, and if it was by the answer to the consent; empty if
    it goes on.
    """

    what: str = ""
    why: str = ""
    at: str = ""
    by_consent: bool = False


def _ended(end: Record | None, left: _End | None, consent: Record | None) -> _End:
    """Return how a participation ended: by a record of it, by a withdrawal from everything, or as
    the person does not agree, or agrees no longer, to the study.
    """
    if end:
        return _End(str(end.content["what"]), str(end.content["reason"]), end.at)
    if left:
        return left
    if consent and (known := _WITHOUT_CONSENT.get(str(consent.content["answer"]))):
        return _End(*known, consent.recorded_at, by_consent=True)
    return _End()


def _left(db: sqlite3.Connection) -> dict[str, _End]:
    """Return who withdrew altogether, and the codes of those who were erased, with the reason."""
    events = people_events.events(db)
    return {
        event.replaced_by: _End("erased", "asked for it", event.at)
        for event in events
        if event.event == "erased"
    } | {
        code: _End("withdrawn", event.reason or "withdrew altogether", event.at)
        for code, event in people_events.withdrawals(events).items()
    }


def is_own(participant: str) -> bool:
    """Return True if a participant is one of this site."""
    return "@" not in participant


def enrolment(db: sqlite3.Connection, study: str, participant: str) -> Enrolment:
    """Return the enrolment of a person. Raises StoreError if they are not in the study."""
    for one in enrolments(db, study, participant):
        return one
    raise StoreError(
        Sentence(
            "{who} is not enrolled in the study {study}: sar-tui study enrol {who}",
            who=participant,
            study=study,
        ),
        bad_input=True,
    )


def note(
    db: sqlite3.Connection,
    name: str,
    plan: Study,
    participant: str,
    content: Mapping[str, Value],
    *,
    author: str,
    now: datetime | None = None,
) -> None:
    """Store a record of a study on a person: a deviation, an end, a form, a look at the group.

    Args:
        db: the database.
        name: of the kind.
        plan: of the study; the record gets its name, and its version if the kind has one.
        participant: the person.
        content: values of the other fields; empty ones are left out.
        author: who records it.
        now: when; None for the present.

    Raises:
        StoreError: the participant is of another site, or the disk cannot write.
    """
    check_own(participant)
    kind = records.kind_of(name)
    given: dict[str, Value | None] = {"study": plan.name}
    if any(field.name == "version" for field in kind.fields):
        given["version"] = plan.version
    given |= {field: value for field, value in content.items() if value != ""}
    records.add(db, kind, participant, "", given, author=author, now=now)


def of_study(db: sqlite3.Connection, kind: str, study: str, participant: str = "") -> list[Record]:
    """Return the records of a kind that belong to a study, by time; of one person, or of all."""
    found = records.listing(db, kinds=(kind,), participant=participant or None)
    return [each for each in found if each.content["study"] == study]


def consent_of(db: sqlite3.Connection, study: str, participant: str) -> Record | None:
    """Return the last consent of a person to a study; None without one."""
    found = of_study(db, CONSENT, study, participant)
    return max(found, key=lambda each: (each.day, each.recorded_at), default=None)


def played(db: sqlite3.Connection, study: str, mode: Mode, participant: str = "") -> list[Played]:
    """Return the sessions of a study that count, and the forms that were filled in, by time; of one
    person, or of all.
    """
    counted = COUNTS if mode == "live" else "sessions.mode='simulated'"
    rows = db.execute(
        "SELECT sessions.id, participant, status, started_at, ended_at, study,"
        f" {UTC_OFFSET}, {', '.join((*_SETTINGS, *_LEVELS))} FROM sessions"
        " JOIN seats ON seats.session=sessions.id AND seat='A'"
        f" WHERE study IS NOT NULL AND json_extract(study, '$.study')=? AND {counted}"
        f"{' AND participant=?' if participant else ''} ORDER BY sessions.rowid",
        (study, participant) if participant else (study,),
    )
    folder = _folder(db)
    found = []
    for id, who, status, began, ended, place, offset_s, *of_attempts in rows:
        planned, policy, decided_by, level, done, lowest, highest = of_attempts
        is_fixed = _is_fixed(policy) and decided_by != "manual" and lowest is not None
        values = msgspec.json.decode(place)
        del values["study"]
        day = trained_at(began, offset_s).strftime("%Y-%m-%d")
        found.append(
            Played(
                id=id,
                participant=who,
                status=status_now(status, id, folder),
                day=day,
                began=began,
                ended=ended or began,
                attempts=int(done),
                planned=planned or 0,
                level_by_hand=(
                    is_fixed and (lowest, highest) != (level, level) and _is_set_by_hand(db, id)
                ),
                **values,
            )
        )
    for record in of_study(db, FORM, study, participant):
        content = record.content
        _, sign, site = record.id.partition("@")  # as of all records of another site
        found.append(
            Played(
                id=f"{content['record']}{sign}{site}",
                participant=record.participant,
                visit=str(content["visit"]),
                block=str(content["block"]),
                version=int(content["version"]),
                day=trained_at(record.at, None).strftime("%Y-%m-%d"),
                began=record.at,
                ended=record.at,
            )
        )
    return sorted(found, key=lambda one: one.ended)


def _is_fixed(policy: str | None) -> bool:
    """Return True if a difficulty policy never changes a level."""
    known = DIFFICULTY.get(policy or "")
    return known is not None and known.step is stay


def _is_set_by_hand(db: sqlite3.Connection, session: str) -> bool:
    """Return True if somebody has set the level in a session. Attempts at another level than that
    of the start are the reason to look: all messages of the session are read.
    """
    rows = db.execute(
        "SELECT message FROM events WHERE session=? AND topic=?", (session, LEVEL.name)
    )
    return any(
        msgspec.json.decode(text, type=LevelChanged).reason == "operator" for (text,) in rows
    )


def _folder(db: sqlite3.Connection) -> Path:
    """Return the data folder of a database, in which locks of its sessions are."""
    (_, _, file) = db.execute("PRAGMA database_list").fetchone()
    return Path(file).parent
