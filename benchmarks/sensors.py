"""Each interface of a sensor that sends over a line or a network: lost samples, the error of their
stamps, and CPU time. All are measured at once, each with a sender and a receiver in a process of
its own.

A sender's clock is too fast by ``DRIFT``, as that of a board, and numbers its samples. What was
sent in the first ``RUN_IN_S`` is not counted.
"""

import json
import os
import select
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.lsl_here import ON_THIS_MACHINE
from sar_tui.drivers.lsl import library
from sar_tui.inputs.imu import DEGREE, G
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.line_format import HEADER
from sar_tui.inputs.sensor import DRAIN
from sar_tui.inputs.sources import open_source
from sar_tui.loop.clock import host_now
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.samples import Samples, join

RATES_HZ = {"serial": 200, "udp": 200, "lsl": 500, "phyphox": 200}
"""Samples a second of each interface."""
DRIFT = 30e-6
RUN_IN_S = 3.0
MINUTES = 1.0
QUICK_S = 20.0
_LINGER_S = 2.0
"""Time from the last sample to the end of its receiver."""
_PATIENCE_S = 60.0
_STEP = 0.01
"""Unit in which a sample's angular rate holds its number, in rad/s."""
_ROW = 1000


def seconds(minutes: float | None, quick: bool) -> float:
    """Return the duration of the measurement in s."""
    return 60 * minutes if minutes else QUICK_S if quick else 60 * MINUTES


def measure(duration_s: float, folder: Path, on_second: Callable[[], None]) -> dict[str, Any]:
    """Measure all interfaces at once, and check that every sample arrived once, and in order."""
    configuration = folder / "lsl_api.cfg"
    configuration.write_text(ON_THIS_MACHINE)
    environment = os.environ | {"LSLAPICFG": str(configuration)}
    with ExitStack() as stack:

        def child(*words: str) -> subprocess.Popen[str]:
            command = [sys.executable, "-m", "benchmarks.sensors", *words]
            process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
                env=environment,
            )
            stack.callback(process.wait)
            stack.callback(process.kill)
            return process

        senders = {kind: child("send", kind, f"{duration_s}") for kind in RATES_HZ}
        receivers = {
            kind: child("receive", _read(sender), str(folder / f"{kind}.npy"))
            for kind, sender in senders.items()
        }
        for receiver in receivers.values():
            _read(receiver)
        for sender in senders.values():
            print(file=sender.stdin, flush=True)
        for _ in range(round(RUN_IN_S + duration_s)):
            time.sleep(1)
            on_second()
        sent = {kind: json.loads(_read(sender)) for kind, sender in senders.items()}
        time.sleep(_LINGER_S)
        received = {kind: json.loads(_end(each)) for kind, each in receivers.items()}
        for sender in senders.values():
            _end(sender)
    kinds = {
        kind: _figures(kind, np.load(folder / f"{kind}.npy"), sent[kind]) | received[kind]
        for kind in RATES_HZ
    }
    checks = {
        f"{kind}: each sample once, and in order": each["lost"] == each["twice"] == 0
        and each["out_of_order"] == 0
        for kind, each in kinds.items()
    }
    return {"seconds": duration_s, "kinds": kinds, "checks": checks}


def _read(process: subprocess.Popen[str]) -> str:
    """Return the next line that a process prints."""
    assert process.stdout
    if not (line := process.stdout.readline()):
        raise RuntimeError("A sender or a receiver ended early.")
    return line.strip()


def _end(process: subprocess.Popen[str]) -> str:
    """Have a process end, and return what it prints last."""
    return process.communicate("\n", timeout=_PATIENCE_S)[0].strip()


def _figures(kind: str, samples: Samples, sent: Mapping[str, float]) -> dict[str, Any]:
    """Compare the samples that were received with those that were sent."""
    run_in, last = round(RUN_IN_S * RATES_HZ[kind]), round(sent["count"])
    numbers = _numbers(samples["rate"])
    counted = (run_in <= numbers) & (numbers < last)
    numbers, found = numbers[counted], np.unique(numbers[counted])
    true_ns = sent["began_ns"] + numbers * (SECOND / RATES_HZ[kind] / (1 + DRIFT))
    error_ms = (samples["at"][counted] - true_ns) / MS
    delay_ms = (samples["host"][counted] - true_ns) / MS
    return {
        "rate_hz": RATES_HZ[kind],
        "sent": last - run_in,
        "received": len(numbers),
        "lost": last - run_in - len(found),
        "twice": len(numbers) - len(found),
        "out_of_order": int((np.diff(numbers) < 0).sum()),
        "latest_ms": sent["latest_ms"],
        "delay_ms": _percentiles(delay_ms),
        "error_ms": _percentiles(error_ms),
    }


def _percentiles(values: npt.NDArray[np.float64]) -> list[float]:
    """Return median, 95th and 99th percentile; of nothing, none."""
    return np.percentile(values, (50, 95, 99)).tolist() if len(values) else []


# --- the sample of a number


def _rate(number: int) -> tuple[float, float, float]:
    """Return an angular rate in rad/s that holds a number."""
    high, low = divmod(number, _ROW)
    return low * _STEP, high * _STEP, 0.0


def _numbers(rates: npt.NDArray[np.float32]) -> npt.NDArray[np.int64]:
    """Return the numbers that angular rates hold."""
    low, high, _ = np.rint(rates.astype(float) / _STEP).astype(int).T
    numbers: npt.NDArray[np.int64] = high * _ROW + low
    return numbers


# --- a process that sends


def _send(kind: str, duration_s: float) -> None:
    """Print the name of the sensor, send samples when told to, and print how many and when."""
    rate_hz = RATES_HZ[kind]
    with ExitStack() as stack:
        name, send = _SENDERS[kind](stack)
        print(name, flush=True)
        sys.stdin.readline()
        count = round((RUN_IN_S + duration_s) * rate_hz)
        began_ns, latest_ns = host_now(), 0
        for number in range(count):
            due_ns = began_ns + round(number * SECOND / rate_hz / (1 + DRIFT))
            while (left_ns := due_ns - host_now()) > 0:
                time.sleep(left_ns / SECOND)
            send(number)
            latest_ns = max(latest_ns, host_now() - due_ns)
        sent = {"count": count, "began_ns": began_ns, "latest_ms": latest_ns / MS}
        print(json.dumps(sent), flush=True)
        sys.stdin.readline()


_Sender = tuple[str, Callable[[int], object]]


def _lines(rate_hz: int, write: Callable[[bytes], object]) -> Callable[[int], object]:
    """Return a function that writes the sample of a number as a line, and a header each second."""

    def send(number: int) -> None:
        values = [*(each / DEGREE for each in _rate(number)), 0.0, 0.0, 1.0]
        line = ",".join([f"{number * 1_000_000 // rate_hz}", *(f"{each:.4f}" for each in values)])
        header = f"{HEADER}\n" if number % rate_hz == 0 else ""
        write(f"{header}{line}\n".encode())

    return send


def _serial(stack: ExitStack) -> _Sender:
    import tty  # not on Windows

    board, computer = os.openpty()
    tty.setraw(computer)
    stack.callback(os.close, board)
    stack.callback(os.close, computer)
    return f"serial://{os.ttyname(computer)}", _lines(
        RATES_HZ["serial"], lambda text: os.write(board, text)
    )


def _udp(stack: ExitStack) -> _Sender:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        place = free.getsockname()
    out = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
    return f"udp://127.0.0.1:{place[1]}", _lines(
        RATES_HZ["udp"], lambda text: out.sendto(text, place)
    )


def _lsl(_: ExitStack) -> _Sender:
    pylsl = library()
    name, rate_hz = f"sar-tui-benchmark-{os.getpid()}", RATES_HZ["lsl"]
    info = pylsl.StreamInfo(name, "IMU", 6, rate_hz, pylsl.cf_float32, name)
    channels = info.desc().append_child("channels")
    for label, unit in [
        *((f"gyro_{axis}", "rad/s") for axis in "xyz"),
        *((f"acc_{axis}", "m/s2") for axis in "xyz"),
    ]:
        channel = channels.append_child("channel")
        channel.append_child_value("label", label)
        channel.append_child_value("unit", unit)
    outlet = pylsl.StreamOutlet(info)
    began_s = pylsl.local_clock()

    def send(number: int) -> None:
        outlet.push_sample([*_rate(number), 0.0, 0.0, G], began_s + number / rate_hz)

    return f"lsl://{name}", send


def _phyphox(stack: ExitStack) -> _Sender:
    from tests.inputs.fake_phone import phone

    it = stack.enter_context(phone())
    step_s = 1 / RATES_HZ["phyphox"]
    return f"phyphox://127.0.0.1:{it.port}", lambda number: it.measure(
        1, step_s, lambda _: _rate(number)
    )


_SENDERS: Mapping[str, Callable[[ExitStack], _Sender]] = {
    "serial": _serial,
    "udp": _udp,
    "lsl": _lsl,
    "phyphox": _phyphox,
}


# --- a process that receives


def _receive(name: str, file: Path) -> None:
    """Drain a sensor as a session does until told to end; store its samples, and print the share
    of the CPU from the first to the last.
    """
    feed, blocks = ImuFeed(open_source(name), host_now), list[Samples]()
    used: list[tuple[int, int]] = []
    feed.start()
    print("started", flush=True)
    due_ns = host_now() + DRAIN
    while not select.select([sys.stdin], [], [], max(0, due_ns - host_now()) / SECOND)[0]:
        due_ns += DRAIN
        if len(samples := feed.drain().samples):
            blocks.append(samples)
            used = [*used[:1], (host_now(), time.process_time_ns())]
    feed.stop()
    np.save(file, join(blocks))
    (began_ns, before_ns), (ended_ns, after_ns) = used
    print(json.dumps({"cpu_share": (after_ns - before_ns) / (ended_ns - began_ns)}), flush=True)


if __name__ == "__main__":
    if sys.argv[1] == "send":
        _send(sys.argv[2], float(sys.argv[3]))
    else:
        _receive(sys.argv[2], Path(sys.argv[3]))
