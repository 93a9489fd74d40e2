"""``[outcome]`` and ``[power]`` of a plan: the main outcome, and the model of it that power needs."""

import math
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Literal, NamedTuple, TypeVar

import msgspec

from sar_tui.simulation.participant_model import (
    MEAN_MS,
    PERSON_SD_MS,
    SESSION_SD_MS,
    TRIAL_SD_MS,
)
from sar_tui.store.database import StoreError

Design = Literal["within", "groups", "groups, baseline"]
MEASURES = ("metric", "accuracy", "level", "success_rate")
"""Measures of a block of sessions; another is the score of a form, such as ``sus.score``."""
_FORM_SCORE = re.compile(r"[\w-]+\.[\w-]+")

LARGEST = 5000
"""Most people that a study is simulated with."""


class Baseline(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The same measure before the treatment: name of its visit and of its block."""

    visit: str
    block: str


class Outcome(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """``[outcome]``: the one outcome that the study is planned for.

    Attributes:
        measure: one of `MEASURES`, or KIND.score of a form.
        visit, block: where it is measured. A form may be without a block.
        compared: conditions of one person (within), groups, or groups with the baseline as a
            covariate.
        baseline: of groups with a baseline.
        conditions: the two that are compared within people, if the block has more.
    """

    measure: str = "metric"
    visit: str
    block: str = ""
    compared: Design = "groups"
    baseline: Baseline | None = None
    conditions: tuple[str, ...] = ()

    @property
    def is_form(self) -> bool:
        """True if the measure is the score of a form."""
        return self.measure not in MEASURES


class Number(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A number, and where it comes from."""

    value: float
    source: str = "stated in the plan"


class Power(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """``[power]``: the model of the outcome. Without a number, that of healthy people's reaction
    times is taken, if the outcome is one.

    Attributes:
        unit: of the measure.
        place: of the sessions; at home people vary more, and are lost.
        mean: of the measure; it changes no power.
        person_sd: standard deviation (SD) of people's own means.
        session_sd: SD of a person's sessions around their own mean.
        trial_sd: SD of the trials of a session. ``trials``: their number, whose mean is the outcome;
            by default that of the plan's block.
        retest: correlation of two visits, instead of ``session_sd``.
        dropout: share of people who are lost before the outcome.
        effect: difference of the means, in the unit; or ``effect_d``, in SDs of the outcome between
            people; or ``effect_dz``, in SDs of a person's differences.
        sizes: numbers of people to simulate.
        wanted: the power that the smallest size must reach.
    """

    unit: str = "ms"
    place: Literal["lab", "home"] = "lab"
    mean: float | Number | None = None
    person_sd: float | Number | None = None
    session_sd: float | Number | None = None
    trial_sd: float | Number | None = None
    trials: float | Number | None = None
    retest: float | Number | None = None
    dropout: float | Number | None = None
    effect: float | Number | None = None
    effect_d: float | Number | None = None
    effect_dz: float | Number | None = None
    sizes: list[int] = []
    wanted: float = 0.8


_EFFECTS = ("effect", "effect_d", "effect_dz")

_DEARY = "Deary et al. 2011, 10.3758/s13428-010-0024-1"
_REACTION_TIMES = {
    "mean": Number(MEAN_MS, _DEARY),
    "person_sd": Number(PERSON_SD_MS, f"SD of 45 ms with 40 trials: {_DEARY}"),
    "session_sd": Number(SESSION_SD_MS, "weekly retest of .75: 10.3389/fnhum.2015.00595"),
    "trial_sd": Number(TRIAL_SD_MS, _DEARY),
    "trials": Number(40, _DEARY),
}
_OTHERS = {
    "trial_sd": Number(0, "the SD of sessions includes it"),
    "trials": Number(1, "the SD of sessions includes it"),
}
_AT_HOME = {
    "retest": Number(0.55, "at home, four weeks: 10.1371/journal.pone.0231627"),
    "dropout": Number(
        0.2,
        "at home, .15 to .25: 10.1177/15459683231159660",
    ),
}
_IN_LAB = {"dropout": Number(0, "nobody is lost")}

_Rule = tuple[Callable[[float], bool], str]
_AN_SD: _Rule = (lambda sd: 0 <= sd < math.inf, "0 or more")
_AN_EFFECT: _Rule = (lambda effect: effect != 0 and math.isfinite(effect), "other than 0")
_RULES: dict[str, _Rule] = {
    "mean": (math.isfinite, "a finite number"),
    "person_sd": _AN_SD,
    "session_sd": _AN_SD,
    "trial_sd": _AN_SD,
    "trials": (
        lambda number: 1 <= number <= 10_000 and number == int(number),
        "a whole number from 1 to 10,000",
    ),
    "retest": (lambda r: 0 < r < 1, "more than 0 and less than 1"),
    "dropout": (lambda share: 0 <= share <= 0.9, "a share from 0 to 0.9"),
    **dict.fromkeys(_EFFECTS, _AN_EFFECT),
}
"""Bounds of numbers, with the words for them."""
_FORMS = {
    "unit": "a text",
    "place": '"lab" or "home"',
    "sizes": "a list of whole numbers, such as [20, 40, 60]",
    "wanted": "a number, such as 0.8",
    "measure": "a text",
    "visit": "the name of a visit",
    "block": "the name of a block",
    "compared": '"within", "groups" or "groups, baseline"',
    "baseline": '{ visit = "first", block = "baseline" }',
}
_A_NUMBER = 'a number, or { value = 39, source = "…" }'


# --- reading


def read_outcome(plan: Mapping[str, Any]) -> Outcome:
    """Return the outcome of a plan. Raises StoreError."""
    outcome = _converted(plan, "outcome", Outcome)
    if outcome.is_form and not _FORM_SCORE.fullmatch(outcome.measure):
        known = ", ".join(MEASURES)
        raise _refusal(
            f"[outcome] measure must be one of {known}, or the score of a form: SUS.score."
        )
    if not outcome.block and not outcome.is_form:
        raise _refusal(f"[outcome] block is missing: in which block is {outcome.measure} measured?")
    if (outcome.compared == "groups, baseline") != (outcome.baseline is not None):
        raise _refusal(
            '[outcome] baseline and compared = "groups, baseline" belong together: state both, or '
            "neither."
        )
    return outcome


def read_power(plan: Mapping[str, Any], outcome: Outcome) -> Power:
    """Return the model of a plan's outcome, with its numbers checked. Raises StoreError."""
    power = _converted(plan, "power", Power)
    for name, number in _stated(power):
        is_right, words = _RULES[name]
        if not is_right(number.value):
            raise _refusal(f"[power] {name} must be {words}, not {number.value:g}.")
    if not 0.05 < power.wanted < 1:
        raise _refusal(
            f"[power] wanted must be more than 0.05 and less than 1, not {power.wanted:g}."
        )
    least = least_size(outcome.compared)
    for size in power.sizes:
        if not least <= size <= LARGEST:
            raise _refusal(
                f"[power] sizes must be from {least} to {LARGEST:,} people, not {size:,}."
            )
    given = [name for name in _EFFECTS if getattr(power, name) is not None]
    if len(given) != 1:
        raise _refusal(
            f"State one effect in [power]: effect = 20 (in {power.unit}), effect_d = 0.5 (in "
            "standard deviations between people) or effect_dz (in those of a person's differences)."
        )
    if given == ["effect_dz"] and outcome.compared != "within":
        raise _refusal('[power] effect_dz is for compared = "within": state effect_d instead.')
    if power.retest is not None and power.session_sd is not None:
        raise _refusal(
            "State session_sd or retest in [power], not both: each follows from the other."
        )
    return power


def least_size(design: Design) -> int:
    """Return the least number of people with whom a design can be tested."""
    return {"within": 2, "groups": 4, "groups, baseline": 4}[design]


def tasks_of(plan: Mapping[str, Any], outcome: Outcome) -> list[str]:
    """Return the names of the tasks by which the block of the outcome is played."""
    conditions: Mapping[str, Any] = plan.get("conditions", {})
    blocks = [
        block
        for visit in plan.get("visits", ())
        for block in visit.get("blocks", ())
        if visit.get("name") == outcome.visit and block.get("name") == outcome.block
    ]
    names: list[str] = []
    for block in blocks:
        names += block.get("conditions", [])
        if block.get("condition") == "as allocated":
            names += [group.get("condition", "") for group in plan.get("groups", {}).values()]
        elif "condition" in block:
            names.append(block["condition"])
    tasks = (conditions.get(name, {}).get("task") for name in names)
    return list(dict.fromkeys(filter(None, tasks)))


_Table = TypeVar("_Table", Outcome, Power)


def _converted(plan: Mapping[str, Any], name: str, kind: type[_Table]) -> _Table:
    table = plan.get(name)
    if not isinstance(table, Mapping):
        example = ", such as effect = 20" if name == "power" else ""
        raise _refusal(f"The plan has no [{name}]: add it{example} (docs/power.md).")
    fields = kind.__struct_fields__
    if unknown := sorted(table.keys() - set(fields)):
        raise _refusal(
            f"[{name}] has unknown entries: {', '.join(unknown)}. Known are: {', '.join(fields)}."
        )
    try:
        return msgspec.convert(dict(table), kind)
    except msgspec.ValidationError as error:
        inside = re.search(r"`\$\.(\w+)", str(error))
        missing = re.search(r"missing required field `(\w+)`", str(error))
        field = next((found[1] for found in (inside, missing) if found), "")
        what = "is missing: it must be" if missing and not inside else "must be"
        raise _refusal(f"[{name}] {field} {what} {_FORMS.get(field, _A_NUMBER)}.") from None


def _stated(power: Power) -> Iterator[tuple[str, Number]]:
    for name in _RULES:
        given = getattr(power, name)
        if given is not None:
            yield name, given if isinstance(given, Number) else Number(given)


def _refusal(sentence: str) -> StoreError:
    return StoreError(sentence, bad_input=True)


# --- the model


class Model(NamedTuple):
    """The model that studies are drawn from, in the unit of the measure.

    A person's mean of one session is normal around the mean of the measure: a part of the person,
    with ``person_sd``, and one of the session, with ``within_sd``; in the session of the baseline
    with ``baseline_sd``, if that has another number of trials.
    """

    design: Design
    effect: float
    person_sd: float
    within_sd: float
    dropout: float = 0.0
    baseline_sd: float | None = None

    @property
    def of_baseline(self) -> float:
        """SD of a person's baselines."""
        return self.within_sd if self.baseline_sd is None else self.baseline_sd

    @property
    def total_sd(self) -> float:
        """SD of the outcome between people."""
        return math.hypot(self.person_sd, self.within_sd)

    @property
    def difference_sd(self) -> float:
        """SD of the difference of a person's two conditions."""
        return math.sqrt(2) * self.within_sd

    @property
    def retest(self) -> float:
        """Correlation of two visits; of the baseline and the outcome with a baseline."""
        return self.person_sd**2 / (self.total_sd * math.hypot(self.person_sd, self.of_baseline))


class Assumptions(msgspec.Struct, frozen=True):
    """The model of a plan, and the numbers that it follows from, each with its source."""

    model: Model
    unit: str
    numbers: dict[str, Number]

    @property
    def effect(self) -> str:
        """The effect in words."""
        model = self.model
        in_unit = f"{abs(model.effect):.4g} {self.unit}".strip()
        d = f"d = {abs(model.effect) / model.total_sd:.3g}"
        if model.design == "within":
            d = f"dz = {abs(model.effect) / model.difference_sd:.3g}, {d}"
        return f"{in_unit} ({d})"


def assumptions(
    power: Power,
    outcome: Outcome,
    pilot: Mapping[str, Number] | None = None,
    planned_trials: Number | None = None,
    baseline_trials: Number | None = None,
) -> Assumptions:
    """Return the model of an outcome.

    The mean of m trials of a session varies within a person by √(session² + trial² / m). A
    correlation r of two visits gives it as person · √((1 - r) / r) instead.

    Args:
        power, outcome: of the plan.
        pilot: numbers that replace those of the plan, and its correlation of visits, but not the
            number of trials.
        planned_trials: of the plan's block, if ``[power]`` does not say how many there are.
        baseline_trials: of the baseline's block, likewise. If they are others, the SD of a person's
            baselines is √(within² - trial² / m + trial² / m_baseline).

    Raises:
        StoreError: a number is missing, or two contradict each other.
    """
    stated = dict(_stated(power))
    is_time = outcome.measure == "metric" and power.unit == "ms"
    if planned_trials and (is_time or pilot or "trial_sd" in stated):
        stated.setdefault("trials", planned_trials)
    if pilot:
        stated.pop("retest", None)
        stated = {**stated, **pilot, **{k: v for k, v in stated.items() if k == "trials"}}
    defaults = {
        **(_REACTION_TIMES if is_time else _OTHERS),
        **(_AT_HOME if power.place == "home" else _IN_LAB),
    }
    if "session_sd" in stated:
        defaults.pop("retest", None)
    numbers = {**defaults, **stated}
    if "retest" in numbers:
        numbers.pop("session_sd", None)
    needed = ["person_sd", "retest" if "retest" in numbers else "session_sd"]
    if missing := [name for name in needed if name not in numbers]:
        raise _refusal(
            f"[power] {' and '.join(missing)} must be stated: there are defaults for reaction times "
            'only (measure = "metric", unit = "ms").'
        )
    numbers["within_sd"] = within = _within(numbers)
    person = numbers["person_sd"].value
    unit_model = Model(outcome.compared, 1.0, person, within.value, numbers["dropout"].value)
    if not unit_model.total_sd:
        raise _refusal("[power] says that nothing varies: state a standard deviation above 0.")
    if outcome.compared != "groups" and not unit_model.within_sd:
        raise _refusal(
            "[power] says that nobody varies from visit to visit: state session_sd above 0."
        )
    if outcome.baseline and baseline_trials and power.trials is None:
        numbers |= _of_baseline(numbers, baseline_trials)
        if "baseline_sd" in numbers:
            unit_model = unit_model._replace(baseline_sd=numbers["baseline_sd"].value)
    name = next(name for name in _EFFECTS if name in numbers)
    scale = {
        "effect": 1.0,
        "effect_d": unit_model.total_sd,
        "effect_dz": unit_model.difference_sd,
    }[name]
    model = unit_model._replace(effect=numbers[name].value * scale)
    numbers.setdefault("retest", Number(round(model.retest, 3), "follows from the SDs"))
    return Assumptions(model, power.unit, _in_order(numbers))


def _within(numbers: Mapping[str, Number]) -> Number:
    """Return the SD of a person's sessions, with their trials. Raises StoreError."""
    person, trial = numbers["person_sd"].value, numbers["trial_sd"].value
    trials = numbers["trials"].value
    of_trials = trial / math.sqrt(trials)
    if "retest" not in numbers:
        session = numbers["session_sd"].value
        how = f"√({session:g}² + {trial:g}² / {trials:g})" if trial else "that of sessions"
        return Number(math.hypot(session, of_trials), how)
    r = numbers["retest"].value
    within = person * math.sqrt((1 - r) / r)
    if within < of_trials:
        highest = person**2 / (person**2 + of_trials**2)
        raise _refusal(
            f"[power] retest = {r:g} is more than {trials:g} trials with an SD of {trial:g} allow: "
            f"at most {highest:.3g}."
        )
    return Number(within, f"{person:g} · √((1 - {r:g}) / {r:g}), from the retest")


def _of_baseline(numbers: Mapping[str, Number], trials: Number) -> dict[str, Number]:
    """Return the number of trials of a baseline, and the SD of a person's baselines; nothing if it
    has as many as the outcome.
    """
    if trials.value == numbers["trials"].value:
        return {}
    within, trial = numbers["within_sd"].value, numbers["trial_sd"].value
    if not trial:
        return {}
    of_session = max(0.0, within**2 - trial**2 / numbers["trials"].value)
    sd = math.sqrt(of_session + trial**2 / trials.value)
    how = f"√({of_session**0.5:.4g}² + {trial:g}² / {trials.value:g})"
    return {"baseline_trials": trials, "baseline_sd": Number(sd, how)}


def _in_order(numbers: Mapping[str, Number]) -> dict[str, Number]:
    order = [*_RULES]
    at = order.index("trials") + 1
    order[at:at] = ["within_sd", "baseline_trials", "baseline_sd"]
    return {name: numbers[name] for name in order if name in numbers}
