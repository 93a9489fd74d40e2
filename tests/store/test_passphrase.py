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


def test_only_the_passphrase_that_was_set_is_right(data: Path, clock: _Clock) -> None:
    stored = Passphrase(data, clock)
    assert not stored.is_set
    stored.set(RIGHT)
    assert stored.is_set
    assert stored.check(RIGHT)
    for wrong in ("", "Quiet river", RIGHT + " ", "\x00\x1b", "\ud800"):
        clock.now += 400
        assert not stored.check(wrong)


def test_the_file_is_private_and_does_not_hold_the_passphrase(data: Path, clock: _Clock) -> None:
    Passphrase(data, clock).set(RIGHT)
    Passphrase(data, clock).check("another one")
    for name in (passphrase.FILE, passphrase.LOG):
        assert stat.S_IMODE((data / name).stat().st_mode) == 0o600
        for secret in (b"quiet", b"river", b"another"):
            assert secret not in (data / name).read_bytes()
    first = (data / passphrase.FILE).read_bytes()
    Passphrase(data, clock).set(RIGHT)
    assert (data / passphrase.FILE).read_bytes() != first, "each has a salt of its own"
    assert sorted(os.listdir(data)) == [passphrase.FILE, passphrase.LOG]


def test_an_accent_may_be_typed_in_one_part_or_two(data: Path, clock: _Clock) -> None:
    stored = Passphrase(data, clock)
    stored.set("canci\u00f3n azul")
    assert stored.check("cancio\u0301n azul")


def test_a_short_one_is_refused_and_the_earlier_one_stays(data: Path, clock: _Clock) -> None:
    stored = Passphrase(data, clock)
    stored.set(RIGHT)
    with pytest.raises(StoreError, match="at least 6"):
        stored.set("abc")
    assert stored.check(RIGHT)


def test_wrong_ones_in_a_row_are_followed_by_longer_and_longer_waits(
    data: Path, clock: _Clock
) -> None:
    stored = Passphrase(data, clock)
    stored.set(RIGHT)
    waits = []
    for _ in range(FREE_TRIES + 8):
        assert not stored.check("wrong one")
        waits.append(stored.wait_s)
        clock.now += stored.wait_s
    assert waits == [0, 0, 5, 10, 20, 40, 80, 160, 300, 300, 300]
    assert stored.check(RIGHT), "after the wait the right one is taken"
    assert stored.wait_s == 0


def test_during_the_wait_not_even_the_right_one_is_taken_and_nothing_is_logged(
    data: Path, clock: _Clock
) -> None:
    stored = Passphrase(data, clock)
    stored.set(RIGHT)
    for _ in range(FREE_TRIES):
        stored.check("wrong one")
    assert not stored.check(RIGHT)
    assert len(stored.tries()) == FREE_TRIES


def test_a_restart_of_the_program_does_not_shorten_the_wait(data: Path, clock: _Clock) -> None:
    stored = Passphrase(data, clock)
    stored.set(RIGHT)
    for _ in range(FREE_TRIES):
        stored.check("wrong one")
    assert Passphrase(data, clock).wait_s == stored.wait_s == 5


def test_a_clock_that_is_set_back_does_not_lock_the_therapist_out(
    data: Path, clock: _Clock
) -> None:
    stored = Passphrase(data, clock)
    stored.set(RIGHT)
    for _ in range(FREE_TRIES):
        stored.check("wrong one")
    clock.now -= 1_000_000
    assert stored.check(RIGHT)


def test_every_try_is_logged_with_its_time_and_screen(data: Path, clock: _Clock) -> None:
    stored = Passphrase(data, clock)
    stored.set(RIGHT)
    stored.check("wrong one", "pause")
    stored.check(RIGHT, "patient mode")
    assert [(each.result, each.where, each.seconds) for each in stored.tries()] == [
        ("wrong", "pause", clock.now),
        ("right", "patient mode", clock.now),
    ]


def test_without_a_log_the_waits_are_kept_by_the_program(data: Path, clock: _Clock) -> None:
    stored = Passphrase(data, clock)
    stored.set(RIGHT)
    (data / passphrase.LOG).mkdir()
    for _ in range(FREE_TRIES):
        stored.check("wrong one")
    assert stored.wait_s == 5
    clock.now += 5
    assert stored.check(RIGHT)


@pytest.mark.parametrize(
    "lines", [b"\x00\xff\n{", b'{"at":"no date","result":"wrong"}\n' * 5, b"[]\n"]
)
def test_a_damaged_log_locks_nobody_out(lines: bytes, data: Path, clock: _Clock) -> None:
    stored = Passphrase(data, clock)
    stored.set(RIGHT)
    (data / passphrase.LOG).write_bytes(lines)
    assert stored.check(RIGHT)


@pytest.mark.parametrize("content", [b"", b"{}", b'{"salt":"","key":"","cost":1000000000}'])
def test_a_damaged_passphrase_is_never_right_and_says_what_to_do(
    content: bytes, data: Path, clock: _Clock
) -> None:
    data.mkdir(exist_ok=True)
    (data / passphrase.FILE).write_bytes(content)
    stored = Passphrase(data, clock)
    assert stored.is_set
    with pytest.raises(StoreError, match="sar-tui passphrase"):
        stored.check("")


def test_a_kept_passphrase_guards_on_when_its_file_is_removed(data: Path, clock: _Clock) -> None:
    stored = Passphrase(data, clock)
    stored.set(RIGHT)
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
