"""List of the recorded sessions on which operators have practised, in the data folder."""

from datetime import UTC, datetime
from pathlib import Path

import msgspec

from sar_tui.drivers.files import append_private
from sar_tui.model.protocol import WizardProtocol

FILE = "wizard-practice.jsonl"
"""Name of the file in the data folder: a line for each practice that was played to its end."""


class Practised(msgspec.Struct, frozen=True):
    """A practice. ``at``: its end, UTC. ``hash``: of the protocol's file."""

    at: str
    operator: str
    session: str
    protocol: str
    version: int
    hash: str


def note_practice(folder: Path, operator: str, session: str, protocol: WizardProtocol) -> None:
    """Add a practice to the list. Raises OSError."""
    at = datetime.now(UTC).isoformat(timespec="seconds")
    done = Practised(at, operator, session, protocol.name, protocol.version, protocol.hash)
    append_private(folder / FILE, msgspec.json.encode(done).decode() + "\n")


def times_practised(folder: Path, operator: str, protocol: WizardProtocol) -> int:
    """Return how many practices an operator has finished by a protocol of this name and version."""
    try:
        lines = (folder / FILE).read_bytes().splitlines()
    except OSError:
        return 0
    count = 0
    for line in lines:
        try:
            done = msgspec.json.decode(line, type=Practised)
        except msgspec.MsgspecError:
            continue
        same = (done.operator, done.protocol, done.version)
        count += same == (operator, protocol.name, protocol.version)
    return count
