"""Sessions with a sensor on the trunk, from the command line: simulated, replayed, exported,
refused.
"""

import csv
import sqlite3
from contextlib import closing
from pathlib import Path
from statistics import median

import pytest

from tests.program import Call


def leans(folder: Path) -> list[float]:
    (file,) = folder.glob("*.db")
    query = "SELECT trunk_excursion_deg FROM v_reaches WHERE trunk_excursion_deg IS NOT NULL"
    with closing(sqlite3.connect(file)) as database:
        return [lean for (lean,) in database.execute(query)]


def simulate(call: Call, folder: Path, user: str) -> None:
    settings = f"--set imu_trunk=simulated --seed 5 --attempts 4 --data {folder}"
    assert call(f"simulate reaching --user {user} {settings}").code == 0


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
    for kind in ("csv", "bids"):
        export = f"export --all --simulated --data {tmp_path}/data --format {kind} --to"
        assert call(export, tmp_path / kind).code == 0
    with (tmp_path / "csv" / "imu_streams.csv").open() as file:
        streams = {row["part"]: row["stream"] for row in csv.DictReader(file)}
    assert sorted(streams) == ["hand", "trunk"]
    with (tmp_path / "csv" / "imu.csv").open() as file:
        assert {row["stream"] for row in csv.DictReader(file)} == set(streams.values())
    places = set()
    for channels in (tmp_path / "bids").rglob("*_channels.tsv"):
        for row in csv.DictReader(channels.read_text().splitlines(), delimiter="\t"):
            if row["type"] == "GYRO":
                places.add((row["tracked_point"], row["placement"]))
    assert places == {("hand", "back of the hand"), ("trunk", "sternum")}
