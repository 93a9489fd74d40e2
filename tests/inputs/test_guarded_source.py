"""A plug-in's sensor that breaks its contract: it is reported, and nothing of it reaches the
program.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from sar_tui.inputs.imu import NOTHING, Info, Sample, Status
from sar_tui.inputs.imu_feed import Drained, ImuFeed
from sar_tui.inputs.sources import GuardedSource
from sar_tui.loop.clock import VirtualClock
from sar_tui.model.units import MS, SECOND

INFO = Info(source="test", model="By hand", rate_hz=100.0)
STILL = (0.0, 0.0, 0.0)
GOOD = Sample(SECOND, 1000.0, NOTHING, STILL)
ATTACHED = Status(state="attached", at=0)


class Sensor:
    """A sensor that delivers what a test gives it."""

    def __init__(self, *items: object, info: object = INFO) -> None:
        self.items = items
        self.info: Any = info

    def start(self, sink: Callable[[Any], None], on_status: Callable[[Any], None]) -> None:
        for item in self.items:
            (on_status if isinstance(item, Status) or item is None else sink)(item)

    def stop(self) -> None: ...

    def zero(self) -> None: ...


def drained(sensor: Sensor) -> Drained:
    """Return what a session gets of a plug-in's sensor."""
    feed = ImuFeed(GuardedSource(sensor, "mine"), VirtualClock().now)
    feed.start()
    return feed.drain()


@pytest.mark.parametrize(
    "wrong",
    [
        GOOD._replace(rate=("a", "b", "c")),
        GOOD._replace(rate=None),
        GOOD._replace(rate=(10**400, 0, 0)),
        GOOD._replace(acceleration=(None, None, None)),
        GOOD._replace(field=("north", 0.0, 0.0)),
        GOOD._replace(host_ns="now"),
        GOOD._replace(host_ns=2**80),
        GOOD._replace(host_ns=-1),
        GOOD._replace(device_ms="1000"),
        GOOD[:3],
        5,
        "text",
    ],
)
def test_a_sample_of_wrong_types_is_left_out_and_reported_once(wrong: Any) -> None:
    samples, statuses = drained(Sensor(ATTACHED, wrong, wrong, GOOD))
    assert list(samples["device_ms"]) == [1000.0]
    assert [status.state for status in statuses] == ["attached", "error"]
    assert "such samples are left out" in statuses[1].detail


def test_numbers_of_numpy_are_numbers() -> None:
    sample = Sample(np.int64(SECOND), np.float32(1000), (np.float32(1),) * 3, (1, 2, 3), NOTHING)  # type: ignore[arg-type]
    info = Info(source="test", model="numpy", rate_hz=np.float64(100))
    samples, statuses = drained(Sensor(Status(state="attached", at=np.int64(5)), sample, info=info))  # type: ignore[arg-type]
    assert (samples["rate"].tolist(), statuses) == (
        [[1.0, 2.0, 3.0]],
        [Status(state="attached", at=5)],
    )


@pytest.mark.parametrize(
    "wrong",
    [
        None,
        Status(state="dancing", at=0),  # type: ignore[arg-type]
        Status(state="error", at="now"),  # type: ignore[arg-type]
        Status(state="error", at=2**80),
        Status(state="error", at=0, detail=5),  # type: ignore[arg-type]
        Status(state="gap", at=0, duration_ms=math.inf),
    ],
)
def test_a_status_that_cannot_be_read_is_reported(wrong: Any) -> None:
    samples, statuses = drained(Sensor(ATTACHED, wrong, GOOD))
    assert (len(samples), [status.state for status in statuses]) == (1, ["attached", "error"])
    assert statuses[1].detail.startswith("The sensor mine does not keep its contract (")


@pytest.mark.parametrize(
    "info",
    [
        "a text",
        Info(source="test", model="m", rate_hz="100"),
        Info(source="test", model="m", rate_hz=math.nan),
    ],
)
def test_a_sensor_that_describes_itself_wrongly_is_not_attached(info: Any) -> None:
    (status,) = drained(Sensor(ATTACHED, info=info)).statuses
    assert (status.state, "does not keep its contract" in status.detail) == ("error", True)
    assert GuardedSource(Sensor(info=info), "mine").info is None


@pytest.mark.parametrize("error", [ValueError("no port"), SystemExit(3)])
@pytest.mark.parametrize(
    ("method", "what"), [("start", "started"), ("stop", "stopped"), ("zero", "zeroed")]
)
def test_a_method_that_raises_is_reported(
    monkeypatch: pytest.MonkeyPatch, error: BaseException, method: str, what: str
) -> None:
    def fail(*_: object) -> None:
        raise error

    sensor, statuses = Sensor(), list[Status]()
    monkeypatch.setattr(sensor, method, fail)
    guarded = GuardedSource(sensor, "mine")
    guarded.start(lambda sample: None, statuses.append)
    guarded.zero()
    guarded.stop()
    (status,) = statuses
    assert status.detail == f"The sensor mine cannot be {what} ({type(error).__name__}: {error})."


def test_a_sensor_that_keeps_its_bias_says_so_through_its_guard(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert not GuardedSource(Sensor(), "mine").keeps_bias
    monkeypatch.setattr(Sensor, "keeps_bias", True, raising=False)
    assert GuardedSource(Sensor(), "mine").keeps_bias


def test_a_good_sensor_passes_unchanged() -> None:
    saturated = Status(state="saturated", at=2 * MS, count=1)
    received, statuses = list[Sample](), list[Status]()
    guarded = GuardedSource(Sensor(ATTACHED, GOOD, saturated), "mine")
    guarded.start(received.append, statuses.append)
    assert (received, statuses, guarded.info) == ([GOOD], [ATTACHED, saturated], INFO)
