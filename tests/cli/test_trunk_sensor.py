"""Sessions with a sensor on the trunk, from the command line: simulated, replayed, exported,
refused.
"""

import csv
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from statistics import median
from typing import Any

import pytest

Call = Callable[..., Any]


def leans(folder: Path) -> list[float]:
    (file,) = folder.glob("*.db")
    with closing(sqlite3.connect(file)) as database:
        return [
            lean
            for (lean,) in database.execute("SELECT trunk_excursion_deg FROM v_reaches")
            if lean is not None
        ]


def simulate(call: Call, folder: Path, user: str, *more: str) -> None:
    settings = ("--set", "imu_trunk=simulated", "--seed", "5", "--attempts", "4", "--data", folder)
    assert call("simulate reaching --user", user, *settings, *more).code == 0


@pytest.mark.slow
def test_people_who_compensate_lean_farther_and_the_session_replays(
    call: Call, tmp_path: Path
) -> None:
    for user in ("poor", "competent"):
        simulate(call, tmp_path / user, user)
        assert call("replay last --data", tmp_path / user).code == 0
    assert median(leans(tmp_path / "competent")) < 5
    assert 10 < median(leans(tmp_path / "poor")) < 25
    assert len(leans(tmp_path / "poor")) > 2


def test_an_export_tells_the_sensor_on_the_hand_from_that_on_the_trunk(
    call: Call, tmp_path: Path
) -> None:
    simulate(call, tmp_path / "data", "average")
    assert (
        call("export --all --simulated --data", tmp_path / "data", "--to", tmp_path / "csv").code
        == 0
    )
    with (tmp_path / "csv" / "imu_streams.csv").open() as file:
        streams = {row["part"]: row["stream"] for row in csv.DictReader(file)}
    assert sorted(streams) == ["hand", "trunk"]
    with (tmp_path / "csv" / "imu.csv").open() as file:
        assert {row["stream"] for row in csv.DictReader(file)} == set(streams.values())
    assert (
        call(
            "export --all --simulated --format bids --data",
            tmp_path / "data",
            "--to",
            tmp_path / "bids",
        ).code
        == 0
    )
    places = set()
    for channels in (tmp_path / "bids").rglob("*_channels.tsv"):
        rows = csv.DictReader(channels.read_text().splitlines(), delimiter="\t")
        places |= {
            (row["tracked_point"], row["placement"]) for row in rows if row["type"] == "GYRO"
        }
    assert places == {("hand", "back of the hand"), ("trunk", "sternum")}
