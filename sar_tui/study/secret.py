"""The secret of a study, from which its assignments follow, and the list that was made elsewhere.

Both are files outside of the data folder, so that they are in no backup, export or merge of data.
"""

import csv
import secrets
from pathlib import Path

import platformdirs

from sar_tui.drivers.files import write_private
from sar_tui.model.language import Sentence
from sar_tui.study.allocation import AllocationError, Draws, ListedGroup

_BYTES = 32
_UNREADABLE = "{path} cannot be read: {why}."


class KeyMissing(AllocationError):
    """The file of the key is not there."""


def key_file(study: str) -> Path:
    """Return where the secret of a study is kept on this computer."""
    return platformdirs.user_config_path("sar-tui") / "studies" / f"{study}.key"


def create(path: Path) -> Draws:
    """Write a new secret into a file that only its owner can read.

    Raises:
        AllocationError: the file exists, or cannot be written.
    """
    secret = secrets.token_bytes(_BYTES)
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        write_private(path, f"{secret.hex()}\n")
    except FileExistsError:
        raise AllocationError(
            Sentence("{path} exists already: it is the key of another study.", path=str(path))
        ) from None
    except OSError as error:
        raise AllocationError(
            Sentence("{path} cannot be written: {why}.", path=str(path), why=error.strerror)
        ) from error
    return Draws(secret)


def read(path: Path) -> Draws:
    """Read a secret.

    Raises:
        KeyMissing: there is none.
        AllocationError: it cannot be read, or is no key.
    """
    try:
        secret = bytes.fromhex(path.read_text().strip())
    except FileNotFoundError:
        raise KeyMissing(
            Sentence(
                "The key of the study is not here ({path}): copy it from the computer where the "
                "first person was enrolled.",
                path=str(path),
            )
        ) from None
    except OSError as error:
        raise AllocationError(_unreadable(path, error)) from error
    except ValueError:
        secret = b""
    if len(secret) != _BYTES:
        raise AllocationError(Sentence("{path} is not the key of a study.", path=str(path)))
    return Draws(secret)


def read_list(path: Path, groups: tuple[str, ...]) -> tuple[ListedGroup, ...]:
    """Read a list of groups made elsewhere: CSV with the columns group and, if there are strata,
    stratum.

    Raises:
        AllocationError: it cannot be read, or names a group that is not in the plan.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.DictReader(file))
    except OSError as error:
        raise AllocationError(_unreadable(path, error)) from error
    except UnicodeDecodeError:
        raise AllocationError(Sentence("{path} is not a text in UTF-8.", path=str(path))) from None
    found = []
    for number, row in enumerate(rows, 2):
        group = (row.get("group") or "").strip()
        if group not in groups:
            raise AllocationError(
                Sentence(
                    "{path}, line {number}: the group is one of {groups}, not {group}.",
                    path=str(path),
                    number=number,
                    groups=groups,
                    group=f"{group!r:.40}",
                )
            )
        found.append(ListedGroup(group, (row.get("stratum") or "").strip()))
    return tuple(found)


def _unreadable(path: Path, error: OSError) -> Sentence:
    return Sentence(_UNREADABLE, path=str(path), why=error.strerror)
