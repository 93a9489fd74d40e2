"""Programmes: settings as versions. None is ever overwritten, and none is lost."""

import subprocess
import sys
from contextlib import closing
from pathlib import Path
from sqlite3 import Connection
from typing import Any

import pytest

from sar_tui.store.database import StoreError, connect
from sar_tui.store.programmes import Programme, Superseded, find, newest, save, tasks, versions
from tests.store.by_hand import sql


def saved(
    database: Connection, after: int, author: str = "", reason: str = "", **parameters: Any
) -> Programme:
    changed = Programme(parameters)
    return save(database, "P07", "keyboard", changed, after=after, author=author, reason=reason)


def test_a_participant_without_a_programme_has_the_defaults(database: Connection) -> None:
    assert newest(database, "P07", "keyboard") == Programme({}, "calm", 0)
    assert versions(database, "P07", "keyboard") == []
    assert tasks(database, "P07") == []


def test_each_version_keeps_who_changed_it_when_and_why(database: Connection, data: Path) -> None:
    first = saved(database, 0, "ana", "Start", attempts=5, levels=["fj", "dfjk"], threshold=850.5)
    second = saved(database, 1, "ben", "Goal reached four times", attempts=5, threshold=800.0)
    with closing(connect(data)) as again:
        assert versions(again, "P07", "keyboard") == [first, second]
        assert newest(again, "P07", "keyboard") == second
        assert find(again, "P07", "keyboard", 1) == first
        assert tasks(again, "P07") == ["keyboard"]
    assert (first.version, first.author, first.reason) == (1, "ana", "Start")
    assert (second.version, second.author, second.reason) == (2, "ben", "Goal reached four times")
    assert second.created_at >= first.created_at > "2000"
    assert saved(database, 2, "eva", attempts=5, threshold=800.0) == second, "nothing changed"
    assert versions(database, "P07", "keyboard") == [first, second]
    assert newest(database, "P08", "keyboard") == newest(database, "P07", "reaching") == Programme()


def test_the_second_of_two_therapists_overwrites_nothing(database: Connection, data: Path) -> None:
    saved(database, 0, attempts=5)
    with closing(connect(data)) as other:
        theirs = saved(other, 1, "ben", "Tired", attempts=3)
    with pytest.raises(Superseded) as caught:
        saved(database, 1, "ana", attempts=9)
    assert str(caught.value) == (
        "The programme of P07 was changed meanwhile: version 2 (ben: Tired). Nothing was saved."
    )
    assert caught.value.newest == newest(database, "P07", "keyboard") == theirs


def test_a_version_that_does_not_exist_is_named(database: Connection) -> None:
    with pytest.raises(StoreError, match="The programme of P07 for keyboard has no version 4"):
        find(database, "P07", "keyboard", 4)


SAVER = """
import sys
from pathlib import Path
from sar_tui.store.database import connect
from sar_tui.store.programmes import Programme, save
database = connect(Path(sys.argv[1]))
for version in range(1_000_000):
    save(database, "P07", "keyboard", Programme({"attempts": version + 1}), after=version, author="ana", reason="more")
    print(version + 1, flush=True)
"""


def test_a_kill_while_saving_loses_no_version_that_was_saved(data: Path) -> None:
    command = [sys.executable, "-c", SAVER, str(data)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as saver:
        assert saver.stdout
        for _ in range(7):
            saver.stdout.readline()
        saver.kill()
        told = [7, *map(int, saver.stdout.read().split())][-1]
    with closing(connect(data)) as database:
        assert sql(database, "PRAGMA integrity_check") == [("ok",)]
        kept = versions(database, "P07", "keyboard")
    assert told <= len(kept) <= told + 1
    for number, each in enumerate(kept, 1):
        assert (each.version, each.parameters, each.reason) == (
            number,
            {"attempts": number},
            "more",
        )
