"""Seen from the outside, in what the system tells of its processes: a session opens no socket unless asked to."""

import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.end_to_end.operator_terminal import Room, children
from tests.end_to_end.participant_terminal import see_the_summary

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")

_LISTENS = 0x10000
_NETWORK = ("tcp", "tcp6", "udp", "udp6", "udplite", "udplite6", "raw", "raw6", "icmp", "icmp6", "packet", "netlink")
_INODE = {"packet": 8, "netlink": 9}
"""In which column the tables have the number of a socket; else in the tenth."""


class Sockets(NamedTuple):
    """What a program and all that it has started hold open. ``own``: pairs that a process talks to itself with."""

    network: list[str]
    listening: list[str]
    other: list[str]
    own: int


def sockets(pid: int) -> Sockets:
    """Look at every process of a program."""
    found = Sockets([], [], [], 0)
    for process in (pid, *children(pid)):
        held = _held(Path(f"/proc/{process}"))
        for table in _NETWORK:
            found.network.extend(f"{table}: {line}" for line in _table(process, table, held))
        nameless = 0
        for line in _table(process, "unix", held):
            _, _, _, flags, _, _, _, *name = line.split()
            if int(flags, 16) & _LISTENS:
                found.listening.append(" ".join(name))
            elif name:
                found.other.append(" ".join(name))
            else:
                nameless += 1
        found = found._replace(own=found.own + nameless)
    return found


def _held(process: Path) -> set[str]:
    """The numbers of a process' sockets."""
    numbers = set()
    for file in (process / "fd").iterdir():
        try:
            target = file.readlink().name
        except FileNotFoundError:  # closed meanwhile
            continue
        if target.startswith("socket:["):
            numbers.add(target[len("socket:[") : -1])
    return numbers


def _table(process: int, name: str, held: set[str]) -> list[str]:
    """The lines of a table of the system's that are about sockets of these numbers."""
    file = Path(f"/proc/{process}/net/{name}")
    lines = file.read_text().splitlines()[1:] if file.exists() else []
    column = 6 if name == "unix" else _INODE.get(name, 9)
    return [line for line in lines if line.split()[column] in held]


def test_a_session_that_nobody_may_join_opens_no_socket_from_its_first_screen_to_its_last(data: Path) -> None:
    with Room(data) as room:
        participant = room.participant(prompts_per_attempt=3, attempts=1)
        pid = participant.terminal.process.pid
        participant.terminal.wait_for("Press Enter to go on.")
        looks = [sockets(pid)]
        usual = participant.answers

        def looking(number: int, expected: str) -> tuple[float, str]:
            looks.append(sockets(pid))
            return usual(number, expected)

        participant.answers = looking
        participant.answer(3)
        see_the_summary(participant.terminal)
        looks.append(sockets(pid))
        assert not list(room.runtime.rglob("*")), "nor is anything announced"
    assert len(looks) == 5
    for look in looks:
        assert (look.network, look.listening, look.other) == ([], [], [])
        assert look.own <= 2, "the two ends of the event loop's own alarm, and no third that leads elsewhere"


def test_a_session_for_operators_on_this_machine_listens_at_one_place_that_is_this_users_alone(data: Path) -> None:
    with Room(data) as room:
        participant = room.participant("--operator", prompts_per_attempt=1, attempts=1)
        pid = participant.terminal.process.pid
        participant.terminal.wait_for("Press Enter to go on.")
        alone = sockets(pid)
        room.panel()
        room.until(lambda: room.is_operated, "the operator steers")
        joined = sockets(pid)
        assert any("sar_tui.link.broker" in words for words in children(pid).values())

        (place,) = [Path(name) for name in alone.listening]
        assert place.parent == room.runtime / "sar-tui"
        assert place.parent.stat().st_mode & 0o777 == 0o700
        participant.terminal.press("ctrl+q")
        assert participant.terminal.wait() == 0
        assert not list(place.parent.iterdir()), "nothing is left of it"
    assert alone.network == joined.network == []
    assert joined.listening == [str(place)]
    assert set(joined.other) == {str(place)}, "its ends of the panel's connection"
