"""Sets up the exchange of letters: a letterbox at the clinic, invitations, and a home that joins."""

import hashlib
import secrets
import sqlite3
import unicodedata
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import NamedTuple

import msgspec

from sar_tui.drivers.files import replace_private, write_private
from sar_tui.letterbox import contents as rows_of
from sar_tui.letterbox import correspondents as stored
from sar_tui.letterbox import folder, identity, sealing
from sar_tui.letterbox.correspondents import Correspondent
from sar_tui.letterbox.folder import Letterbox
from sar_tui.letterbox.identity import Identity
from sar_tui.letterbox.sealing import Invitation, Keys
from sar_tui.model.language import Sentence
from sar_tui.store import passphrase, programmes, sites
from sar_tui.store.database import StoreError, connect, transaction
from sar_tui.store.interface_language import interface_language
from sar_tui.store.merge.merge import merge
from sar_tui.store.participants import check_known, check_own
from sar_tui.store.passphrase import Passphrase
from sar_tui.store.people_events import check_may_record
from sar_tui.store.texts import check_text

DEFAULT_FOLDER = "sar-tui-letterbox"
"""Name of the letterbox in the user's home folder, unless another is named."""
DAYS = 30
"""Days for which an invitation can be used."""
LONGEST_NAME = 40
_LATE = timedelta(days=1)
"""A clock at home may be behind the clinic's by this much before it counts as wrong."""


# --- at the clinic


def new(data: Path, clinic: str, path: Path | None) -> Identity:
    """Make a letterbox, or move to another folder; return who the data folder is then.

    Args:
        data: the data folder.
        clinic: the clinic's name, which people at home read.
        path: the folder; None for one in the user's home folder.

    Raises:
        StoreError: the name or the folder cannot be used, or somebody trains at home here.
    """
    clinic = check_text("The clinic's name", clinic, LONGEST_NAME)
    if not clinic.strip():
        raise StoreError("The clinic needs a name, which people at home read.", bad_input=True)
    before = identity.read(data)
    if before is not None and before.is_home:
        raise StoreError(
            f"{before.participant} trains at home with this data folder. A clinic needs another "
            "one: --data DIR.",
            bad_input=True,
        )
    path = (path or Path.home() / DEFAULT_FOLDER).expanduser().absolute()
    folder.make(path, data)
    Letterbox(path)
    with closing(connect(data)) as db:
        if not sites.own(db):
            sites.set_own(db, _site_code(clinic))
    keys = before.keys if before is not None else Keys.new()
    found = Identity(role="clinic", clinic=clinic, folder=str(path), keys=keys)
    identity.write(data, found)
    return found


def _site_code(clinic: str) -> str:
    """Return a site's code made from a clinic's name: KLINIK-BERN-SUD for Klinik Bern Süd."""
    split = unicodedata.normalize("NFKD", clinic).upper()
    plain = "".join(letter if letter.isascii() and letter.isalnum() else " " for letter in split
                    if not unicodedata.combining(letter))  # fmt: skip
    code = "-".join(plain.split())[:16].strip("-")
    if not code:
        raise StoreError(
            "The clinic's name has no letters that a code can be made of. Set one first, such as: "
            "sar-tui site BERN",
            bad_input=True,
        )
    return sites.check_site(code)


class Invited(NamedTuple):
    """An invitation: its file, the code that opens it, and the home that it is for."""

    file: Path
    code: str
    home: Correspondent


def invite(
    data: Path, participant: str, to: Path | None = None, now: datetime | None = None
) -> Invited:
    """Write an invitation for a computer of a participant.

    Args:
        data: the data folder of the clinic.
        participant: the code.
        to: a file or a folder to write it to; None for the letterbox.
        now: when it is written; None for the present.

    Raises:
        StoreError: the participant cannot train at home, or the file cannot be written.
    """
    me = _clinic(data)
    now = now or datetime.now(UTC)
    with rows_of.alone(data), closing(connect(data)) as db:
        code = check_known(db, check_own(participant))
        check_may_record(db, [code])
        if not programmes.tasks(db, code):
            raise StoreError(
                f"{code} has no programme to train by. Save one in the app first: choose {code}, "
                "and F2.",
                bad_input=True,
            )
        if not Passphrase(data).is_set:
            raise StoreError(
                "At home your passphrase ends patient mode. Set one first: sar-tui passphrase.",
                bad_input=True,
            )
        words = sealing.new_code(interface_language(data))
        secret = secrets.token_bytes(32)
        numbers = [one.number for one in stored.correspondents(db) if one.participant == code]
        home = Correspondent(
            id=stored.new_id(),
            participant=code,
            number=max(numbers, default=0) + 1,
            invitation=hashlib.sha256(secret).hexdigest(),
            invited_at=now.isoformat(timespec="seconds"),
            expires_at=(now + timedelta(days=DAYS)).isoformat(timespec="seconds"),
        )
        own = {
            name: rows for name, rows in rows_of.of_person(db, code).items() if name == "programmes"
        }
        sealed = sealing.seal_invitation(
            Invitation(
                clinic=me.clinic,
                site=sites.own(db),
                participant=code,
                keys=me.keys.public,
                secret=secret,
                created_at=home.invited_at,
                expires_at=home.expires_at,
                passphrase=(data / passphrase.FILE).read_bytes(),
                rows=rows_of.pack(data, code, own),
            ),
            words,
        )
        file = _place(to, Path(me.folder))
        if to is None:
            Letterbox(file.parent).put(file.name, sealed)
        else:
            _write_new(file, sealed)
        with transaction(db):
            stored.add(db, home)
    return Invited(file, words, home)


def _place(to: Path | None, box: Path) -> Path:
    name = folder.new_name(folder.INVITATION)
    if to is None:
        return box / name
    return to / name if to.is_dir() else to


def _write_new(file: Path, content: bytes) -> None:
    try:
        write_private(file, content)
    except FileExistsError:
        raise StoreError(f"{file} exists already. Choose another name.", bad_input=True) from None
    except OSError as error:
        raise StoreError(f"{file} cannot be written ({error.strerror}).", bad_input=True) from error


def revoke(data: Path, name: str) -> list[Correspondent]:
    """Take no more letters from a home, and write none to it; return the computers that this is
    about.

    Args:
        data: the data folder of the clinic.
        name: a participant with one computer, or one of several, such as P07/2.

    Raises:
        StoreError: there is no such home, or the participant has several.
    """
    _clinic(data)
    with closing(connect(data)) as db:
        code, _, number = name.partition("/")
        homes = [
            one
            for one in stored.correspondents(db)
            if one.participant.casefold() == code.strip().casefold()
            and one.state in ("invited", "joined")
            and number in ("", str(one.number))
        ]
        if not homes:
            raise StoreError(
                f"No home of {name} is invited or has joined. sar-tui letterbox lists them.",
                bad_input=True,
            )
        if len(homes) > 1:
            names = " or ".join(f"{one.participant}/{one.number}" for one in homes)
            raise StoreError(f"{code} has several computers. Name one: {names}.", bad_input=True)
        with transaction(db):
            for one in homes:
                stored.change(db, one.id, state="revoked")
    return homes


def find_home(data: Path, db: sqlite3.Connection, participant: str) -> str:
    """Return the code, as it is stored, of a participant who trains at home. Raises StoreError: this
    is no clinic, or they do not.
    """
    _clinic(data)
    code = check_known(db, check_own(participant))
    if not any(
        one.participant == code and one.state in ("invited", "joined")
        for one in stored.correspondents(db)
    ):
        raise StoreError(
            f"{code} does not train at home. Invite them first: sar-tui letterbox invite {code}",
            bad_input=True,
        )
    return code


def _clinic(data: Path) -> Identity:
    me = identity.require(data)
    if me.is_home:
        raise StoreError(
            f"{me.participant} trains at home here: this is done at the clinic.", bad_input=True
        )
    return me


# --- at home


class Joined(NamedTuple):
    """The clinic's name, who trains, and the letterbox."""

    clinic: str
    participant: str
    folder: Path


def read_invitation(file: Path) -> bytes:
    """Return the bytes of an invitation's file. Raises StoreError: it is none."""
    try:
        with open(file, "rb") as opened:
            content = opened.read(sealing.LARGEST_INVITATION + 1)
    except OSError as error:
        raise StoreError(
            Sentence("{file} cannot be read ({why}).", file=str(file), why=error.strerror),
            bad_input=True,
        ) from error
    sealing.check_is_invitation(content)
    return content


def join(data: Path, sealed: bytes, code: str, path: Path, now: datetime | None = None) -> Joined:
    """Let a person train at home with this data folder, and its letters go to their clinic.

    What was begun and cut off goes on when it is called again.

    Args:
        data: the data folder at home, empty or of this person.
        sealed: the bytes of the invitation.
        code: its eight words.
        path: the letterbox.
        now: the time by this computer's clock; None for the present.

    Raises:
        StoreError: it is not the code, the invitation is too old, the letterbox is not there, or the
            data folder is somebody else's.
    """
    invitation = sealing.open_invitation(sealed, sealing.check_code(code))
    _check_date(invitation, now or datetime.now(UTC))
    path = path.expanduser().absolute()
    folder.check_apart(path, data)
    Letterbox(path)
    before = identity.read(data)
    if before is not None and before.secret == invitation.secret:
        me = msgspec.structs.replace(before, folder=str(path))
    else:
        me = _new_home(data, before, invitation, path)
    with closing(connect(data)) as db:
        _check_is_free(db, data, invitation)
    with rows_of.alone(data):
        _store(data, invitation)
    identity.write(data, me)  # from here on the person has joined
    return Joined(invitation.clinic, invitation.participant, path)


def _check_date(invitation: Invitation, now: datetime) -> None:
    created, expires = (
        datetime.fromisoformat(text) for text in (invitation.created_at, invitation.expires_at)
    )
    if now > expires:
        raise StoreError(
            Sentence(
                "This invitation could be used until {day}. Ask your therapist for a new one. If "
                "the date of this computer is wrong ({today}), set it first.",
                day=expires.date().isoformat(),
                today=now.date().isoformat(),
            ),
            bad_input=True,
        )
    if now < created - _LATE:
        raise StoreError(
            Sentence(
                "The date of this computer is wrong: {today} is before the invitation was written "
                "({day}). Set it first.",
                today=now.date().isoformat(),
                day=created.date().isoformat(),
            ),
            bad_input=True,
        )


def _new_home(data: Path, before: Identity | None, invitation: Invitation, path: Path) -> Identity:
    if before is not None and not before.is_home:
        raise StoreError(
            f"This data folder is the clinic's ({before.clinic}). A home needs another one: --data "
            "DIR.",
            bad_input=True,
        )
    return Identity(
        role="home",
        clinic=invitation.clinic,
        folder=str(path),
        keys=Keys.new(),
        participant=invitation.participant,
        secret=invitation.secret,
    )


def _check_is_free(db: sqlite3.Connection, data: Path, invitation: Invitation) -> None:
    """Raise StoreError if a database is of another clinic, or of other people."""
    site = sites.own(db)
    if site and site != invitation.site:
        raise StoreError(
            Sentence(
                "This computer's data is of {site}, and the invitation of {clinic}. A person "
                "trains with one clinic: use another data folder (--data DIR).",
                site=site,
                clinic=invitation.clinic,
            ),
            bad_input=True,
        )
    others = db.execute(
        "SELECT code FROM participants WHERE code<>? LIMIT 1", (invitation.participant,)
    ).fetchone()
    if others:
        raise StoreError(
            Sentence(
                "The data folder {folder} has other people. A home has one person: use another "
                "data folder (--data DIR).",
                folder=str(data),
            ),
            bad_input=True,
        )


def _store(data: Path, invitation: Invitation) -> None:
    """Bring what the invitation says into the database."""
    with closing(connect(data)) as db:
        if not sites.own(db):
            sites.set_own(db, invitation.site)
        secret = hashlib.sha256(invitation.secret).hexdigest()
        known = stored.correspondents(db)
        with transaction(db):
            for one in known:
                if one.invitation != secret and one.state == "joined":
                    stored.change(db, one.id, state="revoked")
            if not any(one.invitation == secret for one in known):
                stored.add(
                    db,
                    Correspondent(
                        id=stored.new_id(),
                        participant=invitation.participant,
                        state="joined",
                        verify_key=invitation.keys.verify,
                        seal_key=invitation.keys.seal,
                        invitation=secret,
                        invited_at=invitation.created_at,
                        expires_at=invitation.expires_at,
                    ),
                )
    _store_passphrase(data, invitation.passphrase)
    with rows_of.work_folder(data) as place:
        path = place / "invitation.db"
        sealing.unpack(invitation.rows, path)
        merge(
            data,
            path,
            one_site=True,
            check_letter=lambda db: rows_of.check_rows(db, invitation.participant, "clinic"),
            start=lambda step: lambda done, total: None,
        )


def _store_passphrase(data: Path, content: bytes) -> None:
    try:
        replace_private(data / passphrase.FILE, content)
    except OSError as error:
        raise StoreError(f"{data} cannot be written ({error.strerror}).") from error
