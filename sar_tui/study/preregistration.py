"""The text of a preregistration from a plan, in the order of AsPredicted's nine questions."""

from collections.abc import Iterator

from sar_tui.study.allocation import sizes
from sar_tui.study.outcome import Outcome
from sar_tui.study.plan import Study

_TO_ADD = "(To be written: [prereg] {key} in the plan.)"
QUESTIONS = {
    "data": "Have any data been collected for this study already?",
    "hypothesis": "What's the main question being asked or hypothesis being tested in this study?",
    "outcome": "Describe the key dependent variable(s) specifying how they will be measured.",
    "conditions": "How many and which conditions will participants be assigned to?",
    "analysis": "Specify exactly which analyses you will conduct to examine the main "
    "question/hypothesis.",
    "exclusions": "Describe exactly how outliers will be defined and handled, and your precise "
    "rule(s) for excluding observations.",
    "people": "How many observations will be collected or what will determine sample size?",
    "other": "Anything else you would like to pre-register?",
    "type": "Type of study and name.",
}
"""The questions by the keys under ``[prereg]`` with which a plan answers them itself."""


def preregistration(plan: Study, sha256: str) -> str:
    """Return the answers in Markdown. What the plan does not say is marked as to be written.

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
