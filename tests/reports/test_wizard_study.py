"""Statistics on the operators of several sessions, written by hand."""

import random
from typing import Any

import pytest

from sar_tui.model import messages as m
from sar_tui.reports.wizard_study import (
    ALIKE,
    FEWEST,
    Exclusion,
    OperatedSession,
    WizardStudy,
    read_session,
    study,
    trend,
)
from sar_tui.reports.wizard_study_words import sections
from tests.reports.session_script import Script, action, has, pending, proposal, seen


def row_of(name: str, who: str, status: str = "completed", **parameters: Any) -> dict[str, Any]:
    return {"id": name, "task": "keyboard", "mode": "live", "status": status, "participant": who,
            "partner": None, "parameters": parameters}  # fmt: skip


ANNA, BEN = "operator.anna", "operator.ben"


def session(
    name: str, decided: dict[str, tuple[str, float]], who: str = ANNA, status: str = "completed",
    **parameters: Any,
) -> OperatedSession:  # fmt: skip
    """Return a session in which an operator decided on proposals: by id, the verdict and the time
    it took (ms).
    """
    script = Script().join(0, who)
    for number, (id, (verdict, took)) in enumerate(decided.items(), 1):
        shown = number * 10_000
        made = proposal(id, valence="negative", text="You were slow.")
        ended = action(made, "accepted")
        if verdict == "edit":
            ended = action(made, "edited", valence="neutral")
        script.log(shown, made, pending(made)).log(shown, seen(id, shown, who))
        at = round((shown + took) * 1e6)
        key = m.Decision(action=id, verdict=verdict, actor=who, at=at, valence="neutral")
        script.log(shown + took, key).log(shown + took, ended)
    script.log(100_000, m.Waiting(what="", stage="review"))
    settings = {"operator_feedback": "approve", **parameters}
    return read_session(row_of(name, f"P{name}", status, **settings), script)


def unattended(name: str) -> OperatedSession:
    script = Script().log(5_000, m.Waiting(what="", stage="review"))
    return read_session(row_of(name, "P9"), script)


@pytest.fixture(scope="module")
def found() -> WizardStudy:
    first = session("1", {"a1": ("accept", 1000), "a2": ("edit", 2000)})
    decided = {"a1": ("accept", 600.0), "a2": ("accept", 800.0)}
    second = session("2", decided, BEN, "aborted", operator_feedback="veto")
    return study([first, second, unattended("3")], [Exclusion("4", "The microphone failed.")])


def test_agreement_and_latencies_are_those_of_all_decisions_together(found: WizardStudy) -> None:
    has(found.agreement, decided=4, accepted=3, edited=1)
    assert found.agreement_by_kind["feedback"] == found.agreement
    has(found, accepted_shares=(0.5, 0.75, 1.0), operators=[ANNA, BEN])
    has(found.decision_ms, n=4, median=900, worst=2000)


def test_sessions_without_an_operator_or_excluded_do_not_count(found: WizardStudy) -> None:
    assert [each.session for each in found.sessions] == ["1", "2"]
    assert [(each.session, each.why) for each in found.excluded] == [
        ("4", "The microphone failed."), ("3", "No operator took part."),
    ]  # fmt: skip
    assert found.sessions[1].remarks == ["stopped early"]


def test_latencies_are_told_by_operator_and_by_differing_plans(found: WizardStudy) -> None:
    groups = [(each.operator, each.condition, each.sessions, each.decided) for each in found.groups]
    assert groups == [
        (ANNA, "operator_feedback approve", 1, 2),
        (BEN, "operator_feedback veto", 1, 2),
    ]
    medians = [each.decision_ms.median for each in found.groups if each.decision_ms]
    assert medians == [1500, 700]
    alike = study([session("1", {}), session("2", {})])
    assert {each.condition for each in alike.sessions} == {ALIKE}


def test_drift_is_the_change_from_session_to_session_and_within_them() -> None:
    def decided(n: int) -> dict[str, tuple[str, float]]:
        second = "edit" if n > 3 else "accept"
        return {"a1": ("accept", 1000 + 100 * n), "a2": (second, 2000 + 100 * n)}

    read = [session(str(n), decided(n)) for n in range(6)]
    (drift,) = study(read).drift
    has(drift, sessions=6, first_half_ms=1250, second_half_ms=2250)
    has(drift.decision_ms, slope=100, low=100, high=100)
    assert drift.accepted_share is not None
    assert drift.accepted_share.slope < 0
    has(study(read[:3]).drift[0], decision_ms=None, accepted_share=None)


def test_the_words_name_conditions_exclusions_and_what_must_be_added(found: WizardStudy) -> None:
    titles = [section.title for section in sections(found)]
    assert titles == "Sessions,Agreement,Latencies,Drift,Deviations,Exclusions,To add".split(",")
    text = str(sections(found))
    assert "A  operator_feedback approve\\nB  operator_feedback veto" in text
    assert "too few for a trend" in text
    assert "The microphone failed." in text
    nobody = sections(study([unattended("1")]))
    assert nobody[0].parts == ["No operator took part in any of these sessions."]


@pytest.mark.parametrize("seed", range(4))
def test_the_slope_and_its_interval_are_those_of_scipy(seed: int) -> None:
    stats = pytest.importorskip("scipy.stats")
    chance = random.Random(seed)
    values = [chance.choice((0.5, 3.0)) * step + chance.gauss(0, 4) for step in range(6 + 3 * seed)]
    values[2] = values[1]  # a tie
    found, theirs = trend(values), stats.theilslopes(values, alpha=0.95)
    assert found is not None
    assert (found.slope, found.low, found.high) == pytest.approx(
        (theirs.slope, theirs.low_slope, theirs.high_slope)
    )


def test_few_values_have_no_trend_and_equal_ones_a_flat_one() -> None:
    assert trend([1.0] * (FEWEST - 1)) is None
    flat = trend([7.0] * FEWEST)
    assert flat is not None
    assert (flat.slope, flat.low, flat.high) == (0, 0, 0)
