"""A clinic and homes with data folders of their own, each with its own copy of the letterbox, and a
carrier between the copies that does what synchronisation programs do at their worst.
"""

import random
import shutil
from contextlib import closing
from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from sar_tui.letterbox import identity, letterbox, sealing
from sar_tui.letterbox.exchange import Exchanged, exchange
from sar_tui.letterbox.sealing import Keys, Letter
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import participants, programmes, records
from sar_tui.store.database import connect
from sar_tui.store.passphrase import Passphrase
from sar_tui.store.programmes import Programme
from sar_tui.store.tables import SESSION_TABLES, TABLES

PASSPHRASE = "kornblume"
BEGAN = datetime(2026, 9, 7, 8, 0, tzinfo=UTC)
catalogue = cache(Catalogue)


class Clock:
    """The time of a computer. ``wrong``: by which its clock is ahead of the true time."""

    def __init__(self, now: datetime = BEGAN, wrong: timedelta = timedelta(0)) -> None:
        self.true = now
        self.wrong = wrong

    def __call__(self) -> datetime:
        return self.true + self.wrong


class Computer:
    """A computer with a data folder and a copy of the letterbox."""

    def __init__(self, folder: Path) -> None:
        self.data = folder / "data"
        self.box = folder / "box"
        self.box.mkdir(parents=True)
        self.clock = Clock()

    def exchange(self) -> Exchanged:
        """Take and send letters."""
        return exchange(self.data, self.clock)

    def query(self, sql: str, *values: Any) -> list[tuple[Any, ...]]:
        """Return rows of the database."""
        with closing(connect(self.data)) as db:
            return db.execute(sql, values).fetchall()

    def train(
        self,
        code: str,
        seed: int = 1,
        task: str = "keyboard",
        leave_after: int = 0,
        **settings: Any,
    ) -> str:
        """Play a session by the newest programme, or some attempts of it; return its id."""
        with closing(connect(self.data)) as db:
            saved = programmes.newest(db, code, task)
        plan = make_plan(catalogue(), task, [code], settings, saved=saved, seed=seed)
        return simulate(
            plan,
            PEOPLE["average"],
            self.data,
            catalogue(),
            began=self.clock(),
            leave_after=leave_after,
        )

    def record(self, kind: str, code: str, **values: Any) -> str:
        """Enter a record of a person, and return its id."""
        with closing(connect(self.data)) as db:
            found = records.kind_of(kind)
            return records.add(db, found, code, "", values, now=self.clock()).id


class Clinic(Computer):
    """A clinic with some participants, each with a programme."""

    def __init__(self, folder: Path, *codes: str, name: str = "Bern") -> None:
        super().__init__(folder)
        letterbox.new(self.data, name, self.box)
        Passphrase(self.data).set(PASSPHRASE)
        for code in codes:
            with closing(connect(self.data)) as db:
                participants.add(db, code, self.clock())
            self.save(code, attempts=1, prompts_per_attempt=3, instructions="never")

    def save(self, code: str, task: str = "keyboard", **settings: Any) -> Programme:
        """Save the next version of a programme."""
        with closing(connect(self.data)) as db:
            last = programmes.newest(db, code, task)
            changed = Programme({**last.parameters, **settings})
            return programmes.save(
                db, code, task, changed, after=last.version, author="th", now=self.clock()
            )

    def invite(self, code: str) -> letterbox.Invited:
        """Invite a computer of a person."""
        return letterbox.invite(self.data, code, self.box.parent, now=self.clock())

    def home(self, code: str, folder: Path, box: Path | None = None) -> "Home":
        """Return a home of a person that has joined; by default on the clinic's own letterbox."""
        invited = self.invite(code)
        return Home(folder, code, invited.file.read_bytes(), invited.code, box or self.box)


class Home(Computer):
    """A home that has joined a clinic."""

    def __init__(self, folder: Path, code: str, invitation: bytes, words: str, box: Path) -> None:
        super().__init__(folder)
        self.code = code
        self.box = box
        letterbox.join(self.data, invitation, words, box, now=self.clock())

    def train_today(self, seed: int = 1, **settings: Any) -> str:
        """Play a session of the person who trains here."""
        return self.train(self.code, seed, **settings)


def rows(computer: Computer, code: str) -> dict[str, list[tuple[Any, ...]]]:
    """Return all rows of a person in a database, by table, in an order that does not depend on when
    they were stored; numbers of topics and sessions are replaced by what they stand for.
    """
    found = {}
    with closing(connect(computer.data)) as db:
        mine = f"(SELECT session FROM seats WHERE participant='{code}')"
        for table in ("sessions", *SESSION_TABLES):
            names = ", ".join(f'"{name}"' for name in TABLES[table].names)
            own = "id" if table == "sessions" else "session"
            found[table] = db.execute(
                f"SELECT {names} FROM {table} WHERE {own} IN {mine}"
            ).fetchall()
        found["messages"] = db.execute(
            "SELECT session_numbers.id, seq, run, at_ns, name, fields, message FROM messages JOIN session_numbers"
            f" ON number=session_number JOIN topics ON topics.id=topic WHERE session_numbers.id IN {mine}"
        ).fetchall()
        for table in ("records", "programmes", "people_events"):
            names = ", ".join(f'"{name}"' for name in TABLES[table].names)
            found[table] = db.execute(
                f"SELECT {names} FROM {table} WHERE participant=?", (code,)
            ).fetchall()
    return {table: sorted(each, key=repr) for table, each in found.items()}


class Carrier:
    """Copies files between the copies of a letterbox, with delays, and with what goes wrong.

    Args:
        boxes: the copies.
        seed: of what happens.
        faults: share of the files that are half-written first, doubled as a conflict copy, or lost.
        longest_h: longest delay, in hours.
    """

    def __init__(self, boxes: list[Path], seed: int, faults: float, longest_h: float) -> None:
        self._boxes = boxes
        self._random = random.Random(seed)
        self._faults = faults
        self._longest_h = longest_h
        self._known: dict[tuple[Path, str], tuple[int, int]] = {}
        self._due: list[tuple[datetime, int, Path, Path, str, str]] = []
        self._count = 0
        self.lost = 0
        self.offline: set[Path] = set()

    def carry(self, now: datetime, *, all_of_it: bool = False) -> None:
        """See what is new, and do what is due by now; ``all_of_it``: everything, without faults."""
        self._look(now, all_of_it)
        waiting = []
        for event in sorted(self._due, key=lambda one: one[:2]):
            at, _, source, target, name, how = event
            reachable = not {source, target} & self.offline
            if reachable and (at <= now or all_of_it):
                self._do(source, target, name, "whole" if all_of_it and how == "half" else how)
            else:
                waiting.append(event)
        self._due = waiting

    def _look(self, now: datetime, all_of_it: bool) -> None:
        for box in self._boxes:
            there = {
                path.name: (path.stat().st_size, path.stat().st_mtime_ns)
                for path in box.iterdir()
                if path.is_file() and not path.name.startswith(".")
            }
            for name, facts in there.items():
                if self._known.get((box, name)) != facts:
                    self._known[box, name] = facts
                    for other in self._boxes:
                        if other != box:
                            self._plan(now, box, other, name, all_of_it)
            for key in [key for key in self._known if key[0] == box and key[1] not in there]:
                del self._known[key]
                for other in self._boxes:
                    if other != box:
                        self._add(now, box, other, key[1], "gone")

    def _plan(self, now: datetime, box: Path, other: Path, name: str, all_of_it: bool) -> None:
        luck = self._random.random()
        if all_of_it or luck >= self._faults:
            self._add(now, box, other, name, "whole")
        elif luck < self._faults / 3:
            self.lost += 1
        elif luck < self._faults * 2 / 3:
            self._add(now, box, other, name, "half")
            if self._random.random() < 0.7:  # else it stays cut off
                self._add(now + timedelta(hours=self._longest_h), box, other, name, "whole")
        else:
            self._add(now, box, other, name, "whole")
            self._add(now, box, other, name, "doubled")

    def _add(self, now: datetime, source: Path, target: Path, name: str, how: str) -> None:
        self._count += 1
        delay = timedelta(hours=self._random.uniform(0, self._longest_h))
        self._due.append((now + delay, self._count, source, target, name, how))

    def _do(self, source: Path, target: Path, name: str, how: str) -> None:
        place = target / name
        if how == "gone":
            place.unlink(missing_ok=True)
            self._known.pop((target, name), None)
            return
        if not (source / name).exists():
            return
        if how == "doubled":
            place = target / f"{Path(name).stem}.sync-conflict-20260907-ABCDEF7{Path(name).suffix}"
        content = (source / name).read_bytes()
        place.write_bytes(
            content[: self._random.randrange(len(content))] if how == "half" else content
        )
        facts = place.stat()
        self._known[target, place.name] = (facts.st_size, facts.st_mtime_ns)


def copy_of(computer: Computer, folder: Path) -> Path:
    """Copy a data folder, as a backup of the computer does, and return the copy."""
    return Path(shutil.copytree(computer.data, folder))


def settle(*computers: Computer) -> None:
    """Exchange until nobody has anything to say."""
    for _ in range(6):
        done = [each.exchange() for each in computers]
        if not any(one.taken or one.written for one in done):
            return
    raise AssertionError(done)


def put(clinic: Clinic, writer: Keys, **changes: Any) -> None:
    """Put a letter to the clinic into the letterbox that somebody wrote with their keys."""
    me = identity.require(clinic.data)
    letter = Letter(reader=me.keys.public.seal, number=99, written_at="2026-09-07T08:00:00+00:00")
    sealed = sealing.seal(replace(letter, **changes), writer)
    (clinic.box / f"{random.randbytes(8).hex()}.letter").write_bytes(sealed)
