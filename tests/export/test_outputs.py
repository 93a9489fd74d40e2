"""Parts of actions leave as their outputs did them, from start to end."""

from contextlib import closing
from pathlib import Path
from typing import Any

from sar_tui.store.database import connect
from tests.export.exported import export_csv, read_csv
from tests.export.varied import store_trials
from tests.store.by_hand import add_message

REPORTS: list[tuple[str, str, str, str, int]] = [
    ("a1", "speech", "say", "queued", 10),
    ("a1", "screen", "show", "queued", 10),
    ("a1", "screen", "show", "started", 20),
    ("a1", "speech", "say", "started", 30),
    ("a1", "speech", "say", "aborted", 40),
    ("go-1", "ros://robot.clinic:9090", "tone", "queued", 50),
    ("a1", "speech", "say", "started", 60),
    ("a1", "speech", "say", "done", 70),
]


def test_each_part_of_an_action_has_its_times(tmp_path: Path) -> None:
    store_trials(tmp_path / "data", [])
    store_reports(tmp_path / "data", REPORTS)
    export_csv(tmp_path / "data", tmp_path / "out")
    rows = read_csv(tmp_path / "out", "outputs")
    names = ("action", "output", "deed", "started_ns", "ended_ns", "outcome")
    assert [tuple(row[name] for name in names) for row in rows] == [
        ("a1", "speech", "say", 30, 40, "aborted"),
        ("a1", "screen", "show", 20, None, None),
        ("go-1", "ros", "tone", None, None, None),
        ("a1", "speech", "say", 60, 70, "done"),
    ]


def test_signals_for_cameras_leave(tmp_path: Path) -> None:
    store_trials(tmp_path / "data", [])
    store_messages(
        tmp_path / "data", "output/sync", [{"what": "flash", "at": 5, "source": "flush"}]
    )
    export_csv(tmp_path / "data", tmp_path / "out")
    (row,) = read_csv(tmp_path / "out", "sync_signals")
    assert row == {
        "session": "s1",
        "signal": 1,
        "run": 1,
        "at_ns": 5,
        "what": "flash",
        "source": "flush",
    }


def store_reports(
    data: Path, reports: list[tuple[str, str, str, str, int]], session: str = "s1"
) -> None:
    names = ("action", "output", "deed", "state", "at")
    store_messages(
        data,
        "output/report",
        [dict(zip(names, report, strict=True)) for report in reports],
        session,
    )


def store_messages(
    data: Path, topic: str, messages: list[dict[str, Any]], session: str = "s1"
) -> None:
    with closing(connect(data)) as database:
        (last,) = database.execute("SELECT coalesce(max(seq), 0) FROM messages").fetchone()
        for seq, message in enumerate(messages, last + 1):
            add_message(database, session, seq, message["at"], topic, message)
