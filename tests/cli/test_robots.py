"""``sar-tui robots``: which robots are there, and one that speaks, moves and is stopped."""

import pytest

from sar_tui.outputs import robot
from sar_tui.outputs.examination import Examined, Stopped, Tried, _problems
from tests.fake_furhat import furhat
from tests.fake_rosbridge import ros_bridge
from tests.program import Call


def test_a_robot_speaks_moves_and_is_stopped(call: Call) -> None:
    with furhat("obliging", 0.4) as server:
        address = f"furhat://{server.host}"
        called = call("robots", address, "--say", "Hello.", "--gesture", "nod")
        assert called.code == 0, called.err
        for words in (
            "Robot    reachable",
            "Speech   began",
            "Gesture  began",
            "Stop     confirmed",
        ):
            assert words in called.out
        assert [said["text"] for said in server.events("speak.text")] == [
            "Hello.",
            "Hello. " * 2 + "Hello.",
        ]
        assert server.events("speak.stop")
        found = call("robots", address, "--json").json
        assert (found["address"], found["reachable"], found["problems"]) == (address, True, [])
        assert found["said"]["state"] == found["moved"]["state"] == "done"
        assert 0 <= found["said"]["started_ms"] <= found["said"]["ended_ms"]
        assert found["stopped"]["took_ms"] >= 0


def test_a_robot_that_is_only_looked_for_neither_speaks_nor_moves(call: Call) -> None:
    with ros_bridge() as bridge:
        for kind in ("ros", "ros4hri"):
            assert call("robots", f"{kind}://{bridge.host}", "--quiet").code == 0
        assert not bridge.goals("say")
        assert not bridge.data("/sar_tui/speech")


def test_a_robot_that_does_not_stop_fails(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robot, "LONGEST", 0)
    with furhat("deaf") as server:
        called = call("robots", f"furhat://{server.host}", "--say", "Hello.", "--gesture", "")
        assert called.code == 1
        assert "did not report that it was done" in called.out
        assert "The stop was not confirmed." in called.out


def test_servos_are_there_if_they_move(call: Call) -> None:
    called = call("robots servo --json")
    assert called.code == 1
    assert called.json["reachable"] is False
    assert called.json["moved"]["state"] == "failed"


def test_what_ends_by_itself_is_not_stopped(call: Call) -> None:
    with furhat("obliging", 0.05) as server:
        called = call("robots", f"furhat://{server.host}", "--say", "", "--gesture", "wave")
        assert called.code == 0
        assert "no gesture for wave" in called.out
        assert "Stop" not in called.out


def test_absent_robots_are_told_with_what_to_do(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(robot, "PATIENCE", 0)
    monkeypatch.setattr("sar_tui.outputs.examination.PATIENCE", 100_000_000)
    for kind in ("ros", "ros4hri", "furhat", "reachy"):
        called = call("robots", f"{kind}://127.0.0.1:9")
        assert called.code == 1
        assert "! " in called.out
        assert "127.0.0.1, port 9" in called.out


def test_robots_of_earlier_sessions_are_tried_and_the_forms_of_addresses_listed(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    call("robots").shows("No robot has been used", "furhat://HOST[:9000]", "sar-tui robots ADDRESS")
    with furhat() as server:
        address = f"furhat://{server.host}"
        outputs = f"screen,{address}"
        call("simulate keyboard --user average --attempts 1 --outputs", outputs)
        call("robots").shows(f"{address}: reachable")
        found = call("robots --json").json
        assert [each["address"] for each in found["robots"]] == [address]
        assert "reachy://HOST[:8000]" in found["to_name"]


def test_a_late_stop_and_a_part_that_is_skipped_are_problems() -> None:
    skipped = Tried("done", 1, 1, "This robot has no gesture for wave.")
    found = Examined("servo", True, 1, None, skipped, Stopped(140.0))
    assert _problems(found) == (
        "This robot has no gesture for wave.",
        "The stop was confirmed after 140 ms, later than 100 ms.",
    )
