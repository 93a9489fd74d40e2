"""``sar-tui doctor``: what works here, and what does not."""

import json
import sys
from collections import namedtuple
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from threading import Barrier
from typing import Any

import pytest

from sar_tui.cli.doctor import examination, sensors
from sar_tui.cli.doctor.finding import Finding
from sar_tui.drivers import phidget as phidget_driver
from sar_tui.drivers.installation import pip_install
from sar_tui.inputs import phidget
from sar_tui.inputs.imu import Info, Sample, Status
from sar_tui.outputs.sound import mixer
from sar_tui.outputs.sound.mixer import examine
from sar_tui.outputs.sound.protocol import Examined
from tests.plugged_in import offer
from tests.program import Call, Called


def finding(called: Called, name: str) -> dict[str, Any]:
    return next(row for row in called.json["checks"] if row["name"] == name)


class Plugged:
    """Fake PhidgetSpatial that reports its statuses at once."""

    statuses: tuple[Status, ...] = ()
    info: Info | None = None
    stopped = 0

    def start(self, sink: Callable[[Sample], None], on_status: Callable[[Status], None]) -> None:
        for status in self.statuses:
            on_status(status)

    def stop(self) -> None:
        type(self).stopped += 1


@pytest.fixture(autouse=True)
def plugged(monkeypatch: pytest.MonkeyPatch) -> type[Plugged]:
    """Fake sensor, not plugged in unless a test sets its statuses; the doctor does not wait for a
    real one.
    """

    class Socket(Plugged):
        pass

    monkeypatch.setattr(phidget, "PhidgetSource", Socket)
    monkeypatch.setattr(phidget_driver, "new_channel", lambda _kind: None)
    monkeypatch.setattr(phidget_driver, "usb_denied", lambda: False)
    monkeypatch.setattr(phidget_driver, "plugged_in", lambda: False)
    monkeypatch.setattr(sensors, "_SENSOR_S", 0.001)
    return Socket


@pytest.fixture(scope="module")
def _examined() -> dict[object, Examined]:
    return {}


@pytest.fixture(autouse=True)
def examined_once(_examined: dict[object, Examined], monkeypatch: pytest.MonkeyPatch) -> None:
    """Start the voice once: what it answers about speech and sound is the same in every test."""

    def recall(program: Sequence[str], *settings: Any) -> Examined:
        key = (tuple(program), *map(repr, settings))
        if key not in _examined:
            _examined[key] = examine(program, *settings)
        return _examined[key]

    monkeypatch.setattr(mixer, "examine", recall)


@pytest.fixture(autouse=True)
def known_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setenv("LINES", "30")


def test_without_problems_the_exit_code_is_0(call: Call) -> None:
    called = call("doctor")
    assert (called.code, called.err) == (0, "")
    assert "✗" not in called.out
    for name in (
        "Python",
        "Terminal",
        "Clock",
        "Onset stamps",
        "Priority",
        "Data",
        "Disk space",
        "Tasks",
        "Themes",
    ):
        assert name in called.out


def test_json_has_one_row_per_finding(call: Call) -> None:
    rows = call("doctor", "--json").json["checks"]
    assert all(set(row) == {"name", "state", "found", "mend"} for row in rows)
    assert {row["state"] for row in rows} <= {"ok", "care", "bad"}


def test_checks_that_wait_for_devices_and_the_voice_wait_side_by_side(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    together = Barrier(4)

    def meets(name: str) -> Finding:
        together.wait(timeout=60)
        return Finding(name, "ok", "met the others")

    def voice() -> Examined:
        together.wait(timeout=60)
        return Examined(card="Null")

    for name in ("sensor_driver", "motion_sensor", "servo_controller"):
        monkeypatch.setattr(examination, name, partial(meets, name))
    monkeypatch.setattr(examination, "examine_voice", voice)
    rows = call("doctor", "--json").json["checks"]
    assert [row["name"] for row in rows if row["found"] == "met the others"] == [
        "sensor_driver",
        "motion_sensor",
        "servo_controller",
    ]
    assert [row["name"] for row in rows].index("motion_sensor") == 11


def test_a_check_that_fails_beside_others_is_a_finding(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails() -> Finding:
        raise ZeroDivisionError("a plain mistake")

    monkeypatch.setattr(examination, "motion_sensor", fails)
    found = finding(call("doctor", "--json"), "Motion sensor")
    assert (found["state"], found["found"]) == (
        "bad",
        "This check failed (ZeroDivisionError: a plain mistake).",
    )


def test_the_data_folder_is_made_and_named(call: Call, tmp_path: Path) -> None:
    data = finding(call("doctor", "--json"), "Data")
    assert data["state"] == "ok"
    assert str(tmp_path / "data") in data["found"]


def test_a_damaged_database_exits_with_1_and_says_how_to_fix_it(call: Call, tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "sar-tui.db").write_text("no database at all")
    called = call("doctor")
    assert called.code == 1
    assert "✗ Data" in called.out
    assert "→ Choose another folder" in called.out
    assert finding(call("doctor", "--json"), "Data")["state"] == "bad"


def test_a_task_that_does_not_load_exits_with_1(call: Call, tmp_path: Path) -> None:
    (tmp_path / "mine" / "broken").mkdir(parents=True)
    (tmp_path / "mine" / "broken" / "task.py").write_text("this is no Python")
    called = call("doctor", "--tasks", tmp_path / "mine")
    assert called.code == 1
    assert "✗ Tasks" in called.out


def test_a_missing_tasks_folder_is_a_finding(call: Call) -> None:
    called = call("doctor", "--tasks", "/no/such", "--json")
    assert called.code == 1
    assert finding(called, "Tasks")["state"] == "bad"
    assert finding(called, "Themes")["state"] == "ok"


def test_ssh_and_multiplexers_are_noticed(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SSH_CONNECTION", "10.0.0.1 22")
    monkeypatch.setenv("TMUX", "/tmp/tmux")
    found = finding(call("doctor", "--json"), "Connection")
    assert found["state"] == "care"
    assert "SSH and tmux" in found["found"]


def test_a_small_terminal_is_noticed(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    assert finding(call("doctor", "--json"), "Terminal size")["state"] == "care"


def test_a_dumb_terminal_exits_with_1(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "dumb")
    assert call("doctor").code == 1


def test_redirected_output_is_no_fault(call: Call) -> None:
    called = call("doctor", "--json")
    assert finding(called, "Terminal")["state"] == "care"
    assert called.code == 0


def test_no_color_is_fine(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    assert finding(call("doctor", "--json"), "Colours")["state"] == "ok"


@pytest.mark.parametrize(
    ("way", "found"),
    [
        ("kitty", "by kitty's graphics"),
        ("half blocks", "in half blocks, as this"),
        (None, "not installed."),
    ],
)
def test_the_way_of_showing_pictures_is_told(
    call: Call, monkeypatch: pytest.MonkeyPatch, way: str | None, found: str
) -> None:
    monkeypatch.setattr("sar_tui.widgets.prompt_pictures.find_way", lambda: way)
    told = finding(call("doctor", "--json"), "Pictures")
    assert told["state"] == "ok"
    assert told["found"].startswith(found)
    assert (".[images]" in told["mend"]) == (way is None)


@pytest.mark.parametrize(("free", "state"), [(10, "bad"), (100, "care"), (10_000, "ok")])
def test_a_full_disk_is_noticed(
    call: Call, monkeypatch: pytest.MonkeyPatch, free: int, state: str
) -> None:
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr("shutil.disk_usage", lambda _: usage(10**12, 0, free * 1_000_000))
    called = call("doctor", "--json")
    assert finding(called, "Disk space")["state"] == state
    assert called.code == (1 if state == "bad" else 0)


@pytest.mark.parametrize(
    ("text", "state", "says"),
    [
        (None, "care", "sar-tui timing"),
        ("{", "care", "sar-tui timing"),
        (json.dumps({"verdict": "fit"}), "care", "sar-tui timing"),
        ("fit", "ok", ""),
        ("not fit", "care", "says why"),
    ],
    ids=["none", "broken", "incomplete", "fit", "not fit"],
)
def test_measured_timing_is_reported(
    call: Call, tmp_path: Path, text: str | None, state: str, says: str
) -> None:
    if text is not None:
        (tmp_path / "data").mkdir()
        figures = {
            "measured_at": "2026-01-02T03:04",
            "median_ms": 0.3,
            "robust_sd_ms": 0.1,
            "p99_ms": 0.9,
        }
        whole = (
            json.dumps({**figures, "verdict": text}) if "fit" in text and "{" not in text else text
        )
        (tmp_path / "data" / "timing.json").write_text(whole)
    found = finding(call("doctor", "--json"), "Measured timing")
    assert found["state"] == state
    assert says in found["mend"]


def test_a_check_that_fails_is_a_finding(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    def break_down(_: str) -> None:
        raise ZeroDivisionError("no clock")

    monkeypatch.setattr("time.get_clock_info", break_down)
    called = call("doctor", "--json")
    assert called.code == 1
    assert "ZeroDivisionError" in finding(called, "Clock")["found"]


@pytest.mark.skipif(sys.platform == "win32", reason="the driver of POSIX systems")
def test_a_textual_without_the_expected_file_is_noticed(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    from textual.drivers.linux_driver import LinuxDriver

    monkeypatch.setattr(LinuxDriver, "__init__", lambda self: None)
    assert finding(call("doctor", "--json"), "Onset stamps")["state"] == "care"


def test_no_motion_sensor_is_no_fault(call: Call, plugged: type[Plugged]) -> None:
    plugged.statuses = (Status(state="detached", at=0, detail="Waiting"),)
    called = call("doctor", "--json")
    found = finding(called, "Motion sensor")
    assert (called.code, found["state"], plugged.stopped) == (0, "ok", 1)
    assert found["found"].startswith("none plugged in")


def test_a_motion_sensor_is_named(call: Call, plugged: type[Plugged]) -> None:
    plugged.info = Info(
        source="USB", model="PhidgetSpatial 3/3/3 (1044_1B)", serial="629001", rate_hz=250.0
    )
    plugged.statuses = (Status(state="detached", at=0), Status(state="attached", at=1))
    found = finding(call("doctor", "--json"), "Motion sensor")
    assert (found["state"], plugged.stopped) == ("ok", 1)
    assert found["found"] == "PhidgetSpatial 3/3/3 (1044_1B), serial 629001, 250 samples a second"


def test_an_unusable_motion_sensor_is_reported(call: Call, plugged: type[Plugged]) -> None:
    plugged.statuses = (Status(state="error", at=0, detail="It has no gyroscope."),)
    called = call("doctor", "--json")
    found = finding(called, "Motion sensor")
    assert (called.code, found["state"], found["found"]) == (0, "care", "It has no gyroscope.")


def test_missing_permission_for_a_motion_sensor_exits_with_1_and_shows_the_udev_rule(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(phidget_driver, "usb_denied", lambda: True)
    called = call("doctor", "--json")
    found = finding(called, "Motion sensor")
    assert (called.code, found["state"]) == (1, "bad")
    assert 'SUBSYSTEM=="usb", ATTRS{idVendor}=="06c2", TAG+="uaccess"' in found["mend"]
    assert "/etc/udev/rules.d/70-phidget.rules" in found["mend"]


@pytest.mark.parametrize(
    ("system", "rule", "says"),
    [
        ("linux", False, "To be allowed to use one, write the line"),
        ("linux", True, ""),
        ("win32", False, ""),
    ],
)
def test_without_a_sensor_the_doctor_says_what_one_needs(
    call: Call, monkeypatch: pytest.MonkeyPatch, system: str, rule: bool, says: str
) -> None:
    monkeypatch.setattr(sensors.os, "geteuid", lambda: 1000)
    monkeypatch.setattr(sensors, "_has_udev_rule", lambda: rule)
    if system != "linux":
        monkeypatch.setattr(sensors.sys, "platform", system)
    found = sensors.motion_sensor()
    assert (found.state, bool(found.advice)) == ("ok", bool(says))
    assert found.advice.startswith(says)
    assert ("No permission is needed" in found.found) == (system == "win32")


def test_a_udev_rule_is_known_by_its_vendor(tmp_path: Path) -> None:
    (tmp_path / "50-other.rules").write_text('ATTRS{idVendor}=="1234"')
    assert not sensors._has_udev_rule((tmp_path, tmp_path / "none"))
    (tmp_path / "99-lab.rules").write_text('SUBSYSTEM=="usb", ATTRS{idVendor}=="06C2", MODE="0666"')
    assert sensors._has_udev_rule((tmp_path,))


@pytest.mark.parametrize(
    ("error", "found", "advice"),
    [
        (
            ImportError("Phidget22"),
            "The Python package Phidget22 is missing",
            "Install it with: " + pip_install("phidget22"),
        ),
        (
            OSError("libusb-1.0.so.0: none"),
            "libusb-1.0.so.0: none",
            "pip install phidget22 libusb-package",
        ),
    ],
    ids=["package", "library"],
)
def test_a_missing_driver_is_reported_with_its_fix(
    call: Call, monkeypatch: pytest.MonkeyPatch, error: Exception, found: str, advice: str
) -> None:
    def fail(_kind: str) -> None:
        raise error

    monkeypatch.setattr(phidget_driver, "new_channel", fail)
    called = call("doctor", "--json")
    row = finding(called, "Sensor driver")
    assert (called.code, row["state"]) == (0, "care")
    assert found in row["found"]
    assert advice in row["mend"]


# --- outputs


class Plugin:
    """An entry point."""

    name, value = "lamp", "lamp:Lamp"

    def __init__(self, error: Exception | None = None) -> None:
        self.error = error

    def load(self) -> object:
        if self.error:
            raise self.error
        return object


@pytest.fixture
def plugged_in(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Installs an output of that kind."""

    def install(plugin: Plugin) -> None:
        offer(monkeypatch, "sar_tui.outputs", [plugin])

    return install


def test_outputs_are_listed(call: Call) -> None:
    row = finding(call("doctor", "--json"), "Outputs")
    assert (row["state"], row["mend"]) == ("ok", "")
    assert {"ros", "screen", "servo", "speech", "tones"} <= set(row["found"].split(", "))


def test_an_output_of_a_plug_in_is_listed(call: Call, plugged_in: Callable[[Plugin], None]) -> None:
    plugged_in(Plugin())
    assert "lamp" in finding(call("doctor", "--json"), "Outputs")["found"].split(", ")


def test_an_output_of_a_plug_in_that_does_not_load_exits_with_1(
    call: Call, plugged_in: Callable[[Plugin], None]
) -> None:
    plugged_in(Plugin(ImportError("no lamp here")))
    called = call("doctor", "--json")
    row = finding(called, "Outputs")
    assert (called.code, row["state"]) == (1, "bad")
    assert (
        row["found"] == "The output lamp (lamp:Lamp) cannot be loaded: ImportError: no lamp here."
    )
    assert row["mend"] == "Install its package again, or remove it."
