"""docs/synchronise-with-eeg-and-video.md: its scripts run, its addresses are valid, its bytes are
those sent.
"""

import re
import shlex
import socket
from pathlib import Path

import pytest

from sar_tui.outputs.markers.destinations import Udp, make_destinations, split_addresses
from sar_tui.outputs.markers.marker import CODES, Marker
from tests.cli.test_sessions import record
from tests.outputs.markers.receivers import udp_receiver
from tests.outputs.markers.xdf_writer import write_xdf
from tests.program import Call

PAGE = (Path(__file__).parents[3] / "docs" / "synchronise-with-eeg-and-video.md").read_text(
    encoding="utf-8"
)


def script(word: str) -> str:
    """Return the script that has a word in it."""
    return next(
        block for block in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL) if word in block
    )


def test_the_script_that_receives_datagrams_prints_ten(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    class Receiver(socket.socket):
        """A socket on a port that is free here, to which ten markers have been sent."""

        def bind(self, address: object) -> None:
            assert address == ("127.0.0.1", 5005)
            super().bind(("127.0.0.1", 0))
            sender = Udp(f"udp://127.0.0.1:{self.getsockname()[1]}")
            sender.open("s1", "keyboard")
            for number in range(10):
                sender.send(Marker("test", number))
            sender.close()

    with udp_receiver():
        """Skip where there is no loopback network."""
    code = script("SOCK_DGRAM").replace("socket.socket(", "Receiver(")
    exec(compile(code, "receive.py", "exec"), {"Receiver": Receiver})
    assert capsys.readouterr().out.splitlines() == [f"test {number}" for number in range(10)]


def test_the_script_that_reads_a_recording_prints_prompts_and_responses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("pyxdf")
    monkeypatch.chdir(tmp_path)
    fields = {"attempt": 1, "trial": 2}
    sent = [
        Marker("session_start", 5),
        Marker("prompt_onset", 10, fields),
        Marker("response", 20, fields),
    ]
    header = (
        "<?xml "
        "version='1.0'?><info><name>sar-tui</name><type>Markers</type><channel_count>1</channel_count>"
        "<nominal_srate>0</nominal_srate><channel_format>string</channel_format></info>"
    )
    samples = [(48794.25 + number, marker.text) for number, marker in enumerate(sent)]
    write_xdf(tmp_path / "recording.xdf", header, samples, [(48794.0, 0.0)])
    exec(compile(script("pyxdf"), "read.py", "exec"), {})
    assert capsys.readouterr().out.splitlines() == [
        "48795.250000 prompt_onset 1-2",
        "48796.250000 response 1-2",
    ]


def test_the_script_that_aligns_a_video_prints_the_time_of_each_prompt(
    call: Call,
    simulated: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    trials = call("show", simulated, "--json").json["trials"]
    at = trials[0]["onset_ns"] - 2_000_000_000
    record(tmp_path, simulated, "output/sync", what="flash", at=at, source="flush", seat="A")
    monkeypatch.chdir(tmp_path)
    exec(compile(script("flash_in_video_s"), "align.py", "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "1 1 14.480 s"
    assert len(lines) == len([trial for trial in trials if trial["onset_ns"]])


def test_every_address_on_the_page_is_valid() -> None:
    commands = [
        shlex.split(line, comments=True) for line in re.findall(r"^sar-tui .*$", PAGE, re.MULTILINE)
    ]
    given = [words[words.index("--markers") + 1] for words in commands if "--markers" in words]
    assert len(given) > 4
    for addresses in given:
        assert make_destinations(split_addresses([addresses]))


def test_the_page_has_every_event_with_its_byte() -> None:
    described: dict[str, int] = {}
    for names, codes in re.findall(r"^\| ((?:`\w+`(?:, )?)+) \| ([\d, ]+) \|", PAGE, re.MULTILINE):
        described |= dict(
            zip(re.findall(r"`(\w+)`", names), map(int, codes.split(", ")), strict=True)
        )
    assert described == CODES
