"""Ledger of exports: what left, when, and for whom. Append-only."""

import sqlite3
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

import msgspec

from sar_tui.store.database import read_json, transaction


class LedgerEntry(msgspec.Struct, frozen=True, kw_only=True):
    """An export.

    Attributes:
        exported_at: UTC. ``exported_by``: the login name of the user who exported.
        recipient: for whom, in words; empty if it was not said.
        sessions: ids.
        options: what was asked for besides the sessions.
        manifest: SHA-256 of ``sar-tui-export.json``.
    """

    exported_at: str
    exported_by: str
    recipient: str
    format: str
    sessions: list[str]
    options: dict[str, Any]
    manifest: str


def record(
    db: sqlite3.Connection,
    *,
    author: str,
    recipient: str,
    format: str,
    sessions: Sequence[str],
    options: Mapping[str, object],
    manifest: str,
) -> None:
    """Add an export to the ledger. Raises StoreError."""
    with transaction(db) as connection:
        connection.execute(
            "INSERT INTO exports (exported_at, exported_by, recipient, format, sessions, options, manifest)"
            " VALUES (?,?,?,?,?,?,?)",
            (
                datetime.now(UTC).isoformat(), author, recipient, format, msgspec.json.encode(list(sessions)).decode(),
                msgspec.json.encode(dict(options)).decode(), manifest,
            ),
        )  # fmt: skip


def ledger(db: sqlite3.Connection) -> list[LedgerEntry]:
    """Return all exports, the newest first."""
    rows = db.execute(
        "SELECT exported_at, exported_by, recipient, format, sessions, options, manifest FROM "
        "exports"
        " ORDER BY number DESC"
    )
    return [
        LedgerEntry(
            exported_at=at, exported_by=by, recipient=recipient, format=format, sessions=read_json(sessions),
            options=read_json(options), manifest=manifest,
        )
        for at, by, recipient, format, sessions, options, manifest in rows
    ]  # fmt: skip
