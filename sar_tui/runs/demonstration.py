"""A demonstration: six invented people and eight weeks of their sessions, made by the simulators.

Each person has a story, which the same screens and reports tell as those of real people. The
sessions are played by simulated participants, and stored as of the days on which they would have
been; their mode says that they are a demonstration.
"""

import os
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import datetime, time, timedelta
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

from sar_tui.drivers.files import make_private
from sar_tui.model.theme import ENGLISH, Theme
from sar_tui.plugins import Catalogue
from sar_tui.records.kind import find
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.operator import PROFILES
from sar_tui.simulation.participant_model import PEOPLE, Person
from sar_tui.store import participants, programmes, records, wellbeing
from sar_tui.store.database import StoreError, commit_unsynced, connect, sync
from sar_tui.store.programmes import Programme
from sar_tui.store.record_changes import BY_MISTAKE, change_status

NOTE = "DEMONSTRATION.txt"
"""File that says what the folder is, for people who open it."""
_SAYS = (
    "This data folder is a demonstration of sar-tui. Its people are invented, and their sessions\n"
    "are simulated: their mode is `demonstration`. Nothing of it is merged into other data.\n"
)
_BY = "therapist"
"""Author of the programmes and the records."""
_NOON = time(12)


def make_demonstration(
    folder: Path,
    now: datetime | None = None,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> None:
    """Make a data folder of invented people, whose last session was today, or yesterday in the
    morning.

    The same day gives the same sessions, except for their ids.

    Args:
        folder: is made; see `check_free`.
        now: the present time; None for that of this machine.
        progress: called with the number of steps that are done, and of all.

    Raises:
        StoreError: the folder is not free, or the disk cannot write.
        PluginError: a bundled task or theme cannot be loaded.
    """
    check_free(folder)
    now = (now or datetime.now()).astimezone()
    last_day = now.date() - timedelta(days=now.time() < _NOON)
    make_private(folder)
    (folder / NOTE).write_text(_SAYS, encoding="utf-8")
    with closing(connect(folder)) as database:
        commit_unsynced(database)
        maker = _Maker(folder, _ThemesReadOnce(), database)
        steps = sorted((step for story in _STORIES for step in story()), key=lambda step: step.when)
        for done, step in enumerate(steps, 1):
            day = last_day - timedelta(days=step.days_ago)
            step.make(maker, datetime.combine(day, step.clock).astimezone())
            progress(done, len(steps))
        sync(database)


def check_free(folder: Path) -> None:
    """Raise StoreError if a folder is there that holds anything, or a file."""
    if os.path.lexists(folder) and not (folder.is_dir() and not any(folder.iterdir())):
        raise StoreError(
            f"{folder} is no empty folder. A demonstration needs a folder of its own.",
            bad_input=True,
        )


class _ThemesReadOnce(Catalogue):
    """A catalogue for many sessions in a row: nobody changes a theme between them."""

    def __init__(self) -> None:
        super().__init__()
        self._read: dict[tuple[str, str], Theme] = {}

    def theme(self, name: str, language: str = ENGLISH) -> Theme:
        if (name, language) not in self._read:
            self._read[name, language] = super().theme(name, language)
        return self._read[name, language]


class _Maker(NamedTuple):
    """Data folder that is filled."""

    folder: Path
    catalogue: Catalogue
    database: sqlite3.Connection


class _Step(NamedTuple):
    """Something that happens at a time of a day, so many days before the last one."""

    days_ago: int
    clock: time
    make: Callable[[_Maker, datetime], object]

    @property
    def when(self) -> tuple[int, time]:
        """Place in the order of all steps."""
        return -self.days_ago, self.clock


# --- what can happen


class _Felt(NamedTuple):
    """Ratings of pain and tiredness, before and after a session; None: not asked."""

    pain: tuple[int, int] | None = None
    tiredness: tuple[int, int] | None = None


class _Session(msgspec.Struct, frozen=True):
    """A session of one or two people.

    ``skill``: time that the person needs, as a share of that of an average one; of each of two.
    ``leave_after``: as in `simulate`. ``is_mistake``: it was started by mistake.
    """

    task: str
    codes: tuple[str, ...]
    seed: int
    skill: tuple[float, ...]
    felt: _Felt = _Felt()
    operator: str = ""
    leave_after: int = 0
    is_mistake: bool = False

    def __call__(self, maker: _Maker, began: datetime) -> None:
        """Play it by the newest programme."""
        saved = programmes.newest(maker.database, self.codes[0], self.task)
        plan = make_plan(
            maker.catalogue,
            self.task,
            self.codes,
            saved=saved,
            seed=self.seed,
            mode="demonstration",
        )
        session = simulate(
            plan,
            _person(self.skill[0]),
            maker.folder,
            maker.catalogue,
            operator=PROFILES.get(self.operator),
            partner=_person(self.skill[-1]),
            began=began,
            leave_after=self.leave_after,
        )
        ended = _end_of(maker.database, session)
        if self.is_mistake:
            change_status(
                maker.database, maker.folder, session, "discarded",
                actor="participant", reason=BY_MISTAKE, now=ended,
            )  # fmt: skip
        for kind, ratings in zip(wellbeing.KINDS, self.felt, strict=True):
            if ratings:
                told = ((began - _ASKED, "before"), (ended + _ASKED, "after"))
                for (at, moment), rating in zip(told, ratings, strict=True):
                    _rate(maker.database, self.codes[0], kind, rating, at, session, moment)


_ASKED = timedelta(seconds=40)
"""Time between an answer and the session."""


def _person(share: float) -> Person:
    average = PEOPLE["average"]
    return msgspec.structs.replace(
        average,
        base_ms=average.base_ms * share,
        per_bit_ms=average.per_bit_ms * share,
        pace=average.pace * share,
    )


def _end_of(database: sqlite3.Connection, session: str) -> datetime:
    (ended,) = database.execute("SELECT ended_at FROM sessions WHERE id=?", (session,)).fetchone()
    return datetime.fromisoformat(ended)


def _rate(
    database: sqlite3.Connection,
    code: str,
    kind: str,
    rating: int,
    at: datetime,
    session: str | None = None,
    moment: str = "before",
    **more: str,
) -> None:
    given: dict[str, Any] = {"answer": wellbeing.RATED, "rating": rating, **more}
    records.add(database, find(kind), code, "", given, session=session, moment=moment, now=at)


def _programme(code: str, task: str, reason: str, **settings: Any) -> Callable[..., object]:
    """Return a step that saves the next version of a programme."""

    def save(maker: _Maker, at: datetime) -> None:
        participants.add(maker.database, code, at)
        last = programmes.newest(maker.database, code, task)
        changed = Programme({**last.parameters, **settings})
        programmes.save(
            maker.database, code, task, changed,
            after=last.version, author=_BY, reason=reason, now=at,
        )  # fmt: skip

    return save


def _record(code: str, kind: str, **given: Any) -> Callable[..., object]:
    """Return a step that enters a therapist's record."""

    def enter(maker: _Maker, at: datetime) -> None:
        records.add(
            maker.database, find(kind), code, "", given, author=_BY, is_new=False, now=at
        )  # fmt: skip

    return enter


def _days(first: int, last: int, sessions: int) -> Iterator[tuple[int, int]]:
    """Yield the number and the day of sessions that are spread over some days."""
    for number in range(sessions):
        yield number, round(first + (last - first) * number / (sessions - 1))


# --- their stories


def _improves() -> Iterator[_Step]:
    """P01 needs less and less time after some weeks, and two tests of the arm say the same."""
    yield _Step(
        56, time(9), _programme(
            "P01", "keyboard", "First programme, after the assessment.",
            attempts=8, prompts_per_attempt=8, threshold=900.0, ask_wellbeing=True,
            days_between_visits=4,
        ),
    )  # fmt: skip
    for day, motor, blocks in ((56, 34, 21), (28, 39, 26), (1, 44, 31)):
        yield _Step(day, time(9, 5), _record("P01", "FMA-UE", score=motor))
        yield _Step(day, time(9, 10), _record("P01", "BBT", score=blocks))
    yield _Step(
        27, time(9, 30),
        _programme("P01", "keyboard", "Tires less: two attempts more.", attempts=10),
    )  # fmt: skip
    for number, day in _days(56, 0, 16):
        felt = _Felt(
            (2 if number < 5 else 1 if number < 10 else 0,) * 2,
            (2, 5 if number < 8 else 4),
        )
        skill = 1.3 * 0.97 ** max(0, number - 4)
        made = _Session("keyboard", ("P01",), 100 + number, (skill,), felt)
        yield _Step(day, time(10, 5 + number), made)


def _stays() -> Iterator[_Step]:
    """P02 got better at first, and has been as good as now for five weeks. The last session was
    left before its end.
    """
    yield _Step(
        55, time(11), _programme(
            "P02", "keyboard", "First programme.",
            attempts=8, prompts_per_attempt=8, threshold=850.0,
        ),
    )  # fmt: skip
    for day, motor in ((55, 47), (20, 50)):
        yield _Step(day, time(11, 5), _record("P02", "FMA-UE", score=motor))
    yield _Step(
        20, time(11), _programme(
            "P02", "keyboard", "No change for three weeks: figures, compared with the best.",
            feedback_form="quantitative", feedback_compared_with="best attempt",
        ),
    )  # fmt: skip
    for number, day in _days(55, 3, 11):
        yield _Step(
            day, time(11, 10 + number),
            _Session("keyboard", ("P02",), 200 + number, (max(1.0, 1.12 - 0.05 * number),)),
        )  # fmt: skip
    mistake = _Session("keyboard", ("P02",), 298, (1.0,), leave_after=1, is_mistake=True)
    yield _Step(18, time(11, 5), mistake)
    yield _Step(0, time(8, 40), _Session("keyboard", ("P02",), 299, (1.0,), leave_after=4))


def _hurts() -> Iterator[_Step]:
    """P03 has had more and more pain for two weeks, trains less, and did not begin the last
    session.
    """
    yield _Step(
        54, time(8, 30), _programme(
            "P03", "gonogo", "First programme.",
            attempts=4, ask_wellbeing=True, days_between_visits=4,
        ),
    )  # fmt: skip
    pains = [(1, 1), (0, 1), (1, 2), (1, 1), (1, 1), (2, 2), (1, 2), (2, 2), (2, 3), (3, 5), (3, 7)]
    days = [54, 49, 45, 41, 37, 33, 28, 24, 20, 14, 8]
    for number, (day, pain) in enumerate(zip(days, pains, strict=True)):
        felt = _Felt(pain, (2, 3 if pain[1] < 3 else 6))
        made = _Session("gonogo", ("P03",), 300 + number, (1.2,), felt)
        yield _Step(day, time(9, 10), made)
    yield _Step(
        8, time(9, 30), _record(
            "P03", "adverse-event", what="Pain in the right shoulder, from training on",
            severity="moderate", action="Training shortened; the physician was told",
        ),
    )  # fmt: skip
    yield _Step(
        8, time(9, 40),
        _programme("P03", "gonogo", "Pain of 7 after the session: shorter.", attempts=3),
    )  # fmt: skip
    yield _Step(
        1, time(9, 15), lambda maker, at: _rate(
            maker.database, "P03", "pain", 6, at, place="right shoulder", advice="stopped"
        ),
    )  # fmt: skip


def _misses() -> Iterator[_Step]:
    """P04 came twice a week, and has not come for twelve days."""
    yield _Step(
        53, time(14), _programme(
            "P04", "tapping", "First programme.", attempts=4, threshold=48.0, days_between_visits=4,
            questions=("exertion",),
        ),
    )  # fmt: skip
    for number, day in _days(53, 12, 10):
        yield _Step(day, time(15, number), _Session("tapping", ("P04",), 400 + number, (1.1,)))


def _reaches() -> Iterator[_Step]:
    """P05 reaches with a motion sensor, and plays with P06 once a week."""
    yield _Step(
        50, time(9), _programme(
            "P05", "reaching", "Reaches with the right arm.", attempts=8, imu="simulated:patient"
        ),
    )  # fmt: skip
    yield _Step(
        49,
        time(9),
        _programme("P05", "pairs", "With P06, once a week.", attempts=8, threshold=880.0),
    )
    for number, day in _days(50, 5, 6):
        reached = _Session("reaching", ("P05",), 500 + number, (1.2 - 0.03 * number,))
        yield _Step(day, time(9, 20), reached)
    for number, day in _days(49, 1, 6):
        skill = (1.15 - 0.02 * number, 1.05)
        yield _Step(day, time(10), _Session("pairs", ("P05", "P06"), 520 + number, skill))


def _is_led() -> Iterator[_Step]:
    """P06 trains while an operator in the next room approves what the agent says."""
    yield _Step(
        29, time(13), _programme(
            "P06", "keyboard", "For the comparison of feedback with and without an operator.",
            attempts=6, prompts_per_attempt=8, threshold=850.0, operator_feedback="approve",
        ),
    )  # fmt: skip
    for number, day in _days(29, 2, 5):
        operator = "careful" if number % 2 == 0 else "absent"
        led = _Session("keyboard", ("P06",), 600 + number, (0.95,), operator=operator)
        yield _Step(day, time(13, 30), led)


_STORIES = (_improves, _stays, _hurts, _misses, _reaches, _is_led)
