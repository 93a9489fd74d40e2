"""Exports sessions: selects them, and lets a format write them into a folder that is complete or
absent.
"""

import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import msgspec

from sar_tui.drivers.files import unused
from sar_tui.export.contents import Contents
from sar_tui.export.damage import with_any_text
from sar_tui.export.errors import ExportError
from sar_tui.export.methods import FILE as METHODS
from sar_tui.export.methods import methods
from sar_tui.export.passports import FILE as PASSPORTS
from sar_tui.export.passports import Passport, passports
from sar_tui.export.privacy import Privacy
from sar_tui.export.recoding import recoding, shuffled
from sar_tui.export.registry import Format
from sar_tui.export.sites import Part, check_folder, parts, site_target
from sar_tui.export.target import MANIFEST, check, forget_times, sync, target, write_manifest
from sar_tui.store import studies
from sar_tui.store.database import StoreConnection, StoreError
from sar_tui.store.exports import record
from sar_tui.store.selection import Request, Selection, select

if TYPE_CHECKING:
    from sar_tui.plugins import Catalogue


class Exported(msgspec.Struct, frozen=True, kw_only=True):
    """Result of an export.

    Attributes:
        sessions: the ids of those that it holds.
        left_out: columns that did not leave.
        problems: a sentence on each session, or part of one, that it lacks.
        notices: a sentence on each task that cannot be loaded, so that its details are not
            described, and on each person who has withdrawn, and whose data is excluded.
        manifest: SHA-256 of the manifest; of each site's, with spaces between them, in a format for
            many sites.
    """

    folder: str
    format: str
    sessions: list[str]
    left_out: list[str]
    problems: list[str]
    notices: list[str]
    manifest: str


Start = Callable[[int], Callable[[], None]]
"""Called with a number of steps; returns what is called after each."""


class Options(msgspec.Struct, frozen=True, kw_only=True):
    """Choices besides the sessions.

    Attributes:
        with_notes: texts that somebody may have typed leave, too.
        with_events: with a row for each message of the sessions.
        study: name of the study that is exported; of records, only its own leave. Empty: all do.
        recode: the file with random codes and date shifts; None: codes and dates leave as they are.
        recipient: for whom, for the ledger. ``author``: the login name of who exports.
    """

    with_notes: bool = False
    with_events: bool = False
    study: str = ""
    recode: Path | None = None
    recipient: str = ""
    author: str = ""

    @property
    def facts(self) -> dict[str, bool]:
        """The options as the manifest and the ledger have them."""
        return {
            "with_notes": self.with_notes,
            "with_events": self.with_events,
            "recoded": self.recode is not None,
        }


FOLDER = "exports"
"""Folder of the exports, in the data folder, unless another is named."""
_DEFAULTS = Options()
_RUNNING = "A session that runs is left out until it has ended."
_UNRECORDED = "The data folder cannot be written to, so this export is not in its ledger."


def new_folder(data: Path, format: Format, options: Options = _DEFAULTS) -> Path:
    """Return a folder for an export that is in none yet, in a data folder. Its name has the time if
    dates leave.
    """
    ending = "recoded" if options.recode else f"{datetime.now(UTC):%Y%m%dT%H%M%SZ}"
    return unused((data / FOLDER / f"{format.name}-{ending}").absolute())


def export(
    database: sqlite3.Connection,
    data: Path,
    catalogue: "Catalogue",
    request: Request,
    format: Format,
    folder: Path,
    start: Start,
    options: Options = _DEFAULTS,
) -> Exported:
    """Export sessions into a folder, and add that to the ledger.

    Args:
        data: the data folder of the database.
        folder: made, or replaced if it holds an earlier export in the same format.
        start: for a progress bar.

    Raises:
        ExportError: nothing can be exported, or not there.
        StoreError: a session does not exist, or the database cannot be read.
    """
    by_site = getattr(format, "by_site", False)
    folder = folder.resolve()
    if by_site:
        check_folder(folder)
    else:
        check(folder, format.name)
    if options.recode is not None and (
        options.recode.resolve().is_relative_to(folder)
        or any((each / MANIFEST).exists() for each in options.recode.resolve().parents)
    ):
        raise ExportError(
            "The map of codes must not be in a folder that leaves. Name a file outside.",
            bad_input=True,
        )
    written: list[_Written] = []
    with ExitStack() as targets, ExitStack() as snapshot:
        snapshot.enter_context(_snapshot(database))
        chosen = selection = with_any_text(
            database, lambda: select(database, data, request, also_damaged=True)
        )
        _check_not_blind(database, selection)
        recoded = (
            recoding(database, options.recode, selection.participants) if options.recode else None
        )
        if recoded is not None:  # they are in the order in which people came
            selection = msgspec.structs.replace(
                selection, sessions=tuple(shuffled(selection.sessions))
            )
        made = []
        for part in parts(database, selection, folder, recoded) if by_site else [Part(selection)]:
            privacy = Privacy(options.with_notes, recoded, part.of_site)
            measured = passports(part.selection.sessions, with_dates=recoded is None)
            contents = with_any_text(
                database,
                partial(
                    Contents,
                    database,
                    part.selection,
                    privacy,
                    catalogue,
                    measured,
                    with_events=options.with_events,
                    study=options.study,
                ),
            )
            made.append((part, contents, measured))
        advance = start(sum(contents.steps for _, contents, _ in made))
        for part, contents, measured in made:
            place = site_target(folder, part.site) if by_site else target(folder, format.name)
            hidden = targets.enter_context(place)
            format.write(contents, hidden, advance)
            _add_provenance(hidden / part.about, part.selection, measured, contents)
            written.append(_Written(hidden, part, contents))
        snapshot.close()
        manifests = [
            _finish(each, database, format, options, selection.refused) for each in written
        ]
    if recoded is not None:
        forget_times(folder, files=False)  # folders have that of the last name in them
    return Exported(
        folder=str(folder),
        format=format.name,
        sessions=chosen.ids,
        left_out=list(
            dict.fromkeys(column for each in written for column in each.contents.left_out)
        ),
        problems=[
            *selection.refused,
            *dict.fromkeys(
                each.contents.here(problem)
                for each in written
                for problem in each.contents.problems
            ),
            *_unrecorded(database),
        ],
        notices=list(
            dict.fromkeys(
                [
                    *selection.set_aside,
                    *(notice for each in written for notice in each.contents.notices),
                ]
            )
        ),
        manifest=" ".join(manifests),
    )


class _Written(NamedTuple):
    """Contents that are written into a hidden folder."""

    hidden: Path
    part: Part
    contents: Contents


def _check_not_blind(database: sqlite3.Connection, selection: Selection) -> None:
    """Raise StoreError if a session is of a study that is blind still: its settings, and what was
    said in it, tell the condition.
    """
    blind = studies.blind(database)
    for row in selection.sessions:
        study = (row.get("study") or {}).get("study")
        if study in blind:
            raise StoreError(
                f"Session {row['id']} is of the blind study {study}: its settings tell the "
                "condition. `sar-tui study export` writes the results. After the end of the "
                "study, freeze a version with blind = false: sar-tui study amend FILE --reason …",
                bad_input=True,
            )


def _finish(
    written: _Written,
    database: sqlite3.Connection,
    format: Format,
    options: Options,
    refused: Sequence[str],
) -> str:
    """Write the manifest of a folder, and add the export to the ledger. Return the SHA-256 of the
    manifest.
    """
    is_recoded = options.recode is not None
    created = {} if is_recoded else {"created": datetime.now(UTC).isoformat(timespec="seconds")}
    running = [_RUNNING] if is_recoded and refused else refused
    manifest = write_manifest(
        written.hidden,
        written.part.about,
        format=format.name,
        **created,
        options=options.facts,
        sessions=written.contents.sessions,
        left_out=written.contents.left_out,
        notices=written.contents.notices,
        problems=[*running, *dict.fromkeys(written.contents.problems), *_unrecorded(database)],
        **({"replaces": written.part.replaces} if written.part.replaces else {}),
    )
    sync(written.hidden)
    if is_recoded:
        forget_times(written.hidden)
    # before the folder appears: nothing leaves that the ledger does not have
    if isinstance(database, StoreConnection):
        record(
            database,
            author=options.author,
            recipient=options.recipient,
            format=format.name,
            sessions=written.part.selection.ids,
            options=options.facts,
            manifest=manifest,
        )
    return manifest


def _unrecorded(database: sqlite3.Connection) -> list[str]:
    """Return a sentence if the database can only be read: it has no ledger."""
    return [] if isinstance(database, StoreConnection) else [_UNRECORDED]


def _add_provenance(
    folder: Path, selection: Selection, measured: Sequence[Passport], contents: Contents
) -> None:
    """Write the timing of the machines, and the methods in words, beside the data."""
    folder.mkdir(parents=True, exist_ok=True)
    passports = [
        msgspec.structs.replace(each, sessions=contents.measured(each.sessions))
        for each in measured
    ]
    timing = msgspec.json.format(msgspec.json.encode({"passports": passports}))
    (folder / PASSPORTS).write_bytes(timing + b"\n")
    (folder / METHODS).write_text(methods(selection.sessions, measured), encoding="utf-8")


@contextmanager
def _snapshot(database: sqlite3.Connection) -> Iterator[None]:
    """Read the database as it is now, whatever other programs write meanwhile."""
    database.execute("BEGIN")
    try:
        yield
    finally:
        database.execute("ROLLBACK")
        database.text_factory = str  # damaged texts may have changed it
