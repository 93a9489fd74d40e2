"""Sealed letters and invitations as bytes. All cryptography is libsodium's, through PyNaCl.

A letter is signed by its writer, padded to one of a few sizes, and sealed to its reader. Its
signature covers the reader's key, the writer's key and the letter's number, so that a letter cannot
be given to another reader, or take the place of another one.

An invitation is sealed by a code of eight words, which is told by another way than the file.
"""

import hashlib
import secrets
import zlib
from pathlib import Path
from typing import Any, Final, NamedTuple

import msgspec

from sar_tui.drivers.files import write_private
from sar_tui.drivers.installation import pip_install_extra
from sar_tui.model.language import Sentence
from sar_tui.store.database import StoreError

_SIZES: Final = tuple(2**14 * 4**step for step in range(8))
"""Sizes to which letters are padded: 16 KiB, 64 KiB, … 256 MiB."""
LARGEST_FILE: Final = _SIZES[-1] + 48
"""Bytes of the largest sealed letter: of its padded content, and of the seal."""
_INVITATION_SIZE: Final = 2**16
LARGEST_INVITATION: Final = 4 * _INVITATION_SIZE
_HIGHEST = 2**31
"""The highest number of a letter."""
_MOST_NUMBERS = 10_000
"""Numbers that a letter names at most."""
_MOST_ROWS = 2**29
"""Bytes of an unpacked database of a letter."""
_AT_ONCE = 2**20
"""Bytes that are unpacked at once."""
_LETTER, _INVITATION = b"sar-tui letter 1\n", b"sar-tui invitation 1\n"
"""First bytes of what is signed, and of an invitation's file: what it is, and its format."""
CODE_WORDS: Final = 8
"""Words of an invitation's code, of a list of 2048: 88 bits."""


class Damaged(Exception):
    """A file is no letter for this reader: it was changed, cut off, or is for somebody else."""


class Forged(Exception):
    """A letter could be opened, and must not be believed. The message says why."""


# --- letters

Ranges = tuple[tuple[int, int], ...]
"""Numbers, as the first and the last of each range."""


class Letter(msgspec.Struct, frozen=True, kw_only=True):
    """The content of a sealed letter.

    Attributes:
        reader: public key to which it is sealed.
        number: 1, 2, …, of all letters from this writer to this reader.
        written_at: UTC, by the writer's clock.
        version: of the data in ``rows`` (`store.tables.VERSION`).
        taken: ranges of numbers of the reader's letters that have arrived, first and last.
        refused: ranges of numbers of those that were refused.
        void: ranges of numbers of the writer's letters that never come.
        seen: ranges of numbers of the reader's letters that a person has looked at.
        wanted: numbers of the reader's letters that it has to write again.
        secret: of the invitation, in the first letter from a home; else empty.
        notice: why no further letter will come: ``used`` or ``expired``, of the invitation, or
            ``revoked``; else empty.
        seal_key: of a home, the key to which letters for it are sealed; else empty.
        device: of a home's computer, what helps to understand its data.
        sessions: the session of each record whose session is not among the rows.
        rows: a database of what is new, packed with zlib; empty: nothing is.
    """

    reader: bytes
    number: int
    written_at: str
    version: int = 0
    taken: Ranges = ()
    refused: Ranges = ()
    void: Ranges = ()
    seen: Ranges = ()
    wanted: tuple[int, ...] = ()
    secret: bytes = b""
    notice: str = ""
    seal_key: bytes = b""
    device: dict[str, str] = {}
    sessions: dict[str, str] = {}
    rows: bytes = b""


class Opened(NamedTuple):
    """A letter, the public key of who signed it, and the SHA-256 of what was signed."""

    letter: Letter
    writer: bytes
    digest: str


class Keys(msgspec.Struct, frozen=True):
    """The secret keys of a computer, 32 bytes each. They stay on it.

    ``sign``: of an Ed25519 signature. ``seal``: of a Curve25519 key to which letters are sealed.
    """

    sign: bytes
    seal: bytes

    @classmethod
    def new(cls) -> "Keys":
        """Return new random keys."""
        return cls(secrets.token_bytes(32), secrets.token_bytes(32))

    @property
    def public(self) -> "PublicKeys":
        """The keys that others need."""
        nacl = _nacl()
        return PublicKeys(
            bytes(nacl.signing.SigningKey(self.sign).verify_key),
            bytes(nacl.public.PrivateKey(self.seal).public_key),
        )


class PublicKeys(msgspec.Struct, frozen=True):
    """Public keys of a computer: by which its signatures are checked, and to which is sealed."""

    verify: bytes
    seal: bytes


def seal(letter: Letter, writer: Keys) -> bytes:
    """Return a letter signed, padded and sealed. Raises StoreError: it is too large."""
    nacl = _nacl()
    signer = nacl.signing.SigningKey(writer.sign)
    signed = bytes(signer.sign(_LETTER + bytes(signer.verify_key) + msgspec.msgpack.encode(letter)))
    padded = _padded(signed)
    try:
        return bytes(nacl.public.SealedBox(nacl.public.PublicKey(letter.reader)).encrypt(padded))
    except (nacl.exceptions.CryptoError, ValueError, TypeError) as error:
        raise StoreError("A letter cannot be sealed: the key of its reader is wrong.") from error


def open_letter(sealed: bytes, reader: Keys) -> Opened:
    """Return what a file says, after every check that needs no database.

    Raises:
        Damaged: the file is not for this reader, or was changed or cut off.
        Forged: it is for this reader, and its signature, form or reader is wrong.
    """
    nacl = _nacl()
    secret = nacl.public.PrivateKey(reader.seal)
    try:
        padded = nacl.public.SealedBox(secret).decrypt(sealed)
    except (nacl.exceptions.CryptoError, ValueError, TypeError):
        raise Damaged from None
    try:
        signed = nacl.bindings.sodium_unpad(padded, len(padded))
        start = nacl.bindings.crypto_sign_BYTES + len(_LETTER)
        writer = signed[start : start + nacl.bindings.crypto_sign_PUBLICKEYBYTES]
        content = nacl.signing.VerifyKey(writer).verify(signed)
    except (nacl.exceptions.CryptoError, ValueError, TypeError):
        raise Forged("its signature is wrong") from None
    if not content.startswith(_LETTER):
        raise Forged("it is of a version of sar-tui that is not known here")
    try:
        letter = msgspec.msgpack.decode(content[len(_LETTER) + len(writer) :], type=Letter)
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
        raise Forged("it has not the form of a letter") from None
    if letter.reader != bytes(secret.public_key):
        raise Forged("it was written to another computer")
    ranges = (*letter.taken, *letter.refused, *letter.void, *letter.seen)
    numbers = (letter.number, *letter.wanted, *(number for each in ranges for number in each))
    if len(numbers) > _MOST_NUMBERS or not all(0 < number <= _HIGHEST for number in numbers):
        raise Forged("a number in it is wrong")
    return Opened(letter, writer, hashlib.sha256(content).hexdigest())


def packed(database: bytes) -> bytes:
    """Return the bytes of a database as a letter has them."""
    return zlib.compress(database)


def unpack(rows: bytes, path: Path) -> None:
    """Write the database of a letter into a new file. Raises Forged, OSError."""
    unpacking, left, size = zlib.decompressobj(), rows, 0
    write_private(path, b"")
    with open(path, "wb") as file:
        while not unpacking.eof:
            try:
                some = unpacking.decompress(left, _AT_ONCE)
            except zlib.error:
                raise Forged("its rows cannot be unpacked") from None
            left, size = unpacking.unconsumed_tail, size + len(some)
            if size > _MOST_ROWS:
                raise Forged("its rows are larger than any session")
            if not some and not left and not unpacking.eof:
                raise Forged("its rows cannot be unpacked")
            file.write(some)


def _padded(signed: bytes) -> bytes:
    for size in _SIZES:
        if len(signed) < size:
            return bytes(_nacl().bindings.sodium_pad(signed, size))
    raise StoreError("A session is too large for a letter. Bring it by a backup and sar-tui merge.")


# --- invitations


class Invitation(msgspec.Struct, frozen=True, kw_only=True):
    """All that a home needs to write to its clinic.

    Attributes:
        clinic: name of the clinic, for people. ``site``: its code.
        participant: who trains at home.
        keys: the clinic's.
        secret: 32 bytes that show the clinic that this home was invited.
        created_at, expires_at: UTC, by the clinic's clock.
        passphrase: the file of the clinic's passphrase, which ends patient mode at home, too.
        rows: as in a letter: the programmes, so that training can begin at once.
    """

    clinic: str
    site: str
    participant: str
    keys: PublicKeys
    secret: bytes
    created_at: str
    expires_at: str
    passphrase: bytes
    rows: bytes


def seal_invitation(invitation: Invitation, code: str) -> bytes:
    """Return the bytes of an invitation's file."""
    nacl = _nacl()
    salt = secrets.token_bytes(nacl.pwhash.argon2id.SALTBYTES)
    content = nacl.bindings.sodium_pad(msgspec.msgpack.encode(invitation), _INVITATION_SIZE)
    return _INVITATION + salt + bytes(nacl.secret.SecretBox(_key(code, salt)).encrypt(content))


def open_invitation(file: bytes, code: str) -> Invitation:
    """Return an invitation.

    Raises:
        StoreError: the file is no invitation, or the code is not its code.
    """
    nacl = _nacl()
    start = len(_INVITATION)
    salt, sealed = file[start:][: nacl.pwhash.argon2id.SALTBYTES], file[start:]
    sealed = sealed[nacl.pwhash.argon2id.SALTBYTES :]
    check_is_invitation(file)
    try:
        content = nacl.secret.SecretBox(_key(code, salt)).decrypt(sealed)
        content = nacl.bindings.sodium_unpad(content, len(content))
        return msgspec.msgpack.decode(content, type=Invitation)
    except (nacl.exceptions.CryptoError, ValueError, TypeError, msgspec.MsgspecError):
        raise StoreError(
            Sentence(
                "These are not the words of this invitation. Ask your therapist to say them once "
                "more."
            ),
            bad_input=True,
        ) from None


def check_is_invitation(file: bytes) -> None:
    """Raise StoreError if the bytes of a file are no invitation."""
    if not file.startswith(_INVITATION) or len(file) < _INVITATION_SIZE:
        raise StoreError(
            Sentence("This file is no invitation, or is not complete yet."), bad_input=True
        )


def _key(code: str, salt: bytes) -> bytes:
    argon = _nacl().pwhash.argon2id
    return bytes(
        argon.kdf(
            32, code.encode(), salt, opslimit=argon.OPSLIMIT_MODERATE,
            memlimit=argon.MEMLIMIT_MODERATE,
        )
    )  # fmt: skip


# --- the code of an invitation


def new_code(language: str) -> str:
    """Return eight random words, of the list of a language if there is one; else English ones."""
    words = _lists()[_LISTS.get(language, "english")]
    return " ".join(secrets.choice(words) for _ in range(CODE_WORDS))


def check_code(typed: str) -> str:
    """Return the code that somebody typed, as it is stored.

    The first four letters of a word, which no two words of a list share, are enough.

    Raises:
        StoreError: these are not eight words of one list. It names the word.
    """
    given = [_plain(word) for word in typed.replace(",", " ").split()]
    if len(given) != CODE_WORDS:
        raise StoreError(
            Sentence("The code has 8 words; these are {count}.", count=len(given)), bad_input=True
        )
    wrong = list[str]()
    for words in _lists().values():
        by_start = {_plain(word)[:4]: word for word in words}
        found = [by_start.get(word[:4], "") for word in given]
        unknown = [word for word, one in zip(given, found, strict=True) if not _is(word, one)]
        if not unknown:
            return " ".join(found)
        if not wrong or len(unknown) < len(wrong):
            wrong = unknown
    raise StoreError(
        Sentence(
            "“{word}” is no word of such a code. Check how it is written.", word=wrong[0][:40]
        ),
        bad_input=True,
    )


_LISTS = {"en": "english", "es": "spanish"}
"""Lists of words by language. There is none in German: the English words are spelled."""


def _is(typed: str, word: str) -> bool:
    return bool(word) and len(typed) >= min(4, len(word)) and _plain(word).startswith(typed)


def _plain(word: str) -> str:
    """Return a word in small letters without accents."""
    import unicodedata

    split = unicodedata.normalize("NFD", word.casefold())
    return "".join(letter for letter in split if not unicodedata.combining(letter))


def _lists() -> dict[str, list[str]]:
    try:
        from mnemonic import Mnemonic
    except ImportError as error:
        raise _missing() from error
    return {name: list(Mnemonic(name).wordlist) for name in _LISTS.values()}


def _nacl() -> Any:
    """Return the package, with all modules that are used here."""
    try:
        import nacl.bindings
        import nacl.exceptions
        import nacl.public
        import nacl.pwhash
        import nacl.secret
        import nacl.signing
    except ImportError as error:
        raise _missing() from error
    return nacl


def _missing() -> StoreError:
    return StoreError(
        f"Sealed letters need packages that are not installed here: {pip_install_extra('letterbox')}"
    )
