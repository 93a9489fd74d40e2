"""A study in words: the summary of its plan, its preregistration, and its methods for a paper."""

import sqlite3
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from sar_tui.export.methods import methods as methods_of_sessions
from sar_tui.export.passports import passports
from sar_tui.store import sessions
from sar_tui.study import ledger
from sar_tui.study.allocation import sizes
from sar_tui.study.ledger import Frozen, Participation
from sar_tui.study.outcome import Outcome
from sar_tui.study.plan import QUESTIONS, Block, Study, orders

# --- summary


def summary(plan: Study) -> Iterator[str]:
    """Yield lines on a plan: name, groups, conditions, visits and their blocks."""
    yield f"{plan.title or plan.name}: version {plan.version} of the study {plan.name} is fine."
    if plan.groups:
        named = ", ".join(f"{name} ({each.condition})" for name, each in plan.groups.items())
        blind = ", blind" if plan.allocation.blind else ""
        yield f"Groups: {named}; allocated by {plan.allocation.method}{blind}."
    conditions = ", ".join(f"{name} ({each.task})" for name, each in plan.conditions.items())
    yield f"Conditions: {conditions}."
    for visit in plan.visits:
        before, after = visit.window
        days_before = "1 day" if before == 1 else f"{before} days"
        days = f" ({days_before} before to {after} after)" if before or after else ""
        yield f"Visit {visit.name}, day {visit.day}{days}:"
        for block in visit.blocks:
            yield f"  {block.name}: {_block(plan, block)}"
    if plan.consent:
        yield f"Nobody begins without consent to version {plan.consent.version} of the text."


def _block(plan: Study, block: Block) -> str:
    if block.form:
        return f"the form {block.form}"
    what = block.condition or ", ".join(block.conditions)
    if block.conditions and block.order != "fixed":
        what += f" in {len(orders(plan, block.conditions))} orders ({block.order})"
    attempts = f", {block.attempts} attempts" if block.attempts else ""
    purpose = "" if block.purpose == "training" else f", {block.purpose}"
    level = "" if block.level is None else f", level {block.level}"
    return f"{what}{attempts}{level}{purpose}"


# --- preregistration


_TO_ADD = "(To be written: [prereg] {key} in the plan.)"


def preregistration(plan: Study, sha256: str) -> str:
    """Return the answers to AsPredicted's nine questions in Markdown. What the plan does not say is
    marked as to be written.

    ``sha256``: of the plan.
    """
    derived = {
        "hypothesis": plan.hypothesis,
        "outcome": " ".join(_outcome(plan, plan.outcome)) if plan.outcome else "",
        "conditions": " ".join(conditions_in_words(plan)),
        "analysis": _analysis(plan.outcome) if plan.outcome else "",
        "people": f"{plan.people} people." if plan.people else "",
        "other": f"The plan of the study is fixed: SHA-256 {sha256}.",
        "type": f"Experiment. {plan.title or plan.name}",
    }
    parts = [f"# Preregistration: {plan.title or plan.name}"]
    for number, (key, question) in enumerate(QUESTIONS.items(), 1):
        own = plan.prereg.get(key, "")
        found = " ".join(filter(None, (derived.get(key, ""), own)))
        parts.append(f"## {number}. {question}\n\n{found or _TO_ADD.format(key=key)}")
    return "\n\n".join(parts) + "\n"


def _outcome(plan: Study, outcome: Outcome) -> Iterator[str]:
    form, dot, _ = outcome.measure.partition(".")
    what = {
        "metric": "The mean over the attempts of the task's measure",
        "accuracy": "The mean accuracy over the attempts",
        "level": "The mean level of the attempts",
        "success_rate": "The share of attempts that reach the goal",
    }.get(outcome.measure, f"The score of the form {form}" if dot else outcome.measure)
    yield f"{what}, in the block {outcome.block} of the visit {outcome.visit}."
    block = plan.block(outcome.visit, outcome.block)
    if block.attempts:
        yield f"The block has {block.attempts} attempts."
    if not block.gives_feedback:
        yield f"It is a {block.purpose} block: without feedback."


def conditions_in_words(plan: Study) -> Iterator[str]:
    """Yield sentences on groups, allocation, orders and conditions."""
    if plan.groups:
        given = plan.allocation
        groups = ", ".join(f"{name} ({group.condition})" for name, group in plan.groups.items())
        yield f"{len(plan.groups)} groups: {groups}."
        weights = {name: group.weight for name, group in plan.groups.items()}
        if len(set(weights.values())) > 1:
            yield f"They are weighted {':'.join(map(str, weights.values()))}."
        yield {
            "simple": "Each person is allocated at random, independently of the others.",
            "blocks": "People are allocated in permuted blocks of random size "
            f"({', '.join(map(str, sizes(given, weights)))}).",
            "big stick": "People are allocated at random until the groups differ by "
            f"{given.largest_difference} (big stick design).",
            "minimisation": "People are allocated by minimisation, which is followed with a "
            f"probability of {given.certainty:g}.",
            "list": "People are allocated by a list that was made elsewhere.",
        }[given.method]
        factors = [*(["site"] if plan.sites else []), *given.strata]
        if factors:
            yield f"Strata: {', '.join(factors)}."
        yield (
            "The assignment is drawn when a person is enrolled, from a key that is not in the plan "
            "or the data, so that nobody can know the next one."
        )
        if given.blind:
            yield "Those who work with participants see neutral codes of groups and conditions."
    for conditions, order in plan.squares.items():
        design = "a Williams design" if order == "williams" else "a balanced Latin square"
        yield f"Within people: {', '.join(conditions)}, in orders of {design}."
    settings = (
        f"{name}: the task {each.task}"
        + "".join(f", {key} = {value}" for key, value in each.settings.items())
        for name, each in plan.conditions.items()
    )
    yield f"Conditions: {'; '.join(settings)}. All other settings have their defaults."


def _analysis(outcome: Outcome) -> str:
    match outcome.compared:
        case "groups":
            return "A two-sided t-test of the outcome between the groups, alpha .05."
        case "within":
            pair = f" ({' and '.join(outcome.conditions)})" if outcome.conditions else ""
            return f"A two-sided paired t-test between the two conditions{pair}, alpha .05."
    base = outcome.baseline
    where = f" (block {base.block}, visit {base.visit})" if base else ""
    return (
        f"Analysis of covariance: the outcome on the group and the baseline{where}; a two-sided "
        "test of the group, alpha .05."
    )


# --- methods


def methods(db: sqlite3.Connection, folder: Path, frozen: Frozen) -> str:
    """Return a page in Markdown: participants and design, then the methods of the sessions. All
    numbers are from the log.
    """
    people = ledger.people(db, frozen)
    ids = {one.id for each in people for one in each.played}
    rows = [row for row in sessions.listing(db, folder) if row["id"] in ids][::-1]
    design = " ".join(_design(frozen, people))
    rest = methods_of_sessions(rows, passports(rows, with_dates=True)) if rows else ""
    return f"# Methods of {frozen.plan.title or frozen.plan.name}\n\n{design}\n\n" + rest.replace(
        "# Methods\n\n", "", 1
    )


def _design(frozen: Frozen, people: Sequence[Participation]) -> Iterator[str]:
    plan = frozen.plan
    enrolled = [one.enrolled for one in people]
    sites = {one.participant.partition("@")[2] for one in enrolled}
    at = f" at {len(sites)} sites" if len(sites) > 1 else ""
    yield f"{len(people)} people were enrolled{at}."
    groups = Counter(one.group for one in enrolled if one.group)
    if groups:
        counts = ", ".join(f"{count} in {name}" for name, count in sorted(groups.items()))
        yield f"By group: {counts}."
    yield from conditions_in_words(plan)
    days = ", ".join(f"{visit.name} (day {visit.day})" for visit in plan.visits)
    yield f"Visits: {days}."
    ended = Counter(one.ended for one in enrolled if one.ended)
    if ended:
        yield f"Participation ended early: {', '.join(f'{n} {how}' for how, n in ended.items())}."
    deviations = Counter(each.what for one in people for each in one.deviations)
    if deviations:
        told = ", ".join(f"{count} {what}" for what, count in deviations.most_common())
        yield f"Deviations from the plan: {told}."
    yield (
        f"The plan was frozen on {frozen.frozen_at[:10]} as version {plan.version} (SHA-256 "
        f"{frozen.sha256})."
    )
