"""A disk that fills during a session: the participant is informed, nothing is lost, and the session
resumes.
"""

import os
import resource
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from sar_tui.model.units import MS
from sar_tui.timing.pty import Terminal
from sar_tui.timing.scripted_participant import ScriptedParticipant, random_answers
from tests.end_to_end.participant_terminal import rows, run_command


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A folder that holds eight megabytes: a tmpfs of its own where this user may mount one, else
    any folder.
    """
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=8m", "tmpfs", str(folder)]
    mounted = (
        os.geteuid() == 0
        and subprocess.run(mount, check=False, capture_output=True).returncode == 0
    )
    yield folder
    if mounted:
        subprocess.run(["umount", "--lazy", str(folder)], check=True)


def _fill(folder: Path, terminal: Terminal) -> Callable[[], object]:
    """Leave no room on the disk (or, without a disk of its own, for the program's files); returns
    the cure.
    """
    if not os.path.ismount(folder):
        before = resource.prlimit(terminal.process.pid, resource.RLIMIT_FSIZE)
        resource.prlimit(terminal.process.pid, resource.RLIMIT_FSIZE, (1, before[1]))
        return lambda: resource.prlimit(terminal.process.pid, resource.RLIMIT_FSIZE, before)
    filler = folder / "filler"
    with filler.open("wb", buffering=0) as file:
        for size in (4096, 64, 1):
            try:
                while True:
                    file.write(b"x" * size)
            except OSError:
                continue
    return filler.unlink


@pytest.mark.slow
def test_the_session_pauses_while_the_disk_is_full_and_continues_when_there_is_space(
    small_disk: Path,
) -> None:
    with Terminal(run_command(small_disk, prompts_per_attempt=20, attempts=1)) as terminal:
        participant = ScriptedParticipant(terminal, random_answers(5, 80, 140))
        participant.run(4)
        cure = _fill(small_disk, terminal)
        while b"Please fetch the experimenter" not in terminal.output:
            participant.run(until=time.monotonic_ns() + 100 * MS)
        cure()
        terminal.wait_for("Everything is saved again")
        terminal.confirm()
        participant.run()
        assert terminal.wait() == 0

    assert rows(small_disk, "PRAGMA integrity_check") == [("ok",)]
    assert rows(small_disk, "SELECT trial FROM trials") == [(trial,) for trial in range(1, 21)]
    seqs = [seq for (seq,) in rows(small_disk, "SELECT seq FROM events ORDER BY seq")]
    assert seqs == list(range(1, len(seqs) + 1)), "every message is there, in order"
    assert rows(small_disk, "SELECT count(*) FROM events WHERE topic='store/changed'") == [(2,)]
