"""The recordings of people in ``tests/data/real-reaches``, and their labels; see the README there."""

import json
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sar_tui.motion.samples import Recording

FOLDER = Path(__file__).parent.parent / "tests" / "data" / "real-reaches"
BY_EYE = FOLDER / "labels-by-eye.json"
BY_RULE = FOLDER / "labels-by-rule.json"
EXERCISES = tuple(sorted(path.name[:-7] for path in (FOLDER / "exercises").glob("*.csv.gz")))
DAILY_LIFE = tuple(sorted(path.name[:-7] for path in (FOLDER / "daily-life").glob("*.csv.gz")))


class Label(NamedTuple):
    """A labelled reach: its times in s, NaN where the label is not known well."""

    onset_s: float
    arrival_s: float
    departure_s: float
    end_s: float


class LabelledSet(NamedTuple):
    """Repetitions in a row, done in one ``manner``, and the time around them, in s.

    ``doubtful``: time spans of what may be a reach: neither found nor false.
    """

    manner: str
    from_s: float
    to_s: float
    reaches: tuple[Label, ...]
    doubtful: tuple[tuple[float, float], ...] = ()


@cache
def read_exercise(name: str) -> Recording:
    """Return the recording of an exercise: a name in ``EXERCISES``."""
    return _read(FOLDER / "exercises" / f"{name}.csv.gz")


@cache
def read_daily_life(name: str) -> Recording:
    """Return the recording of a person in ``DAILY_LIFE``, who does not reach."""
    return _read(FOLDER / "daily-life" / f"{name}.csv.gz")


def _read(path: Path) -> Recording:
    columns = np.loadtxt(path, delimiter=",", skiprows=1, usecols=range(7))
    return Recording(columns[:, 0], columns[:, 1:4], columns[:, 4:7])


def is_by_eye(name: str) -> bool:
    """Return True if the reaches of an exercise are labelled by eye, False if by the rule."""
    return name in json.loads(BY_EYE.read_text())


def labels(name: str) -> tuple[LabelledSet, ...]:
    """Return the labelled sets of an exercise, in order of time."""
    by_eye = json.loads(BY_EYE.read_text())
    if name in by_eye:
        reaches = tuple(Label(*times) for times in by_eye[name])
        return (LabelledSet("well", reaches[0].onset_s - 3.0, reaches[-1].end_s + 3.0, reaches),)
    return tuple(
        LabelledSet(
            each["manner"],
            each["from_s"],
            each["to_s"],
            tuple(
                Label(*(np.nan if time is None else time for time in times))
                for times in each["reaches"]
            ),
            tuple((times[0], times[-1]) for times in each["doubtful"]),
        )
        for each in json.loads(BY_RULE.read_text())["recordings"][name]
    )
