"""``sar-tui reanalyse``: finds the reaches of a recorded session again in its stored samples."""

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from sar_tui.cli.common import AsJson, Home, RecordedSession, console, print_json
from sar_tui.cli.detect import explain_flags
from sar_tui.cli.errors import Refused
from sar_tui.cli.progress_line import progress_line
from sar_tui.motion.detector_names import COLUMN_NAMES, DetectorName

if TYPE_CHECKING:
    import sqlite3

    from sar_tui.motion.analysis import AnalysisParameters, Window
    from sar_tui.motion.samples import Samples

Row = dict[str, Any]
_WINDOW = (
    "window_from_ns",
    "window_started_ns",
    "window_to_ns",
    "detector",
    "detector_parameters",
    "hand",
)


class _StoredSamples(NamedTuple):
    """The samples of a session, in order with its events by their sequence numbers.

    ``blocks``: the event that each block came before, and its samples. ``attached``: the events at
    which a sensor was attached. ``ended``: the event that ended each attempt's trial.
    """

    blocks: "list[tuple[int, Samples]]"
    attached: list[int]
    ended: dict[tuple[int, int], int]

    @classmethod
    def of(cls, database: "sqlite3.Connection", session: str) -> "_StoredSamples":
        """Read them. Raises StoreError if samples are damaged."""
        from sar_tui.loop.topics import IMU, SENSOR, TRIAL
        from sar_tui.model.messages import ImuBlock
        from sar_tui.motion.samples import unpack
        from sar_tui.store import imu

        blocks = [
            (record.seq, unpack(record.message.samples))
            for record in imu.blocks(database, session)
            if record.topic is IMU and isinstance(record.message, ImuBlock)
        ]
        attached = [
            seq
            for seq, message in _events(database, session, SENSOR.name)
            if message["state"] == "attached"
        ]
        trials = _events(database, session, TRIAL.name)
        return cls(
            blocks,
            attached,
            {(message["attempt"], message["trial"]): seq for seq, message in trials},
        )

    def before(self, row: Row, window: "Window") -> "Samples":
        """Return the samples of a window that perception had: from the last attachment until the
        trial ended.

        Older samples may have been dropped before the reach began, so the newest are taken, up to
        their stored number.
        """
        from sar_tui.motion.samples import join

        ended = self.ended.get((row["attempt"], row["trial"]), 0)
        attached = max((seq for seq in self.attached if seq < ended), default=-1)
        parts = []
        for seq, samples in self.blocks:
            if (
                attached < seq <= ended
                and samples["at"][-1] >= window.from_ns
                and samples["at"][0] < window.to_ns
            ):
                parts.append(
                    samples[(samples["at"] >= window.from_ns) & (samples["at"] < window.to_ns)]
                )
        whole = join(parts)
        seen = row["details"].get("samples") or 0
        newest: Samples = whole[max(0, len(whole) - seen) :]
        return newest


def _events(database: "sqlite3.Connection", session: str, topic: str) -> Iterator[tuple[int, Row]]:
    from sar_tui.store.database import read_json

    for seq, message in database.execute(
        "SELECT seq, message FROM events WHERE session=? AND topic=? ORDER BY seq", (session, topic)
    ):
        yield seq, read_json(message)


class _Trial(NamedTuple):
    """A recorded trial, and how to analyse it."""

    row: Row
    window: "Window"
    parameters: "AnalysisParameters"


def reanalyse(
    home: Home,
    session: RecordedSession,
    detector: Annotated[
        DetectorName | None,
        typer.Option(
            show_default=False,
            help="Detector to use, with its default parameters. Default: the session's.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Find the reaches of a session again, in its stored samples.

    The record is not changed.
    """
    from sar_tui.store import sessions as store

    with home.session(session) as (database, found):
        stored_trials = [
            row for row in store.rows(database, "trials", found["id"]) if _has_window(row)
        ]
        if any(row["seat"] != "A" for row in store.rows(database, "trials", found["id"])):
            raise Refused(
                f"The session {found['id']} ({found['task']}) has two participants. Their reaches "
                "cannot be found "
                "again: the samples are stored, but not which sensor each reach came from."
            )
        if not stored_trials:
            raise Refused(
                f"The session {found['id']} ({found['task']}) has no reach that can be found "
                "again: "
                "none of its trials has samples of a motion sensor."
            )
        measured = _StoredSamples.of(database, found["id"])
        least_confidence = found["parameters"].get("least_confidence", 0.0)
    rows: list[Row] = []
    with progress_line("Analysing") as show:
        for row in stored_trials:
            show("Analysing", len(rows), len(stored_trials))
            rows.append(_reanalyse(measured, _trial(row, detector, least_confidence)))
    if as_json:
        names = dict.fromkeys(row["details"]["detector"] for row in rows)
        print_json({"session": found["id"], "detector": ", ".join(names), "trials": rows})
    else:
        _print(rows, [row["details"] for row in stored_trials])


def _has_window(row: Row) -> bool:
    return all(row["details"].get(name) is not None for name in _WINDOW)


def _trial(row: Row, detector: DetectorName | None, least_confidence: float) -> _Trial:
    """Return how to analyse a trial: as recorded, or by the given detector. Raises Refused."""
    import msgspec

    from sar_tui.motion.analysis import AnalysisParameters, Window

    details = row["details"]
    name = detector or details["detector"]
    asked = {
        "detector": name,
        "hand": details["hand"],
        "least_confidence": least_confidence,
    }
    try:
        if not detector:
            asked[name.replace("-", "_")] = msgspec.json.decode(details["detector_parameters"])
        parameters = msgspec.convert(asked, AnalysisParameters)
    except msgspec.MsgspecError as error:
        raise Refused(
            f"Attempt {row['attempt']}, trial {row['trial']} was found by the detector {name} "
            "with parameters that "
            f"this version of sar-tui does not know ({error}). Choose a detector with --detector."
        ) from error
    known = tuple(flag for flag in row["timing"]["flags"] if flag in ("saturated", "error"))
    window = Window(
        from_ns=details["window_from_ns"],
        started_ns=details["window_started_ns"],
        to_ns=details["window_to_ns"],
        flags=known,
    )
    return _Trial(row, window, parameters)


def _reanalyse(measured: _StoredSamples, trial: _Trial) -> Row:
    """Return the reach of a trial as found now."""
    from sar_tui.motion.analysis import analyse

    row, window, parameters = trial
    samples = measured.before(row, window)
    finding = analyse(samples, window, parameters)
    recorded, now = row["details"].get("reach_time_ms"), finding.details.get("reach_time_ms")
    was = (row["onset_ns"], row["response_ns"], recorded)
    others = [
        f"{stored}_reach_time_ms"
        for name, stored in COLUMN_NAMES.items()
        if name != parameters.detector
    ]
    return {
        "attempt": row["attempt"],
        "trial": row["trial"],
        "recorded_ms": recorded,
        "reach_time_ms": now,
        "difference_ms": None if recorded is None or now is None else round(now - recorded, 3),
        "equal": recorded is now is None or was == (finding.onset_ns, finding.end_ns, now),
        "missing_samples": max(0, (row["details"].get("samples") or 0) - len(samples)),
        "details": {name: value for name, value in finding.details.items() if name not in others},
        "flags": list(dict.fromkeys(filter(None, (*finding.flags, finding.invalid)))),
    }


def _print(rows: Sequence[Row], recorded: Sequence[Row]) -> None:
    from sar_tui.cli.tables import add, table

    numbers = ("attempt", "trial", "recorded, ms", "now, ms", "difference, ms")
    made = table(*numbers, "flags", right=numbers)
    for row in rows:
        times = (row["recorded_ms"], row["reach_time_ms"])
        shown = [None if value is None else f"{value:.1f}" for value in times]
        change = row["difference_ms"]
        add(
            made,
            row["attempt"],
            row["trial"],
            *shown,
            None
            if change is None
            else "0"
            if change == 0
            else f"{change:+.3g}"
            if abs(change) < 1
            else f"{change:+.1f}",
            ", ".join(row["flags"]),
        )
    out = console()
    out.print(made)
    for line in explain_flags(flag for row in rows for flag in row["flags"]):
        out.print(line, markup=False, soft_wrap=True)
    for row in rows:
        if row["missing_samples"]:
            out.print(
                f"Attempt {row['attempt']}, trial {row['trial']}: {row['missing_samples']} of its "
                "samples "
                "were never stored.",
                soft_wrap=True,
            )
    out.print(_sentence(rows, recorded), markup=False, soft_wrap=True)


def _sentence(rows: Sequence[Row], recorded: Sequence[Row]) -> str:
    equal = sum(row["equal"] for row in rows)
    then, now = _versions(recorded), _versions(row["details"] for row in rows)
    missing = sum(row["recorded_ms"] is not None and row["reach_time_ms"] is None for row in rows)
    return (
        f"{equal} of {len(rows)} {'trial is' if len(rows) == 1 else 'trials are'} exactly as "
        "recorded"
        f"{f', and in {missing} there is no reach now' if missing else ''}. "
        f"Recorded: {then} detector. Now: {now} detector."
    )


def _versions(details: Iterable[Row]) -> str:
    return ", ".join(
        dict.fromkeys(f"{d['detector']} (version {d.get('detector_version')})" for d in details)
    )
