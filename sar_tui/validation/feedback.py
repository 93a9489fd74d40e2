"""Augmented feedback (thesis 4.4.2): Figures 4.11 to 4.14, from simulated users over twenty
attempts.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import partial

from sar_tui.loop.phrase_keys import holds_number
from sar_tui.validation import charts
from sar_tui.validation.charts import draw_feedback
from sar_tui.validation.report import Claim, Column, Conditions, Report, Row
from sar_tui.validation.simulated_sessions import SessionRunner, Simulated, session_runner

VALENCES = ("positive", "neutral", "negative")
BAND_MS, LEAST_ACCURACY = 10.0, 0.8
"""Results within this distance of the goal are neutral; praise needs at least this share of correct
responses.
"""
EVERY = 3
"""Number of attempts per feedback in the second condition of Figure 4.14."""
TRUE_FIGURES = (
    "Every figure is the result, the goal, or the difference from the last result at that level."
)
_NUMBER = re.compile(r"\d+(?:\.\d+)?")


def poor(conditions: Conditions) -> Report:
    """Return Figure 4.11: one row per attempt of a poor user."""
    return _of_users(conditions, "figure-4.11", ("poor",))


def competent(conditions: Conditions) -> Report:
    """Return Figure 4.12: one row per attempt of a competent user, and of a poor one for
    comparison.
    """
    report = _of_users(conditions, "figure-4.12", ("competent", "poor"))
    claims = [*report.claims, *differs_by_user(report.rows)]
    return report._replace(claims=claims)


def differs_by_user(rows: Sequence[Row]) -> list[Claim]:
    """Return the claims that competent users are praised more than poor ones, and blamed less."""
    seeds = dict.fromkeys(row["seed"] for row in rows)
    fewer = [
        f"seed {seed}: {theirs} against {poors}"
        for seed, theirs, poors in _by_seed(rows, "positive")
        if theirs <= poors
    ]
    negative = [
        sum(counts) for counts in zip(*(row[1:] for row in _by_seed(rows, "negative")), strict=True)
    ]
    return [
        Claim(
            f"Competent users get more positives than poor ones in all {len(seeds)} seeds.",
            "; ".join(fewer),
        ),
        Claim(
            "Over all seeds, poor users get more negative feedback than competent ones.",
            "" if negative[1] > negative[0] else f"they get {negative[1]} against {negative[0]}",
        ),
    ]


def has_its_form(texts: Mapping[str, Sequence[str]]) -> list[Claim]:
    """Return the claims that feedback in words has no numbers, and that in figures has some."""
    words = [text for text in texts["qualitative"] if holds_number(text)]
    figures = [text for text in texts["quantitative"] if not _NUMBER.search(text)]
    return [
        Claim(
            "No qualitative feedback contains a number, in digits or in words.", "; ".join(words)
        ),
        Claim("All quantitative feedback contains a figure.", "; ".join(figures)),
    ]


def examples(conditions: Conditions) -> Report:
    """Return Figure 4.13: one row per feedback, in words and in figures."""
    rows = []
    with session_runner(conditions.catalogue, conditions.known) as runner:
        for number, form in enumerate(("qualitative", "quantitative")):
            conditions.progress("figure-4.13", number, 2)
            for seed in conditions.seeds[:3]:
                rows += said_rows(form, seed, runner.run("average", seed, feedback_form=form))
    texts = {
        form: [row["text"] for row in rows if row["form"] == form]
        for form in ("qualitative", "quantitative")
    }
    untrue = [row["text"] for row in rows if row["form"] == "quantitative" and not is_true(row)]
    claims = [
        *has_its_form(texts),
        Claim(TRUE_FIGURES, "; ".join(untrue)),
    ]
    seen = _one_of_each(rows)
    return Report(rows, [_EXAMPLES], claims, seen=seen, chart=charts.sentences(seen, "feedback"))


def frequency(conditions: Conditions) -> Report:
    """Return Figure 4.14: one row per attempt of a competent user, with feedback after each, and
    after every three.
    """
    rows: list[Row] = []
    unsaid: list[str] = []
    with session_runner(conditions.catalogue, conditions.known) as runner:
        for number, seed in enumerate(conditions.seeds):
            conditions.progress("figure-4.14", number, len(conditions.seeds))
            for every in (1, EVERY):
                done = runner.run("competent", seed, feedback_every=every)
                found = [{"every": every, **row} for row in feedback_rows(done, "competent", seed)]
                marked = {row["attempt"] for row in found if row["feedback"] != "none"}
                if set(done.feedback) != marked:
                    unsaid.append(f"seed {seed}, every {every}")
                rows += found
    claims = [
        _feedback_claim(rows, 1, "With feedback after every attempt, each attempt has it."),
        _feedback_claim(
            rows,
            EVERY,
            "With feedback after every three, the attempts 3, 6, 9 … have it, and no others.",
        ),
        Claim(
            "The log holds what the agent said on those attempts, and on no others.",
            "; ".join(unsaid),
        ),
    ]
    first = conditions.seeds[0]
    drawings = [
        draw_feedback(
            _only(rows, seed=first, every=every), f"Competent user, seed {first}: feedback {how}"
        )
        for every, how in ((1, "after every attempt"), (EVERY, "after every three attempts"))
    ]
    groups = [
        (f"Feedback {how}", _only(rows, seed=first, every=every))
        for every, how in ((1, "after every attempt"), (EVERY, "after every three attempts"))
    ]
    return Report(rows, [], claims, drawings, chart=charts.feedback(groups))


# --- sessions as rows


def _of_users(conditions: Conditions, name: str, users: Sequence[str]) -> Report:
    rows: list[Row] = []
    with session_runner(conditions.catalogue, conditions.known) as runner:
        for number, seed in enumerate(conditions.seeds):
            conditions.progress(name, number, len(conditions.seeds))
            rows += _of_seed(runner, users, seed)
    wrong = [
        f"{row['user']}, seed {row['seed']}, attempt {row['attempt']}"
        for row in rows
        if not fits(row)
    ]
    claim = Claim(
        f"Feedback is positive under the goal, negative over it, and neutral within {BAND_MS:g} "
        "ms of it.",
        "; ".join(wrong),
    )
    first, title = (
        _only(rows, user=users[0], seed=conditions.seeds[0]),
        f"{users[0].capitalize()} user",
    )
    drawn = draw_feedback(first, f"{title}, seed {conditions.seeds[0]}")
    seen = [_counted(rows, user, seed) for seed in conditions.seeds for user in users]
    return Report(rows, [_COUNTS], [claim], [drawn], seen, charts.feedback([(title, first)]))


def _of_seed(runner: SessionRunner, users: Sequence[str], seed: int) -> list[Row]:
    return [row for user in users for row in feedback_rows(runner.run(user, seed), user, seed)]


def feedback_rows(done: Simulated, user: str, seed: int) -> list[Row]:
    """Return one row for each attempt of a session."""
    return [
        {
            "user": user,
            "seed": seed,
            "attempt": attempt["attempt"],
            "level": attempt["level"],
            "reaction_time_ms": attempt["metric"],
            "goal_ms": attempt["goal"],
            "accuracy": attempt["accuracy"],
            "feedback": attempt["feedback"],
        }
        for attempt in done.attempts
    ]


def _only(rows: Iterable[Row], **fields: object) -> list[Row]:
    return [row for row in rows if all(row[name] == value for name, value in fields.items())]


def _counted(rows: Sequence[Row], user: str, seed: int) -> Row:
    given = [row["feedback"] for row in _only(rows, user=user, seed=seed)]
    return {"seed": seed, "user": user} | {valence: given.count(valence) for valence in VALENCES}


def _by_seed(rows: Sequence[Row], valence: str) -> list[tuple[int, int, int]]:
    """Return each seed with the number of times that a competent and a poor user got this
    feedback.
    """
    seeds = dict.fromkeys(row["seed"] for row in rows)
    return [
        (seed, _counted(rows, "competent", seed)[valence], _counted(rows, "poor", seed)[valence])
        for seed in seeds
    ]


def fits(row: Row) -> bool:
    """Return True if feedback is as the thesis describes, without praise for too few correct
    responses.
    """
    if row["reaction_time_ms"] is None or row["accuracy"] < LEAST_ACCURACY:
        return bool(row["feedback"] == "negative")
    over = row["reaction_time_ms"] - row["goal_ms"]
    expected = "neutral" if abs(over) <= BAND_MS else "negative" if over > 0 else "positive"
    return bool(row["feedback"] == expected)


def _feedback_claim(rows: Sequence[Row], every: int, sentence: str) -> Claim:
    wrong = [
        f"seed {row['seed']}, attempt {row['attempt']}"
        for row in _only(rows, every=every)
        if (row["feedback"] != "none") != (row["attempt"] % every == 0)
    ]
    return Claim(sentence, "; ".join(wrong))


# --- what was said


def said_rows(form: str, seed: int, done: Simulated) -> list[Row]:
    """Return one row for each feedback that was given, with what its figures may be."""
    rows: list[Row] = []
    last: dict[int, float | None] = {}
    for attempt in done.attempts:
        said = done.feedback[attempt["attempt"]]["final"]
        rows.append(
            {
                "form": form,
                "seed": seed,
                "attempt": attempt["attempt"],
                "level": attempt["level"],
                "reaction_time_ms": attempt["metric"],
                "last_at_level_ms": last.get(attempt["level"]),
                "goal_ms": attempt["goal"],
                "correct": attempt["correct"],
                "trials": attempt["trials"],
                "feedback": attempt["feedback"],
                "degree": said["degree"],
                "text": said["text"],
            }
        )
        last[attempt["level"]] = attempt["metric"] or last.get(attempt["level"])
    return rows


def is_true(row: Row) -> bool:
    """Return True if each figure in a text belongs to the attempt."""
    result, last = row["reaction_time_ms"], row["last_at_level_ms"]
    measured = {f"{row['goal_ms'] / 1000:.4g}", str(row["correct"]), str(row["trials"])}
    # times are said in seconds; three decimals set a result apart from the goal
    for decimals in (
        2,
        3,
    ):
        now, before = (
            None if value is None else round(value / 1000, decimals) for value in (result, last)
        )
        difference = None if now is None or before is None else abs(now - before)
        measured |= {f"{value:.{decimals}f}" for value in (now, difference) if value is not None}
    return set(_NUMBER.findall(row["text"])) <= measured


def _one_of_each(rows: Iterable[Row]) -> list[Row]:
    """Return the first feedback of each form, valence and degree; the best first."""
    found: dict[tuple[str, str, str], Row] = {}
    for row in rows:
        found.setdefault((row["form"], row["feedback"], row["degree"]), row)
    forms = [row["form"] for row in found.values()]
    return sorted(
        found.values(), key=lambda row: (forms.index(row["form"]), VALENCES.index(row["feedback"]))
    )


# --- columns


def _count(valence: str, row: Row) -> str:
    return str(row[valence])


def _graded(row: Row) -> str:
    return (
        str(row["feedback"])
        if row["feedback"] == "neutral"
        else f"{row['feedback']}, {row['degree']}"
    )


def _compared(row: Row) -> str | None:
    """Return the result in ms, and the last one at that level, if there is one."""
    result, last = row["reaction_time_ms"], row["last_at_level_ms"]
    if result is None:
        return None
    return f"{result:.0f}" if last is None else f"{result:.0f} ({last:.0f})"


_COUNTS = [
    Column("seed", lambda row: str(row["seed"])),
    Column("user", lambda row: str(row["user"]), is_number=False),
    *(Column(valence, partial(_count, valence)) for valence in VALENCES),
]
_EXAMPLES = [
    Column("form", lambda row: str(row["form"]), is_number=False),
    Column("feedback", _graded, is_number=False),
    Column("ms (last)", _compared),
    Column("what was said", lambda row: str(row["text"]), is_number=False),
]
