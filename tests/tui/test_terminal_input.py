"""Input that cannot be read is dropped and reported, and the next key counts."""

import asyncio
from types import SimpleNamespace
from typing import Any
from unittest.mock import AsyncMock, patch

import pytest
from hypothesis import given
from hypothesis import strategies as st
from textual import events
from textual._xterm_parser import XTermParser
from textual.drivers import linux_driver, web_driver
from textual.geometry import Size
from textual.message import Message

from sar_tui.plugins import Catalogue
from sar_tui.tui import terminal_input
from sar_tui.tui.base_app import BaseApp
from sar_tui.tui.terminal_input import (
    LONGEST_PASTE,
    TYPED_AT_MOST,
    PasteDropped,
    TolerantParser,
    UnreadableInput,
    tolerate,
    tolerate_in_terminals,
)
from tests.app.app_driver import AppDriver, OpenApp, known, open_app
from tests.examples import examples
from tests.settle import settle
from tests.tui.unreadable import UNREADABLE

NOISE = st.lists(
    st.binary(max_size=6)
    | st.sampled_from(
        [b"\x1b", b"\x1b[", b"\x1b[<", b"\x1bO", b"\x1b[200~", b"\x1b[201~", b"\xc3\xb1", b"j"]
    )
    | st.from_regex(rb"\A\x1b\[[<?]?[0-9:;]{0,12}[A-Za-z~]\Z")
    | st.sampled_from(list(UNREADABLE.values())),
    max_size=8,
).map(b"".join)


class Reader:
    """Reads bytes as Textual's driver does, with a clock that is advanced by hand."""

    def __init__(self) -> None:
        self.now = 0.0
        decoder = SimpleNamespace(getincrementaldecoder=None)
        tolerate(decoder)  # type: ignore[arg-type]
        self._decode = decoder.getincrementaldecoder("utf-8")().decode
        self._parser = TolerantParser(now=lambda: self.now)

    def read(self, data: bytes) -> list[Message]:
        """Return the messages of bytes that are read at once."""
        with patch("textual._parser.get_time", lambda: self.now):
            text = self._decode(data)
            return list(self._parser.feed(text)) if text else []

    def wait(self, seconds: float) -> list[Message]:
        self.now += seconds
        with patch("textual._parser.get_time", lambda: self.now):
            return list(self._parser.tick())


def keys(messages: list[Message]) -> list[str | None]:
    return [message.character for message in messages if isinstance(message, events.Key)]


def dropped(messages: list[Message]) -> list[str]:
    return [message.what for message in messages if isinstance(message, UnreadableInput)]


@pytest.mark.parametrize("data", UNREADABLE.values(), ids=UNREADABLE)
def test_what_cannot_be_read_is_dropped_and_the_keys_around_it_count(data: bytes) -> None:
    messages = Reader().read(b"f" + data + b"j")
    assert keys(messages) == ["f", "j"]
    assert len(dropped(messages)) == 1
    assert not [message for message in messages if isinstance(message, events.Resize)]
    reader = Reader()
    messages = [message for byte in b"f" + data + b"j" for message in reader.read(bytes([byte]))]
    assert keys(messages) == ["f", "j"], "it may arrive byte by byte"
    assert dropped(messages)


def test_other_input_is_read_as_by_textual() -> None:
    reader, plain = Reader(), XTermParser()
    typed = "jñ漢👩\u200d👧 \r\t\x7f\x1b[A\x1bOP\x1b[1;5C\x1b[97;5u"
    data = f"{typed}\x1b[<0;5;6M\x1b[I\x1b[200~pasted\x1b[201~\x1b[48;30;90;600;900tq"
    mine, theirs = reader.read(data.encode()), list(plain.feed(data))
    assert [repr(message) for message in mine] == [repr(message) for message in theirs]
    assert [message.size for message in mine if isinstance(message, events.Resize)] == [
        Size(90, 30)
    ]


def test_the_mouse_is_where_it_is_after_something_was_dropped() -> None:
    reader = Reader()
    reader.read(b"\x1b[48;24;80;480;800t")
    reader.read(b"\x1b[48;9999;9999;1;1t\x1b[1114112u")
    (down,) = reader.read(b"\x1b[<0;101;41M")
    assert isinstance(down, events.MouseDown)
    assert (down.x, down.y) == (10, 2)


def test_a_paste_without_an_end_swallows_no_key_after_it() -> None:
    reader = Reader()
    assert reader.read(b"\x1b[200~some text") == []
    assert reader.wait(0.4) == []
    assert reader.read(b" and more") == []
    assert dropped(reader.wait(0.6)) == [r"\x1b[200~"], (
        "as of every paste, the text is not recorded"
    )
    assert keys(reader.read(b"j")) == ["j"]


def test_a_long_paste_in_parts_stays_a_paste() -> None:
    reader = Reader()
    for part in (b"\x1b[200~", b"x" * 4000, b"\xc3", b"\xb1", b"y"):
        assert reader.read(part) == []
        assert reader.wait(0.2) == []
    assert reader.read(b"\x1b[20") == []
    (paste,) = [message for message in reader.read(b"1~j") if isinstance(message, events.Paste)]
    assert paste.text == "x" * 4000 + "ñy"


@examples(300)
@given(st.lists(NOISE, max_size=4))
def test_after_any_bytes_the_next_key_counts(parts: list[bytes]) -> None:
    reader = Reader()
    for part in parts:
        for message in reader.read(part):
            repr(message)
    reader.wait(1)
    reader.read(b"\x80")  # ends a character that was begun
    reader.wait(1)
    assert keys(reader.read(b"j"))[-1:] == ["j"]


def test_the_drivers_of_terminals_and_browsers_read_so(monkeypatch: pytest.MonkeyPatch) -> None:
    import sar_tui.tui.web_driver  # noqa: F401  exchanges the parser of Textual's

    assert web_driver.XTermParser is TolerantParser  # type: ignore[attr-defined]
    monkeypatch.setattr(linux_driver, "XTermParser", XTermParser)
    monkeypatch.setattr(linux_driver, "getincrementaldecoder", None)
    tolerate_in_terminals()
    assert linux_driver.XTermParser is TolerantParser  # type: ignore[attr-defined]
    assert linux_driver.getincrementaldecoder("utf-8")().decode(b"\xf1j") == "\udcf1j"  # type: ignore[attr-defined]


# --- pastes, marked and not

PART = 4096
"""Bytes that a driver reads at once."""
FLOODS = {
    "letters": b"abcdefghij",
    "arrows": b"\x1b[A",
    "escapes": b"\x1b",
    "colours": b"\x1b[31mhello\x1b[0m",
    "unknown sequences": b"\x1b[99;99;99y",
    "other bytes": b"\xf1\x80",
}


def flood(reader: Reader, data: bytes, count: int = 0, within: float = 0.02) -> list[Message]:
    """Read bytes in parts, without a pause; ``count``: only so many parts."""
    messages: list[Message] = []
    for at in range(0, len(data), PART)[: count or None]:
        messages += reader.read(data[at : at + PART]) + reader.wait(within)
    return messages


@pytest.mark.parametrize("unit", FLOODS.values(), ids=FLOODS)
def test_what_nobody_types_is_dropped(unit: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    parsed = []
    parse = XTermParser.feed
    monkeypatch.setattr(
        XTermParser, "feed", lambda self, data: (parsed.append(data), parse(self, data))[1]
    )
    reader = Reader()
    size = 300_000 // len(unit) * len(unit)
    messages = flood(reader, unit * (size // len(unit)))
    messages += reader.wait(0.2)
    (gone,) = [message for message in messages if isinstance(message, PasteDropped)]
    assert len("".join(parsed)) <= 2 * TYPED_AT_MOST, "the work does not grow with the input"
    assert size - 2 * TYPED_AT_MOST <= gone.length <= size
    assert (
        len([message for message in messages if isinstance(message, events.Key)])
        <= 2 * TYPED_AT_MOST
    )
    assert keys(reader.read(b"j")) == ["j"]


@pytest.mark.parametrize(("key", "sent"), [("f1", b"\x1bOP"), ("f2", b"\x1b[12~")])
def test_help_and_stop_act_in_the_middle_of_it(key: str, sent: bytes) -> None:
    reader = Reader()
    flood(reader, b"x" * PART * 3)
    found = reader.read(b"y" * 1000 + sent[:2]) + reader.read(sent[2:] + b"z" * 1000)
    assert [message.key for message in found if isinstance(message, events.Key)] == [key]


def test_a_paste_that_is_not_marked_arrives_whole() -> None:
    reader = Reader()
    text = "".join(f"line {number} ñ " for number in range(500))
    messages = flood(reader, text.encode())
    assert not [message for message in messages if isinstance(message, events.Paste)]
    messages += reader.wait(0.2)
    (paste,) = [message for message in messages if isinstance(message, events.Paste)]
    assert "".join(map(str, keys(messages))) + paste.text == text


def test_a_paste_is_passed_on_up_to_a_length_and_without_control_sequences() -> None:
    reader = Reader()
    (paste,) = flood(reader, b"\x1b[200~" + b"\x1b[31mx" * (LONGEST_PASTE // 6) + b"\x1b[201~")
    assert isinstance(paste, events.Paste)
    assert paste.text == "x" * (LONGEST_PASTE // 6)
    (gone,) = flood(reader, b"\x1b[200~" + b"x" * (LONGEST_PASTE + 1) + b"\x1b[201~")
    assert isinstance(gone, PasteDropped)
    assert gone.length == LONGEST_PASTE + 1
    assert keys(reader.read(b"j")) == ["j"]


@examples(200)
@given(st.text(st.characters(exclude_categories=["Cc", "Cs"]), min_size=1), st.data())
def test_a_marked_paste_may_be_cut_anywhere(text: str, data: st.DataObject) -> None:
    reader = Reader()
    sent = f"\x1b[200~{text}\x1b[201~j".encode()
    found: list[Message] = []
    while sent:
        count = data.draw(st.integers(1, len(sent)))
        found += reader.read(sent[:count])
        sent = sent[count:]
    assert [message.text for message in found if isinstance(message, events.Paste)] == [text]
    assert keys(found) == ["j"]


def test_a_mouse_that_moves_and_a_key_that_is_held_are_no_paste() -> None:
    reader = Reader()
    messages = []
    for _ in range(300):
        messages += reader.read(b"\x1b[<35;10;10M" * 5 + b"\x1b[<35;11;11M\x1b[A")
        messages += reader.wait(0.033)
    assert len([message for message in messages if isinstance(message, events.Key)]) == 300
    assert len([message for message in messages if isinstance(message, events.MouseMove)]) == 1800


# --- the apps


async def send(app: BaseApp, data: bytes) -> None:
    """Let an app get what a driver would read from these bytes."""
    reader = Reader()
    for message in (*reader.read(data), *reader.wait(1)):
        message.set_sender(app)
        app.post_message(message)
    await settle(app)


async def test_input_that_was_dropped_in_a_session_is_recorded(driver: AppDriver) -> None:
    prompt = await driver.to_first_prompt()
    await send(driver.app, b"\xff" * 100)
    await send(driver.app, b"\x1b[200~" + b"x" * (LONGEST_PASTE + 1) + b"\x1b[201~")
    await driver.settle()
    assert [message["what"] for message in driver.messages("input/unreadable")] == [r"\xff" * 80]
    assert [one["length"] for one in driver.messages("input/paste")] == [LONGEST_PASTE + 1]
    await driver.answer(prompt)
    ((correct, timing),) = driver.stored("SELECT correct, timing FROM trials")
    assert correct == 1
    assert '"unreadable_input"' in timing


async def test_what_was_dropped_is_told_when_the_app_has_ended(
    opened: OpenApp, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    async with opened() as driver:
        await send(driver.app, b"\x80")
        await send(driver.app, b"\x1b[55296u")
        await send(driver.app, b"\x1b[200~" + b"x" * (LONGEST_PASTE + 1) + b"\x1b[201~")
    monkeypatch.setattr(BaseApp, "run_async", AsyncMock())
    await asyncio.to_thread(driver.app.run_here)
    told = capsys.readouterr().err
    assert r"cannot be read, 2 times (last: \x1b[55296u)." in told
    assert "A paste was dropped: too long, or no text (65,537 characters)." in told


async def test_a_window_larger_than_any_is_drawn_up_to_a_limit(
    opened: OpenApp, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(terminal_input, "LARGEST", Size(120, 40))
    async with opened() as driver:
        await driver.resize(9999, 9999)
        assert driver.app.size == Size(120, 40)
        assert driver.app.screen.size == driver.app.size
        await driver.resize(80, 24)
        assert driver.app.screen.size == Size(80, 24)


@examples(30)
@given(parts=st.lists(NOISE, min_size=1, max_size=6))
async def test_the_app_survives_any_bytes(
    parts: list[bytes], tmp_path_factory: Any, catalogue: Catalogue
) -> None:
    folder = tmp_path_factory.mktemp("noise")
    known(folder)
    async with open_app(folder, catalogue) as driver:
        for part in parts:
            await send(driver.app, part)
        assert driver.app.failure == ""
        assert driver.app.return_code in (None, 0, 130), "it goes on, or a key quit it"
