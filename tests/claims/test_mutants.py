"""Fifteen faults planted by hand, each in a number that analysts use: the validation fails because
of each.
"""

from collections.abc import Callable, Iterator, Sequence
from statistics import fmean, median
from typing import Any, NamedTuple

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
from sar_tui.motion import repetitions
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


def stored_times_are_late(patch: Patch) -> None:
    rows_of = recorder.rows_of

    def late(*given: Any) -> Any:
        rows = rows_of(*given)
        rows["trials"] = [
            (*row[:10], row[10] and row[10] + 200.0, *row[11:]) for row in rows["trials"]
        ]
        return rows

    patch.setattr(recorder, "rows_of", late)


def keys_are_perceived_late(patch: Patch) -> None:
    _change_emitted(patch, Perception, KeyPerceived, lambda key: replace(key, at=key.at + 150 * MS))


def least_accuracy_is_ignored(patch: Patch) -> None:
    judge = attempt_scoring.judge
    patch.setattr(
        attempt_scoring,
        "judge",
        lambda score, metric, target, least: judge(score, metric, target, 0.0),
    )


def result_is_a_median(patch: Patch) -> None:
    _change_score(
        patch,
        lambda score, results: replace_metric(score, median, [r for r in results if r.counts]),
    )


def wrong_responses_are_averaged(patch: Patch) -> None:
    _change_score(patch, lambda score, results: replace_metric(score, fmean, results))


def misses_are_no_prompts(patch: Patch) -> None:
    def answered(score: Score, results: Sequence[Result]) -> Score:
        given = [result for result in results if result.value is not None]
        return replace(score, accuracy=score.correct / max(1, len(given)), trials=len(given))

    _change_score(patch, answered)


def level_moves_the_wrong_way(patch: Patch) -> None:
    policy, turned = DIFFICULTY["one-up-one-down"], {"success": "failure", "failure": "success"}

    def step(state: Any, attempt: Any, *given: Any) -> Any:
        return policy.step(state, attempt._replace(outcome=turned[attempt.outcome]), *given)

    patch.setitem(DIFFICULTY, "one-up-one-down", policy._replace(step=step))


def feedback_praises_everything(patch: Patch) -> None:
    _change_emitted(
        patch, EventHandler, Feedback, lambda feedback: replace(feedback, valence="positive")
    )
    judge = attempt_scoring.judge
    patch.setattr(
        attempt_scoring,
        "judge",
        lambda *given: replace(judge(*given), valence="positive", reason="goal"),
    )


def feedback_tells_other_figures(patch: Patch) -> None:
    _change_emitted(
        patch,
        EventHandler,
        Feedback,
        lambda feedback: (
            feedback
            if feedback.metric is None
            else replace(feedback, metric=feedback.metric + 100.0)
        ),
    )


def dose_counts_repetitions_twice(patch: Patch) -> None:
    plus = limits.Dose.plus
    patch.setattr(
        limits.Dose,
        "plus",
        lambda self, *, repetitions, **more: plus(self, repetitions=2 * repetitions, **more),
    )


def report_counts_repetitions_twice(patch: Patch) -> None:
    dose = intervention._dose

    def twice(*given: Any) -> Any:
        found = dose(*given)
        return replace(found, repetitions=2 * found.repetitions)

    patch.setattr(intervention, "_dose", twice)


def swings_are_counted_twice(patch: Patch) -> None:
    count = repetitions.count_repetitions

    def twice(*given: Any) -> Any:
        found = count(*given)
        return replace(found, count=2 * found.count)

    patch.setattr(measures, "count_repetitions", twice)


def sparc_has_the_other_sign(patch: Patch) -> None:
    sparc = motion_measures.sparc
    patch.setattr(motion_measures, "sparc", lambda *given: _turned(sparc(*given)))


def ldlj_has_the_other_sign(patch: Patch) -> None:
    ldlj = motion_measures.ldlj
    patch.setattr(motion_measures, "ldlj", lambda *given: _turned(ldlj(*given)))


def export_lacks_the_last_row(patch: Patch) -> None:
    rows = Contents.rows

    def fewer(self: Contents, table: Any, owner: str) -> Iterator[Any]:
        found = list(rows(self, table, owner))
        return iter(found[:-1] if table.name == "trials" else found)

    patch.setattr(Contents, "rows", fewer)


class Mutant(NamedTuple):
    """A fault, the validation that must fail, and the beginning of a sentence that must not
    hold.
    """

    plant: Callable[[Patch], None]
    caught_by: str
    claim: str


MUTANTS = [
    Mutant(stored_times_are_late, "exports", "Each reaction time"),
    Mutant(keys_are_perceived_late, "exports", "Each reaction time"),
    Mutant(least_accuracy_is_ignored, "exports", "An attempt that is fast enough"),
    Mutant(result_is_a_median, "exports", "Each result"),
    Mutant(wrong_responses_are_averaged, "exports", "Each result"),
    Mutant(misses_are_no_prompts, "exports", "Each accuracy"),
    Mutant(level_moves_the_wrong_way, "exports", "Each level"),
    Mutant(feedback_praises_everything, "exports", "Feedback follows"),
    Mutant(feedback_tells_other_figures, "figure-4.13", "Every figure"),
    Mutant(dose_counts_repetitions_twice, "exports", "A limit of 40 repetitions"),
    Mutant(report_counts_repetitions_twice, "exports", "The intervention report"),
    Mutant(swings_are_counted_twice, "measures", "Repetitions of a swing"),
    Mutant(sparc_has_the_other_sign, "exports", "SPARC computed anew"),
    Mutant(ldlj_has_the_other_sign, "smoothness", "LDLJ of a minimum-jerk movement"),
    Mutant(export_lacks_the_last_row, "exports", "Each accuracy"),
]

RUNS = {name: validation.run for name, validation in VALIDATIONS.items()}
RUNS |= {"exports": exported_tables.run, "measures": measures.run, "smoothness": smoothness.run}


def failed(catalogue: Catalogue, name: str, reaches: int = 1) -> list[str]:
    conditions = Conditions(catalogue, reaches, is_quick=True, seeds=range(1, 2))
    report = RUNS[name](conditions)
    return [claim.sentence for claim in report.claims if not claim.holds]


@pytest.mark.parametrize("mutant", first(3, MUTANTS), ids=lambda mutant: mutant.plant.__name__)
def test_a_planted_fault_fails_its_claim(
    monkeypatch: Patch, catalogue: Catalogue, mutant: Mutant
) -> None:
    mutant.plant(monkeypatch)
    assert any(
        sentence.startswith(mutant.claim) for sentence in failed(catalogue, mutant.caught_by)
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted({mutant.caught_by for mutant in MUTANTS} - {"exports"}))
def test_without_a_fault_each_of_these_validations_holds(catalogue: Catalogue, name: str) -> None:
    assert failed(catalogue, name, reaches=20) == []


def test_exported_tables_hold_without_a_fault(catalogue: Catalogue) -> None:
    assert failed(catalogue, "exports") == []


# --- ways to plant


def _change_emitted(patch: Patch, node: Any, kind: type, change: Callable[[Any], Any]) -> None:
    emit = node.emit
    patch.setattr(
        node,
        "emit",
        lambda self, topic, message: emit(
            self, topic, change(message) if isinstance(message, kind) else message
        ),
    )


def _change_score(patch: Patch, change: Callable[[Score, Sequence[Result]], Score]) -> None:
    score = Task.score
    patch.setattr(Task, "score", lambda self, results: change(score(self, results), results))


def replace_metric(
    score: Score, mean: Callable[[list[float]], float], results: Sequence[Result]
) -> Score:
    values = [result.value for result in results if result.value is not None]
    return replace(score, metric=mean(values) if values else None)


def _turned(value: float | None) -> float | None:
    return None if value is None else -value
