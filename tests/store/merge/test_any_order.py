"""Databases of several sites, some merged from others, hold the same once each got all, whatever
the order.
"""

import random
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.examples import examples
from tests.store.by_hand import insert, sql
from tests.store.merge.sites import change, copy, go_on, holds, merge, play, save_programme, site

SITES = ("BERN", "BASEL", "CHUR")
_STATES = ("interrupted", "running", "dismissed", "completed", "aborted")
_PAIRS = ("P01@BERN=P01@BASEL", "P02@CHUR=P01@BASEL", "P02@BERN=P02@BASEL")


class World:
    """Sites that record, take copies of their databases, and merge copies of others."""

    def __init__(self, folder: Path, random: random.Random) -> None:
        self.folder = folder
        self.random = random
        self.sites = {code: site(folder / code, code) for code in SITES}
        self.copies: list[tuple[str, Path]] = []
        self._sessions: dict[Path, list[str]] = {}
        self._number = 0

    def act(self) -> None:
        code = self.random.choice(SITES)
        acts = (self.play, self.play, self.go_on, self.dismiss, self.programme, self.record, self.edit, self.take_copy,
                self.take_copy, self.merge)  # fmt: skip
        self.random.choice(acts)(code)

    def copies_of(self, code: str) -> list[Path]:
        return [path for of, path in self.copies if of == code]

    def person(self) -> str:
        return f"P0{self.random.randint(1, 2)}"

    def play(self, code: str) -> None:
        self._number += 1
        id = f"{self._number:010x}"
        began = f"2026-03-{self.random.randint(1, 28):02}T10:00:00+00:00"
        given = {"status": self.random.choice(_STATES), "began": began}
        mode, trials = self.random.choice(("live", "live", "simulated")), self.random.randint(0, 2)
        play(self.sites[code], id, self.person(), trials=trials, mode=mode, **given)
        self._sessions.setdefault(self.sites[code], []).append(id)

    def go_on(self, code: str) -> None:
        """Let a session go on, sometimes in a copy, so that there are two records of it."""
        if found := self._sessions.get(self.sites[code]):
            query = "SELECT 1 FROM sessions WHERE id=?"
            places = [path for path in self.copies_of(code) if sql(path, query, found[-1])]
            place = self.random.choice([self.sites[code], self.sites[code], *places])
            response, status = self.random.choice("fj"), self.random.choice(_STATES)
            go_on(place, found[-1], response=response, status=status)

    def dismiss(self, code: str) -> None:
        if found := self._sessions.get(self.sites[code]):
            dismiss = "UPDATE sessions SET status='dismissed' WHERE id=? AND status<>'completed'"
            change(self.sites[code], dismiss, found[-1])

    def programme(self, code: str) -> None:
        version, attempts = self.random.randint(1, 2), self.random.randint(1, 3)
        place = self.random.choice([self.sites[code], *self.copies_of(code)])
        change(place, "DELETE FROM programmes WHERE participant='P01' AND version=?", version)
        save_programme(place, "P01", version, f'{{"attempts":{attempts}}}', f"2026-0{attempts}-01")

    def record(self, code: str) -> None:
        self._number += 1
        place, at = self.sites[code], f"2026-04-01T{self._number:06}"
        records = (
            (f"{self._number:06}", 1, "pain"),
            ("abc", 1, "adverse-event"),
            ("abc", 2, "adverse-event"),
        )
        given, stamps = {"participant": self.person()}, {"at": at, "recorded_at": at}
        for id, version, kind in records:
            if not sql(place, "SELECT 1 FROM records WHERE (id, version)=(?,?)", id, version):
                insert(place, "records", id=id, version=version, kind=kind, **given, **stamps)
        export = {"format": "csv", "sessions": "[]", "options": "{}", "site": ""}
        insert(place, "exports", number=None, exported_at=at, **export)

    def edit(self, code: str) -> None:
        if places := self.copies_of(code):
            place = self.random.choice(places)
            change(place, "UPDATE trials SET correct=0 WHERE trial=1 AND run=1")

    def take_copy(self, code: str) -> None:
        self.copies.append((code, copy(self.sites[code], self.folder / f"copy-{len(self.copies)}")))

    def merge(self, code: str) -> None:
        others = [path for of, path in self.copies if of != code]
        if others:
            pair = [self.random.choice(_PAIRS)] if self.random.random() < 0.3 else []
            merge(self.sites[code], self.random.choice(others), same=tuple(pair))


@pytest.fixture(autouse=True)
def _no_backups(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make no backups, which other tests look at, and look for no flaws: it takes most of the
    time.
    """
    monkeypatch.setattr("sar_tui.store.merge.merge.back_up", lambda folder, path: None)
    monkeypatch.setattr("sar_tui.store.merge.source.flaws", lambda database, *, gaps: ())


@pytest.mark.slow
@given(seed=st.integers(0, 2**32))
@examples(20)
def test_the_order_of_merges_makes_no_difference(seed: int) -> None:
    with TemporaryDirectory() as place:
        world = World(Path(place), random.Random(seed))
        for _ in range(14):
            world.act()
        for code in SITES:
            world.take_copy(code)
        several = {code: copy(world.sites[code], Path(place) / f"{code}-2") for code in SITES}
        for targets in (world.sites, several):
            for code, folder in targets.items():
                bring_all(world, code, folder)
        first = holds(world.sites[SITES[0]])
        for folder in (*world.sites.values(), *several.values()):
            assert holds(folder) == first
        for code, folder in world.sites.items():
            of, other = world.random.choice(world.copies)
            assert merge(folder, other, one_site=of == code).backup is None
            assert holds(folder) == first


def bring_all(world: World, code: str, folder: Path) -> None:
    """Merge all copies in any order, and some of them twice."""
    others = [*world.copies, *world.random.sample(world.copies, 2)]
    world.random.shuffle(others)
    for of, path in others:
        merge(folder, path, one_site=of == code)
    merge(folder, None, same=_PAIRS)
