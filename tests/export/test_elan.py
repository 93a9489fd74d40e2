"""Sessions leave as tiers for ELAN: valid documents, in which every act is at its time."""

import re
from datetime import datetime
from itertools import chain
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.export.formats.elan import Annotation, Tier, annotation, document
from tests.export.exported import export_as, export_csv, read_csv
from tests.export.resumed import resumed
from tests.export.test_outputs import REPORTS, store_messages, store_reports
from tests.export.varied import NOTE, store_trials, varied
from tests.program import Call
from tests.store.by_hand import insert

Tiers = dict[str, list[tuple[int, int, str]]]
MS = 1_000_000


def read_eaf(path: Path) -> Tiers:
    """Return the annotations of each tier. Raises AssertionError if the document breaks a rule of
    EAF 3.0.
    """
    root = ElementTree.parse(path).getroot()
    order = ["HEADER", "TIME_ORDER", "TIER", "LINGUISTIC_TYPE", "CONSTRAINT"]
    assert [each.tag for each in root] == sorted((each.tag for each in root), key=order.index)
    assert root.tag == "ANNOTATION_DOCUMENT"
    assert (root.get("FORMAT"), root.get("VERSION")) == ("3.0", "3.0")
    assert datetime.fromisoformat(root.attrib["DATE"]).tzinfo

    def unique(tag: str, name: str) -> list[str]:
        found = [each.attrib[name] for each in root.iter(tag)]
        assert len(set(found)) == len(found)
        return found

    times = [int(slot.attrib["TIME_VALUE"]) for slot in root.iter("TIME_SLOT")]
    slots = dict(zip(unique("TIME_SLOT", "TIME_SLOT_ID"), times, strict=True))
    assert times == sorted(times)
    types = {each.attrib["LINGUISTIC_TYPE_ID"] for each in root.iter("LINGUISTIC_TYPE")}
    ids = unique("ALIGNABLE_ANNOTATION", "ANNOTATION_ID")
    ends = (unique("ALIGNABLE_ANNOTATION", f"TIME_SLOT_REF{end}") for end in (1, 2))
    assert sorted(chain(*ends)) == sorted(slots), "each slot is of one end of one annotation"
    assert all(re.fullmatch(r"[a-z]+\d+", id) for id in [*ids, *slots])
    tiers: Tiers = {name: [] for name in unique("TIER", "TIER_ID")}
    for tier in root.iter("TIER"):
        assert tier.attrib["LINGUISTIC_TYPE_REF"] in types
        found = tiers[tier.attrib["TIER_ID"]]
        for (each,) in tier:
            start, end = (slots[each.attrib[f"TIME_SLOT_REF{number}"]] for number in (1, 2))
            assert 0 <= start < end
            assert not found or found[-1][1] <= start, "no overlap"
            (value,) = each
            found.append((start, end, value.text or ""))
    return tiers


def test_every_act_of_varied_sessions_is_there(tmp_path: Path) -> None:
    varied(tmp_path / "data")
    export_csv(tmp_path / "data", tmp_path / "csv", with_notes=True)
    export_as("elan", tmp_path / "data", tmp_path / "out", with_notes=True)
    for session in read_csv(tmp_path / "csv", "sessions"):
        if session["session"] == "s1":
            continue
        tiers = read_eaf(tmp_path / "out" / f"session_{session['session']}.eaf")

        def own(table: str, of: str = session["session"], **equal: Any) -> list[dict[str, Any]]:
            rows = read_csv(tmp_path / "csv", table)
            return [row for row in rows if row | equal == row and row["session"] == of]

        (run,) = own("runs")
        for seat in "AB" if session["partner"] else "A":
            shown = [row["onset_ns"] or row["response_ns"] for row in own("trials", seat=seat)]
            begun = [round((at - run["clock_ns"]) / MS) for at in shown if at]
            assert sorted(start for start, _, _ in _all(tiers, f"{seat} trials")) == sorted(begun)
            assert len(_all(tiers, f"{seat} attempts")) == len(own("attempts", seat=seat))
            effort, remark = own("answers", seat=seat)
            known = effort["value"] is not None
            assert values(tiers, f"{seat} questions") == [
                f"exertion: {format(effort['value'], 'g') if known else effort['status']}",
                f"remark: {remark['words'] or remark['status']}",
            ]
        for deed in ("say", "show", "gesture", "gaze", "tone"):
            done = [row for row in own("outputs", deed=deed) if row["started_ns"] is not None]
            assert len(_all(tiers, f"agent {deed}")) == len(done)
        assert len(_all(tiers, "operator")) == len(own("actions", decided_by="operator"))
        assert f"operator: pausa: {NOTE.replace(chr(13), '')}" in values(tiers, "notes")
        assert len(_all(tiers, "sensors")) == len(own("sensor_faults"))


def _all(tiers: Tiers, name: str) -> list[tuple[int, int, str]]:
    """Return the annotations of a tier, and of those that what overlaps went to."""
    names = [found for found in tiers if re.fullmatch(rf"{name}( \d+)?", found)]
    return [each for found in names for each in tiers[found]]


def values(tiers: Tiers, name: str) -> list[str]:
    return [value for _, _, value in _all(tiers, name)]


def test_the_parts_of_an_action_are_tiers(tmp_path: Path) -> None:
    data = tmp_path / "data"
    store_trials(data, [])
    final = '{"text": "Hola, \\"Ana\\" <3 & \\u001b", "spoken": "¡Hola!"}'
    given = {"kind": "greeting", "decision": "accepted", "actor": "agent"}
    insert(data, "actions", session="s1", id="a1", final=final, **given)
    anchor = '{"clock_ns": 0, "utc": "2026-01-01T00:00:00+00:00"}'
    insert(data, "runs", session="s1", clock_anchor=anchor)
    gazes = [(id, "screen", "gaze", "started", at) for id, at in (("a1", 200), ("cue-2", 900))]
    store_reports(data, [(*report[:4], report[4] * MS) for report in (*REPORTS, *gazes)])
    store_messages(data, "output/sync", [{"what": "flash", "at": 7 * MS, "source": "flush"}])
    export_as("elan", data, tmp_path / "out", with_notes=True)
    tiers = read_eaf(tmp_path / "out" / "session_s1.eaf")
    assert tiers["agent say"] == [(30, 40, "greeting: ¡Hola!"), (60, 70, "greeting: ¡Hola!")]
    assert tiers["agent show"] == [(20, 120, 'greeting: Hola, "Ana" <3 & \ufffd')], "no known end"
    assert tiers["agent tone"] == [], "never started"
    gazes_seen = [times[:2] for times in tiers["agent gaze"]]
    assert gazes_seen == [(200, 900), (900, 1000)], "until the next"
    assert (7, 107, "flash") in _all(tiers, "session")


def test_a_resumed_session_goes_on_on_the_time_line(tmp_path: Path) -> None:
    resumed(tmp_path / "data")
    export_as("elan", tmp_path / "data", tmp_path / "out", with_notes=True)
    (path,) = (tmp_path / "out").glob("*.eaf")
    tiers = read_eaf(path)
    assert values(tiers, "session") == ["run 1", "run 2"]
    assert set(values(tiers, "notes")) == {"operator: in run 1", "operator: in run 2"}
    assert len(_all(tiers, "A trials")) == 6
    export_csv(tmp_path / "data", tmp_path / "csv")
    (run, _), (_, cut) = (read_csv(tmp_path / "csv", table) for table in ("runs", "attempts"))
    begun = round((cut["started_ns"] - run["clock_ns"]) / MS)
    assert begun in [start for start, _, _ in _all(tiers, "A attempts")], "in the first run"
    ends = [end for tier in tiers.values() for _, end, _ in tier]
    assert max(ends) < 60_000, "the clocks of both runs are related"


def test_a_run_whose_start_is_not_stored_is_named(call: Call, tmp_path: Path) -> None:
    store_trials(tmp_path / "data", [{"stimulus": "f", "onset_ns": 5, "response_ns": 6}])
    exported = export_as("elan", tmp_path / "data", tmp_path / "out")
    assert any("its acts are left out (1)" in problem for problem in exported.problems)
    assert read_eaf(tmp_path / "out" / "session_s1.eaf")["A trials"] == []


TIMES = st.tuples(st.integers(0, 500), st.none() | st.integers(0, 600), st.text(max_size=5))


@given(acts=st.lists(TIMES, max_size=20))
def test_any_acts_make_a_valid_document_and_none_is_lost(
    tmp_path_factory: pytest.TempPathFactory, acts: list[tuple[int, int | None, str]]
) -> None:
    path = tmp_path_factory.mktemp("eaf") / "a.eaf"
    given: list[Annotation] = [annotation(*act) for act in acts]
    tiers = [Tier("notes", given), Tier("empty", [])]
    document(tiers, "2026-01-01T00:00:00+00:00").to_file(path)
    found = [each[:2] for each in _all(read_eaf(path), "notes")]
    assert sorted(found) == sorted((each.start, each.end) for each in given)
