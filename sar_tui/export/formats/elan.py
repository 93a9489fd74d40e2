"""A file for ELAN a session, for coding beside a video of it."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec

from sar_tui.drivers.installation import pip_install_extra
from sar_tui.export.contents import Contents
from sar_tui.export.errors import ExportError
from sar_tui.export.session_clock import SessionClock, session_clock

Row = Mapping[str, Any]
POINT_MS = 100
"""Length of what has no duration: ELAN shows no annotation that is shorter than a millisecond."""
_NOT_IN_XML = re.compile("[^\t\n\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_DEEDS = {
    "say": ("final_spoken", "final_text"),
    "show": ("final_text",),
    "gesture": ("final_gesture",),
    "gaze": ("final_gaze",),
    "tone": ("final_tone",),
}
"""Each part of an action, with the columns that say what it was."""
_OWN = {"go": "go signal", "end": "end of the attempt", "cue": "cue"}
"""Meaning of what outputs do without an action of the agent, by the beginning of its id."""


class ElanFormat:
    """Tiers of signals for cameras, attempts and trials, what the agent did, decisions, notes and
    faults.

    Time 0 is when the first run of the session began. Times are rounded to ms.
    """

    name = "elan"
    title = "a file a session for ELAN, to code it beside a video"

    def write(self, contents: Contents, folder: Path, progress: Callable[[], None]) -> None:
        """Write a file for each session. Raises ExportError if pympi is not installed."""
        try:
            import pympi  # noqa: F401
        except ImportError as error:
            raise ExportError(
                "The format elan needs the package pympi-ling. Install it with: "
                f"{pip_install_extra('export')}"
            ) from error
        for table in contents.tables:
            if table.of == "participant":
                for _ in contents.owners(table):
                    progress()
        of_sessions = [table for table in contents.tables if table.of == "session"]
        for session in contents.owners(of_sessions[0]):
            found = _Session(contents, session)
            document(found.tiers(), found.date).to_file(folder / f"session_{session}.eaf")
            if found.unplaced:
                contents.problems.append(
                    f"Session {session}: the start of a run is not stored, and its acts are left "
                    "out "
                    f"({found.unplaced})."
                )
            for _ in of_sessions:
                progress()


class Annotation(msgspec.Struct, frozen=True, order=True):
    """A value from a start to an end, in ms."""

    start: int
    end: int
    value: str


class Tier(msgspec.Struct, frozen=True):
    """A line of annotations.

    Attributes:
        participant: the code of the person it is about; empty if none.
    """

    name: str
    annotations: Sequence[Annotation]
    participant: str = ""


def annotation(start: int, end: int | None, value: str) -> Annotation:
    """Return an annotation. Without an end after its start it is as long as `POINT_MS`."""
    return Annotation(start, end if end is not None and end > start else start + POINT_MS, value)


def document(tiers: Iterable[Tier], date: str) -> Any:
    """Return the document of a session, a ``pympi.Eaf`` of EAF 3.0.

    Args:
        date: with time, ISO 8601.
    """
    from pympi.Elan import Eaf

    made = Eaf(author="sar-tui")
    made.remove_tier("default")
    made.adocument |= {
        "DATE": date,
        "FORMAT": "3.0",
        "VERSION": "3.0",
        "xsi:noNamespaceSchemaLocation": "http://www.mpi.nl/tools/elan/EAFv3.0.xsd",
    }
    made.header = {"MEDIA_FILE": "", "TIME_UNITS": "milliseconds"}
    for tier in tiers:
        for line in _without_overlap(tier):
            made.add_tier(line.name, part=line.participant or None)
            for each in line.annotations:
                made.add_annotation(line.name, each.start, each.end, _text(each.value))
    _sort_time_slots(made)
    made.properties = [("lastUsedAnnotationId", made.maxaid)]
    return made


def _without_overlap(tier: Tier) -> list[Tier]:
    """Return a tier, and others for what overlaps in it, which ELAN does not allow: "notes", "notes
    2", …
    """
    lines: list[list[Annotation]] = [[]]
    for each in sorted(tier.annotations):
        line = next((line for line in lines if not line or line[-1].end <= each.start), None)
        if line is None:
            lines.append(line := [])
        line.append(each)
    return [
        Tier(tier.name if number == 1 else f"{tier.name} {number}", line, tier.participant)
        for number, line in enumerate(lines, 1)
    ]


def _text(value: str) -> str:
    """Return a text that XML can hold: line ends as LF, and a mark for a control character."""
    return _NOT_IN_XML.sub("\ufffd", re.sub("\r\n?", "\n", value))


def _sort_time_slots(document: Any) -> None:
    """Number the time slots by time: pympi writes them by their numbers, EAF wants them in order.

    Each end keeps a slot of its own: annotations that share one move together when it is dragged in
    ELAN.
    """
    ends = sorted(document.timeslots.items(), key=lambda slot: slot[1])
    names = {slot: f"ts{number}" for number, (slot, _) in enumerate(ends, 1)}
    document.timeslots = {names[slot]: time for slot, time in ends}
    for annotations, *_ in document.tiers.values():
        for id, (start, end, *rest) in annotations.items():
            annotations[id] = (names[start], names[end], *rest)


class _Session:
    """The tiers of a session.

    Attributes:
        date: when it began.
        unplaced: number of stamps that have no place on the time line.
    """

    def __init__(self, contents: Contents, session: str) -> None:
        self._contents = contents
        self._id = session
        self._clock: SessionClock = session_clock(contents, session)
        (self._row,) = self._rows("sessions")
        self.date: str = self._row["started_at"] or "1970-01-01T00:00:00+00:00"
        self.unplaced = 0

    def tiers(self) -> Iterator[Tier]:
        """Yield all tiers, those without annotations as well: files of all sessions have the
        same.
        """
        runs = [(row, f"run {row['run']}", row["clock_ns"], None) for row in self._rows("runs")]
        signals = [
            (row, row["what"] or "signal", row["at_ns"], None) for row in self._rows("sync_signals")
        ]
        yield Tier("session", self._placed([*runs, *signals]))
        seats = {"A": self._row["participant"], "B": self._row["partner"]}
        trials, answers = self._rows("trials"), self._rows("answers")
        for seat, code in seats.items():
            if seat == "A" or code:
                own = [row for row in trials if row["seat"] == seat]
                yield Tier(f"{seat} attempts", self._attempts(seat), code or "")
                yield Tier(
                    f"{seat} trials",
                    self._placed((row, _trial(row), *_times(row)) for row in own),
                    code or "",
                )
            if asked := [row for row in answers if row["seat"] == seat]:
                told = ((row, _answer(row), row["shown_ns"], row["answered_ns"]) for row in asked)
                yield Tier(f"{seat} questions", self._placed(told), code or "")
        yield from self._agent()
        yield Tier("operator", self._decisions())
        yield Tier(
            "notes",
            self._placed((row, _note(row), row["at_ns"], None) for row in self._rows("notes")),
        )
        if faults := self._rows("sensor_faults"):
            yield Tier(
                "sensors", self._placed((row, _fault(row), row["at_ns"], None) for row in faults)
            )

    def _rows(self, name: str) -> list[dict[str, Any]]:
        (table,) = (table for table in self._contents.tables if table.name == name)
        names = [column.name for column in table.columns]
        return [dict(zip(names, row, strict=True)) for row in self._contents.rows(table, self._id)]

    def _placed(self, acts: Any) -> list[Annotation]:
        """Return annotations.

        Args:
            acts: the row with the run, the value, start and end in ns, each None if missing.
        """
        found = []
        for row, value, start, end in acts:
            if start is None:
                continue
            began = self._clock.milliseconds(row["run"], start)
            if began is None:
                self.unplaced += 1
            else:
                found.append(annotation(began, self._clock.milliseconds(row["run"], end), value))
        return found

    def _attempts(self, seat: str) -> list[Annotation]:
        found = []
        for row in self._rows("attempts"):
            if row["seat"] != seat or row["started_ns"] is None:
                continue
            start = self._clock.milliseconds(row["started_run"], row["started_ns"])
            if start is None:
                self.unplaced += 1
            else:
                found.append(
                    annotation(
                        start, self._clock.milliseconds(row["run"], row["ended_ns"]), _attempt(row)
                    )
                )
        return found

    def _agent(self) -> Iterator[Tier]:
        actions = {row["action"]: row for row in self._rows("actions")}
        outputs = [row for row in self._rows("outputs") if row["started_ns"] is not None]
        _end_gazes(outputs)
        for deed, columns in _DEEDS.items():
            yield Tier(
                f"agent {deed}",
                self._placed(
                    (row, _act(row["action"], actions, columns), row["started_ns"], row["ended_ns"])
                    for row in outputs
                    if row["deed"] == deed
                ),
            )

    def _decisions(self) -> list[Annotation]:
        """Return what operators decided, each from when they could see it."""
        return self._placed(
            (
                row,
                f"{row['decision'] or 'undecided'}: {row['kind']}",
                row["decided_ns"] if row["shown_ns"] is None else row["shown_ns"],
                row["decided_ns"],
            )
            for row in self._rows("actions")
            if row["decided_by"] == "operator"
        )


def _end_gazes(outputs: list[dict[str, Any]]) -> None:
    """Let each gaze without an end last until the next one of its run."""
    gazes = [row for row in outputs if row["deed"] == "gaze"]
    for row, following in pairwise(gazes):
        if row["ended_ns"] is None and row["run"] == following["run"]:
            row["ended_ns"] = following["started_ns"]


def _times(trial: Row) -> tuple[int | None, int | None]:
    onset, response = trial["onset_ns"], trial["response_ns"]
    return (response, None) if onset is None else (onset, response)


def _trial(row: Row) -> str:
    missed = row["response"] is None and row["response_ns"] is None
    said = f"{row['stimulus'] or ''} → {'no response' if missed else row['response'] or ''}"
    if not missed and row["correct"] is False:
        said += ", wrong"
    return f"{said} [{row['flags']}]" if row["flags"] else said


def _answer(row: Row) -> str:
    """Return a question, or another step, and its answer; words that were typed only if they
    leave.
    """
    given = next(
        (row[name] for name in ("value", "chosen", "words") if row.get(name) is not None), None
    )
    said = row["status"] if given is None else f"{given:g}" if isinstance(given, float) else given
    return f"{row['step']}: {said}"


def _attempt(row: Row) -> str:
    parts = [f"attempt {row['attempt']}", f"level {row['level']}"]
    if row["practice"]:
        parts.append("practice")
    if row["outcome"]:
        parts.append(row["outcome"])
    return ", ".join(parts)


def _act(action: str | None, actions: Mapping[str, Row], columns: tuple[str, ...]) -> str:
    """Return the kind of an act, and what it was if that leaves."""
    row = actions.get(action or "")
    if row is None:
        return _OWN.get((action or "").partition("-")[0], "")
    found = next(filter(None, (row.get(column) for column in columns)), None)
    return f"{row['kind']}: {found}" if found else str(row["kind"])


def _note(row: Row) -> str:
    said = ": ".join(filter(None, (row.get("label"), row.get("text"))))
    return f"{row['written_by'] or 'other'}: {said or 'note'}"


def _fault(row: Row) -> str:
    parts = [row["state"]]
    if row["samples"]:
        parts.append(f"{row['samples']} samples")
    if row["duration_ms"]:
        parts.append(f"{row['duration_ms']:g} ms")
    return ", ".join(parts)
