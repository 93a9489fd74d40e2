"""Doctor's checks of markers: LSL with its clock, serial ports, and packages that are missing."""

import importlib.util

import pytest

from sar_tui.cli.doctor.markers import lsl_markers, serial_markers
from sar_tui.drivers.installation import pip_install_extra


def test_lsl_has_the_clock_of_the_session() -> None:
    pytest.importorskip("pylsl")
    found = lsl_markers()
    assert found.state == "ok"
    assert "its clock is " in found.found


def test_serial_ports_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("serial")
    monkeypatch.setattr(
        "serial.tools.list_ports.comports", lambda: [type("Port", (), {"device": "/dev/ttyUSB0"})]
    )
    assert serial_markers().found == "ports: /dev/ttyUSB0"
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: [])
    assert serial_markers().found == "installed; there is no serial port now"


def test_missing_packages_are_no_fault_and_named_with_the_command(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(
        "importlib.util.find_spec", lambda name: None if name in ("pylsl", "serial") else find(name)
    )
    for found, extra in ((lsl_markers(), "lsl"), (serial_markers(), "serial")):
        assert (found.state, found.advice) == ("ok", f"To install it: {pip_install_extra(extra)}")
        assert found.found == "not installed. Only `--markers` needs it."
