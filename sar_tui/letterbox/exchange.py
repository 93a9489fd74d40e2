"""Takes the letters that lie in the letterbox, and writes those that are due.

Each step is one transaction, and can be done twice: a program that is killed anywhere goes on where
it was. A letter is stored here, with its number, before it is put into the letterbox, and is put
there again until the other side says that it has it.
"""

import contextlib
import hashlib
import platform
import sqlite3
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

import sar_tui
from sar_tui.letterbox import contents as rows_of
from sar_tui.letterbox import correspondents as stored
from sar_tui.letterbox.contents import Contents, Role, alone
from sar_tui.letterbox.correspondents import Correspondent, Sent, ranges, within
from sar_tui.letterbox.folder import Letterbox, LetterFile, new_name
from sar_tui.letterbox.identity import Identity, require
from sar_tui.letterbox.sealing import (
    Damaged,
    Forged,
    Letter,
    Opened,
    open_letter,
    seal,
    unpack,
)
from sar_tui.store.database import StoreError, connect, transaction
from sar_tui.store.locks import is_held
from sar_tui.store.merge.merge import merge
from sar_tui.store.sessions import is_demonstration
from sar_tui.store.tables import VERSION

_UNFINISHED_FOR = timedelta(hours=1)
"""A file that is half-written for this time is nobody's any more."""
_MOST_AHEAD = 10_000
"""Numbers by which a letter may be ahead of those that have arrived."""
PUT_AGAIN_AFTER = timedelta(days=2)
"""A letter of which the other side does not say that it has it is put into the letterbox again
after this time, under another name: a synchronisation program may have lost it.
"""


class Exchanged(msgspec.Struct, frozen=True, kw_only=True):
    """Result of an exchange.

    Attributes:
        taken: the number of letters that arrived, by the name of the correspondent.
        written: number of letters that were written. ``again``: that were put there again.
        doubled: number of letters that had been taken before.
        refused: sentences on files that were refused now.
        troubles: why something has to wait.
        changed: participants of whom something new is in the database.
    """

    taken: list[tuple[str, int]] = []
    written: int = 0
    again: int = 0
    doubled: int = 0
    refused: list[str] = []
    troubles: list[str] = []
    changed: list[str] = []


def exchange(data: Path, now: Callable[[], datetime] = lambda: datetime.now(UTC)) -> Exchanged:
    """Take the letters that have arrived, and write those that are due.

    Args:
        data: the data folder.
        now: the time, UTC.

    Raises:
        StoreError: there is no letterbox, it cannot be reached, or nothing can be stored here.
        Busy: another program does so now.
    """
    identity = require(data)
    with alone(data):
        box = Letterbox(Path(identity.folder))
        box.remove_unfinished(before=(now() - _UNFINISHED_FOR).timestamp())
        with closing(connect(data)) as db:
            return _Exchange(data, identity, box, db, now).run()


class _Arrived(NamedTuple):
    """A letter that was opened, of a correspondent who is known."""

    file: LetterFile
    opened: Opened
    sender: Correspondent


class _Exchange:
    """One exchange, with the database open and the letterbox at hand."""

    def __init__(
        self,
        data: Path,
        identity: Identity,
        box: Letterbox,
        db: sqlite3.Connection,
        now: Callable[[], datetime],
    ) -> None:
        self._data = data
        self._identity = identity
        self._box = box
        self._db = db
        self._now = now
        self._taken: dict[str, int] = {}
        self._changed: set[str] = set()
        self._refused: list[str] = []
        self._troubles: list[str] = []
        self._doubled = 0
        self._written = 0
        self._again = 0

    def run(self) -> Exchanged:
        """Take, then write."""
        for arrived in self._open_files():
            with self._told():
                self._take(arrived)
        for correspondent in stored.correspondents(self._db):
            with self._told():
                self._write_to(correspondent)
        for correspondent in stored.correspondents(self._db):
            self._put(correspondent)
        return Exchanged(
            taken=sorted(self._taken.items()),
            written=self._written,
            again=self._again,
            doubled=self._doubled,
            refused=self._refused,
            troubles=self._troubles,
            changed=sorted(self._changed),
        )

    @contextlib.contextmanager
    def _told(self) -> Iterator[None]:
        """Keep the reason why something must wait, and go on with the rest."""
        try:
            yield
        except StoreError as error:
            self._tell(str(error))
        except Exception as error:  # no letter of one may hold up those of others
            self._tell(f"A letter cannot be handled ({type(error).__name__}: {error}).")

    def _tell(self, trouble: str) -> None:
        if trouble not in self._troubles:
            self._troubles.append(trouble)

    def _at(self) -> str:
        return self._now().isoformat(timespec="seconds")

    # --- opening files

    def _open_files(self) -> list[_Arrived]:
        """Open the files that were not looked at yet, and return the letters from those who are
        known, in the order of their numbers.
        """
        there = list(self._box.files())
        looked_at = {
            name: (size, changed_ns)
            for name, size, changed_ns in self._db.execute(
                "SELECT name, size, changed_ns FROM letter_files"
            )
        }
        with transaction(self._db) as db:
            gone = [(name,) for name in looked_at.keys() - {file.name for file in there}]
            db.executemany("DELETE FROM letter_files WHERE name=?", gone)
        own = {
            digest
            for (digest,) in self._db.execute("SELECT digest FROM letters WHERE direction='out'")
        }
        found = []
        for file in there:
            if looked_at.get(file.name) == (file.size, file.changed_ns):
                continue
            with self._told():
                if (arrived := self._open(file, own)) is not None:
                    found.append(arrived)
        return sorted(found, key=lambda one: (one.sender.id, one.opened.letter.number))

    def _open(self, file: LetterFile, own: set[str]) -> _Arrived | None:
        try:
            if (sealed := self._box.read(file)) is None:
                return None
            if hashlib.sha256(sealed).hexdigest() in own:
                self._looked_at(file)
                return None
            opened = open_letter(sealed, self._identity.keys)
            sender = self._sender(opened)
        except Damaged:
            # at home, a letter of the clinic to another home; it may also be half-written
            is_told = not self._identity.is_home
            self._looked_at(
                file, "It cannot be opened: it is not complete, or was changed." if is_told else ""
            )
            return None
        except Forged as error:
            self._looked_at(file, f"It was refused: {error}.")
            return None
        return _Arrived(file, opened, sender)

    def _looked_at(self, file: LetterFile, refused: str = "") -> None:
        """Note that a file need not be opened again."""
        with transaction(self._db) as db:
            self._note(db, file, refused)

    def _note(self, db: sqlite3.Connection, file: LetterFile, refused: str = "") -> None:
        db.execute(
            "INSERT OR REPLACE INTO letter_files (name, size, changed_ns, refused, at) VALUES "
            "(?,?,?,?,?)",
            (*file, refused, self._at()),
        )
        if refused:
            self._refused.append(f"{file.name}: {refused}")

    def _sender(self, opened: Opened) -> Correspondent:
        """Return the correspondent who signed a letter. Raises Forged: nobody who is known did, or
        may.
        """
        known = [one for one in stored.correspondents(self._db) if one.verify_key == opened.writer]
        for one in sorted(known, key=lambda each: each.state != "joined"):
            if one.state == "revoked":
                raise Forged(f"the computer of {one.name} that wrote it was revoked")
            if one.state == "declined" and not self._identity.is_home:
                raise Forged(f"the invitation of {one.name} by which it came was not valid")
            return one
        if self._identity.is_home or not opened.letter.secret:
            raise Forged("nobody who is known here wrote it")
        return self._admit(opened)

    def _admit(self, opened: Opened) -> Correspondent:
        """Return the correspondent whose invitation a letter brings, who has joined then."""
        secret = hashlib.sha256(opened.letter.secret).hexdigest()
        seal_key = opened.letter.seal_key
        try:
            seal(Letter(reader=seal_key, number=1, written_at=""), self._identity.keys)
        except StoreError:
            raise Forged("its key to write back to is wrong") from None
        keys: dict[str, Any] = {"verify_key": opened.writer, "seal_key": seal_key}
        with transaction(self._db) as db:
            invited = [one for one in stored.correspondents(db) if one.invitation == secret]
            if not invited:
                raise Forged("nobody who is known here wrote it")
            one = next((each for each in invited if each.state != "declined"), invited[0])
            objection = _objection(one, self._now())
            if not objection:
                stored.change(db, one.id, state="joined", owes_answer=1, **keys)
                return msgspec.structs.replace(one, state="joined", **keys)
            if len(invited) == 1:  # the other computer is told, once
                told = msgspec.structs.replace(
                    one, id=stored.new_id(), state="declined", notice=objection, **keys
                )
                stored.add(db, told)
        raise Forged(f"the invitation of {one.name} {_OBJECTIONS[objection]}")

    # --- taking a letter

    def _take(self, arrived: _Arrived) -> None:
        """Bring what a letter says into the database."""
        file, (letter, _, digest), sender = arrived
        known = {one.number: one for one in stored.letters(self._db, sender.id, "in")}
        if (before := known.get(letter.number)) is not None:
            self._take_again(arrived, before)
            return
        if letter.number > max(known, default=0) + _MOST_AHEAD:
            self._looked_at(file, f"It was refused: its number {letter.number} is too high.")
            return
        is_newest = letter.number > max(known, default=0)
        contents: Contents = {}
        reason = ""
        if letter.rows:
            try:
                contents = self._merge(sender, letter)
            except Forged as error:
                reason = str(error)
            except StoreError as error:
                if not error.bad_input:
                    raise  # it is taken the next time
                reason = str(error)
        with transaction(self._db) as db:
            self._note(
                db, file, f"Letter {letter.number} of {sender.name} was refused: {reason}."
                if reason else "",
            )  # fmt: skip
            stored.add_letter(
                db,
                sender.id,
                "in",
                number=letter.number,
                state="refused" if reason else "taken",
                at=self._at(),
                file=file.name,
                digest=digest,
                contents=contents,
                reason=reason[:500],
            )
            changes: dict[str, Any] = {"heard_at": self._at()}
            if letter.rows or not known:
                changes["owes_answer"] = 1
            if is_newest:  # an older one knows less
                changes["void"] = letter.void
            if is_newest and letter.device:
                changes["device"] = _shown_device(letter)
            if letter.notice and self._identity.is_home:
                changes["state"] = "revoked" if letter.notice == "revoked" else "declined"
            stored.change(db, sender.id, **changes)
            self._read_answers(db, sender, letter, is_newest=is_newest)
        if not reason:
            self._taken[sender.name] = self._taken.get(sender.name, 0) + 1
            if contents:
                self._changed.add(sender.participant)

    def _take_again(self, arrived: _Arrived, before: Sent) -> None:
        """Take a letter whose number was taken before: the same one is passed over; another one is
        refused, and asked for under another number.
        """
        file, (letter, _, digest), sender = arrived
        if digest == before.digest:
            self._doubled += 1
            with transaction(self._db) as db:
                self._note(db, file)
                if letter.rows:  # the answer may have been lost
                    stored.change(db, sender.id, owes_answer=1)
            return
        with transaction(self._db) as db:
            self._note(
                db,
                file,
                f"Letter {letter.number} of {sender.name} was refused: another one of this number "
                "has come before. The computer has gone back to an earlier state, or two computers "
                "have copies of one data folder. It is asked to write again.",
            )
            (row,) = db.execute(
                "SELECT wanted FROM correspondents WHERE id=?", (sender.id,)
            ).fetchone()
            wanted = {*msgspec.json.decode(row), letter.number}
            stored.change(db, sender.id, wanted=sorted(wanted), owes_answer=1)

    def _merge(self, sender: Correspondent, letter: Letter) -> Contents:
        """Merge the rows of a letter, and return what they were.

        Raises:
            Forged: they are no database.
            StoreError: they cannot be merged, or not now.
        """
        contents: Contents = {}
        writer: Role = "clinic" if self._identity.is_home else "home"
        if letter.version > VERSION:
            raise StoreError(
                f"Letters of {sender.name} are of a newer sar-tui: update it here.", temporary=True
            )
        if is_demonstration(self._db):
            raise StoreError("This data folder holds a demonstration: no letters are taken.")

        def check(db: sqlite3.Connection) -> None:
            rows_of.check_rows(db, sender.participant, writer, letter.sessions)
            found = rows_of.of_person(db, sender.participant, "other")
            contents.update({table: rows for table, rows in found.items() if rows})

        with rows_of.work_folder(self._data) as place:
            path = place / "letter.db"
            unpack(letter.rows, path)
            try:
                merge(
                    self._data,
                    path,
                    one_site=True,
                    check_letter=check,
                    start=lambda step: lambda done, total: None,
                )
            except StoreError as error:
                if not error.bad_input:
                    raise
                why = str(error).replace(str(path), "Its database")
                raise StoreError(why.removesuffix("."), bad_input=True) from error
            except (OSError, sqlite3.OperationalError) as error:  # the disk's, not the letter's
                raise StoreError(f"A letter cannot be taken now: {error}.") from error
            except Exception as error:
                raise Forged(f"its rows cannot be read ({type(error).__name__})") from error
        return contents

    def _read_answers(
        self, db: sqlite3.Connection, sender: Correspondent, letter: Letter, *, is_newest: bool
    ) -> None:
        """Note what the other side says of the letters from here."""
        out = {one.number: one for one in stored.letters(db, sender.id, "out")}
        farther = max((last for _, last in letter.taken), default=0)
        void = {number for number in letter.wanted if number in out}
        if max(out, default=0) < farther <= max(out, default=0) + _MOST_AHEAD:
            # The other side has more than was written here: this is an earlier state, from a
            # backup. What was written since then has numbers that were used before.
            void |= {number for number, one in out.items() if one.state == "sent"}
            stored.change(db, sender.id, least_number=farther + 1)
        missed = {
            number
            for number in out
            if number < farther
            and not within(number, letter.taken)
            and not within(number, letter.refused)
        }
        if is_newest:
            # The other side has lost what it had: it is an earlier state of it. An older letter may
            # say so of what it had not taken yet.
            void |= {number for number in missed if out[number].state == "acknowledged"}
        for number in void:
            if out[number].state != "void":
                stored.set_state(db, sender.id, [number], "void", before=out[number].state)
        db.executemany(
            "UPDATE letters SET put_at='' WHERE correspondent=? AND direction='out' AND number=? "
            "AND state='sent'",
            [(sender.id, number) for number in missed],
        )
        for state, given in (("acknowledged", letter.taken), ("refused", letter.refused)):
            told = [number for number in out if within(number, given) and number not in void]
            stored.set_state(db, sender.id, told, state, before="sent")
        db.executemany(
            "UPDATE letters SET seen_at=? WHERE correspondent=? AND direction='out' AND number=? "
            "AND seen_at=''",
            [(self._at(), sender.id, number) for number in out if within(number, letter.seen)],
        )

    # --- writing letters

    def _write_to(self, reader: Correspondent) -> None:
        """Store the letters that are due to a correspondent."""
        if reader.notice or (reader.state == "revoked" and not self._identity.is_home):
            self._write_notice(reader)
            return
        if reader.state != "joined":
            return
        self._forget_erased(reader)
        written = [one for one in stored.letters(self._db, reader.id, "out") if one.state != "void"]
        taken = stored.letters(self._db, reader.id, "in")
        is_first = not any(one.contents for one in written)
        known = rows_of.known_to(stored.contents_in_order(self._db, reader.id))
        running = [
            id
            for (id,) in self._db.execute("SELECT id FROM sessions WHERE status='running'")
            if is_held(self._data, "session", id)
        ]
        is_joining = self._identity.is_home and not written
        due: list[Contents] = list(
            rows_of.news(
                self._db,
                reader.participant,
                known,
                writer=self._identity.role,
                running=running,
                is_first=is_first,
            )
        )
        if not due and (reader.owes_answer or is_joining):
            due = [{}]
        for contents in due:
            with self._told():  # one that is too large does not hold up the others
                self._store_letter(reader, contents, taken)

    def _forget_erased(self, reader: Correspondent) -> None:
        """Take back what is on its way of a person who was erased meanwhile."""
        erased = "SELECT 1 FROM people_events WHERE participant=? AND event='erased'"
        if not self._db.execute(erased, (reader.participant,)).fetchone():
            return
        numbers = [
            one.number
            for one in stored.letters(self._db, reader.id, "out")
            if one.contents.keys() - {"people_events"}
        ]
        with transaction(self._db) as db:
            stored.set_state(db, reader.id, numbers, "void", before="sent")

    def _store_letter(
        self,
        reader: Correspondent,
        contents: Contents,
        taken: list[Sent],
        *,
        notice: str = "",
    ) -> None:
        rows = b"" if notice else rows_of.pack(self._data, reader.participant, contents)
        keys = self._identity.keys
        with transaction(self._db) as db:
            number = _next_number(db, reader)
            letter = Letter(
                reader=reader.keys.seal,
                number=number,
                written_at=self._at(),
                version=VERSION,
                taken=ranges(one.number for one in taken if one.state == "taken"),
                refused=ranges(one.number for one in taken if one.state == "refused"),
                void=ranges(
                    one.number
                    for one in stored.letters(db, reader.id, "out")
                    if one.state == "void"
                ),
                seen=ranges(one.number for one in taken if one.seen_at),
                wanted=reader.wanted,
                secret=self._identity.secret,
                sessions=rows_of.elsewhere(contents),
                notice=notice,
                seal_key=keys.public.seal if self._identity.is_home else b"",
                device=_device() if self._identity.is_home else {},
                rows=rows,
            )
            sealed = seal(letter, keys)
            stored.add_letter(
                db,
                reader.id,
                "out",
                number=number,
                state="sent",
                at=self._at(),
                file=new_name(),
                digest=hashlib.sha256(sealed).hexdigest(),
                sealed=sealed,
                contents=contents,
            )
            stored.change(db, reader.id, owes_answer=0, wanted=[], notice="")
        self._written += 1

    def _write_notice(self, reader: Correspondent) -> None:
        """Take the letters to a computer that was revoked or declined out of the letterbox, and
        tell it once.
        """
        letters = stored.letters(self._db, reader.id, "out")
        told = reader.notice or "revoked"
        is_told = any(told in one.contents for one in letters)
        if is_told or reader.verify_key is None:
            return
        for one in letters:
            self._box.remove(one.file)
        with transaction(self._db) as db:
            stored.set_state(db, reader.id, [one.number for one in letters], "void", before="sent")
        taken = stored.letters(self._db, reader.id, "in")
        self._store_letter(reader, {told: {}}, taken, notice=told)

    # --- the letterbox

    def _put(self, reader: Correspondent) -> None:
        """Put the letters into the letterbox that are not there, and take out those that have
        arrived.
        """
        for one in stored.letters(self._db, reader.id, "out"):
            if one.state != "sent":
                self._remove(reader, one)
            elif not self._box.has(one.file, one.size or 0) or self._is_due_again(reader, one):
                with self._told():
                    self._put_letter(reader, one)

    def _is_due_again(self, reader: Correspondent, letter: Sent) -> bool:
        """Return True if a letter was not put yet, was missed by its reader, or was put long ago.

        One that only answers is not put again: the next one answers all, too.
        """
        if not letter.put_at:
            return True
        if reader.heard_at and not letter.contents:
            return False
        age = self._now() - datetime.fromisoformat(letter.put_at)
        return not -PUT_AGAIN_AFTER < age < PUT_AGAIN_AFTER

    def _remove(self, reader: Correspondent, one: Sent) -> None:
        """Take a letter out of the letterbox whose file is of no use any more."""
        if one.file:
            self._box.remove(one.file)
            self._name(reader, one, "")

    def _put_letter(self, reader: Correspondent, one: Sent) -> None:
        """Put a letter into the letterbox; one that did not arrive, under another name."""
        file = one.file
        if one.put_at or self._box.has(one.file, one.size or 0):
            file = new_name()
            self._box.remove(one.file)
            self._name(reader, one, file, put_at=one.put_at)
            self._again += 1
        (sealed,) = self._db.execute(
            "SELECT sealed FROM letters WHERE correspondent=? AND direction='out' AND number=?",
            (reader.id, one.number),
        ).fetchone()
        self._box.put(file, sealed)
        self._name(reader, one, file, put_at=self._at())

    def _name(self, reader: Correspondent, one: Sent, file: str, put_at: str = "") -> None:
        """Store the name of a letter's file."""
        with transaction(self._db) as db:
            db.execute(
                "UPDATE letters SET file=?, put_at=? WHERE correspondent=? AND direction='out' AND "
                "number=?",
                (file, put_at, reader.id, one.number),
            )


_OBJECTIONS = {
    "used": "was used by another computer before",
    "expired": "is too old",
    "revoked": "was revoked",
}


def _objection(invited: Correspondent, now: datetime) -> str:
    """Return why an invitation cannot be used; empty if it can."""
    if invited.state != "invited":
        return "revoked" if invited.state == "revoked" else "used"
    is_late = now > datetime.fromisoformat(invited.expires_at)
    return "expired" if is_late else ""


def _next_number(db: sqlite3.Connection, reader: Correspondent) -> int:
    (highest, least) = db.execute(
        "SELECT (SELECT max(number) FROM letters WHERE correspondent=correspondents.id AND "
        "direction='out'), least_number FROM correspondents WHERE id=?",
        (reader.id,),
    ).fetchone()
    return int(max((highest or 0) + 1, least))


def _device() -> dict[str, str]:
    """Return what helps to understand the data of this computer."""
    return {
        "sar_tui": sar_tui.__version__,
        "system": platform.system(),
        "processor": platform.machine(),
        "python": ".".join(map(str, sys.version_info[:3])),
    }


def _shown_device(letter: Letter) -> dict[str, str]:
    """Return the description of a home's computer as it is stored, with its clock."""
    known = {name: str(value)[:60] for name, value in letter.device.items() if name in _device()}
    return {**known, "written_at": letter.written_at[:40]}
