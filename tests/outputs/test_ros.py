"""A robot behind a rosbridge server as an output."""

import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import msgspec
import pytest

from sar_tui.drivers import rosbridge
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.node import STOP_TIMEOUT
from sar_tui.outputs.output import OutputError
from sar_tui.outputs.robot import ANSWER, LONGEST, PATIENCE
from sar_tui.outputs.ros import CONFIRM, SETTLE, Ros, Topics, read_report
from tests.fake_rosbridge import Manner, RosBridge, hide_roslibpy, ros_bridge, wait_until
from tests.outputs.contract import THEME, Rig
from tests.outputs.ros_fixtures import BenchClock, RosRig, is_ready, robot_bench

UNCONFIRMED = r"^The robot at .* did not confirm that it stopped\.$"


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rosbridge, "FIRST_RETRY_S", 0.02)
    monkeypatch.setattr(rosbridge, "LONGEST_RETRY_S", 0.05)


def asked(robot: RosBridge, what: str) -> list[dict[str, Any]]:
    return [json.loads(data) for data in robot.data(f"/sar_tui/{what}")]


def begin(rig: RosRig, action: str = "a") -> None:
    """Request a gesture and wait until the robot has begun it."""
    rig.ask("gesture", action)
    rig.wait(lambda: rig.states(action, "gesture") == ["started"])


def end(rig: RosRig, part: str, action: str) -> list[str]:
    """Request a part if it was not, wait for its end, and return its states."""
    if (action, part) not in rig.asked:
        rig.ask(part, action)
    rig.wait_for(part, action)
    return rig.states(action, part)


def answer(robot: RosBridge, report: Any) -> None:
    robot.publish("/sar_tui/report", {"data": json.dumps(report)})


def connect(rig: RosRig, robot: RosBridge) -> None:
    rig.wait(lambda: robot.has_subscriber("/sar_tui/report"))
    rig.wait(lambda: is_ready(rig))


def reported(rig: Rig) -> list[tuple[str, str, str]]:
    return [(report.action, report.part, report.state) for report in rig.reports]


def test_the_robot_receives_speech_gesture_and_gaze() -> None:
    with robot_bench() as (rig, robot):
        rig.ask("say", "praise", "You were 40 milliseconds faster.")
        rig.ask("gesture", "praise", "nod")
        rig.ask("gaze", "praise", "up")
        for part in rig.lasting:
            rig.wait_for(part, "praise")
        (said,), (moved,), (looked,) = (
            asked(robot, each) for each in ("speech", "gesture", "gaze")
        )
        keyframes = list(msgspec.to_builtins(THEME.gestures["nod"].keyframes))
        of = {"id": said["id"]}
        assert said == of | {"text": "You were 40 milliseconds faster.", "language": "en"}
        assert moved == of | {"gesture": "nod", "keyframes": keyframes}
        assert looked == of | {"gaze": "up"}
        assert said["id"].startswith("praise-")
        types = {each["type"] for each in robot.received if each["op"] == "advertise"}
        assert types == {"std_msgs/String"}


def test_the_topics_are_those_of_the_address_and_plain_text_is_sent_in_order_if_it_says_so() -> (
    None
):
    with robot_bench("terse", 0, "?form=text&speech=/tts/say&stop=/halt") as (rig, robot):
        rig.ask("say", "a", "Hello.")
        rig.ask("say", "b", "Well done.")
        rig.wait_for("say", "a", "b")
        end(rig, "gesture", "b")
        assert [state for _, _, state in reported(rig)] == ["started", "done"] * 3
        assert robot.data("/tts/say") == ["Hello.", "Well done."]
        assert robot.data("/sar_tui/gesture") == ["wave"]
        rig.output.stop()
        wait_until(lambda: robot.data("/halt") == ["stop"])
        others = {"/sar_tui/gesture", "/sar_tui/gaze"}
        assert set(robot.ops("advertise")) == {"/tts/say", "/halt", *others}


def test_a_robot_that_never_reports_the_end_fails_after_a_time_that_grows_with_the_text() -> None:
    with robot_bench("slow") as (rig, _):
        rig.ask("say", "short", "Hello.")
        rig.wait(lambda: rig.states("short", "say") == ["started"])
        rig.clock.advance(LONGEST + 599 * MS)
        assert not rig.ended("short", "say")
        rig.clock.advance(1 * MS)
        assert rig.states("short", "say") == ["started", "failed"]
        assert "did not report that it was done" in rig.detail("short", "say")


def test_an_end_of_the_robots_own_accord_is_quoted_in_one_line() -> None:
    with robot_bench("failing") as (rig, robot):
        assert end(rig, "gesture", "a") == ["failed"]
        assert rig.detail("a", "gesture") == "My arm is␛[2J stuck."
        robot.manner = "breaking off"
        assert end(rig, "gesture", "b") == ["started", "aborted"]
        assert rig.detail("b", "gesture") == "Somebody came too near."


def test_invalid_reports_are_ignored_and_reported() -> None:
    with robot_bench("muddled") as (rig, robot):
        rig.ask("say", "a", "Hello.")
        wait_until(lambda: asked(robot, "speech"))
        robot.publish("/sar_tui/report", {"data": 3})
        its = asked(robot, "speech")[0]["id"]
        answer(robot, {"state": "started", "id": its})
        rig.wait(lambda: rig.states("a", "say") == ["started"])
        rig.clock.advance(ANSWER + LONGEST)
        assert rig.states("a", "say") == ["started", "failed"]
        assert "could not be understood: Expected `str`, got `int`" in rig.detail("a", "say")


_DONE = {"state": "done"}
OF_NOTHING: list[Any] = [
    *[_DONE, _DONE | {"deed": "say"}, _DONE | {"id": 7}, _DONE | {"id": "other", "deed": "say"}],
    *[{"state": "finished"}, {"state": ["done"]}, ["done"], "done", None, {}],
]


def test_reports_on_an_inactive_part_change_nothing() -> None:
    with robot_bench("slow") as (rig, robot):
        rig.ask("say", "praise", "Hello.")
        rig.wait(lambda: rig.states("praise", "say") == ["started"])
        for report in OF_NOTHING:
            answer(robot, report)
        its = asked(robot, "speech")[0]["id"]
        answer(robot, {"state": "aborted", "id": its, "deed": "say"})
        assert end(rig, "say", "praise") == ["started", "aborted"]


def test_a_stop_reaches_the_robot_and_the_part_is_aborted_on_confirmation() -> None:
    with robot_bench("slow") as (rig, robot):
        rig.ask("say", "a", "Hello.")
        rig.ask("say", "b", "Well done.")
        rig.ask("gesture", "a")
        rig.wait(lambda: len(rig.reports) == 2)
        robot.manner = "silent"
        rig.output.stop()
        assert reported(rig)[2:] == [("b", "say", "aborted")], (
            "what the robot knows nothing of is over at once"
        )
        wait_until(lambda: asked(robot, "stop") == [{"id": ""}])
        rig.clock.advance(CONFIRM - 1)
        assert len(rig.reports) == 3
        at = rig.clock.now()
        its = asked(robot, "speech")[0]["id"]
        for part in ("say", "gesture"):
            answer(robot, {"state": "aborted", "id": its, "deed": part})
            end(rig, part, "a")
        assert [(report[:3], report.at, report.detail) for report in rig.reports[3:]] == [
            (("a", "say", "aborted"), at, ""),
            (("a", "gesture", "aborted"), at, ""),
        ]
        assert [said["text"] for said in asked(robot, "speech")] == ["Hello."]


def test_a_part_that_ends_during_a_stop_is_aborted_or_failed() -> None:
    with robot_bench("slow") as (rig, robot):
        for action, state, detail in (("a", "done", ""), ("b", "failed", "My arm is stuck.")):
            robot.manner = "slow"
            begin(rig, action)
            robot.manner = "silent"
            rig.output.stop()
            its = asked(robot, "gesture")[-1]["id"]
            answer(robot, {"state": state, "id": its, "deed": "gesture", "detail": detail})
            end(rig, "gesture", action)
        assert end(rig, "gesture", "a") == ["started", "aborted"]
        assert end(rig, "gesture", "b") == ["started", "failed"]
        assert rig.detail("b", "gesture") == "My arm is stuck."


def test_a_stop_of_one_action_names_it_and_waiting_parts_follow_until_the_output_is_closed() -> (
    None
):
    with robot_bench("slow") as (rig, robot):
        rig.ask("say", "a", "Hello.")
        rig.ask("say", "b", "Well done.")
        rig.wait(lambda: rig.states("a", "say") == ["started"])
        rig.output.stop("a")
        rig.wait(lambda: rig.states("b", "say") == ["started"])
        first, second = asked(robot, "speech")
        assert asked(robot, "stop") == [{"id": first["id"]}]
        assert second["text"] == "Well done."
        before = reported(rig)
        rig.output.close()
        rig.output.say("c", "Hello.")
        assert reported(rig) == before
        wait_until(lambda: asked(robot, "stop")[1:] == [{"id": ""}])


def test_an_unconfirmed_stop_is_reported_and_the_next_part_is_sent() -> None:
    with robot_bench("slow") as (rig, robot):
        begin(rig)
        robot.manner = "silent"
        asked_at = rig.clock.now()
        rig.output.stop()
        rig.clock.advance(SECOND)
        rig.output.stop()
        wait_until(lambda: len(asked(robot, "stop")) == 2)
        robot.manner = "obliging"
        rig.ask("gesture", "b")
        rig.clock.advance(CONFIRM - SECOND)
        assert CONFIRM < STOP_TIMEOUT, "the node would give up first"
        assert rig.states("a", "gesture") == ["started", "aborted"]
        assert rig.reports[-1].at == asked_at + CONFIRM
        assert re.match(UNCONFIRMED, rig.detail("a", "gesture"))
        assert end(rig, "gesture", "b") == ["started", "done"]


def test_a_robot_lost_before_confirming_a_stop_has_failed_and_is_stopped_after_reconnecting() -> (
    None
):
    with robot_bench("slow") as (rig, robot):
        begin(rig)
        robot.manner = "silent"
        rig.output.stop()
        robot.leave()
        assert end(rig, "gesture", "a") == ["started", "failed"]
        before = len(asked(robot, "stop"))
        robot.arrive()
        rig.wait(lambda: len(asked(robot, "stop")) == before + 1)


def test_what_is_lost_with_the_bridge_fails_and_the_robot_is_stopped_first_when_it_is_back() -> (
    None
):
    with robot_bench("slow") as (rig, robot):
        rig.clock.advance(PATIENCE)
        rig.output.stop()
        begin(rig)
        rig.ask("gesture", "waiting")
        robot.leave()
        rig.wait_for("gesture", "a", "waiting")
        assert rig.states("a", "gesture") == ["started", "failed"]
        assert rig.detail("a", "gesture").endswith("was lost.")
        assert end(rig, "gesture", "lost") == ["failed"]
        assert f"no ROS bridge at 127.0.0.1, port {robot.port}" in rig.detail("lost", "gesture")
        with pytest.raises(OutputError, match=r"^The robot could not be asked to stop\. The robot"):
            rig.output.stop()

        robot.manner = "silent"
        robot.arrive()
        connect(rig, robot)
        wait_until(lambda: asked(robot, "stop") == [{"id": ""}] * 2)
        assert robot.received[-1]["topic"] == "/sar_tui/stop"
        (lost,) = asked(robot, "gesture")
        for _ in range(2):
            with pytest.raises(OutputError, match=UNCONFIRMED):
                rig.output.stop()
        answer(robot, {"state": "done", "id": lost["id"], "part": "gesture"})
        rig.wait(lambda: not cast(Ros, rig.output)._unended)
        rig.output.stop()
        robot.manner = "slow"
        begin(rig, "after")


def test_a_stop_that_cannot_be_sent_as_the_connection_breaks_has_failed() -> None:
    with robot_bench("slow") as (rig, robot):
        begin(rig)
        link = cast(Ros, rig.output)._link
        assert link
        robot.leave()
        wait_until(lambda: not link.is_connected)  # and the output has not been informed yet
        rig.output.stop()
        assert rig.states("a", "gesture") == ["started", "failed"]
        assert rig.detail("a", "gesture").startswith("The robot could not be asked to stop. ")


def test_an_unacknowledged_part_fails_and_a_stop_is_unconfirmed_while_the_robot_may_speak() -> None:
    with robot_bench("silent") as (rig, robot):
        rig.ask("say", "a", "Hello.")
        rig.wait(lambda: len(asked(robot, "speech")) == 1)
        rig.clock.advance(ANSWER - 1)
        assert rig.reports == []
        rig.clock.advance(1)
        assert rig.states("a", "say") == ["failed"]
        assert f"port {robot.port}, which did not acknowledge it" in rig.detail("a", "say")
        with pytest.raises(OutputError, match=UNCONFIRMED):
            rig.output.stop()
        rig.clock.advance(LONGEST)
        rig.output.stop()

        rig.ask("gaze", "b")
        rig.wait(lambda: len(asked(robot, "gaze")) == 1)
        rig.clock.advance(ANSWER)
        robot.manner = "slow"
        begin(rig, "c")
        rig.output.stop()
        assert end(rig, "gesture", "c") == ["started", "aborted"]
        rig.output.stop()  # a robot that confirms a stop has stopped altogether


@pytest.mark.parametrize(("manner", "form"), [("obliging", "json"), ("terse", "text")])
def test_a_confirmed_stop_is_forgotten(manner: Manner, form: str) -> None:
    with robot_bench(manner, 60, f"?form={form}") as (rig, robot):
        rig.ask("gesture", "a")
        rig.ask("gaze", "a")
        rig.wait(lambda: len(rig.reports) == 2)
        robot.lasts_s = 0
        rig.output.stop()
        end(rig, "gesture", "b")
        rig.clock.advance(ANSWER + 1)
        end(rig, "gesture", "c")
        assert [(action, state) for action, _, state in reported(rig)] == [
            *[("a", "started"), ("a", "started"), ("a", "aborted"), ("a", "aborted")],
            *[("b", "started"), ("b", "done"), ("c", "started"), ("c", "done")],
        ]
        assert not any("confirm" in report.detail for report in rig.reports)


def test_without_a_bridge_requests_fail_after_a_time_and_without_the_package_with_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rig = RosRig(Ros("ros://127.0.0.1:9"), BenchClock(), ("say",))
    rig.ask("say", "greeting", "Hello.")
    rig.clock.advance(PATIENCE - 1)
    assert rig.reports == []
    rig.clock.advance(1)
    assert rig.states("greeting", "say") == ["failed"]
    rig.output.close()
    hide_roslibpy(monkeypatch)
    rig = RosRig(Ros("ros://127.0.0.1"), BenchClock(), ("say",))
    rig.ask("say", "greeting", "Hello.")
    assert end(rig, "say", "greeting") == ["failed"]
    assert "pip install -e '.[ros]'" in rig.detail("greeting", "say")
    rig.output.close()


def test_an_output_serves_several_sessions_across_a_restart_of_the_server() -> None:
    with ros_bridge() as robot:
        output = Ros(f"//{robot.host}")
        for session in ("first", "second", "third"):
            rig = RosRig(output, BenchClock(), ("say",))
            rig.ask("say", "greeting", session)
            connect(rig, robot)
            assert end(rig, "say", "greeting") == ["started", "done"]
            assert rig.reports[0].at >= SETTLE
            output.close()
            robot.leave()
            robot.arrive()
        said = asked(robot, "speech")
        assert [each["text"] for each in said] == ["first", "second", "third"]
        assert len({each["id"] for each in said}) == 3


@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("", "Use ros://HOST"),
        ("//robot/imu", "has no meaning"),
        ("//robot?speech=tts", "speech"),
        ("//robot?sing=/la", "sing"),
    ],
)
def test_an_invalid_address_is_refused_with_the_valid_forms(address: str, words: str) -> None:
    with pytest.raises(OutputError, match=words) as refused:
        Ros(address)
    assert "ros://HOST:PORT" in str(refused.value)


class _Ros2:
    """The part of rclpy that the robot in the documentation uses. Tests feed it messages and run
    its timers.
    """

    def __init__(self, name: str) -> None:
        self.subscriptions: dict[str, Callable[[Any], None]] = {}
        self.said: list[Any] = []
        self.due: dict[Callable[[], None], float] = {}

    def create_publisher(self, kind: type, topic: str, depth: int) -> Any:
        return SimpleNamespace(publish=lambda message: self.said.append(read_report(vars(message))))

    def create_subscription(
        self, kind: type, topic: str, callback: Callable[[Any], None], depth: int
    ) -> None:
        self.subscriptions[topic] = callback

    def create_timer(self, seconds: float, ring: Callable[[], None]) -> Any:
        self.due[ring] = seconds
        return SimpleNamespace(cancel=lambda: self.due.pop(ring))


def test_the_robot_in_the_documentation_answers_commands(monkeypatch: pytest.MonkeyPatch) -> None:
    robots: list[Any] = []
    page = (Path(__file__).parents[2] / "docs" / "connect-a-robot.md").read_text(encoding="utf-8")
    program = page.split("```python\n")[1].split("```")[0]
    rclpy = SimpleNamespace(init=lambda: None, spin=robots.append)
    monkeypatch.setitem(sys.modules, "rclpy", rclpy)
    monkeypatch.setitem(sys.modules, "rclpy.node", SimpleNamespace(Node=_Ros2))
    monkeypatch.setitem(sys.modules, "std_msgs.msg", SimpleNamespace(String=SimpleNamespace))
    exec(program, {})
    (robot,) = robots

    def receive(topic: str, identity: str, **what: Any) -> None:
        robot.subscriptions[topic](SimpleNamespace(**Topics().message(identity, what, "")))

    receive("/sar_tui/speech", "a", text="Hello.", language="en")
    receive("/sar_tui/gesture", "a", gesture="nod", keyframes=THEME.gestures["nod"].keyframes)
    receive("/sar_tui/gaze", "b", gaze="left")
    assert sorted(robot.due.values()) == pytest.approx([0.3, 0.4, 0.42])
    receive("/sar_tui/stop", "b")
    next(iter(robot.due))()
    receive("/sar_tui/stop", "")
    assert [(said.id, said.part, said.state) for said in robot.said] == [
        *[("a", "say", "started"), ("a", "gesture", "started"), ("b", "gaze", "started")],
        *[("b", "gaze", "aborted"), ("a", "say", "done"), ("a", "gesture", "aborted")],
    ]
