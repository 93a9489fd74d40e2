"""Robots of several makes: each does what it is asked, and each fault is reported in a sentence."""

import re
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest

from sar_tui.drivers import rosbridge
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs import furhat, reachy
from sar_tui.outputs.furhat import Furhat
from sar_tui.outputs.output import OutputError
from sar_tui.outputs.reachy import Reachy
from sar_tui.outputs.robot import CONFIRM, LONGEST, PATIENCE
from sar_tui.outputs.ros4hri import LOOK, Ros4Hri
from tests.fake_rosbridge import wait_until
from tests.needs_speech import needs_speech
from tests.outputs.robot_fixtures import (
    connected,
    furhat_bench,
    is_ready,
    reachy_bench,
    ros4hri_bench,
)
from tests.outputs.ros_fixtures import BenchClock, RosRig

BENCHES: dict[str, Callable[..., AbstractContextManager[tuple[RosRig, Any]]]] = {
    "ros4hri": ros4hri_bench,
    "furhat": furhat_bench,
    "reachy": reachy_bench,
}
UNCONFIRMED = r"^The robot at .* did not confirm that it stopped\.$"
every_robot = pytest.mark.parametrize("bench", BENCHES.values(), ids=BENCHES.keys())


@pytest.fixture(autouse=True)
def _impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rosbridge, "FIRST_RETRY_S", 0.02)
    monkeypatch.setattr(rosbridge, "LONGEST_RETRY_S", 0.05)
    monkeypatch.setattr(furhat, "RETRY_S", 0.02)
    monkeypatch.setattr(reachy, "WATCH_S", 0.05)


def end(rig: RosRig, part: str, action: str = "a", what: str | None = None) -> list[str]:
    """Request a part, wait for its end, and return its states."""
    rig.ask(part, action, what)
    rig.wait_for(part, action)
    return rig.states(action, part)


def begin(rig: RosRig, action: str = "a", part: str = "gesture") -> None:
    """Request a part, and wait until the robot has begun it."""
    rig.ask(part, action)
    rig.wait(lambda: rig.states(action, part) == ["started"])


# --- what every robot does


@every_robot
def test_a_stop_is_confirmed_by_the_robot_in_less_than_a_tenth_of_a_second(bench: Any) -> None:
    with bench() as (rig, robot):
        robot.lasts_s = 30
        part = "gesture" if bench is reachy_bench else "say"
        begin(rig, part=part)
        asked = time.monotonic()
        rig.output.stop()
        rig.wait_for(part, "a")
        took = time.monotonic() - asked
        assert rig.states("a", part) == ["started", "aborted"]
        assert rig.detail("a", part) == ""
        assert took < 10, "the limit is measured by the benchmark, on a machine that does only that"


@every_robot
def test_a_stop_that_the_robot_does_not_confirm_is_reported(bench: Any) -> None:
    with bench("obliging") as (rig, robot):
        robot.lasts_s = 30
        part = "gesture" if bench is reachy_bench else "say"
        begin(rig, part=part)
        robot.manner = "silent" if bench is ros4hri_bench else "deaf"
        rig.output.stop()
        rig.clock.advance(CONFIRM)
        assert rig.states("a", part) == ["started", "aborted"]
        assert re.match(UNCONFIRMED, rig.detail("a", part))
        with pytest.raises(OutputError, match=UNCONFIRMED):
            rig.output.stop()


@every_robot
def test_a_robot_that_is_lost_fails_what_was_under_way_and_is_used_again_when_it_is_back(
    bench: Any,
) -> None:
    with bench() as (rig, robot):
        robot.lasts_s = 30
        begin(rig)
        robot.leave()
        rig.wait_for("gesture", "a")
        assert rig.states("a", "gesture") == ["started", "failed"]
        rig.clock.advance(PATIENCE)
        assert end(rig, "gesture", "lost") == ["failed"]
        assert "port" in rig.detail("lost", "gesture")
        with pytest.raises(OutputError, match=r"^The robot could not be asked to stop\. The robot"):
            rig.output.stop()
        robot.lasts_s = 0
        robot.arrive()
        rig.wait(lambda: is_ready(rig))
        assert end(rig, "gesture", "back") == ["started", "done"]


@every_robot
def test_a_robot_that_hangs_holds_nothing_up(bench: Any) -> None:
    with bench() as (rig, robot):
        robot.freeze()
        asked = time.monotonic()
        rig.ask("gesture", "a")
        rig.ask("gaze", "a", "left")
        rig.output.stop("nothing")
        assert time.monotonic() - asked < 1
        rig.clock.advance(LONGEST + 2 * SECOND)
        assert rig.ended("a", "gesture")
        assert rig.states("a", "gesture")[-1] == "failed"
        assert rig.detail("a", "gesture").endswith(".")


@every_robot
def test_an_error_of_the_robot_is_quoted_in_one_line(bench: Any) -> None:
    with bench("failing") as (rig, _):
        part = "gesture" if bench is reachy_bench else "say"
        assert end(rig, part)[-1] == "failed"
        words = "Backend not running" if bench is reachy_bench else "stuck."
        assert words in rig.detail("a", part)
        assert "\x1b" not in rig.detail("a", part)


@every_robot
def test_nonsense_fails_or_is_ignored(bench: Any) -> None:
    with bench("muddled") as (rig, _):
        rig.ask("gesture", "a")
        if bench is furhat_bench:
            rig.clock.advance(LONGEST)
        rig.wait_for("gesture", "a")
        assert rig.states("a", "gesture")[-1] == "failed"


@every_robot
def test_a_robot_that_is_not_there_fails_after_a_while(bench: Any) -> None:
    make = {ros4hri_bench: Ros4Hri, furhat_bench: Furhat, reachy_bench: Reachy}[bench]
    rig = RosRig(make("//127.0.0.1:9"), BenchClock(), ("say",))
    rig.ask("say", "greeting", "Hello.")
    rig.clock.advance(PATIENCE - 1)
    assert rig.reports == []
    rig.clock.advance(1)
    assert rig.states("greeting", "say") == ["failed"]
    assert "127.0.0.1, port 9" in rig.detail("greeting", "say")
    rig.output.close()


@pytest.mark.parametrize("bench", [ros4hri_bench, furhat_bench])
def test_a_gesture_that_the_robot_lacks_is_skipped_and_reported(bench: Any) -> None:
    options = "?nod=somersault" if bench is ros4hri_bench else "&nod="
    with bench(options=options) as (rig, _):
        for action in ("a", "b"):
            assert end(rig, "gesture", action, "nod") == ["started", "done"]
            assert rig.detail(action, "gesture").startswith("This robot has no ")
        assert end(rig, "gesture", "c", "wave") == ["started", "done"]
        assert rig.detail("c", "gesture") == ""


# --- ROS4HRI


def test_the_skills_receive_speech_motion_and_point() -> None:
    with ros4hri_bench(options="?nod=bow&frame=torso&eyes=1") as (rig, robot):
        end(rig, "say", what="You <b>were</b> faster.")
        end(rig, "gesture", what="nod")
        for where in ("left", "ahead"):
            end(rig, "gaze", where, where)
        meta = {"meta": {"caller": "sar-tui", "priority": 128}}
        assert robot.goals("say") == [meta | {"input": "You  b were /b  faster."}]
        assert robot.goals("replay_motion") == [meta | {"name": "bow", "unsafe": False}]
        point = {"header": {"frame_id": "torso"}, "point": {"x": 1.0, "y": -0.5, "z": 1.0}}
        assert robot.goals("look_at") == [meta | {"target": point}, meta | {"policy": "reset"}]
        types = {said["action_type"] for said in robot.received if "action_type" in said}
        assert types == {
            "communication_skills/action/Say",
            "motions_skills/action/ReplayMotion",
            "interaction_skills/action/LookAt",
        }


def test_a_goal_is_cancelled_past_a_rosbridge_that_takes_up_one_goal_at_a_time() -> None:
    with ros4hri_bench("slow", one_at_a_time=True) as (rig, _):
        begin(rig, part="say")
        rig.output.stop()
        rig.wait_for("say", "a")
        assert rig.states("a", "say") == ["started", "aborted"]
        assert rig.detail("a", "say") == ""


def test_a_goal_that_is_not_accepted_yet_is_cancelled_again() -> None:
    with ros4hri_bench("slow") as (rig, robot):
        rig.ask("say", "a")
        rig.output.stop()
        wait_until(lambda: robot._goals)
        rig.clock.advance(20 * MS)
        rig.wait_for("say", "a")
        assert rig.states("a", "say")[-1] == "aborted"
        assert rig.detail("a", "say") == ""


def test_a_skill_without_feedback_is_reported_when_it_ends_and_a_missing_one_at_once() -> None:
    with ros4hri_bench("terse", 0.2, skills=("/skill/say",)) as (rig, _):
        rig.ask("say", "a", "Hello.")
        rig.clock.advance(5 * SECOND)
        assert not rig.ended("a", "say")
        rig.wait_for("say", "a")
        assert rig.states("a", "say") == ["started", "done"]
        assert end(rig, "gesture") == ["failed"]
        assert (
            rig.detail("a", "gesture") == "This robot does not have the skill /skill/replay_motion."
        )


def test_a_look_that_follows_a_point_is_done_and_ended_by_the_next_look() -> None:
    with ros4hri_bench("slow") as (rig, robot):
        begin(rig, "left", "gaze")
        rig.clock.advance(LOOK)
        rig.wait_for("gaze", "left")
        assert rig.states("left", "gaze") == ["started", "done"]
        rig.ask("gaze", "ahead", "ahead")
        wait_until(lambda: "cancel_action_goal" in {said["op"] for said in robot.received})
        wait_until(lambda: len(robot._goals) == 1)


def test_a_skill_that_another_one_interrupts_is_aborted() -> None:
    with ros4hri_bench("breaking off") as (rig, _):
        assert end(rig, "say") == ["started", "aborted"]
        assert rig.detail("a", "say") == "Somebody came too near."


# --- Furhat


def test_a_furhat_receives_speech_gesture_and_place_to_look_at() -> None:
    with furhat_bench() as (rig, robot):
        end(rig, "say", what="Well done.")
        end(rig, "gesture", what="nod")
        for where in ("right", "ahead"):
            end(rig, "gaze", where, where)
        wait_until(lambda: robot.events("attend.user"))
        (said,), (moved,) = robot.events("speak.text"), robot.events("gesture.start")
        assert (said["text"], said["abort"]) == ("Well done.", False)
        assert (moved["name"], moved["monitor"]) == ("Nod", True)
        (there,), (user,) = robot.events("attend.location"), robot.events("attend.user")
        assert (there["x"], there["y"], there["z"], user["user_id"]) == (0.5, 0, 1, "closest")
        ids = [event["request_id"] for event in (said, moved, there, user)]
        assert len(set(ids)) == 4


def test_speech_that_the_furhat_breaks_off_is_aborted() -> None:
    with furhat_bench("breaking off") as (rig, _):
        assert end(rig, "say") == ["started", "aborted"]


def test_a_gesture_of_a_furhat_cannot_be_stopped_which_is_reported() -> None:
    with furhat_bench("slow") as (rig, robot):
        begin(rig)
        rig.output.stop()
        rig.wait_for("gesture", "a")
        assert rig.states("a", "gesture") == ["started", "aborted"]
        assert rig.detail("a", "gesture").startswith("Furhat does not stop a gesture")
        wait_until(lambda: robot.events("speak.stop"))


@pytest.mark.parametrize("given", ["", "wrong"])
def test_a_wrong_key_is_reported_and_the_right_one_is_read_from_a_file(
    given: str, tmp_path: Path
) -> None:
    file = tmp_path / "key"
    file.write_text("secret\n")
    with furhat_bench(key="secret", options=f"&key_file={file}") as (rig, robot):
        assert end(rig, "say") == ["started", "done"]
        file.write_text(given)
        other = RosRig(Furhat(f"//{robot.host}?key_file={file}"), BenchClock(), ("say",))
        assert end(other, "say") == ["failed"]
        assert "key" in other.detail("a", "say")
        assert "secret" not in other.detail("a", "say")
        other.output.close()
    missing = RosRig(Furhat(f"//127.0.0.1?key_file={tmp_path / 'none'}"), BenchClock(), ("say",))
    assert end(missing, "say") == ["failed"]
    assert "cannot be read" in missing.detail("a", "say")
    missing.output.close()


def test_the_clients_own_package_is_content_with_the_fake_furhat() -> None:
    client = pytest.importorskip("furhat_realtime_api")
    from tests.fake_furhat import FakeFurhat

    robot = FakeFurhat(lasts_s=0.02, key="secret")
    robot.port = 9000  # the client knows no other
    robot.arrive()
    try:
        with pytest.raises(RuntimeError):
            client.FurhatClient("127.0.0.1", "wrong").connect()
        person = client.FurhatClient("127.0.0.1", "secret")
        person.connect()
        person.request_speak_text("Hello.")
        person.request_gesture_start("Nod", wait=True)
        person.request_speak_stop()
        person.request_attend_user()
        person.disconnect()
        kinds = [said["type"] for said in robot.received][2:]
        assert kinds[:2] == ["request.speak.text", "request.gesture.start"]
    finally:
        robot.close()


# --- Reachy Mini


def test_a_reachy_moves_head_and_antennas_through_the_keyframes_and_looks() -> None:
    with reachy_bench() as (rig, robot):
        end(rig, "gesture", what="wave")
        end(rig, "gaze", what="left")
        raised, rest, left = robot.gotos()
        assert [each["duration"] for each in (raised, rest, left)] == [0.3, 0.3, 0.5]
        assert raised["antennas"][0] == 0
        assert raised["antennas"][1] < -0.5, "the participant's right is the robot's left"
        assert rest["antennas"] == [0, 0]
        assert left["head_pose"]["yaw"] < -0.3, "the participant's left is the robot's right"


@needs_speech
def test_a_reachy_plays_the_sound_of_a_text_and_forgets_it_in_the_end() -> None:
    with reachy_bench() as (rig, robot):
        for action in ("a", "b"):
            assert end(rig, "say", action, "Yes.") == ["started", "done"]
        assert list(robot.sounds) == [robot.playing]
        rig.output.close()
        wait_until(lambda: not robot.sounds)


@needs_speech
def test_speech_of_a_reachy_is_stopped_while_it_is_heard_and_before() -> None:
    with reachy_bench() as (rig, robot):
        rig.ask_much("say", "a")
        rig.output.stop()
        rig.wait_for("say", "a")
        assert rig.states("a", "say") == ["aborted"]
        assert not any("play" in path for path in robot.paths())
        rig.ask_much("say", "b")
        rig.wait_for_start("say", "b")
        rig.output.stop()
        rig.wait_for("say", "b")
        assert rig.states("b", "say") == ["started", "aborted"]
        assert robot.playing == ""


@needs_speech
def test_a_sound_that_the_reachy_refuses_fails() -> None:
    with reachy_bench("unplayable") as (rig, _):
        assert end(rig, "say", what="Yes.") == ["failed"]
        assert "Unsupported or invalid audio file" in rig.detail("a", "say")


@pytest.mark.parametrize(
    ("status", "part", "words"),
    [
        ({"no_media": True}, "say", "loudspeaker"),
        ({"media_released": True}, "say", "loudspeaker"),
        ({"backend_status": {"motor_control_mode": "disabled"}}, "gesture", "motors are off"),
    ],
)
def test_a_reachy_without_sound_or_power_fails_with_a_sentence(
    status: dict[str, Any], part: str, words: str
) -> None:
    from tests.fake_reachy import FakeReachy

    server = FakeReachy()
    server.status = status
    with connected(server, Reachy) as (rig, _):
        assert end(rig, part) == ["failed"]
        assert words in rig.detail("a", part)
