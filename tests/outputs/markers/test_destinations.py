"""Addresses of markers, lines of a serial port, and packages that are missing."""

import importlib.util

import pytest

from sar_tui.outputs.markers.destinations import Udp, make_destinations, split_addresses
from sar_tui.outputs.markers.marker import CODES, Marker, MarkerError
from sar_tui.outputs.markers.serial_line import SerialLine
from tests.outputs.markers.receivers import serial_line


def test_addresses_are_separated_by_commas_or_repeated() -> None:
    assert split_addresses(["lsl, udp://h:1", "serial:COM3"]) == ("lsl", "udp://h:1", "serial:COM3")


@pytest.mark.parametrize(
    ("addresses", "said"),
    [
        ("", "Markers cannot be sent to ''"),
        ("tcp://h:1", "use lsl, udp://HOST:PORT or serial:PORT"),
        ("udp://h", "use udp://HOST:PORT"),
        ("udp://h:70000", "use udp://HOST:PORT"),
        ("serial:", "use serial:PORT or serial:PORT@BAUD"),
        ("serial:/dev/ttyUSB0@0", "use serial:PORT or serial:PORT@BAUD"),
        ("serial:/dev/ttyUSB0?response=256", "the code of response is a number from 0 to 255"),
        ("serial:/dev/ttyUSB0?beep=1", "but not beep=1"),
        ("serial:/dev/ttyUSB0?pulse=-1", "but not pulse=-1"),
        ("lsl lsl", "twice"),
    ],
)
def test_an_invalid_address_is_refused_with_a_sentence(addresses: str, said: str) -> None:
    with pytest.raises(MarkerError) as refused:
        make_destinations(addresses.split(" "))
    assert said in str(refused.value)


def test_a_host_that_is_unknown_is_named() -> None:
    with pytest.raises(MarkerError, match=r"The computer bad\.\.name of udp"):
        Udp("udp://bad..name:5").check()


@pytest.mark.parametrize(
    ("address", "package"), [("lsl", "pylsl"), ("serial:/dev/ttyUSB0", "serial")]
)
def test_a_missing_package_is_named_with_the_command(
    monkeypatch: pytest.MonkeyPatch, address: str, package: str
) -> None:
    (destination,) = make_destinations([address])
    find = importlib.util.find_spec
    for module in ("lsl", "serial_line"):
        monkeypatch.setattr(
            f"sar_tui.outputs.markers.{module}.find_spec",
            lambda name: None if name == package else find(name),
        )
    with pytest.raises(MarkerError, match=r"pip install -e '\.\[(lsl|serial)\]'"):
        destination.check()


def test_a_serial_port_that_is_not_there_is_named() -> None:
    pytest.importorskip("serial")
    with pytest.raises(MarkerError, match=r"/dev/nowhere cannot be opened \(No such file"):
        SerialLine("serial:/dev/nowhere").check()


def test_a_serial_port_that_another_program_uses_is_not_shared() -> None:
    pytest.importorskip("serial")
    with serial_line() as line:
        first, second = (SerialLine(f"serial:{line.name}") for _ in range(2))
        first.open("s1", "keyboard")
        with pytest.raises(MarkerError, match="close other programs that use it"):
            second.check()
        first.close()
        second.check()


def test_a_code_is_followed_by_zero_and_a_line_is_json() -> None:
    pytest.importorskip("serial")
    with serial_line() as line:
        for options, expected in (
            ("?pulse=1", b"\x0a\x00"),
            ("@9600?form=lines", b'{"event":"prompt_onset","ns":5}\n'),
        ):
            destination = SerialLine(f"serial:{line.name}{options}")
            destination.open("s1", "keyboard")
            destination.send(Marker("prompt_onset", 5))
            assert line.read(len(expected)) == expected
            destination.close()


def test_each_event_has_a_byte_of_its_own() -> None:
    assert len(set(CODES.values())) == len(CODES)
    assert all(0 < code < 256 for code in CODES.values())
