"""``_sessions.tsv`` of each subject, and ``_scans.tsv`` of each session."""

from collections.abc import Iterable
from pathlib import Path

from sar_tui.export.formats.bids.study import Session, Study
from sar_tui.export.formats.bids.tsv import described, write_json, write_rows

_ELSEWHERE = ("session", "participant", "partner", "started_at")
_ACQ_TIME = "acq_time"


def write_sessions(study: Study, folder: Path) -> None:
    """Write the sessions of each subject, and what their columns mean."""
    columns = {
        column.name: column for column in study.columns("sessions") if column.name not in _ELSEWHERE
    }
    sessions: dict[str, list[Session]] = {}
    for session in study.sessions:
        sessions.setdefault(session.subject, []).append(session)
    for subject, own in sessions.items():
        rows = (
            (
                f"ses-{session.label}",
                session.row["started_at"],
                session.seat,
                f"sub-{session.partner}" if session.partner else None,
                *(session.row[name] for name in columns),
            )
            for session in own
        )
        path = folder / f"sub-{subject}" / f"sub-{subject}_sessions.tsv"
        path.parent.mkdir(exist_ok=True)
        write_rows(path, ("session_id", _ACQ_TIME, "seat", "partner", *columns), rows)
    added = {
        _ACQ_TIME: {"Description": "When the session began, UTC."},
        "seat": {"Description": "The participant's place: A, or B in a task for two."},
        "partner": {"Description": "The other participant, in a task for two."},
    }
    write_json(folder / "sessions.json", {**added, **described(columns.values())})


def write_scans(
    session: Session, recordings: Iterable[tuple[str, str | None]], folder: Path
) -> None:
    """Write the recordings of a session, each with the time of day of its zero.

    Args:
        folder: of the session.
    """
    write_rows(folder / f"{session.stem}_scans.tsv", ("filename", _ACQ_TIME), recordings)


def describe_scans(folder: Path) -> None:
    """Write what the columns of recordings mean."""
    meaning = "The time of day of the recording's zero, UTC."
    write_json(folder / "scans.json", {_ACQ_TIME: {"Description": meaning}})
