"""Markers of a session in the app: what is sent equals what is stored, and a destination that fails
is told of.
"""

import asyncio
import threading
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest

from sar_tui.model.units import SECOND
from sar_tui.outputs.markers.marker import CODES
from sar_tui.outputs.markers.sender import Sender
from tests.app.app_driver import AppDriver, OpenSession, stored
from tests.outputs.markers.receivers import PATIENCE_S, lsl_inlet, serial_line, udp_receiver
from tests.outputs.markers.xdf_writer import write_xdf

Failed = Callable[[AppDriver], Awaitable[None]]


@pytest.fixture
def failed(monkeypatch: pytest.MonkeyPatch) -> Failed:
    """Function that waits until the thread that sends has noticed that it cannot, and the session
    was told.
    """
    has_failed = threading.Event()
    fail = Sender._fail

    def noted(sender: Sender, error: Exception) -> None:
        fail(sender, error)
        has_failed.set()

    async def until_failed(driver: AppDriver) -> None:
        assert await asyncio.to_thread(has_failed.wait, PATIENCE_S)
        await driver.settle()

    monkeypatch.setattr(Sender, "_fail", noted)
    return until_failed


def stamps(markers: list[dict[str, Any]], event: str) -> list[int]:
    return [marker["ns"] for marker in markers if marker["event"] == event]


def trials(data: Path, column: str) -> list[int]:
    return [
        ns
        for (ns,) in stored(
            data, f"SELECT {column} FROM trials WHERE {column} IS NOT NULL ORDER BY rowid"
        )
    ]


@pytest.mark.slow
async def test_an_lsl_recording_has_the_stamps_of_the_database(
    open_session: OpenSession, data: Path, tmp_path: Path
) -> None:
    pyxdf = pytest.importorskip("pyxdf")
    async with open_session(markers=["lsl"]) as driver:
        inlet = lsl_inlet(driver.session_id)
        await driver.do_session()
        received = []
        while not received or '"session_end"' not in received[-1][1]:
            (text,), stamp = inlet.pull_sample(PATIENCE_S)
            received.append((stamp, text))
        offset = inlet.time_correction(PATIENCE_S)
        xml = inlet.info().as_xml()
        inlet.close_stream()
    write_xdf(tmp_path / "markers.xdf", xml, received, [(received[0][0], offset)])
    (stream,), _ = pyxdf.load_xdf(
        tmp_path / "markers.xdf", dejitter_timestamps=False, synchronize_clocks=False
    )
    info = stream["info"]
    found = (info["name"], info["type"], info["channel_format"])
    assert found == (["sar-tui"], ["Markers"], ["string"])
    assert info["desc"][0]["session"] == [driver.session_id]
    assert "P01" not in xml
    read: dict[str, list[float]] = {}
    for stamp, (text,) in zip(stream["time_stamps"], stream["time_series"], strict=True):
        read.setdefault(msgspec.json.decode(text)["event"], []).append(stamp)
    for event, column in (("prompt_onset", "onset_ns"), ("response", "response_ns")):
        expected = [ns / SECOND for ns in trials(data, column)]
        assert expected
        assert read[event] == pytest.approx(expected, rel=0, abs=1e-6)
    closed = closing(driver)
    assert closed["lost"] == 0
    assert closed["sent"] - closed["unheard"] == len(received)


async def test_datagrams_have_the_stored_stamps_and_each_event_is_its_byte_on_a_serial_line(
    open_session: OpenSession, data: Path
) -> None:
    pytest.importorskip("serial")
    with serial_line() as line, udp_receiver() as receiver:
        to = [f"serial:{line.name}?pulse=0&response=99&text_start=0", receiver.address]
        async with open_session(markers=to) as driver:
            await driver.do_session()
        markers = receiver.until("session_end")
        events = [marker["event"] for marker in markers]
        expected = [
            {"response": 99}.get(event, CODES[event]) for event in events if event != "text_start"
        ]
        assert list(line.read(len(expected))) == expected
    assert stamps(markers, "prompt_onset") == trials(data, "onset_ns")
    assert stamps(markers, "response") == trials(data, "response_ns")
    sent = msgspec.json.encode(markers).decode()
    said = "SELECT json_extract(final, '$.text') AS text FROM actions WHERE text != ''"
    texts = [text for (text,) in stored(data, said)]
    assert texts
    assert not [text for text in ("P01", *texts) if text in sent], (
        "neither codes nor words are sent"
    )


async def test_an_unplugged_line_is_told(
    open_session: OpenSession, data: Path, failed: Failed
) -> None:
    pytest.importorskip("serial")
    with serial_line() as line:
        address = f"serial:{line.name}?pulse=0"
        async with open_session(markers=[address]) as driver:
            prompt = await driver.to_first_prompt()
            line.read(1)
            line.unplug()
            await driver.do_attempt(prompt)
            await failed(driver)
            assert driver.app.live
            assert driver.app.live.trouble.endswith("takes no markers (Input/output error).")
            assert driver.sees("takes no markers"), (
                "a therapist who is there is told between attempts"
            )
            prompt = await driver.begin()
            assert not driver.sees("takes no markers"), (
                "nothing vanishes from the screen in a trial"
            )
            await driver.finish(prompt)
        told = [
            line for line in driver.app.leaving.lines(0) if f"No markers go to {address}" in line
        ]
        assert len(told) == 1
    assert len(trials(data, "response_ns")) == 4
    closed = closing(driver)
    assert closed["lost"] > 0


def closing(driver: AppDriver) -> dict[str, Any]:
    """Return the counts of the only destination."""
    (closed,) = [
        change for change in driver.messages("output/markers") if change["state"] == "closed"
    ]
    return closed
