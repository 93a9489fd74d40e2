"""Every sample of a Phidget's channel is stored in order, although it arrives from another
thread.
"""

import asyncio
import threading
from pathlib import Path

import numpy as np
from sqlite_utils import Database

from benchmarks.fake_phidget import FakeSpatial
from sar_tui.drivers.phidget import new_channel
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.phidget import PhidgetSource
from sar_tui.inputs.sensor import Imu
from sar_tui.loop.clock import LiveClock
from sar_tui.loop.topics import IMU, SENSOR
from sar_tui.model.messages import ImuBlock, SensorChanged
from sar_tui.motion.samples import unpack
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import Run, start
from sar_tui.store import imu, sessions
from sar_tui.store.database import connect

PATIENCE_S = 60.0


async def streamed(run: Run, fake: FakeSpatial, plugged: tuple[int, ...]) -> list[str]:
    """Plug the sensor in repeatedly, each time for a number of samples; return what the session
    received.
    """
    states: list[str] = []
    received = 0
    all_received = asyncio.Event()
    quiet = threading.Semaphore(0)

    def count(block: ImuBlock) -> None:
        nonlocal received
        received += len(unpack(block.samples))
        if received in (plugged[0], sum(plugged)):
            quiet.release()

    def note(sensor: SensorChanged) -> None:
        states.append(sensor.state)
        if len(states) == 1:
            quiet.release()
        if states.count("detached") == len(plugged) + 1 and received == sum(plugged):
            all_received.set()

    run.session.bus.subscribe(IMU, count)
    run.session.bus.subscribe(SENSOR, note)

    def drive() -> None:
        quiet.acquire(timeout=PATIENCE_S)
        for samples in plugged:
            fake.attach()
            for index in range(samples):
                fake.send(index, (0.0, 0.0, index % 90))
            quiet.acquire(timeout=PATIENCE_S)
            fake.detach()

    assert isinstance(run.session.clock, LiveClock)
    loop = asyncio.create_task(run.session.clock.run())
    run.session.clock.call_soon(run.begin)
    driver = threading.Thread(target=drive)
    driver.start()
    try:
        await asyncio.wait_for(all_received.wait(), PATIENCE_S)
    finally:
        driver.join()
        loop.cancel()
    return states


def test_all_samples_are_stored_and_a_reattached_sensor_is_a_new_stream(tmp_path: Path) -> None:
    interval_ms, count = 4, 1250
    fake = FakeSpatial(new_channel("Spatial"), interval_ms)
    catalogue = Catalogue()
    plan = make_plan(catalogue, "reaching", ["P01"], seed=1)

    async def session() -> tuple[str, list[str]]:
        clock = LiveClock(asyncio.get_running_loop())
        feed = ImuFeed(PhidgetSource(make=lambda: fake.spatial, denied=lambda: False), clock.now)
        run = start(plan, tmp_path, catalogue, clock, lambda task, theme, seed: [Imu(feed)])
        stop = threading.Event()
        writer = threading.Thread(target=run.recorder.run, args=(stop.is_set,))
        writer.start()
        try:
            states = await streamed(run, fake, (count, count // 2))
        finally:
            stop.set()
            run.recorder.wake()
            writer.join()
            run.close()
        return run.id, states

    session_id, states = asyncio.run(session())
    database = connect(tmp_path)
    streams = sessions.rows(database, "imu_streams", session_id)
    stored = imu.samples(database, session_id)
    chunks = list(
        Database(database).query("SELECT stream, seq, n FROM imu_chunks ORDER BY stream, seq")
    )
    database.close()
    assert states == ["detached", "attached", "detached", "attached", "detached"]
    assert [(row["stream"], row["rate_hz"]) for row in streams] == [
        (1, 250.0),
        (2, 250.0),
    ]
    assert "1044_1B" in streams[0]["model"]
    sent = [*range(count), *range(count // 2)]
    assert stored["device_ms"].tolist() == [float(index * interval_ms) for index in sent]
    assert np.allclose(np.degrees(stored["rate"][:, 2]), [index % 90 for index in sent], atol=1e-4)
    assert [chunk["seq"] for chunk in chunks if chunk["stream"] == 2] == [
        *range(1, 1 + sum(chunk["stream"] == 2 for chunk in chunks))
    ]
