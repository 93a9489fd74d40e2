"""LSL on a machine whose clock is another one, and with a configuration of the user."""

import sys
from pathlib import Path
from types import ModuleType

import pytest

from sar_tui.drivers import lsl as driver
from sar_tui.loop.clock import host_now
from sar_tui.model.units import SECOND
from sar_tui.outputs.markers import lsl
from sar_tui.outputs.markers.marker import Marker


class Library(ModuleType):
    """LSL with a clock that is ahead of ours, and an outlet that keeps what is pushed."""

    IRREGULAR_RATE, cf_string = 0.0, 3

    def __init__(self, ahead_s: float) -> None:
        super().__init__("pylsl")
        self.ahead_s = ahead_s
        self.pushed: list[tuple[list[str], float]] = []
        self.contents: list[str] = []

    def local_clock(self) -> float:
        return host_now() / SECOND + self.ahead_s

    def set_config_content(self, content: str) -> None:
        self.contents.append(content)

    def itself(self, *_: object) -> "Library":
        return self

    StreamInfo = StreamOutlet = desc = append_child = append_child_value = itself

    def have_consumers(self) -> bool:
        return False

    def push_sample(self, texts: list[str], stamp: float) -> None:
        self.pushed.append((texts, stamp))


@pytest.fixture
def library(monkeypatch: pytest.MonkeyPatch) -> Library:
    library = Library(ahead_s=7.0)
    monkeypatch.setitem(sys.modules, "pylsl", library)
    monkeypatch.setattr(driver, "_configured", False)
    return library


def test_the_offset_of_another_clock_is_added_and_its_drift_told(library: Library) -> None:
    stream = lsl.Lsl()
    stream.open("s1", "keyboard")
    assert stream.send(Marker("response", 5 * SECOND)) is False, "nobody listens"
    assert library.pushed[0][1] == pytest.approx(12.0, abs=0.01)
    library.ahead_s += 0.5
    assert "drifted apart by 5" in stream.close()


def test_the_offset_of_the_same_clock_is_not_added(library: Library) -> None:
    library.ahead_s = 0.0
    stream = lsl.Lsl()
    stream.open("s1", "keyboard")
    stream.send(Marker("response", 5 * SECOND))
    assert library.pushed[0][1] == 5.0


@pytest.mark.parametrize(
    ("own", "used"),
    [
        ("[ports]\nIPv6 = disable\n", ["[ports]\nIPv6 = disable\n\n[log]\nlevel = -3\n"]),
        ("[log]\nlevel = 0\n", []),
    ],
)
def test_lsl_is_quiet_unless_the_users_configuration_says_otherwise(
    library: Library, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, own: str, used: list[str]
) -> None:
    (tmp_path / "lsl_api.cfg").write_text(own, encoding="utf-8")
    monkeypatch.setenv("LSLAPICFG", str(tmp_path / "lsl_api.cfg"))
    driver.library()
    assert library.contents == used
