"""Sensors that send lines of text, over a real UDP socket and a pseudo-terminal as a serial line."""

import math
import os
import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.inputs import delivery, lines
from sar_tui.inputs.imu import DEGREE, G, Sample, SourceError, Status
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.line_format import HEADER, WITHOUT_UNITS, Lines, Units
from sar_tui.inputs.lines import Line as OpenLine
from sar_tui.inputs.lines import LineSource, SerialSource, UdpSource
from sar_tui.loop.clock import host_now
from sar_tui.model.units import SECOND
from tests.fake_rosbridge import wait_until
from tests.outputs.markers.receivers import Line, serial_line, udp_receiver

US = Units(t="us", rate="deg/s", acceleration="g")


def taken(*received: bytes, units: Units | None = US) -> list[Sample | str]:
    reader = Lines(units)
    return [found for each in received for found in reader.take(each, 7)]


def times(*stamps: int, units: Units = US) -> list[float]:
    received = b"".join(b"%d,0,0,0\n" % stamp for stamp in stamps)
    return [each.device_ms for each in taken(received, units=units) if isinstance(each, Sample)]


def test_a_header_names_the_units_and_lines_before_it_are_not_read() -> None:
    begin = f"5000,9,9,9,9,9,9\n{HEADER}\n".encode()
    (sample,) = taken(begin, b"15000,90,0,-90,0,0,1\n", units=None)
    assert isinstance(sample, Sample)
    assert sample.host_ns == 7
    assert sample.rate == pytest.approx((90 * DEGREE, 0, -90 * DEGREE))
    assert sample.acceleration == pytest.approx((0, 0, G))


@pytest.mark.parametrize(
    "line", ["1;2;3;4;5;6;7", "1\t2\t3\t4\t5\t6\t7", "1, 2, 3, 4, 5, 6, 7\r", "1 2 3 4 5 6 7"]
)
def test_commas_semicolons_tabs_and_spaces_separate(line: str) -> None:
    units = Units(t="ms", rate="rad/s")
    (sample,) = taken(f"{line}\n".encode(), units=units)
    assert isinstance(sample, Sample)
    assert (sample.rate, sample.acceleration) == ((2.0, 3.0, 4.0), (5.0, 6.0, 7.0))


def test_a_line_may_have_no_acceleration_and_arrive_in_parts() -> None:
    (sample,) = taken(b"10", b"00,1,", b"2,3", b"\n# a comment\n\n")
    assert isinstance(sample, Sample)
    assert all(math.isnan(axis) for axis in sample.acceleration)


def test_the_counter_of_a_board_may_overflow_and_a_reset_one_begins_anew() -> None:
    for size in (1 << 30, 1 << 32):
        assert times(size - 5000, 0, 5000) == [0.0, 5.0, 10.0]
    assert times(9_000_000, 0, 5000) == [0.0, -9000.0, -8995.0]
    assert times(1_760_000_000, 1_760_000_001, units=Units(t="s", rate="rad/s")) == [0.0, 1000.0]


def test_a_board_may_send_the_time_of_day_in_microseconds() -> None:
    assert times(1_760_000_000_000_000, 1_760_000_000_005_000) == [0.0, 5.0]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (b"1,2,3", "no line of a time, three rates"),
        (b"1,2,3,4,5", "no line"),
        (b"E (123) wifi: \x1b[31mlost\xff", "wifi: ␛[31mlost�"),
        (b"1e300,0,0,0", "no line"),
        (b"nan,0,0,0", "no line"),
        (b"# t=days rate=deg/s", "header is not valid"),
        (b"# rate=deg/s", "header is not valid"),
        (b"# t=us rate=deg/s colour=red", "header is not valid"),
        (b"x" * 2000, "no line"),
    ],
)
def test_a_broken_line_is_one_sentence_and_the_next_is_read(line: bytes, said: str) -> None:
    sentence, sample = taken(line + b"\n1000,1,2,3\n")
    assert isinstance(sentence, str)
    assert said in sentence
    assert isinstance(sample, Sample)


def test_lines_without_units_ask_for_them() -> None:
    found = taken(b"1,2,3,4\n" * (WITHOUT_UNITS + 1), units=None)
    assert len(found) == 1
    assert HEADER in str(found[0])


@given(st.lists(st.binary(max_size=80)))
def test_no_bytes_raise(received: list[bytes]) -> None:
    for found in taken(*received):
        assert isinstance(found, Sample | str)


# --- a board that sends


class Bench:
    """A source and its reports, fed through a feed's queue."""

    def __init__(self, source: LineSource) -> None:
        self.source = source
        self.samples: list[Sample] = []
        self.statuses: list[Status] = []
        source.start(self.samples.append, self.statuses.append)

    def wait_for(self, state: str, times: int = 1) -> Status:
        wait_until(lambda: self.states.count(state) >= times, f"it is {state}")
        return [status for status in self.statuses if status.state == state][times - 1]

    @property
    def states(self) -> list[str]:
        return [status.state for status in list(self.statuses)]


def line(number: int, step_us: int = 5000) -> bytes:
    return b"%d,%d,0,0,0,0,1\n" % (number * step_us, number % 7)


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(delivery, "RETRY_S", 0.01)
    monkeypatch.setattr(lines, "_READ_S", 0.01)


class Board:
    """A board that sends datagrams to a source."""

    def __init__(self, port: int) -> None:
        self.port = port
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def send(self, text: bytes) -> None:
        self._socket.sendto(text, ("127.0.0.1", self.port))

    def close(self) -> None:
        self._socket.close()


@pytest.fixture
def port() -> int:
    with udp_receiver() as receiver:  # skips where there is no loopback
        return int(receiver.address.rpartition(":")[2])


@pytest.fixture
def board(port: int) -> Iterator[Board]:
    made = Board(port)
    yield made
    made.close()


@pytest.fixture
def udp(port: int) -> Iterator[Bench]:
    bench = Bench(UdpSource(f"//:{port}"))
    bench.wait_for("detached")
    yield bench
    bench.source.stop()


def test_datagrams_become_samples(udp: Bench, board: Board) -> None:
    board.send(HEADER.encode())
    for number in range(0, 100, 2):
        board.send(line(number) + line(number + 1))
    wait_until(lambda: len(udp.samples) == 100)
    assert [sample.device_ms for sample in udp.samples] == [5.0 * n for n in range(100)]
    assert udp.states == ["detached", "attached"]
    assert udp.source.info is not None
    assert udp.source.info.rate_hz == pytest.approx(200)
    assert udp.source.info.source == f"udp://127.0.0.1:{board.port}"
    assert udp.source.info.has_acceleration


def test_a_second_sender_is_not_mixed_in(udp: Bench, board: Board) -> None:
    other = Board(board.port)
    board.send(HEADER.encode())
    for number in range(60):
        board.send(line(number))
        other.send(line(1000 + number))
    wait_until(lambda: len(udp.samples) == 60)
    other.close()
    assert udp.samples[-1].device_ms == 59 * 5.0


def test_lost_and_broken_lines_are_counted_as_missing_samples(board: Board) -> None:
    feed = ImuFeed(UdpSource(f"//:{board.port}?t=us&rate=deg/s&acceleration=g"), host_now)
    feed.start()
    random, sent, left_out = Random(3), 0, 0
    statuses = list[Status]()
    wait_until(lambda: statuses.extend(feed.drain().statuses) or statuses)  # type: ignore[func-returns-value]
    for number in range(400):
        kind = random.random() if 60 <= number < 399 else 1.0
        if kind < 0.05:
            left_out += 1
        elif kind < 0.1:
            board.send(line(number)[:5])
            left_out += 1
        else:
            board.send(line(number))
            sent += 1
        if number % 50 == 49:  # the system keeps some 200 datagrams for a reader that is late
            wait_until(lambda sent=sent: feed.drain() and feed.received == sent)  # type: ignore[misc]
    feed.stop()
    assert (feed.lost, feed.dropped) == (left_out, 0)


def test_a_board_that_prints_between_its_samples_does_not_flood_the_reports(
    udp: Bench, board: Board
) -> None:
    began = time.monotonic()
    board.send(HEADER.encode())
    for number in range(200):
        board.send(line(number) + b"temperature %d\n" % number)
    wait_until(lambda: len(udp.samples) == 200)
    assert 1 <= udp.states.count("error") <= 2 + time.monotonic() - began


def test_a_board_that_falls_silent_is_detached_and_may_be_another_afterwards(
    udp: Bench, board: Board, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lines, "SILENCE", SECOND // 50)
    other = Board(board.port)
    for number, each in enumerate((board, other), 1):
        udp.wait_for("detached", number)
        sent = iter(range(10_000))

        def attached(each: Board = each, sent: Iterator[int] = sent, number: int = number) -> bool:
            each.send(HEADER.encode() + b"\n" + line(next(sent)))
            return udp.states.count("attached") == number

        wait_until(attached)
    udp.wait_for("detached", 3)
    other.close()


def test_a_stray_datagram_does_not_keep_the_sensor_out(
    udp: Bench, board: Board, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lines, "SILENCE", SECOND // 50)
    stray = Board(board.port)
    stray.send(b"M-SEARCH * HTTP/1.1")
    udp.wait_for("error")
    sent = iter(range(10_000))

    def attached() -> bool:
        board.send(HEADER.encode() + b"\n" + line(next(sent)))
        return "attached" in udp.states

    wait_until(attached)
    stray.close()


def test_it_listens_to_this_computer_only_unless_another_address_is_named(port: int) -> None:
    for address, host in (
        (f"//:{port}", "127.0.0.1"),
        (f"//127.0.0.2:{port}", "127.0.0.2"),
        (f"//localhost:{port}", "127.0.0.1"),
    ):
        source = UdpSource(address)
        opened = source.open()
        assert opened._port.getsockname()[0] == host  # type: ignore[attr-defined]
        opened.close()


def test_of_a_name_with_addresses_of_both_kinds_the_one_of_ipv4_is_listened_on(
    port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    places = [(socket.AF_INET6, ("::1", port, 0, 0)), (socket.AF_INET, ("127.0.0.1", port))]
    found = [(family, socket.SOCK_DGRAM, 17, "", place) for family, place in places]
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: found)
    opened = UdpSource(f"//board-port:{port}").open()
    assert opened._port.getsockname() == ("127.0.0.1", port)  # type: ignore[attr-defined]
    opened.close()


def test_an_address_of_another_computer_is_told_to_be_none_of_this_one(port: int) -> None:
    assert UdpSource(f"//[::1]:{port}").place == f"udp://[::1]:{port}"
    bench = Bench(UdpSource(f"//192.0.2.1:{port}"))
    assert "Name an address of this computer" in bench.wait_for("error").detail
    bench.source.stop()


class HangingSource(LineSource):
    """A source whose connection opens only as a test lets it."""

    def __init__(self) -> None:
        super().__init__("hanging", US)
        self.opens = threading.Event()
        self.closed = threading.Event()

    def open(self) -> OpenLine:
        self.opens.wait(60)
        return self

    def read(self) -> bytes:
        return b""

    def forget(self) -> None: ...

    def close(self) -> None:
        self.closed.set()


def test_a_connection_that_opens_after_the_source_was_stopped_reports_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(delivery, "CLOSE_S", 0.01)
    source = HangingSource()
    bench = Bench(source)
    source.stop()
    source.opens.set()
    assert source.closed.wait(60)
    assert bench.states == []


def test_a_port_that_another_program_uses_is_an_error_until_it_is_free(port: int) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", port))
        bench = Bench(UdpSource(f"//:{port}"))
        assert "cannot be listened on" in bench.wait_for("error").detail
    bench.wait_for("detached")
    bench.source.stop()
    assert bench.states == ["error", "detached"]


# --- a serial line


@pytest.fixture
def cable() -> Iterator[Line]:
    pytest.importorskip("serial")
    with serial_line() as made:
        yield made


def write(cable: Line, text: bytes) -> None:
    os.write(cable._box, text)


def test_a_serial_line_is_read_from_its_first_whole_line(cable: Line) -> None:
    bench = Bench(SerialSource(f"//{cable.name}@500000"))
    bench.wait_for("detached")
    write(cable, b"34,5,6\n" + HEADER.encode() + b"\r\n")
    for number in range(100):
        write(cable, line(number))
    wait_until(lambda: len(bench.samples) == 100)
    bench.source.stop()
    assert bench.states == ["detached", "attached"]
    assert bench.samples[99].device_ms == 495.0


def test_a_board_that_is_unplugged_is_waited_for_and_read_again(
    cable: Line, tmp_path: Path
) -> None:
    place = str(tmp_path / "board")
    os.symlink(cable.name, place)
    bench = Bench(SerialSource(f"//{place}?t=us&rate=deg/s&acceleration=g"))
    try:
        bench.wait_for("detached")
        write(cable, b"\n" + b"".join(map(line, range(60))))
        bench.wait_for("attached")
        os.unlink(place)
        cable.unplug()
        assert bench.wait_for("detached", 2).detail.endswith("plug the board in again.")
        assert bench.source.info is None
        with serial_line() as another:
            os.symlink(another.name, place)
            sent = iter(range(10_000))

            def attached() -> bool:
                write(another, b"\n" + line(next(sent)))
                return bench.states.count("attached") == 2

            wait_until(attached)
            bench.source.stop()
    finally:
        bench.source.stop()
        os.unlink(place)


def test_a_port_that_is_not_there_is_waited_for_and_one_without_permission_is_not() -> None:
    pytest.importorskip("serial")
    bench = Bench(SerialSource("///dev/nowhere"))
    assert "Waiting for the serial port /dev/nowhere" in bench.wait_for("detached").detail
    bench.source.stop()
    folder = Bench(SerialSource("///tmp"))
    assert "cannot be opened" in folder.wait_for("error").detail
    folder.source.stop()


def test_without_the_package_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lines, "find_spec", lambda name: None)
    bench = Bench(SerialSource("COM3"))
    assert "pip install -e '.[serial]'" in bench.wait_for("error").detail
    bench.source.stop()


@pytest.mark.parametrize(
    "address",
    [
        "",
        "//",
        "//:0",
        "//:70000",
        "//:port",
        "5005",
        "//:5005/x",
        "//:5005?t=us",
        "//:5005?baud=9",
        "//192.168..20:5005",
    ],
)
def test_an_invalid_udp_address_is_refused_with_an_example(address: str) -> None:
    with pytest.raises(SourceError, match="Use udp://:PORT"):
        UdpSource(address)


@pytest.mark.parametrize(
    "address", ["", "//", "//@9600", "///dev/ttyUSB0@0", "COM3?rate=deg/s", "COM3?t=us&rate=rpm"]
)
def test_an_invalid_serial_address_is_refused_with_an_example(address: str) -> None:
    with pytest.raises(SourceError, match="Use serial://PORT"):
        SerialSource(address)
