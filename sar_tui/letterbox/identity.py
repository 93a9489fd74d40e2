"""The part of a data folder in a letterbox, a clinic or a home, with its secret keys, in a file.

The keys are not in the database, so that no backup and no merge takes them elsewhere.
"""

from pathlib import Path
from typing import Literal

import msgspec

from sar_tui.drivers.files import make_private, replace_private
from sar_tui.letterbox import FILE
from sar_tui.letterbox.sealing import Keys
from sar_tui.model.language import Sentence
from sar_tui.store.database import StoreError


class Identity(msgspec.Struct, frozen=True, kw_only=True):
    """The side of a data folder, and its keys.

    Attributes:
        role: a clinic, or a home.
        clinic: name of the clinic, for people.
        folder: the letterbox, an absolute path.
        keys: of this computer.
        participant: at home, who trains here; else empty.
        secret: at home, of the invitation; else empty.
    """

    role: Literal["clinic", "home"]
    clinic: str
    folder: str
    keys: Keys
    participant: str = ""
    secret: bytes = b""

    @property
    def is_home(self) -> bool:
        """True if one person trains here."""
        return self.role == "home"


def read(data: Path) -> Identity | None:
    """Return the side of a data folder; None if it has no letterbox.

    Raises:
        StoreError: the file cannot be read.
    """
    path = data / FILE
    try:
        return msgspec.json.decode(path.read_bytes(), type=Identity)
    except FileNotFoundError:
        return None
    except (OSError, msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise StoreError(
            Sentence("{path} cannot be read: no letter can be opened here.", path=str(path))
        ) from error


def require(data: Path) -> Identity:
    """Return the side of a data folder. Raises StoreError: it has no letterbox, or cannot be read."""
    found = read(data)
    if found is None:
        raise StoreError(
            "There is no letterbox here. At the clinic: sar-tui letterbox new --clinic NAME. At "
            "home: sar-tui letterbox join FILE.",
            bad_input=True,
        )
    return found


def check_programme(data: Path) -> None:
    """Raise StoreError at home: what a person trains there is changed at the clinic."""
    found = read(data)
    if found is not None and found.is_home:
        raise StoreError(
            Sentence("The programme comes from the clinic: change it there."), bad_input=True
        )


def write(data: Path, identity: Identity) -> None:
    """Store the side of a data folder, in place of what was there. Raises StoreError."""
    path = data / FILE
    try:
        make_private(data)
        replace_private(path, msgspec.json.encode(identity))
    except OSError as error:
        raise StoreError(
            Sentence("{path} cannot be written ({why}).", path=str(path), why=error.strerror)
        ) from error
