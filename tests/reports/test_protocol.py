"""Adherence of operators to their protocol, on sessions written by hand."""

from typing import Any

from sar_tui.model import messages as m
from sar_tui.model.protocol import BY_PROTOCOL, ProtocolStep, WizardProtocol
from sar_tui.reports.protocol import NO_REASON, Adherence, TickTimes, pooled
from sar_tui.reports.protocol_words import section
from sar_tui.reports.wizard import report
from sar_tui.reports.wizard_study import Exclusion, read_session, study
from sar_tui.reports.wizard_study_words import sections as sections_of_study
from sar_tui.reports.wizard_words import sections
from tests.reports.session_script import ANNA, Script, action, decision, has, pending, proposal

STEPS = tuple(ProtocolStep("pause", do) for do in ("say greeting", "gesture nod", "Nod to them."))
PROTOCOL = WizardProtocol("praise", 3, "ab" * 32, late_after_s=10, steps=STEPS)


def at(ms: float) -> int:
    return round(ms * 1e6)


def due(id: str, ms: float, number: int = 3) -> m.ProtocolDue:
    do = STEPS[number - 1].do
    return m.ProtocolDue(id=id, what="step", number=number, attempt=2, do=do, at=at(ms))


def tick(id: str, ms: float, outcome: Any = "done", act: str = "") -> m.ProtocolTicked:
    return m.ProtocolTicked(due=id, outcome=outcome, act=act, actor=ANNA, at=at(ms))


def reason(id: str, text: str, verdict: Any = "veto") -> m.ReasonGiven:
    return m.ReasonGiven(action=id, verdict=verdict, digit=1, text=text, actor=ANNA)


def chosen() -> Script:
    script = Script().join(0)
    return script.log(10, m.ProtocolChosen(protocol=PROTOCOL, practised=2, actor=ANNA))


def found(script: Script) -> Adherence:
    made, latencies = report("s1", {"operator_feedback": "approve"}, script)
    assert made.protocol
    texts = [part for each in sections(made, latencies, 80) for part in each.parts]
    assert any(
        "By the protocol praise version 3" in part for part in texts if isinstance(part, str)
    )
    return made.protocol


def test_a_session_without_a_protocol_has_no_adherence() -> None:
    made, _ = report("s1", {}, Script().join(0).log(5, m.Remark(text="Hm.", actor=ANNA)))
    assert made.protocol is None


def test_what_was_due_is_done_late_left_out_refused_or_omitted() -> None:
    said = m.Remark(text="Hello.", actor=ANNA, id="f1", at=at(3000))
    script = chosen().log(1000, due("d1", 1000), due("d2", 1000, 1), due("d3", 1000))
    script.log(3000, tick("d1", 3000), said, tick("d2", 3001, act="f1"))
    refused = m.ActAnswered(id="f1", actor=ANNA, outcome="refused", at=at(3000))
    script.log(3100, refused, tick("d3", 3100, "not done"))
    script.log(20_000, due("d4", 20_000), due("d5", 20_000)).log(35_000, tick("d4", 35_000))
    adherence = found(script)
    assert [item.outcome for item in adherence.items] == [
        "done", "failed", "not done", "late", "omitted",
    ]  # fmt: skip
    has(adherence, due=5, done=1, late=1, omitted=3, not_done=1, failed=1, operators=1)
    assert adherence.latency_s == TickTimes(2, 8.5, 2.0, 15.0)
    assert (adherence.practised, adherence.outside) == ({ANNA: 2}, {})
    first = section(adherence).parts[0]
    assert "done in time 1 (20%), done late 1 (20%), omitted 3 (60%)" in first
    assert f"practised before: {ANNA} 2" in first


def test_the_first_tick_counts_and_is_in_time_until_the_last_moment() -> None:
    script = chosen().log(1000, due("d1", 1000))
    script.log(11_000, tick("d1", 11_000)).log(12_000, tick("d1", 12_000, "not done"))
    assert [(item.outcome, item.latency_s) for item in found(script).items] == [("done", 10.0)]


def nod(ms: float, id: str) -> m.Remark:
    return m.Remark(gesture="nod", source="gesture", actor=ANNA, at=at(ms), id=id)


def test_an_act_by_its_own_key_is_for_one_thing_that_is_due_by_then() -> None:
    script = chosen().log(500, nod(500, "a")).log(1000, due("d1", 1000, 2), due("d2", 1000, 2))
    script.log(2000, nod(2000, "b"), tick("d1", 2100))
    script.log(2200, nod(2200, "c"), tick("d2", 2300))
    assert found(script).outside == {"gesture": 1}, "the first nod was before it"
    early = chosen().log(500, nod(500, "a")).log(1000, due("d1", 1000, 2), tick("d1", 2100))
    assert found(early).outside == {"gesture": 1}


def test_what_is_told_again_after_a_resume_is_one_item_of_the_new_run() -> None:
    script = chosen().log(1000, due("d1", 1000), due("d2", 1000))
    script.begin(2, 90_000).log(90_000, due("d1", 90_000), due("d2", 90_000))
    adherence = found(script.log(93_000, tick("d1", 93_000)))
    assert [(item.run, item.outcome, item.latency_s) for item in adherence.items] == [
        (2, "done", 3.0),
        (2, "omitted", None),
    ]


def test_acts_that_nothing_asked_for_are_outside_of_the_protocol() -> None:
    script = Script().join(0).log(5, m.Remark(text="Before it.", actor=ANNA, at=at(5)))
    script.log(10, m.ProtocolChosen(protocol=PROTOCOL, actor=ANNA))
    script.log(1000, due("d1", 1000, 2))
    script.log(2000, nod(2000, "a"), tick("d1", 2500))
    script.log(4000, m.Remark(text="Hm.", actor=ANNA, at=at(4000)))
    level = m.SessionCommand(command="level", value=2, actor=ANNA, at=at(5000))
    script.log(5000, level, m.SessionCommand(command="stop", actor=ANNA, at=at(5000)))
    script.log(6000, m.SessionCommand(command="skip", actor="therapist", at=at(6000)))
    by_key = found(script)
    assert by_key.outside == {"say": 1, "level": 1}, "a stop never is, and no therapist"
    assert "Acts outside of the protocol: level 1, said 1." in section(by_key).parts[0]


def vetoed_and_edited() -> Script:
    script = chosen()
    for number, ms in enumerate((1000, 2000, 3000), 1):
        made = proposal(f"a{number}")
        script.log(ms, made, pending(made))
        dropped = m.Dropped(id=f"a{number}", reason="vetoed", actor=ANNA)
        script.log(ms + 500, decision(f"a{number}", "veto", ms + 500), dropped)
    script.log(3600, reason("a1", "technical"), reason("a2", BY_PROTOCOL))
    made = proposal("a4")
    edited = action(made, "edited", text="Good.")
    script.log(4000, made, pending(made)).log(4500, decision("a4", "edit", 4500), edited)
    return script


def test_reasons_of_vetoes_and_edits_are_counted() -> None:
    adherence = found(vetoed_and_edited())
    assert adherence.reasons == {
        "vetoed": {"technical": 1, BY_PROTOCOL: 1, NO_REASON: 1},
        "edited": {NO_REASON: 1},
    }
    assert adherence.outside == {"veto": 2, "edit": 1}, "one veto was the protocol's"
    assert "Reasons of 3 vetoes" in section(adherence).parts[0]


def test_sessions_are_pooled() -> None:
    row = {"id": "s1", "participant": "P01", "mode": "live", "task": "keyboard"}
    row |= {"status": "completed", "parameters": {"operator_feedback": "approve"}}
    one = chosen().log(1000, due("d1", 1000)).log(2000, tick("d1", 2000))
    other = vetoed_and_edited().log(9000, due("d1", 9000))
    without = Script().join(0).log(5000, m.NoteAdded(text="x", actor=ANNA))
    whole = study([read_session(row, script) for script in (one, other, without)], [])
    assert whole.protocol
    has(whole.protocol, due=2, done=1, omitted=1, operators=1, items=[])
    assert len(whole.protocol.protocols) == 1
    assert any(each.title == "Protocol" for each in sections_of_study(whole))
    assert study([read_session(row, without)], [Exclusion("s2", "?")]).protocol is None
    assert pooled([], 0) is None


def test_operators_have_practised_as_often_as_one_session_says_at_most() -> None:
    often = found(chosen().log(20, m.ProtocolChosen(protocol=PROTOCOL, practised=5, actor=ANNA)))
    both = pooled([often, found(chosen())], 1)
    assert both
    assert both.practised == {ANNA: 5}
