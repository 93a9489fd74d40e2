"""Exported tables against what happened: a reader has the files alone, and must come to the same
numbers.

Sessions are simulated and exported as CSV. From the files, and from nothing that the program
computed on the way, results, scores, outcomes, levels, feedback, repetitions and smoothness are
computed again. When prompts were shown and keys pressed is known from the inputs of the session.
"""

import csv
import math
import tempfile
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing
from itertools import pairwise
from pathlib import Path
from statistics import fmean
from typing import Any, NamedTuple

import numpy as np
from msgspec.structs import replace

from sar_tui.export.export import export
from sar_tui.export.registry import load
from sar_tui.model.messages import KeyPressed, Shown
from sar_tui.model.units import MS
from sar_tui.motion.samples import Floats
from sar_tui.reports.intervention import intervention, read
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE, Person
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.store.selection import Request, select
from sar_tui.validation.report import Claim, Conditions, Report, Row

CLOSE_MS = 0.01
"""Largest difference of two times: rounding."""
REACH_MS = 80.0
"""Largest median difference of a reach time, from 1 % of the peak rate, from the time at more than
5 % of it.
"""
SPARC = 0.02
"""Largest median difference of a smoothness from the one computed anew."""
MOST_REPETITIONS = 40
"""The limit of repetitions a day in one of the sessions."""

_HASTY = replace(PEOPLE["competent"], name="hasty", errors=0.3)
"""Fast enough for the goal, and often wrong."""
_ALL = Request(everything=True, simulated=True)


class Tables(NamedTuple):
    """The exported tables that are read, and what is known without them.

    ``pressed``: the time (ns) from a prompt on the screen to the first key after it, by session,
    attempt and trial. ``repetitions``: as the intervention report counts them.
    """

    trials: list[Row]
    attempts: list[Row]
    parameters: dict[tuple[str, str], str]
    samples: dict[str, Floats]
    pressed: dict[tuple[str, str, str], int]
    repetitions: int
    limited: str

    def keyboard(self) -> list[list[Row]]:
        """Return the attempts at the keyboard task, session by session, each in order."""
        found: dict[str, list[Row]] = defaultdict(list)
        for row in self.attempts:
            if row["task"] == "keyboard":
                found[row["session"]].append(row)
        return list(found.values())

    def trials_of(self, attempt: Row) -> list[Row]:
        """Return the trials of an attempt."""
        return [
            row
            for row in self.trials
            if (row["session"], row["attempt"]) == (attempt["session"], attempt["attempt"])
        ]

    def number(self, session: str, parameter: str) -> float:
        """Return a parameter of a session."""
        return float(self.parameters[session, parameter])


def run(conditions: Conditions) -> Report:
    """Return one row for each check: on how many rows of the tables it was tried, and on how many
    it failed.
    """
    with tempfile.TemporaryDirectory(prefix="sar-tui-validate-") as folder:
        tables = _exported(conditions, Path(folder))
    rows = [_checked(check, tables) for check in CHECKS]
    return Report(rows, [], [Claim(row["check"], row["against"]) for row in rows])


class Check(NamedTuple):
    """A sentence about the tables. ``find`` yields for each row that it is tried on what is wrong;
    empty if nothing.
    """

    sentence: str
    find: Callable[[Tables], Iterable[str]]


def _checked(check: Check, tables: Tables) -> Row:
    found = list(check.find(tables))
    wrong = [each for each in found if each]
    more = f"; and {len(wrong) - 3} more" if len(wrong) > 3 else ""
    against = "; ".join(wrong[:3]) + more if found else "there was nothing to try it on"
    return {"check": check.sentence, "tried": len(found), "wrong": len(wrong), "against": against}


# --- sessions, and their files


def _exported(conditions: Conditions, folder: Path) -> Tables:
    catalogue, data = conditions.catalogue, folder / "data"
    planned = _sessions(conditions.seeds[: 1 if conditions.is_quick else 3])
    limited = ""
    for task, person, seed, settings in planned:
        plan = make_plan(catalogue, task, ["SIM"], settings, seed=seed, mode="simulated")
        session = simulate(plan, person, data, catalogue)
        limited = session if "repetitions_a_day" in settings else limited
    with closing(connect(data)) as database:
        export(
            database,
            data,
            catalogue,
            _ALL,
            load("csv"),
            folder / "files",
            lambda steps: lambda: None,
        )
        report = intervention(read(database, data, select(database, data, _ALL), lambda: None))
        pressed = {
            (row["id"], *place): taken
            for row in select(database, data, _ALL).sessions
            for place, taken in _pressed(
                [each.message for each in sessions.history(database, row["id"])]
            )
        }
    files = folder / "files"
    return Tables(
        trials=_rows(files / "trials.csv"),
        attempts=_rows(files / "attempts.csv"),
        parameters={
            (row["session"], row["parameter"]): row["value"]
            for row in _rows(files / "parameters.csv")
        },
        samples=_samples(files / "imu.csv"),
        pressed=pressed,
        repetitions=sum(dose.repetitions for dose in report.dose),
        limited=limited,
    )


def _sessions(seeds: Sequence[int]) -> Iterator[tuple[str, Person, int, dict[str, object]]]:
    """Yield the task, the participant, the seed and the settings of each session."""
    for seed in seeds:
        for person in (*map(PEOPLE.__getitem__, ("poor", "average", "competent")), _HASTY):
            yield "keyboard", person, seed, {"attempts": 8, "practice_attempts": 1}
        yield "keyboard", PEOPLE["average"], seed, {"attempts": 8, "feedback_every": 3}
        yield "reaching", PEOPLE["competent"], seed, {"attempts": 10}
    yield "keyboard", PEOPLE["average"], 1, {"attempts": 8, "repetitions_a_day": MOST_REPETITIONS}


def _rows(file: Path) -> list[Row]:
    with file.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


def _samples(file: Path) -> dict[str, Floats]:
    """Return the samples of each session, an array of shape (n, 4): time in s, angular rate in
    rad/s.
    """
    columns = ("at_ns", "rate_x", "rate_y", "rate_z")
    found: dict[str, list[list[float]]] = defaultdict(list)
    for row in _rows(file):
        found[row["session"]].append([float(row[name]) for name in columns])
    return {session: np.array(rows) * (1e-9, 1.0, 1.0, 1.0) for session, rows in found.items()}


def _pressed(messages: Sequence[Any]) -> Iterator[tuple[tuple[str, str], int]]:
    keys = [each.at for each in messages if isinstance(each, KeyPressed)]
    for each in messages:
        if isinstance(each, Shown) and (after := bisect_right(keys, each.at)) < len(keys):
            yield (str(each.attempt), str(each.trial)), keys[after] - each.at


# --- what a reader computes


def _responses(tables: Tables) -> Iterator[str]:
    for row in tables.trials:
        if row["task"] == "keyboard" and row["reaction_time_ms"]:
            told = float(row["reaction_time_ms"])
            true = tables.pressed[row["session"], row["attempt"], row["trial"]] / MS
            stamped = (int(row["response_ns"]) - int(row["onset_ns"])) / MS
            off = max(abs(told - true), abs(stamped - true))
            yield f"{_trial(row)}: {told - true:+.1f} ms" if off > CLOSE_MS else ""


def _is_counted(row: Row) -> bool:
    return bool(row["correct"] == "true" and row["reaction_time_ms"] and not row["flags"])


def _results(tables: Tables) -> Iterator[str]:
    for attempt in (row for session in tables.keyboard() for row in session):
        times = [
            float(row["reaction_time_ms"]) for row in tables.trials_of(attempt) if _is_counted(row)
        ]
        true = fmean(times) if times else None
        told = float(attempt["metric"]) if attempt["metric"] else None
        same = told == true if told is None or true is None else abs(told - true) <= CLOSE_MS
        yield "" if same else f"{_attempt(attempt)}: {told} instead of {true}"


def _accuracies(tables: Tables) -> Iterator[str]:
    for attempt in (row for session in tables.keyboard() for row in session):
        trials = tables.trials_of(attempt)
        planned = tables.number(attempt["session"], "prompts_per_attempt")
        right = sum(row["correct"] == "true" for row in trials)
        told = (
            int(attempt["correct"]),
            int(attempt["trials"]),
            round(float(attempt["accuracy"]), 9),
        )
        true = (right, len(trials), round(right / len(trials), 9))
        is_whole = len(trials) == planned or attempt["session"] == tables.limited
        yield "" if told == true and is_whole else f"{_attempt(attempt)}: {told} instead of {true}"


def _is_fast(attempt: Row) -> bool:
    return bool(attempt["metric"]) and float(attempt["metric"]) < float(attempt["goal"])


def _is_accurate(tables: Tables, attempt: Row) -> bool:
    return float(attempt["accuracy"]) >= tables.number(attempt["session"], "min_accuracy")


def _outcomes(tables: Tables) -> Iterator[str]:
    for attempt in (row for session in tables.keyboard() for row in session):
        true = "success" if _is_fast(attempt) and _is_accurate(tables, attempt) else "failure"
        yield "" if attempt["outcome"] == true else f"{_attempt(attempt)}: {attempt['outcome']}"


def _hasty(tables: Tables) -> Iterator[str]:
    for attempt in (row for session in tables.keyboard() for row in session):
        if _is_fast(attempt) and not _is_accurate(tables, attempt):
            is_told = attempt["outcome"] == "failure" and attempt["feedback"] in (
                "negative",
                "none",
            )
            yield (
                ""
                if is_told
                else f"{_attempt(attempt)}: {attempt['outcome']}, {attempt['feedback']}"
            )


def _levels(tables: Tables) -> Iterator[str]:
    for attempts in tables.keyboard():
        lowest, highest = (
            tables.number(attempts[0]["session"], name) for name in ("min_level", "max_level")
        )
        for before, after in pairwise(attempts):
            step = (
                0 if before["practice"] == "true" else 1 if before["outcome"] == "success" else -1
            )
            true = max(lowest, min(int(before["level"]) + step, highest))
            yield (
                ""
                if int(after["level"]) == true
                else f"{_attempt(after)}: level {after['level']} instead of {true:g}"
            )


def _feedback(tables: Tables) -> Iterator[str]:
    for attempts in tables.keyboard():
        every, band = (
            tables.number(attempts[0]["session"], name)
            for name in ("feedback_every", "neutral_band")
        )
        scored = [row for row in attempts if row["practice"] == "false"]
        for number, attempt in enumerate(scored, 1):
            is_due = number % every == 0
            if not is_due or every == 1:
                true = _valence(tables, attempt, band) if is_due else "none"
                yield (
                    ""
                    if attempt["feedback"] == true
                    else f"{_attempt(attempt)}: {attempt['feedback']}"
                )


def _valence(tables: Tables, attempt: Row, band: float) -> str:
    if not attempt["metric"] or not _is_accurate(tables, attempt):
        return "negative"
    if abs(float(attempt["metric"]) - float(attempt["goal"])) <= band:
        return "neutral"
    return "positive" if _is_fast(attempt) else "negative"


def _repetitions(tables: Tables) -> Iterator[str]:
    done = sum(row["practice"] == "false" for row in tables.trials)
    yield "" if tables.repetitions == done else f"{tables.repetitions} instead of {done}"


def _limit(tables: Tables) -> Iterator[str]:
    done = sum(row["session"] == tables.limited for row in tables.trials)
    yield "" if done == MOST_REPETITIONS else f"it ended after {done}"


def _reaches(tables: Tables) -> Iterator[tuple[Row, Floats, Floats]]:
    """Yield each reach with the times (s) and the norms of the angular rate (rad/s) from 0.5 s
    before to after it.
    """
    for row in tables.trials:
        if row["task"] == "reaching" and row["details_reach_time_ms"]:
            samples = tables.samples[row["session"]]
            first, last = int(row["onset_ns"]) / 1e9 - 0.5, int(row["response_ns"]) / 1e9 + 0.5
            window = samples[(samples[:, 0] >= first) & (samples[:, 0] <= last)]
            yield row, window[:, 0], np.linalg.norm(window[:, 1:], axis=1)


def _reach_times(tables: Tables) -> Iterator[str]:
    differences = []
    for row, time_s, norm in _reaches(tables):
        moving = time_s[norm > 0.05 * norm.max()]
        differences.append(
            float(row["details_reach_time_ms"]) - float(moving[-1] - moving[0]) * 1000
        )
    yield from _median_within(differences, REACH_MS, "ms")


def _smoothness(tables: Tables) -> Iterator[str]:
    differences = []
    for row, time_s, norm in _reaches(tables):
        onset = int(row["onset_ns"]) / 1e9
        is_out = (time_s >= onset) & (time_s <= onset + float(row["details_out_ms"]) / 1000)
        differences.append(
            float(row["details_sparc_out"]) - sparc(norm[is_out], float(row["details_rate_hz"]))
        )
    yield from _median_within(differences, SPARC, "")


def sparc(speed: Floats, rate_hz: float) -> float:
    """Return the spectral arc length by its definition (Balasubramanian et al. 2015,
    doi:10.1186/s12984-015-0090-9).

    Written anew, so that it shares no line with what it is compared with.
    """
    size = 2 ** (math.ceil(math.log2(len(speed))) + 4)
    frequency = np.arange(size) * rate_hz / size
    amplitude = np.abs(np.fft.fft(speed, size))
    amplitude = (amplitude / amplitude.max())[frequency <= 10.0]
    last = np.flatnonzero(amplitude >= 0.05)[-1]
    return -float(sum(math.hypot(1 / last, step) for step in np.diff(amplitude[: last + 1])))


def _median_within(differences: Sequence[float], most: float, unit: str) -> Iterator[str]:
    if differences:
        median = float(np.median(differences))
        yield (
            "" if abs(median) <= most else f"the median difference is {median:+.3g} {unit}".rstrip()
        )


def _attempt(row: Row) -> str:
    return f"{row['session']}, attempt {row['attempt']}"


def _trial(row: Row) -> str:
    return f"{_attempt(row)}, trial {row['trial']}"


CHECKS = (
    Check("Each reaction time is the time from the prompt on the screen to the key.", _responses),
    Check(
        "Each result is the mean of the attempt's reaction times of right responses without a "
        "flag.",
        _results,
    ),
    Check("Each accuracy is the share of right responses, over all planned prompts.", _accuracies),
    Check("Each outcome follows from result, goal, accuracy and minimum accuracy.", _outcomes),
    Check(
        "An attempt that is fast enough and not accurate enough is a failure, and not praised.",
        _hasty,
    ),
    Check("Each level follows from the outcome before it; practice changes none.", _levels),
    Check("Feedback follows from result, goal and accuracy, and comes when it is due.", _feedback),
    Check(
        "The intervention report counts each prompt and reach once, without practice.", _repetitions
    ),
    Check(
        f"A limit of {MOST_REPETITIONS} repetitions a day ends a session after as many rows.",
        _limit,
    ),
    Check(
        f"Reach times are those in the samples (median difference within {REACH_MS:g} ms).",
        _reach_times,
    ),
    Check(
        f"SPARC computed anew from the samples is the same (median difference within {SPARC:g}).",
        _smoothness,
    ),
)
"""In the order in which they are printed."""
