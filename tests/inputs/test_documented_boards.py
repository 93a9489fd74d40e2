"""Programs on the page about connecting a motion sensor: run in processes of their own, and read by
sar-tui over a real UDP socket and a pseudo-terminal.
"""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path

import pytest

from sar_tui.inputs.imu import DEGREE, G, Sample
from sar_tui.inputs.lines import LineSource, SerialSource, UdpSource
from tests.api.pages import DOCS
from tests.fake_rosbridge import wait_until
from tests.inputs.test_lines import Bench
from tests.outputs.markers.receivers import serial_line, udp_receiver

STAND_INS = Path(__file__).with_name("stand_ins")
PAGE = (DOCS / "connect-a-motion-sensor.md").read_text(encoding="utf-8")
SAMPLES = 200
READ_IMU = """\
number = 0


def read_imu():
    global number
    number += 1
    return number % 7, -90, 0.125, 0, 0, 1


"""


def program(language: str, containing: str) -> str:
    """Return the program of the page in a language that contains a text."""
    found = re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)
    (code,) = (each for each in found if containing in each)
    return str(code)


@contextmanager
def running(command: Sequence[str | Path], **options: object) -> Iterator[None]:
    with subprocess.Popen(command, **options) as process:  # type: ignore[call-overload]
        try:
            yield
        finally:
            process.kill()


def read(source: LineSource, command: Sequence[str | Path], **options: object) -> list[Sample]:
    """Return the samples that a source reads of a program."""
    bench = Bench(source)
    try:
        bench.wait_for("detached")
        with running(command, **options):
            wait_until(lambda: len(bench.samples) >= SAMPLES)
    finally:
        bench.source.stop()
    assert bench.states == ["detached", "attached"]
    return bench.samples


def check(samples: Sequence[Sample], step_ms: float | None) -> None:
    """Check that samples are those of the stand-ins, none is missing, and their times go on across
    an overflow of the clock.
    """
    first = round(samples[0].rate[0] / DEGREE)
    for number, sample in enumerate(samples):
        expected = ((first + number) % 7 * DEGREE, -90 * DEGREE, 0.125 * DEGREE)
        assert sample.rate == pytest.approx(expected)
        assert sample.acceleration == pytest.approx((0, 0, G), abs=1e-3)
    steps = [after.device_ms - before.device_ms for before, after in pairwise(samples)]
    if step_ms:
        assert steps == pytest.approx([step_ms] * len(steps))
    assert min(steps) > 0


@pytest.fixture
def port() -> int:
    with udp_receiver() as receiver:  # skips where there is no loopback
        return int(receiver.address.rpartition(":")[2])


def test_the_sketch_of_an_arduino_is_read(tmp_path: Path) -> None:
    pytest.importorskip("serial")
    if not (compiler := shutil.which("g++")):
        pytest.skip("needs the compiler g++")
    sketch, board = tmp_path / "sketch.cpp", tmp_path / "board"
    sketch.write_text(program("cpp", "Arduino_LSM6DS3.h"), encoding="utf-8")
    options = ["-std=c++17", f"-I{STAND_INS}", "-include", "Arduino.h"]
    subprocess.run([compiler, *options, sketch, "-o", board], check=True)
    with serial_line() as cable:
        source = SerialSource(f"//{cable.name}@500000")
        check(read(source, [board], stdout=cable._box), 9.615)


def test_the_program_of_a_board_with_micropython_is_read(tmp_path: Path, port: int) -> None:
    pytest.importorskip("micropython_unix", reason="needs the unix port of MicroPython")
    board = tmp_path / "main.py"
    code = program("python", "ticks_us")
    assert '"192.168.1.10", 5005' in code
    code = code.replace('"192.168.1.10", 5005', f'"127.0.0.1", {port}')
    board.write_text(READ_IMU + code, encoding="utf-8")
    command = [sys.executable, "-m", "micropython_unix", board]
    check(read(UdpSource(f"//:{port}"), command), None)


def test_the_bridge_of_a_bluetooth_sensor_is_read(tmp_path: Path, port: int) -> None:
    bridge = tmp_path / "dot.py"
    code = program("python", "bleak")
    assert '"127.0.0.1", 5005' in code
    bridge.write_text(code.replace("5005", str(port)), encoding="utf-8")
    check(
        read(
            UdpSource(f"//:{port}"),
            [sys.executable, bridge, "Movella DOT"],
            env=os.environ | {"PYTHONPATH": str(STAND_INS)},
        ),
        16.667,
    )
