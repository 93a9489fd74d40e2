"""The part of an output report keeps the name under which pages for authors of plug-ins read it."""

import msgspec

from sar_tui.loop.topics import REPORT


def test_a_report_is_read_and_written_with_its_stored_names() -> None:
    stored = {
        "seat": "A",
        "action": "a1",
        "output": "speech",
        "deed": "say",
        "state": "done",
        "at": 7,
        "detail": "",
    }
    message = msgspec.json.decode(msgspec.json.encode(stored), type=REPORT.type)
    assert message.part == "say"
    assert msgspec.json.decode(msgspec.json.encode(message)) == stored
