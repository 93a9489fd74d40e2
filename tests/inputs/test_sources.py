"""Sensors by name: a source, or an error that lists the names."""

import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sar_tui.inputs.imu import SourceError
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.inputs.phidget import PhidgetSource
from sar_tui.inputs.recorded import RecordedSource
from sar_tui.inputs.simulated import SimulatedSource
from sar_tui.inputs.sources import GuardedSource, open_source, source_names
from sar_tui.loop.clock import VirtualClock
from sar_tui.model.units import SECOND
from sar_tui.motion.synthesis import PROFILES
from sar_tui.motion.trajectories import SimulatedArm
from tests.plugged_in import offer


def makes_a_phidget(text: str) -> PhidgetSource:
    """Like a plug-in's entry point."""
    return PhidgetSource(text)


def makes_nothing(text: str) -> object:
    return text


def fails(text: str) -> object:
    raise RuntimeError(f"no {text} today")


@pytest.fixture
def _plugins(monkeypatch: pytest.MonkeyPatch) -> None:
    entries = [
        EntryPoint(name, f"{__name__}:{value}", "sar_tui.inputs")
        for name, value in {
            "camera": "makes_a_phidget",
            "hollow": "makes_nothing",
            "faulty": "fails",
            "absent": "nowhere",
        }.items()
    ]
    offer(monkeypatch, "sar_tui.inputs", entries)


@pytest.fixture
def walk(tmp_path: Path) -> Path:
    path = tmp_path / "walk.csv"
    rows = (f"{0.01 * index:.2f},0,0,1,0,0,9" for index in range(30))
    path.write_text("\n".join(["t,ax,ay,az,wx,wy,wz", *rows]))
    return path


@pytest.mark.parametrize("name", ["phidget", "phidget:473001", "phidget://lab-pi:5661"])
def test_a_phidget_is_opened_by_name_serial_number_or_host(name: str) -> None:
    assert isinstance(open_source(name), PhidgetSource)


def test_a_simulated_hand_is_of_a_profile_or_a_kind_of_reach_and_seeded() -> None:
    for name, profile in (("simulated", "clean"), ("simulated:noisy", "noisy")):
        source = open_source(name)
        assert isinstance(source, SimulatedSource)
        assert source.hand.profile == PROFILES[profile]
    source = open_source("simulated:kind=drinking")
    assert isinstance(source, SimulatedSource)
    assert isinstance(source.hand, SimulatedArm)
    assert source.hand.kind == "drinking"

    def noise(seed: int) -> bytes:
        clock = VirtualClock()
        feed = ImuFeed(open_source("simulated:noisy", seed=seed, clock=clock), clock.now)
        feed.start()
        clock.advance(SECOND)
        return feed.drain().samples.tobytes()

    assert noise(1) == noise(1) != noise(2)


def test_a_recording_is_opened_with_options_after_the_question_mark(walk: Path) -> None:
    clock = VirtualClock()
    source = open_source(f"recorded:{walk}?rate=deg/s&acceleration=g&speed=fast", clock=clock)
    assert isinstance(source, RecordedSource)
    feed = ImuFeed(source, clock.now)
    feed.start()
    clock.advance(0)
    samples, statuses = feed.drain()
    assert statuses[-1].state == "ended"
    assert np.allclose(samples["rate"][:, 2], np.pi / 20)
    assert np.allclose(samples["acceleration"][:, 2], 9.80665)
    assert source.info is not None
    assert source.info.source == "walk.csv"


@pytest.mark.parametrize(
    "query", ["", "?loop=yes", "?speed=real time&acceleration=m/s²", "?speed=real+time&loop=no"]
)
def test_options_of_a_recording_may_be_left_out(walk: Path, query: str) -> None:
    assert isinstance(open_source(f"recorded:{walk}{query}"), RecordedSource)


@pytest.mark.parametrize(
    "query", ["rate=rpm", "speed", "colour=red", "loop=", "rate=deg/s&", "speed=fast;loop=yes"]
)
def test_an_unknown_option_is_reported_with_the_known_ones(walk: Path, query: str) -> None:
    with pytest.raises(SourceError, match=r"Options after the file: rate=rad/s or deg/s"):
        open_source(f"recorded:{walk}?{query}")


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("recorded", "Name a recording"),
        ("recorded:", "Name a recording"),
        ("recorded:none.csv", "There is no file none.csv"),
        (
            "simulated:kind=jump",
            'There is no kind of reach "jump". Choose one of: lift-extend-touch, from-the-side',
        ),
        (
            "simulated:wild",
            'There is no simulated hand "wild". Choose one of: clean, steady, noisy',
        ),
        ("phidget:first", "phidget:SERIAL"),
        ("telepathy", 'There is no sensor "telepathy". Choose one of: '),
        ("", 'There is no sensor "". Choose one of: '),
        ("camera:first", "phidget:SERIAL"),
        ("hollow:x", "is not a source: it lacks start, stop, zero, info."),
        ("faulty:luck", "cannot be loaded: RuntimeError: no luck today."),
        ("absent", "cannot be loaded: AttributeError"),
    ],
)
@pytest.mark.usefixtures("_plugins")
def test_a_name_that_cannot_be_opened_is_reported(name: str, said: str) -> None:
    with pytest.raises(SourceError) as caught:
        open_source(name)
    assert said in str(caught.value)


@pytest.mark.usefixtures("_plugins")
def test_a_plug_in_is_opened_by_its_name_with_the_text_after_the_colon() -> None:
    camera = open_source("camera:473001")
    assert isinstance(camera, GuardedSource)
    assert isinstance(camera.plug_in, PhidgetSource)
    assert source_names() == [
        "absent",
        "camera",
        "faulty",
        "hollow",
        "lsl",
        "phidget",
        "phyphox",
        "recorded",
        "ros",
        "serial",
        "simulated",
        "udp",
    ]


def test_listing_the_names_loads_no_driver() -> None:
    look = (
        "import sys, sar_tui.inputs.sources as s; s.open_source('phidget'); print('Phidget22' "
        "in sys.modules)"
    )
    run: Any = subprocess.run(
        [sys.executable, "-c", look], capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == "False"
