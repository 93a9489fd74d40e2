"""Weeks of training at home, over a folder that is synchronised as badly as can be."""

import random
from contextlib import closing
from datetime import timedelta
from pathlib import Path

import pytest

from sar_tui.letterbox import status
from sar_tui.letterbox.correspondents import correspondents
from sar_tui.store.database import connect
from tests.letterbox.household import Carrier, Clinic, Computer, Home, rows

PEOPLE = ("P01", "P02", "P03", "P04", "P05")


@pytest.mark.parametrize(("weeks", "people"), [(1, 2), pytest.param(8, 5, marks=pytest.mark.slow)])
def test_the_clinic_has_what_the_homes_have(weeks: int, people: int, tmp_path: Path) -> None:
    """Each computer has its own copy of the letterbox. A third of all files are half-written for
    days, doubled, or lost on their way; each takes up to three days; one home is offline for half
    the time, and one has a clock that is a year behind.
    """
    luck = random.Random(weeks)
    codes = PEOPLE[:people]
    clinic = Clinic(tmp_path / "clinic", *codes)
    homes = []
    for code in codes:
        home = clinic.home(code, tmp_path / code)
        home.box = tmp_path / code / "box"
        _move_letterbox(home, clinic)
        homes.append(home)
    if people > 2:
        homes[-1].clock.wrong = -timedelta(days=365)
    everybody: list[Computer] = [clinic, *homes]
    carrier = Carrier([one.box for one in everybody], seed=weeks, faults=1 / 3, longest_h=72)
    began = clinic.clock.true
    played, named = dict.fromkeys(codes, 0), 0
    for hour in range(0, weeks * 7 * 24, 6):
        now = began + timedelta(hours=hour)
        for one in everybody:
            one.clock.true = now
        carrier.offline = {homes[0].box} if (hour // (7 * 24)) % 2 == 1 else set()
        carrier.carry(now)
        for home in homes:
            if hour % 24 == 12 and luck.random() < 0.8:
                home.exchange()
                session = home.train_today(seed=luck.randrange(1000))
                played[home.code] += 1
                _check_programme(home, session)
                if luck.random() < 0.3:
                    home.record("adverse-event", home.code, what="tired", severity="mild")
                home.exchange()
        if hour % 24 == 18:
            clinic.exchange()
            named += _check_missing(clinic, homes)
            code = luck.choice(codes)
            if luck.random() < 0.3:
                clinic.save(code, prompts_per_attempt=luck.randrange(2, 6))
            if luck.random() < 0.3:
                clinic.record("message-home", code, text=f"Well done, {hour}")
            clinic.exchange()
    _end(everybody, carrier)
    for home in homes:
        assert rows(clinic, home.code) == rows(home, home.code)
        assert len(rows(clinic, home.code)["sessions"]) == played[home.code]
        orders = [
            one.query(
                "SELECT id FROM sessions JOIN seats ON session=id WHERE participant=? ORDER BY "
                "sessions.rowid",
                home.code,
            )
            for one in (clinic, home)
        ]
        assert orders[0] == orders[1]
    assert _check_missing(clinic, homes) == 0
    assert carrier.lost > 0
    if weeks > 1:
        assert named > 0
    print(
        f"\n{weeks} weeks, {people} people: {sum(played.values())} sessions, {carrier.lost} files "
        f"lost on their way, missing letters named {named} times",
    )


def _move_letterbox(home: Home, clinic: Clinic) -> None:
    """Give a home its own copy of the letterbox."""
    from msgspec.structs import replace

    from sar_tui.letterbox import identity
    from sar_tui.letterbox.folder import make

    make(home.box, home.data)
    me = identity.require(home.data)
    identity.write(home.data, replace(me, folder=str(home.box)))


def _check_programme(home: Home, session: str) -> None:
    """Check that a session ran by the newest version that has arrived."""
    ((newest,),) = home.query("SELECT max(version) FROM programmes WHERE participant=?", home.code)
    ((used,),) = home.query("SELECT programme FROM sessions WHERE id=?", session)
    assert used == newest


def _check_missing(clinic: Clinic, homes: list[Home]) -> int:
    """Check that the clinic names exactly the letters that were written and have not arrived,
    before one that has; return their number.
    """
    with closing(connect(clinic.data)) as db:
        named = {one.participant: set(one.missing) for one in status.homes(db)}
        known = {one.participant: one.id for one in correspondents(db)}
    for home in homes:
        written = {
            number for (number,) in home.query("SELECT number FROM letters WHERE direction='out'")
        }
        arrived = {
            number
            for (number,) in clinic.query(
                "SELECT number FROM letters WHERE direction='in' AND correspondent=?",
                known[home.code],
            )
        }
        before = {number for number in written if number < max(arrived, default=0)}
        assert named[home.code] == before - arrived
    return sum(map(len, named.values()))


def _end(everybody: list[Computer], carrier: Carrier) -> None:
    """Synchronise whole, until nobody has anything to say."""
    carrier.offline = set()
    for _ in range(30):
        for one in everybody:
            one.clock.true += timedelta(days=3)
        done = []
        for one in everybody:
            carrier.carry(one.clock.true, all_of_it=True)
            done.append(one.exchange())
        if not any(one.taken or one.written or one.again for one in done):
            return
    raise AssertionError(done)
