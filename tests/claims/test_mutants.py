"""Fifteen faults planted by hand, each in a number that analysts use: the validation fails because
of each.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from statistics import fmean, median
from typing import Any

import pytest
from msgspec.structs import replace

from sar_tui.export.contents import Contents
from sar_tui.loop import attempt_scoring
from sar_tui.loop.nodes.event_handler import EventHandler
from sar_tui.loop.nodes.perception import Perception
from sar_tui.loop.task import Task
from sar_tui.model.messages import Feedback, KeyPerceived
from sar_tui.model.trial_types import Result, Score
from sar_tui.model.units import MS
from sar_tui.motion import measures as motion_measures
from sar_tui.plugins import Catalogue
from sar_tui.reports import intervention
from sar_tui.rules import limits
from sar_tui.rules.policies import DIFFICULTY
from sar_tui.store import recorder
from sar_tui.validation.registry import VALIDATIONS
from sar_tui.validation.report import Conditions
from tests.claims import exported_tables, measures, smoothness
from tests.examples import first

Patch = pytest.MonkeyPatch


# --- ways to plant


def change_result(patch: Patch, owner: Any, name: str, change: Callable[[Any], Any]) -> None:
    """Change what a function returns."""
    made = getattr(owner, name)
    patch.setattr(owner, name, lambda *given, **named: change(made(*given, **named)))


def change_emitted(patch: Patch, node: Any, kind: type, change: Callable[[Any], Any]) -> None:
    """Change the messages of a kind that a node emits."""
    emit = node.emit

    def emit_changed(self: Any, topic: Any, message: Any) -> None:
        emit(self, topic, change(message) if isinstance(message, kind) else message)

    patch.setattr(node, "emit", emit_changed)


def change_score(patch: Patch, change: Callable[[Score, Sequence[Result]], Score]) -> None:
    score = Task.score
    patch.setattr(Task, "score", lambda self, results: change(score(self, results), results))


def with_metric(
    score: Score, mean: Callable[[list[float]], float], results: Iterable[Result]
) -> Score:
    values = [result.value for result in results if result.value is not None]
    return replace(score, metric=mean(values) if values else None)


def turned(value: float | None) -> float | None:
    return None if value is None else -value


# --- faults


def stored_times_are_late(patch: Patch) -> None:
    def late(rows: Any) -> Any:
        trials = rows["trials"]
        rows["trials"] = [(*row[:10], row[10] and row[10] + 200.0, *row[11:]) for row in trials]
        return rows

    change_result(patch, recorder, "rows_of", late)


def keys_are_perceived_late(patch: Patch) -> None:
    change_emitted(patch, Perception, KeyPerceived, lambda key: replace(key, at=key.at + 150 * MS))


def least_accuracy_is_ignored(patch: Patch) -> None:
    judge = attempt_scoring.judge
    patch.setattr(attempt_scoring, "judge", lambda *given: judge(*given[:3], 0.0))


def result_is_a_median(patch: Patch) -> None:
    def of_counted(score: Score, results: Sequence[Result]) -> Score:
        return with_metric(score, median, (result for result in results if result.counts))

    change_score(patch, of_counted)


def wrong_responses_are_averaged(patch: Patch) -> None:
    change_score(patch, lambda score, results: with_metric(score, fmean, results))


def misses_are_no_prompts(patch: Patch) -> None:
    def answered(score: Score, results: Sequence[Result]) -> Score:
        given = [result for result in results if result.value is not None]
        return replace(score, accuracy=score.correct / max(1, len(given)), trials=len(given))

    change_score(patch, answered)


def level_moves_the_wrong_way(patch: Patch) -> None:
    policy, turned = DIFFICULTY["one-up-one-down"], {"success": "failure", "failure": "success"}

    def step(state: Any, attempt: Any, *given: Any) -> Any:
        return policy.step(state, attempt._replace(outcome=turned[attempt.outcome]), *given)

    patch.setitem(DIFFICULTY, "one-up-one-down", policy._replace(step=step))


def feedback_praises_everything(patch: Patch) -> None:
    change_emitted(patch, EventHandler, Feedback, lambda said: replace(said, valence="positive"))
    praise = {"valence": "positive", "reason": "goal"}
    change_result(patch, attempt_scoring, "judge", lambda judged: replace(judged, **praise))


def feedback_tells_other_figures(patch: Patch) -> None:
    def other(said: Feedback) -> Feedback:
        return said if said.metric is None else replace(said, metric=said.metric + 100.0)

    change_emitted(patch, EventHandler, Feedback, other)


def dose_counts_repetitions_twice(patch: Patch) -> None:
    plus = limits.Dose.plus

    def twice(self: limits.Dose, *, repetitions: int, **more: Any) -> limits.Dose:
        return plus(self, repetitions=2 * repetitions, **more)

    patch.setattr(limits.Dose, "plus", twice)


def report_counts_repetitions_twice(patch: Patch) -> None:
    def twice(dose: Any) -> Any:
        return replace(dose, repetitions=2 * dose.repetitions)

    change_result(patch, intervention, "_dose", twice)


def swings_are_counted_twice(patch: Patch) -> None:
    def twice(found: Any) -> Any:
        return replace(found, count=2 * found.count)

    change_result(patch, measures, "count_repetitions", twice)


def sparc_has_the_other_sign(patch: Patch) -> None:
    change_result(patch, motion_measures, "sparc", turned)


def ldlj_has_the_other_sign(patch: Patch) -> None:
    change_result(patch, motion_measures, "ldlj", turned)


def export_lacks_the_last_row(patch: Patch) -> None:
    rows = Contents.rows

    def fewer(self: Contents, table: Any, owner: str) -> Iterator[Any]:
        found = list(rows(self, table, owner))
        return iter(found[:-1] if table.name == "trials" else found)

    patch.setattr(Contents, "rows", fewer)


Mutant = tuple[Callable[[Patch], None], str, str]
MUTANTS: list[Mutant] = [
    (stored_times_are_late, "exports", "Each reaction time"),
    (keys_are_perceived_late, "exports", "Each reaction time"),
    (least_accuracy_is_ignored, "exports", "An attempt that is fast enough"),
    (result_is_a_median, "exports", "Each result"),
    (wrong_responses_are_averaged, "exports", "Each result"),
    (misses_are_no_prompts, "exports", "Each accuracy"),
    (level_moves_the_wrong_way, "exports", "Each level"),
    (feedback_praises_everything, "exports", "Feedback follows"),
    (feedback_tells_other_figures, "figure-4.13", "Every figure"),
    (dose_counts_repetitions_twice, "exports", "A limit of 40 repetitions"),
    (report_counts_repetitions_twice, "exports", "The intervention report"),
    (swings_are_counted_twice, "measures", "Repetitions of a swing"),
    (sparc_has_the_other_sign, "exports", "SPARC computed anew"),
    (ldlj_has_the_other_sign, "smoothness", "LDLJ of a minimum-jerk movement"),
    (export_lacks_the_last_row, "exports", "Each accuracy"),
]
"""Faults, the validation that must fail because of each, and the beginning of a sentence that must
not hold.
"""

RUNS = {name: validation.run for name, validation in VALIDATIONS.items()}
RUNS |= {"exports": exported_tables.run, "measures": measures.run, "smoothness": smoothness.run}


def failed(catalogue: Catalogue, name: str, reaches: int = 1) -> list[str]:
    conditions = Conditions(catalogue, reaches, is_quick=True, seeds=range(1, 2))
    report = RUNS[name](conditions)
    return [claim.sentence for claim in report.claims if not claim.holds]


@pytest.mark.parametrize("mutant", first(3, MUTANTS), ids=lambda mutant: mutant[0].__name__)
def test_a_planted_fault_fails_its_claim(
    monkeypatch: Patch, catalogue: Catalogue, mutant: Mutant
) -> None:
    plant, caught_by, claim = mutant
    plant(monkeypatch)
    assert [each for each in failed(catalogue, caught_by) if each.startswith(claim)]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["figure-4.13", "measures", "smoothness"])
def test_without_a_fault_each_of_these_validations_holds(catalogue: Catalogue, name: str) -> None:
    assert failed(catalogue, name, reaches=20) == []


def test_exported_tables_hold_without_a_fault(catalogue: Catalogue) -> None:
    assert failed(catalogue, "exports") == []
