"""SIGKILL at any moment of sending, taking and joining: nothing is lost, and nothing comes twice."""

import os
import random
import shutil
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from sar_tui.letterbox import letterbox, sealing
from sar_tui.letterbox.exchange import exchange
from tests.letterbox.household import Clinic, Computer, rows, settle

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a system with fork")


def killed(work: Callable[[], object], after_s: float) -> bool:
    """Let another process do something and kill it after a time; return True if it was not done by
    then.
    """
    child = os.fork()
    if child == 0:
        try:
            work()
        finally:
            os._exit(0)
    time.sleep(after_s)
    os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    return os.WIFSIGNALED(status)


def seconds(work: Callable[[], object]) -> float:
    """Return the time that something takes in another process."""
    began = time.monotonic()
    child = os.fork()
    if child == 0:
        try:
            work()
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    return time.monotonic() - began


class Saved:
    """The files of computers as they are now, to be put back."""

    def __init__(self, folder: Path, *computers: Computer) -> None:
        self._folders = list(dict.fromkeys(f for one in computers for f in (one.data, one.box)))
        self._copies = [folder / str(number) for number in range(len(self._folders))]
        for place, copy in zip(self._folders, self._copies, strict=True):
            if place.exists():
                shutil.copytree(place, copy)

    def put_back(self) -> None:
        """Bring all back."""
        for place, copy in zip(self._folders, self._copies, strict=True):
            shutil.rmtree(place, ignore_errors=True)
            if copy.exists():
                shutil.copytree(copy, place)


def _longest(work: Callable[[], object], saved: Saved) -> float:
    """Return the shortest of three times that something took, so that most kills come before its
    end.
    """
    taken = []
    for _ in range(3):
        saved.put_back()
        taken.append(seconds(work))
    return min(taken)


MOMENTS = [6, pytest.param(70, marks=pytest.mark.slow)]


@pytest.mark.parametrize("moments", MOMENTS)
@pytest.mark.parametrize("side", ["sending", "taking"])
def test_killed_while_letters_are_exchanged(side: str, moments: int, tmp_path: Path) -> None:
    clinic = Clinic(tmp_path / "clinic", "P07")
    home = clinic.home("P07", tmp_path / "home")
    settle(home, clinic)
    sessions = {home.train_today(seed=seed) for seed in (1, 2)}
    home.record("adverse-event", "P07", what="dizzy", severity="mild")
    clinic.save("P07", prompts_per_attempt=4)
    clinic.record("message-home", "P07", text="Well done.")
    clinic.exchange()
    if side == "taking":
        home.exchange()
    worker = home if side == "sending" else clinic
    saved = Saved(tmp_path / "saved", home, clinic)

    def work() -> object:
        return exchange(worker.data, worker.clock)

    longest = _longest(work, saved)
    luck, cut_off = random.Random(moments), 0
    for moment in range(moments):
        saved.put_back()
        cut_off += killed(work, longest * (moment + luck.random()) / moments)
        settle(home, clinic)
        assert rows(clinic, "P07") == rows(home, "P07")
        assert {id for (id,) in clinic.query("SELECT id FROM sessions")} == sessions
        for one in (home, clinic):
            assert one.query("SELECT count(*) FROM records") == [(2,)]
            assert one.query("SELECT count(*) FROM conflicts") == [(0,)]
            numbers = [
                number
                for (number,) in one.query(
                    "SELECT number FROM letters WHERE direction='out' ORDER BY number"
                )
            ]
            assert numbers == list(range(1, len(numbers) + 1))
            assert not list(one.data.glob(".letter-*"))
        assert not list(clinic.box.glob(".*"))
    assert cut_off > 0
    print(f"\n{side}: killed {cut_off} of {moments} times before it was done")


@pytest.mark.parametrize("moments", [4, pytest.param(60, marks=pytest.mark.slow)])
def test_killed_while_a_home_joins(
    moments: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clinic = Clinic(tmp_path / "clinic", "P07")
    invited = clinic.invite("P07")
    sealed = invited.file.read_bytes()
    derive, known = sealing._key, dict[tuple[str, bytes], bytes]()

    def key(code: str, salt: bytes) -> bytes:
        """Derive a key once: it takes most of the time, and changes nothing."""
        if (code, salt) not in known:
            known[code, salt] = derive(code, salt)
        return known[code, salt]

    monkeypatch.setattr(sealing, "_key", key)
    sealing.open_invitation(sealed, invited.code)
    home = Computer(tmp_path / "home")
    home.box = clinic.box
    saved = Saved(tmp_path / "saved", home, clinic)

    def join() -> object:
        letterbox.join(home.data, sealed, invited.code, clinic.box, now=home.clock())
        return exchange(home.data, home.clock)

    longest = _longest(join, saved)
    luck, cut_off = random.Random(moments), 0
    for moment in range(moments):
        saved.put_back()
        cut_off += killed(join, longest * (moment + luck.random()) / moments)
        join()
        session = home.train("P07")
        settle(home, clinic)
        assert clinic.query("SELECT id FROM sessions") == [(session,)]
        assert clinic.query("SELECT state FROM correspondents") == [("joined",)]
        assert home.query("SELECT state FROM correspondents") == [("joined",)]
        assert rows(clinic, "P07") == rows(home, "P07")
    assert cut_off > 0
    print(f"\njoining: killed {cut_off} of {moments} times before it was done")
