"""Statistics on the operators of several sessions, written by hand."""

from typing import Any

import pytest

from sar_tui.model import messages as m
from sar_tui.reports.wizard_study import (
    ALIKE,
    Exclusion,
    OperatedSession,
    WizardStudy,
    read_session,
    study,
)
from sar_tui.reports.wizard_study_words import sections
from tests.reports.session_script import Script, action, pending, proposal, seen

ANNA, BEN = "operator.anna", "operator.ben"


def session(
    name: str,
    decided: dict[str, tuple[str, float]],
    who: str = ANNA,
    status: str = "completed",
    **parameters: Any,
) -> OperatedSession:
    """Return a session in which an operator decided on proposals: by id, the verdict and the time
    it took (ms).
    """
    script = Script().join(0, who)
    for number, (id, (verdict, took)) in enumerate(decided.items(), 1):
        shown = number * 10_000
        made = proposal(id, valence="negative", text="You were slow.")
        said = {"accept": (made, "accepted"), "edit": (made, "edited")}
        script.log(shown, made, pending(made)).log(shown, seen(id, shown, who))
        at = round((shown + took) * 1e6)
        script.log(
            shown + took,
            m.Decision(action=id, verdict=verdict, actor=who, at=at, valence="neutral"),
        )
        if verdict in said:
            changes = {"valence": "neutral"} if verdict == "edit" else {}
            script.log(shown + took, action(*said[verdict], **changes))
        else:
            script.log(shown + took, m.Dropped(action=id, reason="vetoed", actor=who))
    script.log(100_000, m.Waiting(what="", stage="review"))
    row = {
        "id": name, "task": "keyboard", "mode": "live", "status": status, "participant": f"P{name}",
        "partner": None, "parameters": {"operator_feedback": "approve", **parameters},
    }  # fmt: skip
    return read_session(row, script)


def unattended(name: str) -> OperatedSession:
    row = {
        "id": name, "task": "keyboard", "mode": "live", "status": "completed", "participant": "P9",
        "partner": None, "parameters": {},
    }  # fmt: skip
    return read_session(row, Script().log(5_000, m.Waiting(what="", stage="review")))


@pytest.fixture(scope="module")
def found() -> WizardStudy:
    first = session("1", {"a1": ("accept", 1000), "a2": ("edit", 2000)})
    second = session(
        "2",
        {"a1": ("accept", 600), "a2": ("accept", 800)},
        BEN,
        "aborted",
        operator_feedback="veto",
    )
    return study([first, second, unattended("3")], [Exclusion("4", "The microphone failed.")])


def test_agreement_and_latencies_are_those_of_all_decisions_together(found: WizardStudy) -> None:
    assert (found.agreement.decided, found.agreement.accepted, found.agreement.edited) == (4, 3, 1)
    assert found.agreement_by_kind["feedback"] == found.agreement
    assert found.accepted_shares == (0.5, 0.75, 1.0)
    assert found.decision_ms is not None
    assert (found.decision_ms.n, found.decision_ms.median, found.decision_ms.worst) == (
        4,
        900,
        2000,
    )
    assert found.operators == [ANNA, BEN]


def test_sessions_without_an_operator_and_those_excluded_by_hand_do_not_count(
    found: WizardStudy,
) -> None:
    assert [each.session for each in found.sessions] == ["1", "2"]
    assert [(each.session, each.why) for each in found.excluded] == [
        ("4", "The microphone failed."), ("3", "No operator took part."),
    ]  # fmt: skip
    assert found.sessions[1].remarks == ["stopped early"]


def test_latencies_are_told_by_operator_and_by_what_differs_in_the_plans(
    found: WizardStudy,
) -> None:
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
    read = [
        session(
            str(n),
            {
                "a1": ("accept", 1000 + 100 * n),
                "a2": ("edit" if n > 3 else "accept", 2000 + 100 * n),
            },
        )
        for n in range(6)
    ]
    (drift,) = study(read).drift
    assert drift.decision_ms is not None
    assert (
        drift.sessions,
        drift.decision_ms.slope,
        drift.decision_ms.low,
        drift.decision_ms.high,
    ) == (
        6,
        100,
        100,
        100,
    )
    assert drift.accepted_share is not None
    assert drift.accepted_share.slope < 0
    assert (drift.first_half_ms, drift.second_half_ms) == (1250, 2250)
    few = study(read[:3]).drift[0]
    assert (few.decision_ms, few.accepted_share) == (None, None)


def test_the_words_name_conditions_exclusions_and_what_must_be_added(found: WizardStudy) -> None:
    titles = [section.title for section in sections(found)]
    assert titles == [
        "Sessions",
        "Agreement",
        "Latencies",
        "Drift",
        "Deviations",
        "Exclusions",
        "To add",
    ]
    text = str(sections(found))
    assert "A  operator_feedback approve\\nB  operator_feedback veto" in text
    assert "too few for a trend" in text
    assert "The microphone failed." in text
    nobody = sections(study([unattended("1")]))
    assert nobody[0].parts == ["No operator took part in any of these sessions."]
