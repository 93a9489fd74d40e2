"""The sentence that reports of progress begin with: each verdict, and that it claims no more than
is known.
"""

import random
import statistics

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.loop.task import Task
from sar_tui.model.trial_types import NO_METRIC
from sar_tui.progress.lines import SessionResults
from sar_tui.progress.task_level import AttemptResult
from sar_tui.reports import progress_words
from sar_tui.reports.progress import Progress, progress
from sar_tui.reports.progress_headline import FEWEST, Headline, headline
from sar_tui.rules.student import t95
from tests.progress.session_results import adapted, at_one_level, session
from tests.reports.test_progress import SPANISH, fast, steady
from tests.untranslated import english_in

NEW_GOAL = {"threshold": 900.0}
SLOW = [AttemptResult(1 + n % 2, 1900.0 + 100 * (n % 2), 20) for n in range(12)]


def found_of(kind: type[Task], sessions: list[SessionResults]) -> Progress:
    return progress("P01", sessions, {"keyboard": kind}.get)


def told(kind: type[Task], sessions: list[SessionResults], code: str = "en") -> Headline:
    found = found_of(kind, sessions)
    return headline(found, found.lines[-1], progress_words.words(code, kind))


def weekly(count: int, base: float = 450.0) -> list[SessionResults]:
    return [session(n, adapted(n, base=base), on_day=7 * n) for n in range(count)]


def last(base: float, day: int) -> SessionResults:
    return session(99, adapted(99, base=base), on_day=day)


HISTORIES: dict[str, tuple[list[SessionResults], str, str]] = {
    "faster": (
        [*weekly(5), last(50.0, 42)],
        "improving",
        "Improving: level 3.3 → 6.0 in 4 weeks, more than noise and practice explain.",
    ),
    "as before": (
        weekly(6),
        "steady",
        "Steady, as far as can be told: level 3.3 → 3.3 in 3 weeks, no more than noise and "
        "practice.",
    ),
    "slower": (
        [*weekly(5), last(750.0, 42)],
        "behind",
        "Behind the earlier level: level 3.3 → 1.5 in 4 weeks, more than noise explains.",
    ),
    "faster, then too easy": (
        [*weekly(5), last(50.0, 42), session(100, at_one_level(9, 400.0), on_day=50)],
        "improving",
        "Improving until 2026-04-10: level 3.3 → 6.0 in 4 weeks, more than noise and practice "
        "explain. The last session was too easy to tell.",
    ),
    "slower, then too easy": (
        [*weekly(5), last(750.0, 42), session(100, at_one_level(9, 400.0), on_day=50)],
        "too little",
        "Too early to say: after 2026-04-10 there was a session in which every result was better "
        "than the goal. Harder levels would tell more.",
    ),
    "faster, then too hard": (
        [*weekly(5), last(50.0, 42), session(100, SLOW, on_day=50)],
        "too little",
        "Too early to say: after 2026-04-10 there was a session in which no result reached the "
        "goal. Easier levels would tell more.",
    ),
    "one session": (
        steady(1),
        "too little",
        "1 session: too few to say. After 4 more, a change can be told from noise and practice.",
    ),
    "three sessions": (
        steady(3),
        "too little",
        "3 sessions: too few to say. After 2 more, a change can be told from noise and practice.",
    ),
    "only the baseline": (
        steady(4),
        "too little",
        "4 sessions: too few to say. After one more, a change can be told from noise and practice.",
    ),
    "some unknown": (
        [fast(0, 1, 400.0), *steady(4)[1:]],
        "too little",
        "4 sessions, 3 of them with a known value: too few to say. It takes 5 of these to tell a "
        "change from noise and practice.",
    ),
    "all too easy": (
        [fast(0, 1, 500.0), fast(1, 2, 400.0)],
        "too little",
        "Too early to say: in the last session every result was better than the goal. Harder "
        "levels would tell more.",
    ),
    "all too hard": (
        [session(0, SLOW)],
        "too little",
        "Too early to say: in the last session no result reached the goal. Easier levels would "
        "tell more.",
    ),
    "nothing grows with the level": (
        [session(0, [AttemptResult(1 + n % 3, 900.0 + 200 * (n % 2), 20) for n in range(3)])],
        "too little",
        "Too early to say: these results do not tell yet how they grow with the level. More "
        "attempts, at several levels, would tell more.",
    ),
    "another goal": (
        [*weekly(6), session(50, adapted(50), NEW_GOAL, on_day=60)],
        "changed",
        "The goal is 0.9 s now, and was 1.0 s until 2026-04-03. 1 session with it: too few to "
        "say. After 4 more, a change can be told from noise and practice.",
    ),
    "another setting": (
        [*weekly(6), session(50, adapted(50), {"prompts_per_attempt": 5}, on_day=60)],
        "changed",
        "The settings were others until 2026-04-03. 1 session with those of now: too few to say. "
        "After 4 more, a change can be told from noise and practice.",
    ),
    "another goal, long ago": (
        [session(0, adapted(0), NEW_GOAL), *weekly(7)[1:]],
        "steady",
        "Steady, as far as can be told: level 3.3 → 3.3 in 3 weeks, no more than noise and "
        "practice.",
    ),
    "at one level": (
        [
            session(n, at_one_level(n, mean), on_day=7 * n)
            for n, mean in enumerate((990, 950, 955, 945, 700))
        ],
        "improving",
        "Improving: 0.951 → 0.702 s in 2 weeks, more than noise and practice explain.",
    ),
    "no result": (
        [session(0, [AttemptResult(1, None, 20)], metric=NO_METRIC, reached=None)],
        "not measured",
        "1 session. This task has no result, so progress in it is not judged.",
    ),
    "no goal": (
        [session(0, adapted(0), {"threshold": None}, reached=None, task="other")],
        "not measured",
        "1 session. This task has no goal, so there is no level at goal to judge.",
    ),
}


@pytest.mark.parametrize("name", HISTORIES)
def test_each_history_has_its_sentence(keyboard: type[Task], name: str) -> None:
    sessions, outlook, text = HISTORIES[name]
    assert told(keyboard, sessions) == Headline(outlook, text)  # type: ignore[arg-type]
    spanish = told(keyboard, sessions, "es")
    assert spanish.outlook == outlook
    assert english_in([spanish.text], SPANISH) == []


@pytest.mark.parametrize(
    ("days", "time"),
    [(0, "1 day"), (1, "1 day"), (13, "13 days"), (14, "2 weeks"), (181, "26 weeks"),
     (182, "6 months"), (800, "26 months")],
)  # fmt: skip
def test_the_time_is_counted_from_the_middle_of_the_baseline(
    keyboard: type[Task], days: int, time: str
) -> None:
    sessions = [session(n, adapted(n), on_day=0) for n in range(4)]
    sessions.append(session(4, adapted(4), on_day=days))
    assert f" in {time}, " in told(keyboard, sessions).text


def test_earlier_sessions_with_other_settings_say_so(keyboard: type[Task]) -> None:
    found = found_of(keyboard, [*weekly(6), session(50, adapted(50), NEW_GOAL, on_day=60)])
    said = headline(found, found.lines[0], progress_words.words("en", keyboard))
    assert said.text.startswith("These are earlier sessions, with other settings. Steady, as far")


def test_the_partner_on_the_other_seat_and_simulated_sessions_are_no_change_of_settings(
    keyboard: type[Task],
) -> None:
    others = [session(7, adapted(7), seat="B"), session(8, adapted(8), mode="simulated")]
    assert told(keyboard, [*others, *steady(2)]).outlook == "too little"


VALUES = st.lists(st.integers(200, 4000), min_size=1, max_size=9)


@given(VALUES, st.sampled_from([1.0, 0.05]))
def test_a_change_is_claimed_only_if_its_interval_leaves_out_none(
    keyboard: type[Task], means: list[int], scale: float
) -> None:
    means_ms = [500.0 + mean * scale for mean in means]
    made = [session(n, [AttemptResult(3, mean, 20)] * 3) for n, mean in enumerate(means_ms)]
    said = told(keyboard, made)
    if len(means) < FEWEST:
        assert said.outlook == "too little"
        return
    probes = [-mean for mean in means_ms[1:4]]
    error = t95(2) * 2**0.5 * statistics.stdev(probes)
    gain = -means_ms[-1] - statistics.fmean(probes)
    practice = max(0.0, probes[-1] - probes[0])
    includes_none = gain - error - practice <= 1e-6 and gain + error >= -1e-6
    assert said.outlook in ("steady", "improving" if gain > 0 else "behind")
    if includes_none:
        assert said.outlook == "steady"
    if said.outlook in ("improving", "behind"):
        assert not gain - error <= 0 <= gain + error


def test_of_people_who_only_practise_few_are_told_of_a_change(keyboard: type[Task]) -> None:
    said = []
    for seed in range(60):
        rng = random.Random(seed)
        sessions = [
            session(n, adapted(1000 * seed + n, base=400 + 90 * 0.5**n + rng.gauss(0, 25)))
            for n in range(8)
        ]
        said.append(told(keyboard, sessions).outlook)
    assert said.count("steady") >= 54
