"""Parts of actions leave as their outputs did them, from start to end."""

from contextlib import closing
from pathlib import Path
from typing import Any

from sar_tui.store.database import connect
from tests.export.exported import csv_of
from tests.export.varied import store_trials
from tests.store.by_hand import add_message, value

REPORTS: list[tuple[str, str, str, str, int]] = [
    ("a1", "speech", "say", "queued", 10), ("a1", "screen", "show", "queued", 10),
    ("a1", "screen", "show", "started", 20), ("a1", "speech", "say", "started", 30),
    ("a1", "speech", "say", "aborted", 40), ("go-1", "ros://robot.clinic:9090", "tone", "queued", 50),
    ("a1", "speech", "say", "started", 60), ("a1", "speech", "say", "done", 70),
]  # fmt: skip


def test_each_part_of_an_action_and_each_signal_for_cameras_has_its_times(tmp_path: Path) -> None:
    store_trials(tmp_path, [])
    store_reports(tmp_path, REPORTS)
    names = ("action", "output", "deed", "started_ns", "ended_ns", "outcome")
    assert [tuple(row[name] for name in names) for row in csv_of(tmp_path, "outputs")] == [
        ("a1", "speech", "say", 30, 40, "aborted"),
        ("a1", "screen", "show", 20, None, None),
        ("go-1", "ros", "tone", None, None, None),
        ("a1", "speech", "say", 60, 70, "done"),
    ]
    flash = {"what": "flash", "source": "flush"}
    store_messages(tmp_path, "output/sync", [flash | {"at": 5}])
    (row,) = csv_of(tmp_path, "sync_signals")
    assert row == {"session": "s1", "signal": 1, "run": 1, "at_ns": 5, **flash}


def test_what_was_taken_back_leaves_without_the_name_of_who_did_it(tmp_path: Path) -> None:
    store_trials(tmp_path, [])
    answer = {"what": "answer", "number": 3, "actor": "participant", "done": 5, "at": 9}
    level = {"what": "level", "act": "0f", "actor": "operator.ann", "done": 20, "at": 30}
    store_messages(tmp_path, "event_handler/taken_back", [answer, level])
    names = ("act", "run", "done_ns", "at_ns", "what", "number", "taken_back_by")
    assert [tuple(row[name] for name in names) for row in csv_of(tmp_path, "taken_back")] == [
        (1, 1, 5, 9, "answer", 3, "participant"),
        (2, 1, 20, 30, "level", None, "operator"),
    ]


def store_reports(data: Path, reports: list[tuple[str, str, str, str, int]]) -> None:
    names = ("action", "output", "deed", "state", "at")
    store_messages(data, "output/report", [dict(zip(names, each, strict=True)) for each in reports])


def store_messages(data: Path, topic: str, messages: list[dict[str, Any]]) -> None:
    with closing(connect(data)) as database:
        last = value(database, "SELECT coalesce(max(seq), 0) FROM messages")
        for seq, message in enumerate(messages, last + 1):
            add_message(database, "s1", seq, message["at"], topic, message)
