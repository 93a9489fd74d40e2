"""A session opens no socket unless asked to, as seen in /proc."""

import sys
from pathlib import Path
from typing import NamedTuple

import pytest
import zenoh

from sar_tui.link.zenoh_settings import config, socket_settings
from sar_tui.timing.closed_loop import LEAVE_KEYS
from tests.end_to_end.operator_terminal import SessionTerminals, children

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="samples into /proc")

_LISTENS = 0x10000
_NETWORK = "tcp tcp6 udp udp6 udplite udplite6 raw raw6 icmp icmp6 packet netlink".split()
_INODE = {"packet": 8, "netlink": 9}
"""Column of the inode in these tables; the tenth in others."""


class Sockets(NamedTuple):
    """Open sockets of a program and its children. ``own``: unnamed ones, of a process to itself."""

    network: list[str]
    listening: list[str]
    other: list[str]
    own: int


def sockets(pid: int) -> Sockets:
    """Return the sockets of a program and all its children."""
    found = Sockets([], [], [], 0)
    for process in (pid, *children(pid)):
        inodes = _inodes(Path(f"/proc/{process}"))
        for table in _NETWORK:
            found.network.extend(f"{table}: {line}" for line in _table(process, table, inodes))
        nameless = 0
        for line in _table(process, "unix", inodes):
            _, _, _, flags, _, _, _, *name = line.split()
            if int(flags, 16) & _LISTENS:
                found.listening.append(" ".join(name))
            elif name:
                found.other.append(" ".join(name))
            else:
                nameless += 1
        found = found._replace(own=found.own + nameless)
    return found


def _inodes(process: Path) -> set[str]:
    """Return the inodes of a process' sockets."""
    numbers = set()
    for file in (process / "fd").iterdir():
        try:
            target = file.readlink().name
        except FileNotFoundError:  # closed meanwhile
            continue
        if target.startswith("socket:["):
            numbers.add(target[len("socket:[") : -1])
    return numbers


def _table(process: int, name: str, inodes: set[str]) -> list[str]:
    """Return the lines of a system table about these sockets."""
    file = Path(f"/proc/{process}/net/{name}")
    lines = file.read_text().splitlines()[1:] if file.exists() else []
    column = 6 if name == "unix" else _INODE.get(name, 9)
    return [line for line in lines if line.split()[column] in inodes]


@pytest.mark.slow
def test_default_session_opens_no_socket(data: Path) -> None:
    with SessionTerminals(data) as terminals:
        participant = terminals.participant(prompts_per_attempt=2, attempts=1)
        pid = participant.terminal.process.pid
        participant.terminal.wait_for("Press Enter to go on.")
        samples = [sockets(pid)]
        answers = participant.answers

        def answer_and_sample(number: int, expected: str) -> tuple[float, str]:
            samples.append(sockets(pid))
            return answers(number, expected)

        participant.answers = answer_and_sample
        participant.answer(2)
        participant.terminal.wait_for("Press Enter to see how it went.")
        samples.append(sockets(pid))
        assert not list(terminals.runtime.rglob("*")), "and announces nothing"
    assert len(samples) == 4
    for sample in samples:
        assert (sample.network, sample.listening, sample.other) == ([], [], [])
        assert sample.own <= 2, "only the two ends of the event loop's own wake-up socket"


@pytest.mark.slow
def test_session_with_operator_listens_on_one_private_socket(data: Path) -> None:
    with SessionTerminals(data) as terminals:
        participant = terminals.participant("--operator", prompts_per_attempt=1, attempts=1)
        pid = participant.terminal.process.pid
        participant.terminal.wait_for("Press Enter to go on.")
        alone = sockets(pid)
        (place,) = [Path(name) for name in alone.listening]
        with zenoh.open(config(socket_settings(place))):
            joined = sockets(pid)
        assert any("sar_tui.link.broker" in words for words in children(pid).values())
        assert place.parent == terminals.runtime / "sar-tui"
        assert place.parent.stat().st_mode & 0o777 == 0o700
        for key in LEAVE_KEYS:
            participant.terminal.confirm(key)
        assert participant.terminal.wait() == 0
        assert not list(place.parent.iterdir()), "no files are left"
    assert alone.network == joined.network == []
    assert joined.listening == [str(place)]
    assert set(joined.other) == {str(place)}, "the session's end of the guest's connection"
