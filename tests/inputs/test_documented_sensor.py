"""The contract test on the page about sensors of one's own passes with the sensor on that page."""

import sys
from pathlib import Path

import pytest

from tests.api.pages import DOCS, python_blocks
from tests.outputs.markers.receivers import udp_receiver


def test_the_test_of_the_page_passes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with udp_receiver() as receiver:  # skips where there is no loopback
        port = receiver.address.rpartition(":")[2]
    blocks = python_blocks((DOCS / "write-your-own-sensor.md").read_text(encoding="utf-8"))
    source, test = blocks[0], blocks[-1].replace("5006", port)
    (tmp_path / "udp_sensor.py").write_text(source, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "udp_sensor", raising=False)
    names: dict[str, object] = {}
    exec(test, names)
    names["test_the_contract"]()  # type: ignore[operator]
    monkeypatch.delitem(sys.modules, "udp_sensor")
