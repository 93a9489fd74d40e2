"""The therapist's passphrase: stored as a hash, slower after each wrong one, every try in a log."""

import os
import stat
from pathlib import Path

import pytest

from sar_tui.store import passphrase
from sar_tui.store.database import StoreError
from sar_tui.store.passphrase import FREE_TRIES, Passphrase

RIGHT = "quiet river"


class _Clock:
    def __init__(self) -> None:
        self.now = 1_800_000_000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> _Clock:
    # the real cost takes a tenth of a second each time
    monkeypatch.setattr(passphrase, "_COST", 16)
    return _Clock()


@pytest.fixture
def stored(data: Path, clock: _Clock) -> Passphrase:
    """A passphrase that was set."""
    made = Passphrase(data, clock)
    assert not made.is_set
    made.set(RIGHT)
    return made


def test_only_the_passphrase_that_was_set_is_right(stored: Passphrase, clock: _Clock) -> None:
    assert stored.is_set
    assert stored.check(RIGHT)
    for wrong in ("", "Quiet river", RIGHT + " ", "\x00\x1b", "\ud800"):
        clock.now += 400
        assert not stored.check(wrong)
    with pytest.raises(StoreError, match="at least 6"):
        stored.set("abc")
    clock.now += 400
    assert stored.check(RIGHT), "the earlier one stays"
    stored.set("canci\u00f3n azul")
    assert stored.check("cancio\u0301n azul"), "an accent may be typed in two parts"


def test_the_file_is_private_and_does_not_hold_the_passphrase(
    stored: Passphrase, data: Path
) -> None:
    stored.check("another one")
    for name in (passphrase.FILE, passphrase.LOG):
        assert stat.S_IMODE((data / name).stat().st_mode) == 0o600
        for secret in (b"quiet", b"river", b"another"):
            assert secret not in (data / name).read_bytes()
    first = (data / passphrase.FILE).read_bytes()
    stored.set(RIGHT)
    assert (data / passphrase.FILE).read_bytes() != first, "each has a salt of its own"
    assert sorted(os.listdir(data)) == [passphrase.FILE, passphrase.LOG]


def test_wrong_ones_are_logged_and_followed_by_longer_and_longer_waits(
    stored: Passphrase, data: Path, clock: _Clock
) -> None:
    waits = []
    for tries in range(1, FREE_TRIES + 9):
        assert not stored.check("wrong one", "pause")
        waits.append(stored.wait_s)
        if stored.wait_s:
            assert not stored.check(RIGHT), "during the wait none is taken"
            assert Passphrase(data, clock).wait_s == stored.wait_s, "after a restart, too"
        assert len(stored.tries()) == tries
        clock.now += stored.wait_s
    assert waits == [0, 0, 5, 10, 20, 40, 80, 160, 300, 300, 300]
    assert stored.check(RIGHT, "patient mode"), "after the wait the right one is taken"
    assert stored.wait_s == 0
    *_, wrong, right = [(each.result, each.where) for each in stored.tries()]
    assert (wrong, right) == (("wrong", "pause"), ("right", "patient mode"))
    assert stored.tries()[-1].seconds == clock.now
    for _ in range(FREE_TRIES):
        assert not stored.check("wrong one")
    clock.now -= 1_000_000
    assert stored.check(RIGHT), "a clock that was set back locks nobody out"


def test_without_a_log_the_waits_are_kept_by_the_program(
    stored: Passphrase, data: Path, clock: _Clock
) -> None:
    (data / passphrase.LOG).mkdir()
    for _ in range(FREE_TRIES):
        assert not stored.check("wrong one")
    assert stored.wait_s == 5
    clock.now += 5
    assert stored.check(RIGHT)


@pytest.mark.parametrize(
    "lines", [b"\x00\xff\n{", b'{"at":"no date","result":"wrong"}\n' * 5, b"[]\n"]
)
def test_a_damaged_log_locks_nobody_out(lines: bytes, stored: Passphrase, data: Path) -> None:
    (data / passphrase.LOG).write_bytes(lines)
    assert stored.check(RIGHT)


@pytest.mark.parametrize("content", [b"", b"{}", b'{"salt":"","key":"","cost":1000000000}'])
def test_a_damaged_one_is_never_right_and_says_so(
    content: bytes, stored: Passphrase, data: Path
) -> None:
    (data / passphrase.FILE).write_bytes(content)
    assert stored.is_set
    with pytest.raises(StoreError, match="sar-tui passphrase"):
        stored.check("")


def test_a_kept_passphrase_guards_on_when_its_file_is_removed(stored: Passphrase) -> None:
    stored.keep()
    stored.remove()
    assert stored.is_set
    assert not stored.check("wrong one")
    assert stored.check(RIGHT)
    stored.set("a newer one")
    assert stored.check("a newer one"), "the therapist may change it meanwhile"
    stored.remove()
    stored.release()
    assert not stored.is_set
