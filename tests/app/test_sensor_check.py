"""The sensor check before a session shows the state of the sensor and what to do."""

import math
import re
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, closing
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest
from textual.widgets import Button

from sar_tui.app.screens.sensor_check import bar
from sar_tui.app.sensor_advice import FLAGS, INVALID, NO_REACH, finding_text, placing, signed
from sar_tui.inputs.imu import NOTHING, Info, Sample, Status
from sar_tui.inputs.simulated import SimulatedSource
from sar_tui.loop.clock import VirtualClock
from sar_tui.model.units import SECOND
from sar_tui.motion.analysis import Finding
from sar_tui.motion.synthesis import PROFILES, Profile, ReachShape, SimulatedHand
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import Plan, make_plan
from sar_tui.store import programmes
from sar_tui.store.database import StoreError, connect
from tests.album import Album
from tests.app.app_driver import AppDriver, OpenApp, known, open_app, stored

SNAPSHOTS = Path(__file__).parent / "sensor_snapshots"
Alter = Callable[[Sample], Sample]
OpenCheck = Callable[..., Any]


def plain(sample: Sample) -> Sample:
    return sample


class Plugged:
    """Sensor that a test attaches and detaches, and whose samples it may alter."""

    def __init__(
        self, profile: Profile = PROFILES["clean"], alter: Alter = plain, at_once: bool = True
    ) -> None:
        self.info: Info | None = None
        self.profile = profile
        self.alter = alter
        self.at_once = at_once
        self.zeroed = 0
        self.running = False
        self.moves: list[ReachShape] = []
        self.serial = "4711"
        self.clock: VirtualClock

    def start(self, sink: Callable[[Sample], None], on_status: Callable[[Status], None]) -> None:
        self.sink, self.on_status, self.running = sink, on_status, True
        self.inner = SimulatedSource(SimulatedHand(self.profile, 250.0, seed=3), self.clock)
        if self.at_once:
            self.plug()

    def stop(self) -> None:
        self.running = False
        self.inner.stop()

    def zero(self) -> None:
        self.zeroed += 1

    def plug(self) -> None:
        self.info = Info(
            source="USB", model="Spatial 3/3/3 (1044)", serial=self.serial, rate_hz=250.0
        )
        self.inner.start(lambda sample: self.sink(self.alter(sample)), self.on_status)

    def unplug(self) -> None:
        self.inner.stop()
        self.info = None
        self.report("detached")

    def report(self, state: Any, detail: str = "") -> None:
        self.on_status(Status(state=state, at=self.clock.now(), detail=detail))


class Moved(Plugged):
    """Sensor with a simulated hand that makes the test reach."""

    def move(self, at_ns: int, shape: ReachShape) -> None:
        self.moves.append(shape)
        self.inner.move(at_ns, shape)


def reaching_plan(catalogue: Catalogue, **parameters: object) -> Plan:
    given = {"attempts": 2, "imu": "simulated"} | parameters
    return make_plan(catalogue, "reaching", ["P01"], given, seed=7)


@pytest.fixture
def open_check(data: Path, catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch) -> OpenCheck:
    """Open the sensor check of a session with the given sensor."""

    @asynccontextmanager
    async def opened(source: Plugged, **parameters: object) -> AsyncIterator[AppDriver]:
        def open_source(_: str, *, clock: VirtualClock, **__: object) -> Plugged:
            source.clock = clock
            return source

        monkeypatch.setattr("sar_tui.runs.sensors.open_source", open_source)
        async with open_app(data, catalogue, reaching_plan(catalogue, **parameters)) as driver:
            yield driver

    return opened


def axis(driver: AppDriver, name: str) -> tuple[str, ...]:
    """Return the bar, rate, and bias in deg/s and in rad/s of an axis."""
    found = re.search(rf" {name} ([─━╼╾┼]{{9,}}) +(\S+) +(\S+) +(\S+)", driver.text)
    assert found
    return found.groups()


# --- the way through


async def test_the_session_takes_over_the_running_sensor(
    open_check: OpenCheck, opened: OpenApp
) -> None:
    source = Plugged()
    async with open_check(source) as driver:
        assert driver.screen_name == "SensorCheckScreen"
        assert driver.stored("SELECT id FROM sessions") == []
        await driver.wait(1000)
        (feed,) = driver.app.start.feeds
        await driver.press("enter")
        driver.see("Rest your hand with the sensor at the start.")
        await driver.wait(1000)
        assert driver.app.start.feeds == ()
        assert feed.is_running
        assert [message["state"] for message in driver.messages("input/sensor")] == ["attached"]
        assert feed.received > 450
        assert feed.lost == 0
        session = driver.session_id
    assert not source.running
    async with opened(session) as driver:
        assert driver.screen_name == "SessionScreen", "a session that is resumed has no check"
    assert driver.stored("SELECT task, mode FROM sessions") == [("reaching", "live")]


async def test_a_sensor_that_is_not_the_one_of_last_time_is_said(open_check: OpenCheck) -> None:
    for serial, is_said in (("4711", False), ("4711", False), ("4712", True)):
        source = Plugged()
        source.serial = serial
        async with open_check(source) as driver:
            await driver.wait(1000)
            said = re.search(
                r"Last time.*\n.*it was Spatial 3/3/3 \(1044\), serial 4711\.", driver.text
            )
            assert bool(said) == is_said
            await driver.press("enter")
            await driver.wait(1000)


async def test_escape_leads_home_and_back_again(opened: OpenApp, data: Path) -> None:
    known(data, theme="high-contrast", task="reaching", imu="simulated")
    async with opened() as driver:
        start = driver.app.screen.query_one("#start", Button)
        start.active_effect_duration = 0  # it takes no second press meanwhile
        for keys in (("enter", "enter"), ("enter",)):
            await driver.press(*keys)
            assert driver.screen_name == "SensorCheckScreen"
            assert driver.app.theme == "sar-high-contrast"
            (feed,) = driver.app.start.feeds
            await driver.press("escape")
            assert driver.screen_name == "HomeScreen"
            assert not feed.is_running
    assert stored(data, "SELECT id FROM sessions") == []


async def test_the_end_of_the_program_releases_the_sensor(open_check: OpenCheck) -> None:
    source = Plugged()
    async with open_check(source) as driver:
        await driver.wait(300)
        assert source.running
        await driver.press("ctrl+c")
    assert not source.running
    assert driver.app.return_code == 130
    assert driver.stored("SELECT id FROM sessions") == []


async def test_a_session_that_cannot_be_opened_releases_the_sensor(
    open_check: OpenCheck, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = Plugged()
    markers = {"marker_distances_cm": (10, 20, 30, 40, 50, 60)}
    async with open_check(source, max_level=6, start_level=6, **markers) as driver:
        full = Mock(side_effect=StoreError("The disk is full."))
        monkeypatch.setattr("sar_tui.app.live.LiveSession.open", full)
        await driver.press("enter", "enter")
        assert driver.app.failure == "The disk is full."
        assert driver.app.return_code == 1
        assert not source.running


async def test_no_unknown_sensor_begins(opened: OpenApp, catalogue: Catalogue) -> None:
    async with opened(reaching_plan(catalogue, imu="wiimote")) as driver:
        assert 'There is no sensor "wiimote".' in driver.app.failure
        assert driver.app.return_code == 1
    assert driver.stored("SELECT id FROM sessions") == []


# --- what is seen of the sensor


async def test_the_states_of_a_sensor_are_told(open_check: OpenCheck) -> None:
    source = Plugged(at_once=False)
    async with open_check(source) as driver:
        await driver.wait(2900)
        driver.see("Sensor … Looking for it")
        await driver.wait(200)
        driver.see("! No sensor found. Plug it in; it is found by itself.")
        driver.lacks("Samples")
        source.report("detached", "Waiting for the sensor with the number 12.")
        await driver.wait(100)
        driver.see("! No sensor found. Waiting for the sensor with the number 12.")
        source.report("error", "You may not use it: ask for permission.")
        await driver.wait(100)
        driver.see("Sensor ! You may not use it: ask for permission.")

        source.plug()
        await driver.wait(2500)
        driver.see("✓ Spatial 3/3/3 (1044), serial 4711")
        driver.see("Samples ✓ 250 a second of 250, none lost", "At rest ✓ still")
        driver.lacks("permission")
        source.report("error", "The sensor reports: packet lost.")
        await driver.wait(100)
        driver.see("Trouble ! The sensor reports: packet lost.")
        await driver.wait(5000)
        driver.lacks("packet lost")

        source.inner.stop()
        await driver.wait(700)
        driver.see("! It is attached, but sends nothing.")
        driver.lacks("At rest")
        source.unplug()
        await driver.wait(100)
        driver.see("! It was disconnected.")
        driver.lacks("Samples")


async def test_a_finished_recording_is_replayed(open_check: OpenCheck) -> None:
    source = Plugged()
    async with open_check(source) as driver:
        await driver.wait(300)
        source.report("ended")
        await driver.wait(100)
        driver.see("! The recording is over.")
        await driver.press("enter")
        await driver.wait(100)
        assert source.running
        assert [message["state"] for message in driver.messages("input/sensor")] == ["attached"]


async def test_without_a_sensor_enter_asks_first_and_nothing_is_zeroed(
    open_check: OpenCheck,
) -> None:
    source = Plugged(at_once=False)
    async with open_check(source) as driver:
        await driver.press("z")
        driver.see("There is no sensor to zero.")
        assert source.zeroed == 0
        await driver.press("enter")
        assert driver.screen_name == "SensorCheckScreen"
        driver.see("There is no sensor, so the session will wait for one. Press Enter again")
        source.plug()
        await driver.wait(200)
        driver.lacks("Press Enter again")
        await driver.press("z")
        assert source.zeroed == 1
        driver.see("keep the hand still for two seconds")
        await driver.wait(3100)
        driver.lacks("keep the hand still for two seconds")
        source.unplug()
        await driver.wait(200)
        await driver.press("enter", "enter")
        assert driver.screen_name == "SessionScreen"
    assert len(driver.stored("SELECT id FROM sessions")) == 1


async def test_lost_and_unusable_samples_are_counted(open_check: OpenCheck) -> None:
    def spoil(sample: Sample) -> Sample:
        return sample._replace(rate=NOTHING) if round(sample.device_ms) % 400 == 0 else sample

    async with open_check(Plugged(PROFILES["lossy"], spoil)) as driver:
        await driver.wait(4000)
        row = next(row for row in driver.rows if "Samples" in row)
        lost = int(row.split(",")[1].split()[0])
        assert 60 < lost < 140
        assert "8 left out" in row
        driver.see("Trouble ! The sensor reports an angular")


async def test_a_slow_sensor_is_reported(open_check: OpenCheck) -> None:
    source = Plugged(at_once=False)
    async with open_check(source) as driver:
        source.info = Info(source="USB", model="Slow", rate_hz=4.0)
        source.inner.hand = SimulatedHand(PROFILES["clean"], 4.0)
        source.inner.start(source.sink, source.on_status)
        await driver.wait(3000)
        driver.see("That is too few to see a reach.")


async def test_the_bias_is_shown_while_at_rest(open_check: OpenCheck) -> None:
    source = Plugged(PROFILES["biased"])
    async with open_check(source, hand="left") as driver:
        thumb = next(row for row in driver.rows if "↑ y" in row)
        assert "╭─╮" in thumb[thumb.index("y") :], "the thumb of a left hand is at the right"
        assert axis(driver, "z") == ("────────┼────────", "–", "–", "–")
        await driver.wait(2500)
        assert axis(driver, "x") == ("────────┼────────", "+0.10", "+6.00", "+0.105")
        assert axis(driver, "y") == ("────────┼────────", "−0.10", "−6.00", "−0.105")
        driver.see("still, but the bias is large: press Z")
        source.inner.move(
            driver.clock.now(), ReachShape(out_s=1.0, back_s=1.0, peak_out=3.0, peak_back=-3.0)
        )
        await driver.wait(500)
        driver.see("At rest … moving")
        turning, _, *bias = axis(driver, "z")
        assert "━━━" in turning.split("┼")[1]
        assert bias == ["–", "–"]


async def test_a_sensor_that_keeps_its_bias_is_not_said_to_be_zeroed(
    open_check: OpenCheck, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Plugged, "keeps_bias", True, raising=False)
    source = Plugged(PROFILES["biased"])
    async with open_check(source) as driver:
        await driver.wait(2500)
        driver.see("still, but the bias is large")
        driver.lacks("press Z")
        await driver.press("z")
        driver.see("This sensor cannot be zeroed")
    assert source.zeroed == 0


# --- how it lies on the hand


@pytest.mark.parametrize(
    ("up", "mark", "says"),
    [
        ((0.0, 0.0, 9.8), "right", "z points up, as"), ((2.0, 3.0, 9.1), "right", "z points up, as"),
        ((0.0, 0.5, -9.8), "wrong", "z points down"), ((9.8, 0.0, 0.3), "wrong", "x points up."),
        ((0.1, -9.8, 0.3), "wrong", "y points down."), ((0.0, 6.5, 7.4), "wrong", "leaning."),
        ((0.0, 0.0, 14.0), "wait", "moving"), (None, "wait", "cannot be seen"),
    ],
)  # fmt: skip
def test_the_axis_that_points_up_is_found_by_gravity(up: Any, mark: str, says: str) -> None:
    fact = placing(up)
    assert fact.mark == mark
    assert says in fact.text


@pytest.mark.parametrize(
    ("value", "drawn"),
    [(0.0, "────┼────"), (0.5, "────┼╾───"), (2.0, "────┼━━──"), (-2.5, "─╼━━┼────"), (9.0, "────┼━━━━"),
     (-9.0, "━━━━┼────"), (math.nan, "────┼────")],
)  # fmt: skip
def test_a_bar_grows_in_steps_of_half_a_cell(value: float, drawn: str) -> None:
    assert bar(value, 4) == drawn


def test_a_number_has_a_sign_and_zero_is_never_negative() -> None:
    found = [signed(value, 1) for value in (1.26, -1.26, -0.01, 0.0)]
    assert found == ["+1.3", "−1.3", "+0.0", "+0.0"]


# --- the test reach


async def test_a_persons_test_reach_is_found_at_rest(open_check: OpenCheck) -> None:
    source = Plugged(PROFILES["noisy"])
    async with open_check(source) as driver:
        await driver.wait(3000)
        await driver.press("t")
        driver.see("Rest the hand at the start, and keep it still")
        await driver.wait(500)
        source.inner.move(
            driver.clock.now() + SECOND, ReachShape(out_s=0.7, back_s=0.6, dwell_s=0.5)
        )
        await driver.wait(3000)
        driver.see("Now reach out")
        await driver.wait(1200)
        driver.see("dwell 0.")
        assert any("dwell" in row and "├" in row for row in driver.rows)
        await driver.press("t")
        assert not any("├─" in row for row in driver.rows)
        await driver.wait(16_000)
        driver.see(f"! {NO_REACH}")


async def calibrate(driver: AppDriver, source: Plugged, *peaks: float) -> None:
    """Make reaches whose way out is as fast as told (rad/s), each with the same way back."""
    for peak in peaks:
        await driver.wait(500)
        driver.see("Now reach out")
        shape = ReachShape(out_s=0.7, back_s=0.7, dwell_s=0.5, peak_out=peak, peak_back=-peak)
        source.inner.move(driver.clock.now() + SECOND, shape)
        await driver.wait(5000)


async def test_three_reaches_set_the_persons_least_turn(open_check: OpenCheck, data: Path) -> None:
    source = Plugged()
    async with open_check(source) as driver:
        await driver.wait(3000)
        await driver.press("c")
        driver.see("Reach 1 of 3. Rest the hand")
        await calibrate(driver, source, 1.5, 1.2, 1.8)
        driver.see("The reaches turned the hand by 32°, 26°, 38°.", "From 9° on it is a reach.")
        driver.see("Enter keeps that for P01")
        await driver.press("t")
        driver.see("Rest the hand at the start")
        await calibrate(driver, source, 1.5)
        driver.see("Reach ", "From 9° on it is a reach.")
        await driver.press("enter")
        await driver.wait(200)
        assert driver.session.task.parameters.least_turn_deg == 9
    with closing(connect(data)) as database:
        saved = programmes.newest(database, "P01", "reaching")
    assert saved.parameters == {"least_turn_deg": 9.0}
    assert saved.reason == "Calibrated by reaches that turned the hand by 32°, 26°, 38°."


async def test_a_doubtful_reach_does_not_calibrate(open_check: OpenCheck) -> None:
    source = Plugged()
    async with open_check(source) as driver:
        await driver.wait(3000)
        await driver.press("c")
        await calibrate(driver, source, 1.5)
        driver.see("Reach 2 of 3.")
        short = ReachShape(out_s=0.7, back_s=0.7, dwell_s=0.5, peak_out=1.5, peak_back=-0.85)
        source.inner.move(driver.clock.now() + SECOND, short)
        await driver.wait(9000)
        driver.see("! It may have been another movement")
        driver.see("Reach 2 of 3.")
        await driver.press("escape")
        driver.lacks("Reach 2 of 3.")
        driver.see("C: calibrate by three.")


async def test_saturation_is_not_attributed_to_the_cable(open_check: OpenCheck) -> None:
    source = Moved(PROFILES["saturating"])
    async with open_check(source) as driver:
        await driver.wait(2000)
        await driver.press("t")
        await driver.wait(2500)
        driver.see("Trouble ! The hand was faster than the sensor can")
        await driver.wait(6000)
        assert re.search(r"Samples ✓ 250 a second of 250, \d+ beyond its", driver.text)
        driver.lacks("lost", "Trouble")


async def test_a_test_reach_that_does_not_return_ends_with_a_message(
    open_check: OpenCheck,
) -> None:
    source = Plugged()
    async with open_check(source) as driver:
        await driver.wait(1500)
        await driver.press("t")
        await driver.wait(500)
        shape = ReachShape(out_s=0.8, back_s=0.1, peak_out=2.0, peak_back=-0.001)
        source.inner.move(driver.clock.now(), shape)
        await driver.wait(5000)
        driver.see(f"! {NO_REACH}")


async def test_waiting_for_a_hand_to_rest_is_limited(open_check: OpenCheck) -> None:
    def shake(sample: Sample) -> Sample:
        return sample._replace(rate=(0.0, 0.0, 2.0 * math.sin(sample.device_ms / 300)))

    source = Plugged(alter=shake)
    async with open_check(source) as driver:
        await driver.wait(500)
        await driver.press("t")
        await driver.wait(7000)
        driver.see("Rest the hand at the start")
        await driver.wait(1500)
        driver.see("Now reach out")
        source.unplug()
        await driver.wait(100)
        driver.see("! There is no sensor to test.")
        await driver.press("t")
        driver.see("! There is no sensor to test.")


@pytest.mark.parametrize("flag", [*FLAGS, "something_new"])
def test_every_flag_has_a_description(flag: str) -> None:
    found = Finding(
        onset_ns=0, turn_ns=1, end_ns=2, details={"reach_time_ms": 900.0}, flags=(flag,)
    )
    numbers, (mark, text) = finding_text(found, "left")
    assert "Reach 0.90 s" in numbers[1]
    assert mark == "wrong"
    assert text.endswith(".")
    assert not set("_{") & set(text)


@pytest.mark.parametrize(
    ("invalid", "flags", "says"),
    [("", (), NO_REACH), ("", ("too_far",), FLAGS["too_far"])]
    + [(name, (), words) for name, words in INVALID.items()],
)
def test_the_reason_for_no_reach_is_shown(invalid: str, flags: tuple[str, ...], says: str) -> None:
    found = Finding(details={}, invalid=invalid, flags=flags)
    assert finding_text(found, "right") == [("wrong", says)]


# --- how it looks


async def test_snapshot_of_the_check(open_check: OpenCheck) -> None:
    album, source = Album(SNAPSHOTS, "calm", (80, 24)), Moved(PROFILES["drifting"], at_once=False)
    async with open_check(source) as driver:
        await driver.wait(3500)
        await driver.press("enter")
        album.take("no-sensor", driver)
        source.plug()
        await driver.wait(3000)
        album.take("at-rest", driver)
        await driver.press("t")
        await driver.wait(5000)
        album.take("test-reach", driver)
    album.check()


# --- a sensor on the trunk


async def test_the_trunk_is_checked_too(opened: OpenApp, catalogue: Catalogue) -> None:
    async with opened(reaching_plan(catalogue, imu_trunk="simulated")) as driver:
        await driver.wait(500)
        driver.see("On the hand", "Sensor ✓ Simulated hand")
        await driver.press("enter")
        driver.see("Fasten this sensor to the breastbone", "Sensor ✓ Simulated trunk")
        driver.lacks("Placing")
        await driver.press("t")  # it has no test reach
        driver.lacks("Rest the hand at the start")
        await driver.press("enter")
        assert driver.screen_name == "SessionScreen"
        await driver.wait(1000)
        for topic in ("input/sensor", "input/trunk_sensor"):
            assert [message["state"] for message in driver.messages(topic)] == ["attached"]
    found = driver.stored("SELECT part, model FROM imu_streams ORDER BY part")
    assert found == [("hand", "Simulated hand"), ("trunk", "Simulated trunk")]


async def test_a_session_can_begin_without_the_sensor_on_the_trunk(
    opened: OpenApp, catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch
) -> None:
    sources = {"hand": Plugged(), "trunk": Plugged(at_once=False)}

    def open_source(name: str, *, clock: VirtualClock, **_: object) -> Plugged:
        source = sources["trunk" if name == "phidget:2" else "hand"]
        source.clock = clock
        return source

    monkeypatch.setattr("sar_tui.runs.sensors.open_source", open_source)
    async with opened(reaching_plan(catalogue, imu="phidget:1", imu_trunk="phidget:2")) as driver:
        await driver.wait(500)
        await driver.press("enter", "enter")
        driver.see("There is no sensor on the trunk. Reaches count without it.")
        await driver.press("enter")
        assert driver.screen_name == "SessionScreen"
        await driver.wait(1000)
        driver.see("Rest your hand with the sensor at the start.")
