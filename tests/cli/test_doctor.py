"""``sar-tui doctor``: what works here, and what does not."""

import importlib.util
import json
import shutil
import sys
import tempfile
from collections import namedtuple
from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path
from socket import socket
from threading import Barrier
from types import SimpleNamespace
from typing import Any

import pytest

from sar_tui.cli.common import Home
from sar_tui.cli.doctor import command, devices, machine
from sar_tui.cli.doctor import devices as link
from sar_tui.cli.doctor.command import Check, examine
from sar_tui.cli.doctor.finding import Finding, Machine, ok
from sar_tui.cli.doctor.letterbox import letterbox
from sar_tui.drivers import phidget as driver
from sar_tui.drivers.installation import pip_install, pip_install_extra
from sar_tui.inputs import phidget
from sar_tui.inputs.imu import Info, Status
from sar_tui.letterbox.exchange import exchange
from sar_tui.letterbox.letterbox import revoke
from sar_tui.link.authority import FOLDER, Authority
from sar_tui.link.discovery import JoinableSession, announce
from sar_tui.link.zenoh_settings import Guest, parse_endpoint
from sar_tui.loop.clock import VirtualClock
from sar_tui.outputs.sound.protocol import Examined
from sar_tui.store.database import connect
from tests.home_and_clinic import Pair, _joined, exchanged, pair
from tests.needs_speech import needs_speech
from tests.outputs.servo_fixtures import UNSUPPORTED, FakeServo
from tests.outputs.voice_fixtures import ENGINE, NOBODY, program_with
from tests.plugged_in import offer
from tests.program import Call

__all__ = ["_joined", "pair"]

NOW = datetime.now(UTC)
Patch = pytest.MonkeyPatch
Look = Callable[[Machine], Finding]


@pytest.fixture(autouse=True)
def known_machine(monkeypatch: Patch) -> None:
    """A terminal, and no devices: the doctor waits neither for a sensor nor for the voice."""
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setenv("LINES", "30")
    monkeypatch.setattr(driver, "new_channel", lambda _kind: None)
    monkeypatch.setattr(driver, "usb_denied", lambda: False)
    monkeypatch.setattr(driver, "plugged_in", lambda: False)
    monkeypatch.setattr(devices, "_SENSOR_S", 0.001)
    monkeypatch.setattr(devices, "_SERVO_S", 0.001)
    monkeypatch.setattr(devices, "motion_sensor", lambda _: ok("none plugged in"))
    monkeypatch.setattr(devices, "examine_voice", lambda: Examined(card="Null"))


motion_sensor = devices.motion_sensor
examine_voice = devices.examine_voice


@pytest.fixture
def here(tmp_path: Path) -> Machine:
    return Machine(Home(tmp_path / "data"), lambda: Examined(card="Null"))


def check(found: Finding, state: str, says: str = "", advice: str = "") -> None:
    assert found.state == state, found
    assert says in found.found
    assert advice in found.advice


def raising(error: Exception) -> Callable[..., None]:
    def fail(*_: object) -> None:
        raise error

    return fail


# --- the command


def test_the_exit_code_is_0_and_1_if_there_is_a_problem(call: Call, data: Path) -> None:
    called = call("doctor")
    assert (called.code, called.err, "✗" in called.out) == (0, "", False)
    rows = call("doctor --json").json["checks"]
    assert {tuple(row) for row in rows} == {("name", "state", "found", "mend")}
    assert [row["name"] for row in rows] == [check.name for check in command.checks()]
    assert all(row["name"] in called.out for row in rows)
    (data / "sar-tui.db").write_text("no database at all")
    call("doctor").shows("✗ Data", "→ Choose another folder", code=1)


def test_checks_that_wait_wait_side_by_side_and_one_that_fails_is_a_finding(tmp_path: Path) -> None:
    together = Barrier(2)

    def meets(_: Machine) -> Finding:
        together.wait(timeout=60)
        return ok("met the other")

    fails = raising(ZeroDivisionError("a plain mistake"))
    checks = [
        ("one", meets, True),
        ("two", fails, True),
        ("three", meets, True),
        ("4", fails, False),
    ]
    says = "This check failed (ZeroDivisionError: a plain mistake)."
    assert list(examine(Home(tmp_path), [Check(*each) for each in checks])) == [
        Finding("one", "ok", "met the other"),
        Finding("two", "bad", says),
        Finding("three", "ok", "met the other"),
        Finding("4", "bad", says),
    ]


# --- the machine


@pytest.mark.parametrize(
    ("look", "variables", "state", "says"),
    [
        (machine.terminal, {"TERM": "dumb"}, "bad", "TERM=dumb"),
        (machine.terminal, {}, "care", "redirected"),
        (machine.size, {"COLUMNS": "60"}, "care", "60×30"),
        (machine.size, {"COLUMNS": "90"}, "ok", "90×30"),
        (machine.colours, {"NO_COLOR": "1"}, "ok", "off"),
        (machine.connection, {}, "ok", "directly"),
        (machine.connection, {"SSH_CONNECTION": "1.2.3.4", "TMUX": "/t"}, "care", "SSH and tmux"),
    ],
)
@pytest.mark.usefixtures("call")
def test_the_terminal_is_judged(
    here: Machine, monkeypatch: Patch, look: Look, variables: dict[str, str], state: str, says: str
) -> None:
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    check(look(here), state, says)


def test_a_full_disk_and_the_way_of_showing_pictures_are_told(
    here: Machine, monkeypatch: Patch
) -> None:
    usage = namedtuple("usage", "total used free")
    for free, state in ((10, "bad"), (100, "care"), (10_000, "ok")):
        found = usage(10**12, 0, free * 1_000_000)
        monkeypatch.setattr("shutil.disk_usage", lambda _, found=found: found)
        assert machine.disk_space(here).state == state
    for way, says in (("kitty", "kitty's"), ("half blocks", "half blocks"), (None, "not inst")):
        monkeypatch.setattr("sar_tui.widgets.prompt_pictures.find_way", lambda way=way: way)
        check(machine.pictures(here), "ok", says)


FIGURES = {"measured_at": "2026-01-02T03:04", "median_ms": 0.3, "robust_sd_ms": 0.1, "p99_ms": 0.9}


@pytest.mark.parametrize(
    ("text", "state", "advice"),
    [
        (None, "care", "sar-tui timing"),
        ("{", "care", "sar-tui timing"),
        (json.dumps({"verdict": "fit"}), "care", "sar-tui timing"),
        (json.dumps({**FIGURES, "verdict": "fit"}), "ok", ""),
        (json.dumps({**FIGURES, "verdict": "not fit"}), "care", "says why"),
    ],
    ids=["none", "broken", "incomplete", "fit", "not fit"],
)
def test_measured_timing_is_reported(
    here: Machine, text: str | None, state: str, advice: str
) -> None:
    if text is not None:
        here.home.folder.mkdir()
        (here.home.folder / "timing.json").write_text(text)
    check(machine.measured_timing(here), state, advice=advice)


@pytest.mark.skipif(sys.platform == "win32", reason="the driver of POSIX systems")
def test_a_textual_without_the_expected_file_is_noticed(here: Machine, monkeypatch: Patch) -> None:
    from textual.drivers.linux_driver import LinuxDriver

    assert machine.onset_stamps(here).state == "ok"
    monkeypatch.setattr(LinuxDriver, "__init__", lambda self: None)
    assert machine.onset_stamps(here).state == "care"


def test_tasks_that_do_not_load_and_folders_that_are_missing_are_noticed(tmp_path: Path) -> None:
    (tmp_path / "mine" / "broken").mkdir(parents=True)
    (tmp_path / "mine" / "broken" / "task.py").write_text("this is no Python")
    for folder in (tmp_path / "mine", tmp_path / "none"):
        here = Machine(Home(tmp_path, (folder,)), Examined)
        assert machine.tasks(here).state == "bad"
        assert machine.themes(here).state == "ok"


def test_outputs_of_plug_ins_are_loaded(here: Machine, monkeypatch: Patch) -> None:
    def offered(load: Callable[[], object]) -> Finding:
        entry = SimpleNamespace(name="lamp", value="lamp:Lamp", load=load)
        offer(monkeypatch, "sar_tui.outputs", [entry])
        return machine.outputs(here)

    assert {"lamp", "ros", "screen"} <= set(offered(lambda: object).found.split(", "))
    says = "The output lamp (lamp:Lamp) cannot be loaded: ImportError"
    check(offered(raising(ImportError("no lamp here"))), "bad", says)


# --- devices


DETACHED = Status(state="detached", at=0)
ATTACHED = Status(state="attached", at=1)
NO_GYROSCOPE = Status(state="error", at=0, detail="It has no gyroscope.")


class Plugged:
    """Fake PhidgetSpatial that reports its statuses at once."""

    stopped = False

    def __init__(self, *statuses: Status) -> None:
        self.statuses = statuses
        self.info = Info(source="USB", model="Spatial 3/3/3", serial="629001", rate_hz=250.0)

    def start(self, sink: object, on_status: Callable[[Status], None]) -> None:
        for status in self.statuses:
            on_status(status)

    def stop(self) -> None:
        self.stopped = True


@pytest.mark.parametrize(
    ("statuses", "system", "rule", "state", "says", "has_advice"),
    [
        ([DETACHED], "linux", False, "ok", "none plugged in", True),
        ([], "linux", True, "ok", "none plugged in", False),
        ([], "win32", False, "ok", "none plugged in", False),
        ([ATTACHED], "linux", False, "ok", "Spatial 3/3/3, serial 629001, 250 samples", False),
        ([NO_GYROSCOPE], "linux", False, "care", "no gyroscope", False),
    ],
)
def test_a_motion_sensor_is_looked_for_and_what_one_needs_is_said(
    here: Machine,
    monkeypatch: Patch,
    statuses: list[Status],
    system: str,
    rule: bool,
    state: str,
    says: str,
    has_advice: bool,
) -> None:
    sensor = Plugged(*statuses)
    monkeypatch.setattr(phidget, "PhidgetSource", lambda: sensor)
    monkeypatch.setattr("os.geteuid", lambda: 1000)
    monkeypatch.setattr(devices, "_has_udev_rule", lambda: rule)
    monkeypatch.setattr(sys, "platform", system)
    found = motion_sensor(here)
    check(found, state, says)
    assert ("write the line" in found.advice) == has_advice
    assert sensor.stopped
    monkeypatch.setattr(driver, "usb_denied", lambda: True)
    line = 'SUBSYSTEM=="usb", ATTRS{idVendor}=="06c2", TAG+="uaccess"'
    check(motion_sensor(here), "bad", advice=line)


def test_phidgets_and_rules_for_them_are_known_by_the_vendor(
    tmp_path: Path, monkeypatch: Patch
) -> None:
    monkeypatch.undo()
    (tmp_path / "50-other.rules").write_text('ATTRS{idVendor}=="1234"')
    assert not devices._has_udev_rule((tmp_path, tmp_path / "none"))
    (tmp_path / "99-lab.rules").write_text('SUBSYSTEM=="usb", ATTRS{idVendor}=="06C2", MODE="0666"')
    assert devices._has_udev_rule((tmp_path,))
    assert driver.plugged_in(tmp_path / "none") is None
    for device, vendor in (("1-1", "046d"), ("1-2", "06c2")):
        assert driver.plugged_in(tmp_path) is False
        (tmp_path / device).mkdir()
        (tmp_path / device / "idVendor").write_text(f"{vendor}\n")
    assert driver.plugged_in(tmp_path) is True


@pytest.mark.parametrize(
    ("error", "says", "advice"),
    [
        (ImportError("Phidget22"), "Phidget22 is missing", pip_install("phidget22")),
        (OSError("libusb-1.0.so.0: none"), "libusb-1.0.so.0: none", "pip install phidget22"),
    ],
)
def test_a_missing_driver_is_reported_with_its_fix(
    here: Machine, monkeypatch: Patch, error: Exception, says: str, advice: str
) -> None:
    assert devices.servo_controller(here).state == "ok", "the system lists none"
    monkeypatch.setattr(driver, "new_channel", raising(error))
    monkeypatch.setattr(driver, "plugged_in", lambda: None)
    check(devices.sensor_driver(here), "care", says, advice)
    assert "Sensor driver" in devices.servo_controller(here).advice
    monkeypatch.setattr(driver, "usb_denied", lambda: True)
    assert devices.servo_controller(here).advice == "See: Motion sensor."


@pytest.mark.parametrize(
    ("opening", "failing", "state", "says", "advice"),
    [
        (FakeServo.plug_in, {}, "ok", "makes its motors limp 1000 ms", ""),
        (FakeServo.plug_in, {"enableFailsafe": UNSUPPORTED}, "care", "has no failsafe", "limp"),
        (lambda motor: None, {}, "ok", "none plugged in, or another program uses it.", ""),
        (lambda motor: motor.err(2, "In use."), {}, "ok", "Close the other program", ""),
    ],
    ids=["failsafe", "no failsafe", "none", "in use"],
)
def test_a_servo_controller_is_looked_for(
    here: Machine,
    monkeypatch: Patch,
    opening: Callable[[FakeServo], None],
    failing: dict[str, Any],
    state: str,
    says: str,
    advice: str,
) -> None:
    motor = FakeServo(VirtualClock())
    motor.during.update(open=lambda: opening(motor))
    motor.failing.update(failing)
    monkeypatch.setattr(driver, "new_channel", lambda _kind: motor)
    monkeypatch.setattr(driver, "plugged_in", lambda: None)
    check(devices.servo_controller(here), state, says, advice)
    assert (motor.sent("setEngaged"), motor.sent("close")) == ([], [None])


@needs_speech
def test_an_engine_with_voices_for_each_language_is_ok(here: Machine) -> None:
    check(
        devices.speech_engine(here._replace(voice=examine_voice)),
        "ok",
        "English, German and Spanish",
    )


@pytest.mark.parametrize(
    ("look", "voice", "state", "says", "advice"),
    [
        ("speech_engine", [program_with(ENGINE)], "care", "1 voice, but none for German or Spanish", "espeak-ng"),
        ("speech_engine", [program_with("def init(): 1 / 0")], "care", "speech engine", "Install espeak-ng"),
        ("sound_card", {"backends": NOBODY}, "ok", "by Null", ""),
        ("sound_card", {"backends": ("WASAPI",)}, "care", "no sound card", "Connect loudspeakers"),
        ("sound_card", [[sys.executable, "-c", ""]], "care", "stopped working", "Restart"),
    ],
)  # fmt: skip
def test_speech_and_sound_are_looked_for(
    here: Machine, look: str, voice: Any, state: str, says: str, advice: str
) -> None:
    given, named = ((), voice) if isinstance(voice, dict) else (voice, {})
    machine = here._replace(voice=lambda: examine_voice(*given, **named))
    check(getattr(devices, look)(machine), state, says, advice)


def test_markers_name_their_clock_and_their_ports(here: Machine, monkeypatch: Patch) -> None:
    pytest.importorskip("pylsl")
    pytest.importorskip("serial")
    assert "its clock is " in devices.lsl_markers(here).found
    port = type("Port", (), {"device": "/dev/ttyUSB0"})
    for ports, found in (([port], "ports: /dev/ttyUSB0"), ([], "installed; there is no serial")):
        monkeypatch.setattr("serial.tools.list_ports.comports", lambda ports=ports: ports)
        assert devices.serial_markers(here).found.startswith(found)


# --- the link


@pytest.fixture
def runtime(monkeypatch: Patch) -> Iterator[Path]:
    """Runtime folder with a short path."""
    folder = Path(tempfile.mkdtemp(prefix="sar-"))
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(folder))
    yield folder
    shutil.rmtree(folder)


def test_operators_can_join_through_a_folder_of_ones_own(
    here: Machine, runtime: Path, monkeypatch: Patch
) -> None:
    says = f"through {runtime}/sar-tui, private to you; no session can be joined now"
    check(link.operator_here(here), "ok", says)
    assert list((runtime / "sar-tui").iterdir()) == []
    with announce(JoinableSession(session="a1", task="keyboard", link="a1", pid=1)):
        assert link.operator_here(here).found.endswith("; 1 session can be joined now")
    (runtime / "sar-tui").chmod(0o755)
    check(link.operator_here(here), "care", "is accessible to others")
    (runtime / "sar-tui").chmod(0o700)
    refused = raising(OSError(95, "Operation not supported"))
    monkeypatch.setattr("socket.socket", type("Refused", (socket,), {"bind": refused}))
    check(link.operator_here(here), "care", advice="XDG_RUNTIME_DIR")


@pytest.mark.parametrize(
    ("look", "missing", "extra"),
    [
        (link.operator_here, "zenoh", "link"),
        (link.browser, "aiohttp", "serve"),
        (link.browser, "zenoh", "link"),
        (devices.lsl_markers, "pylsl", "lsl"),
        (devices.serial_markers, "serial", "serial"),
    ],
)
@pytest.mark.usefixtures("runtime")
def test_missing_packages_are_no_fault_and_named_with_the_command(
    here: Machine, monkeypatch: Patch, look: Look, missing: str, extra: str
) -> None:
    find = importlib.util.find_spec
    for place in ("importlib.util.find_spec", "sar_tui.cli.doctor.devices.find_spec"):
        monkeypatch.setattr(place, lambda name: None if name == missing else find(name))
    check(look(here), "ok", "not installed. ", f"To install it: {pip_install_extra(extra)}")


def test_invitations_that_are_valid_expire_are_readable_by_others_or_damaged(
    here: Machine,
) -> None:
    keys = here.home.folder / FOLDER
    assert link.invitations(here).found.startswith("nobody is invited")
    assert not keys.exists()
    authority = Authority.open_or_create(here.home.folder)
    for name, role, days_left in (
        ("tom", "observer", -40),
        ("anna", "operator", 6),
        ("eva", "observer", 36),
    ):
        guest, began = Guest(name, role), NOW - timedelta(days=60 - days_left)
        authority.invite(guest, [parse_endpoint("lab")], 60, began)
    says = "2 valid: operator.anna, observer.eva; expiring soon: anna on "
    check(link.invitations(here), "care", says)
    authority.revoke("anna", NOW)
    check(link.invitations(here), "ok", "1 valid: observer.eva")
    authority.revoke("eva", NOW)
    check(link.invitations(here), "ok", "none is valid now, so nobody can join over the network")
    keys.chmod(0o755)
    assert f"chmod 700 {keys}" in link.invitations(here).advice
    keys.chmod(0o700)
    (keys / "invitations.json").write_text("{")
    assert link.invitations(here).state == "bad"


def test_a_letterbox_is_looked_at_from_both_sides(
    here: Machine, pair: Pair, monkeypatch: Patch
) -> None:
    def look(data: Path) -> Finding:
        return letterbox(Machine(Home(data), here.voice))

    check(look(here.home.folder), "ok", "none: nobody trains at home")
    check(look(pair.clinic), "ok", "the clinic Klinik Bern, in ")
    check(look(pair.clinic), "ok", "homes: 1 joined, 0 invited")
    check(look(pair.home), "ok", "P01 trains at home for Klinik Bern, in ")
    for number in (1, 2):
        pair.write(f"Message {number}.")
    with closing(connect(pair.clinic)) as database:
        (lost,) = database.execute(
            "SELECT file FROM letters WHERE direction='out' ORDER BY number DESC LIMIT 1 OFFSET 1"
        ).fetchone()
    (pair.box / lost).unlink()
    exchanged(pair.home)
    check(look(pair.home), "care", "1 missing", "They are asked for again.")
    revoke(pair.clinic, "P01")
    for data in (pair.clinic, pair.home):
        exchange(data)
    check(look(pair.home), "care", "takes no letters from here", "Ask it for a new invitation.")
    how = pip_install_extra("letterbox")
    with monkeypatch.context() as patch:
        patch.setattr("sar_tui.cli.doctor.letterbox.find_spec", lambda _: None)
        check(look(pair.home), "bad", "PyNaCl is not installed", how)
        check(look(here.home.folder), "ok", "not installed. ", how)
    shutil.rmtree(pair.box)
    check(look(pair.clinic), "care", "cannot be used")
    (pair.home / "letterbox.json").write_text("{")
    check(look(pair.home), "bad", "cannot be read")
