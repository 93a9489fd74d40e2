"""A reader who has only the exported tables comes to the same numbers as the program.

Results, outcomes, levels, feedback, repetitions and smoothness are computed again from the CSV
files of simulated sessions. When prompts were shown and keys pressed is known from the sessions.
"""

import csv
import math
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterator
from contextlib import closing
from itertools import pairwise
from pathlib import Path
from statistics import fmean
from typing import Any, NamedTuple

import numpy as np
import pytest
from msgspec.structs import replace

from sar_tui.export.export import export
from sar_tui.export.registry import load
from sar_tui.loop.bus import Record
from sar_tui.model.messages import KeyPressed, Shown
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.samples import Floats
from sar_tui.plugins import Catalogue
from sar_tui.reports.intervention import intervention, read
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE, Person
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.store.selection import Request, select

MOST_REPETITIONS = 40
"""The limit of repetitions a day in one of the sessions."""
HASTY = replace(PEOPLE["competent"], name="hasty", errors=0.3)
"""Fast enough for the goal, and often wrong."""
SESSIONS: list[tuple[str, Person, dict[str, object]]] = [
    ("keyboard", PEOPLE["poor"], {"attempts": 8, "practice_attempts": 1}),
    ("keyboard", PEOPLE["average"], {"attempts": 8, "practice_attempts": 1}),
    ("keyboard", PEOPLE["competent"], {"attempts": 8, "practice_attempts": 1}),
    ("keyboard", HASTY, {"attempts": 8, "practice_attempts": 1}),
    ("keyboard", PEOPLE["average"], {"attempts": 8, "feedback_every": 3}),
    ("keyboard", PEOPLE["average"], {"attempts": 8, "repetitions_a_day": MOST_REPETITIONS}),
    ("reaching", PEOPLE["competent"], {"attempts": 10}),
]

Row = dict[str, str]


class Tables(NamedTuple):
    """The exported tables, and facts that are known without them.

    ``pressed_after_ms``: time from a prompt on the screen to the first key after it, by session,
    attempt and trial. ``repetitions``: as the intervention report counts them.
    """

    trials: list[Row]
    attempts: list[Row]
    parameters: dict[tuple[str, str], str]
    samples: dict[str, Floats]
    pressed_after_ms: dict[tuple[str, str, str], float]
    repetitions: int

    def keyboard_attempts(self) -> list[Row]:
        return [row for row in self.attempts if row["task"] == "keyboard"]

    def keyboard_sessions(self) -> list[list[Row]]:
        """Return the attempts at the keyboard task, session by session, each in order."""
        found: dict[str, list[Row]] = defaultdict(list)
        for row in self.keyboard_attempts():
            found[row["session"]].append(row)
        return list(found.values())

    def trials_of(self, attempt: Row) -> list[Row]:
        place = attempt["session"], attempt["attempt"]
        return [row for row in self.trials if (row["session"], row["attempt"]) == place]

    def number(self, row: Row, parameter: str) -> float:
        """Return a parameter of the row's session."""
        return float(self.parameters[row["session"], parameter])

    def is_fast(self, attempt: Row) -> bool:
        return bool(attempt["metric"]) and float(attempt["metric"]) < float(attempt["goal"])

    def is_accurate(self, attempt: Row) -> bool:
        return float(attempt["accuracy"]) >= self.number(attempt, "min_accuracy")

    def reaches(self) -> Iterator[tuple[Row, Floats, Floats]]:
        """Yield each reach with the times (s) and the norms of the angular rate (rad/s) from
        0.5 s before to after it.
        """
        for row in self.trials:
            if row["task"] == "reaching" and row["details_reach_time_ms"]:
                samples = self.samples[row["session"]]
                first_s = int(row["onset_ns"]) / SECOND - 0.5
                last_s = int(row["response_ns"]) / SECOND + 0.5
                window = samples[(samples[:, 0] >= first_s) & (samples[:, 0] <= last_s)]
                yield row, window[:, 0], np.linalg.norm(window[:, 1:], axis=1)


@pytest.fixture(scope="module")
def tables(tmp_path_factory: pytest.TempPathFactory, catalogue: Catalogue) -> Tables:
    """Simulate the sessions, export them all, and read the files."""
    folder = tmp_path_factory.mktemp("exported")
    data, files = folder / "data", folder / "files"
    for task, person, settings in SESSIONS:
        plan = make_plan(catalogue, task, ["SIM"], settings, seed=1, mode="simulated")
        simulate(plan, person, data, catalogue)
    everything = Request(everything=True, simulated=True)
    with closing(connect(data)) as database:
        export(database, data, catalogue, everything, load("csv"), files, lambda _: lambda: None)
        chosen = select(database, data, everything)
        report = intervention(read(database, data, chosen, lambda: None))
        pressed_after_ms = {
            (row["id"], *place): after_ms
            for row in chosen.sessions
            for place, after_ms in first_presses(sessions.history(database, row["id"]))
        }
    return Tables(
        trials=rows_of(files / "trials.csv"),
        attempts=rows_of(files / "attempts.csv"),
        parameters={
            (row["session"], row["parameter"]): row["value"]
            for row in rows_of(files / "parameters.csv")
        },
        samples=samples_of(files / "imu.csv"),
        pressed_after_ms=pressed_after_ms,
        repetitions=sum(dose.repetitions for dose in report.dose),
    )


def rows_of(file: Path) -> list[Row]:
    with file.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


def samples_of(file: Path) -> dict[str, Floats]:
    """Return the samples of each session, an array of shape (n, 4): time in s, angular rate in
    rad/s.
    """
    found: dict[str, list[list[float]]] = defaultdict(list)
    for row in rows_of(file):
        rate = [float(row[name]) for name in ("rate_x", "rate_y", "rate_z")]
        found[row["session"]].append([float(row["at_ns"]) / SECOND, *rate])
    return {session: np.array(rows) for session, rows in found.items()}


def first_presses(history: Iterator[Record]) -> Iterator[tuple[tuple[str, str], float]]:
    """Yield attempt and trial of each prompt with the time (ms) to the first key after it."""
    messages = [record.message for record in history]
    pressed = [each.at for each in messages if isinstance(each, KeyPressed)]
    for each in messages:
        if isinstance(each, Shown) and (after := bisect_right(pressed, each.at)) < len(pressed):
            yield (str(each.attempt), str(each.trial)), (pressed[after] - each.at) / MS


def rounded(value: float) -> Any:
    return pytest.approx(value, abs=0.01)


def test_each_reaction_time_is_the_time_from_the_prompt_on_the_screen_to_the_key(
    tables: Tables,
) -> None:
    answered = [row for row in tables.trials if row["reaction_time_ms"]]
    timed = [row for row in answered if row["task"] == "keyboard"]
    assert len(timed) > 500
    for row in timed:
        true_ms = tables.pressed_after_ms[row["session"], row["attempt"], row["trial"]]
        assert float(row["reaction_time_ms"]) == rounded(true_ms), row
        assert (int(row["response_ns"]) - int(row["onset_ns"])) / MS == rounded(true_ms), row


def test_each_result_is_the_mean_reaction_time_of_right_responses_without_a_flag(
    tables: Tables,
) -> None:
    for attempt in tables.keyboard_attempts():
        times_ms = [
            float(row["reaction_time_ms"])
            for row in tables.trials_of(attempt)
            if row["correct"] == "true" and row["reaction_time_ms"] and not row["flags"]
        ]
        told = float(attempt["metric"]) if attempt["metric"] else None
        assert told == (rounded(fmean(times_ms)) if times_ms else None), attempt


def test_each_accuracy_is_the_share_of_right_responses_over_all_planned_prompts(
    tables: Tables,
) -> None:
    for attempt in tables.keyboard_attempts():
        trials = tables.trials_of(attempt)
        right = sum(row["correct"] == "true" for row in trials)
        assert (int(attempt["correct"]), int(attempt["trials"])) == (right, len(trials)), attempt
        assert float(attempt["accuracy"]) == pytest.approx(right / len(trials), abs=1e-9), attempt
        if tables.number(attempt, "repetitions_a_day") != MOST_REPETITIONS:
            assert len(trials) == tables.number(attempt, "prompts_per_attempt"), attempt


def test_each_outcome_follows_from_result_goal_and_accuracy(tables: Tables) -> None:
    for attempt in tables.keyboard_attempts():
        is_reached = tables.is_fast(attempt) and tables.is_accurate(attempt)
        assert attempt["outcome"] == ("success" if is_reached else "failure"), attempt
    assert any(
        tables.is_fast(attempt) and not tables.is_accurate(attempt)
        for attempt in tables.keyboard_attempts()
    )


def test_each_level_follows_from_the_outcome_before_it_and_practice_changes_none(
    tables: Tables,
) -> None:
    for attempts in tables.keyboard_sessions():
        for before, after in pairwise(attempts):
            step = 1 if before["outcome"] == "success" else -1
            if before["practice"] == "true":
                step = 0
            lowest = tables.number(before, "min_level")
            highest = tables.number(before, "max_level")
            expected = max(lowest, min(int(before["level"]) + step, highest))
            assert int(after["level"]) == expected, after


def test_feedback_follows_from_result_goal_and_accuracy_and_comes_when_it_is_due(
    tables: Tables,
) -> None:
    for attempts in tables.keyboard_sessions():
        every = tables.number(attempts[0], "feedback_every")
        scored = [row for row in attempts if row["practice"] == "false"]
        for number, attempt in enumerate(scored, 1):
            expected = "none" if number % every else expected_valence(tables, attempt)
            assert attempt["feedback"] == expected, attempt


def expected_valence(tables: Tables, attempt: Row) -> str:
    if not attempt["metric"] or not tables.is_accurate(attempt):
        return "negative"
    off_ms = abs(float(attempt["metric"]) - float(attempt["goal"]))
    if off_ms <= tables.number(attempt, "neutral_band"):
        return "neutral"
    return "positive" if tables.is_fast(attempt) else "negative"


def test_the_intervention_report_counts_each_prompt_and_reach_once_without_practice(
    tables: Tables,
) -> None:
    assert tables.repetitions == sum(row["practice"] == "false" for row in tables.trials)


def test_a_limit_of_repetitions_a_day_ends_a_session_after_as_many_rows(tables: Tables) -> None:
    done = [
        row for row in tables.trials if tables.number(row, "repetitions_a_day") == MOST_REPETITIONS
    ]
    assert len(done) == MOST_REPETITIONS


def test_reach_times_are_those_in_the_samples(tables: Tables) -> None:
    """A reach lasts from 1 % of the peak rate, and here while the rate exceeds 5 % of it."""
    differences_ms = []
    for row, time_s, norm in tables.reaches():
        moving_s = time_s[norm > 0.05 * norm.max()]
        seen_ms = float(moving_s[-1] - moving_s[0]) * 1000
        differences_ms.append(float(row["details_reach_time_ms"]) - seen_ms)
    assert len(differences_ms) > 5
    assert abs(np.median(differences_ms)) <= 80.0


def test_smoothness_computed_anew_from_the_samples_is_the_same(tables: Tables) -> None:
    differences = []
    for row, time_s, norm in tables.reaches():
        onset_s = int(row["onset_ns"]) / SECOND
        arrival_s = onset_s + float(row["details_out_ms"]) / 1000
        out = norm[(time_s >= onset_s) & (time_s <= arrival_s)]
        anew = spectral_arc_length(out, float(row["details_rate_hz"]))
        differences.append(float(row["details_sparc_out"]) - anew)
    assert len(differences) > 5
    assert abs(np.median(differences)) <= 0.02


def spectral_arc_length(speed: Floats, rate_hz: float) -> float:
    """Return SPARC by its definition (Balasubramanian et al. 2015, doi:10.1186/s12984-015-0090-9).

    Written anew, so that it shares no line with what it is compared with.
    """
    size = 2 ** (math.ceil(math.log2(len(speed))) + 4)
    frequency = np.arange(size) * rate_hz / size
    amplitude = np.abs(np.fft.fft(speed, size))
    amplitude = (amplitude / amplitude.max())[frequency <= 10.0]
    last = np.flatnonzero(amplitude >= 0.05)[-1]
    return -float(sum(math.hypot(1 / last, step) for step in np.diff(amplitude[: last + 1])))
