"""In patient mode no input leads to another screen than the participant's, and every session stays
whole.

``SAR_TUI_TEST_STRINGS=100000`` types as many random strings, for an hour or so, instead of some
thousand.
"""

import itertools
import os
import random
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from textual.message import Message

from sar_tui.app.app import SarTui
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.session import Session
from sar_tui.model.units import MS, SECOND
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from sar_tui.store import participants, passphrase, programmes, sessions
from sar_tui.store.database import connect
from sar_tui.store.passphrase import Passphrase
from sar_tui.tui.terminal_input import TolerantParser
from tests.app.app_driver import SHORT, AppDriver, open_app
from tests.examples import QUICK

OTHER = "P77"
SEEDS = range(2, 6)
STRINGS = int(os.environ.get("SAR_TUI_TEST_STRINGS", "2000")) // len(SEEDS)
ALLOWED = {
    "PatientScreen", "SessionScreen", "PassphraseScreen", "HelpScreen", "TooSmallScreen",
    "SensorCheckScreen", "SavingScreen", "QuestionScreen",
}  # fmt: skip
"""Screens of a participant who trains alone; and the blank one below all."""

CONTROL = [bytes([code]) for code in (*range(32), 127)]
KEYS = [
    *(b"\x1b[" + end for end in (b"A", b"B", b"C", b"D", b"H", b"F", b"Z", b"5~", b"6~", b"2~", b"3~")),
    *(b"\x1bO" + end for end in (b"P", b"Q", b"R", b"S")),
    *(b"\x1b[%d~" % code for code in (15, 17, 18, 19, 20, 21, 23, 24, 25, 29, 34)),
    *(b"\x1b[%d;%d%s" % (code, changed, end) for code in (1, 24) for changed in range(2, 9) for end in (b"A", b"~")),
    *(b"\x1b[%d;%du" % (code, changed) for code in (3, 17, 26, 28, 113, 112) for changed in (1, 3, 5, 6, 8)),
    b"\x1b\x1b", b"\x1bq", b"\x1b:", b"\r", b"\r", b"\r", b" ", b"\t", b"\x1b[I", b"\x1b[O",
]  # fmt: skip
WORDS = [
    b"q", b"quit", b":q", b"settings", b"exit\r", b"P77\r", b"!sh\r", b"jf", "ñ¿é".encode(),
    b"\xff\xfe",
]  # fmt: skip


def strings(number: int, seed: int) -> Iterator[bytes]:
    """Yield random strings: control bytes, keys, pastes, mouse, sizes, words, and bytes without any
    sense.
    """
    draw = random.Random(seed)
    mouse = b"\x1b[<%d;%d;%d%s"
    for _ in range(number):
        parts = []
        for _ in range(draw.randint(1, 4)):
            match draw.randrange(9):
                case 0 | 1:
                    part = draw.choice(CONTROL)
                case 2 | 3 | 4:
                    part = draw.choice(KEYS)
                case 5:
                    pasted = draw.randbytes(draw.randint(0, 9)).replace(b"\x1b", b"")
                    part = b"\x1b[200~" + pasted + b"\x1b[201~"
                case 6:
                    at = draw.randint(1, 90), draw.randint(1, 30)
                    button = draw.choice([0, 0, 1, 2, 32, 64, 65])
                    part = mouse % (button, *at, b"M") + mouse % (button, *at, b"m")
                case 7:
                    part = draw.choice(WORDS)
                case _:
                    part = draw.randbytes(draw.randint(1, 5))
            parts.append(part)
        yield b"".join(parts)


class Typist:
    """Types bytes into an app through the parser of its terminal, and notes every screen that
    appears.
    """

    def __init__(self, driver: AppDriver, monkeypatch: pytest.MonkeyPatch) -> None:
        self._driver = driver
        self._draw = random.Random(3)
        # a second later each time: nothing is a flood
        self._parser = TolerantParser(now=itertools.count().__next__)
        self.screens: set[str] = set()
        self.texts: list[str] = []
        for name in ("push_screen", "switch_screen"):
            self._note_screens(driver.app, name, monkeypatch)

    def _note_screens(self, app: SarTui, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
        original = getattr(app, name)

        def noted(screen: Any, *args: Any, **how: Any) -> Any:
            self.screens.add(type(screen).__name__ if not isinstance(screen, str) else screen)
            return original(screen, *args, **how)

        monkeypatch.setattr(app, name, noted)

    async def type(self, data: bytes) -> None:
        """Type a string; then let a moment pass, and resize the window now and then."""
        driver, draw = self._driver, self._draw
        messages: list[Message] = list(self._parser.feed(data.decode("utf-8", "surrogateescape")))
        messages += self._parser.feed("") if draw.random() < 0.2 else ()
        for message in messages:
            driver.app._driver.process_message(message)
        await driver.settle()
        driver.clock.advance(draw.choice([0, 50, 800, 1500]) * MS)
        await driver.settle()
        is_small = driver.app.size.width < 80 or driver.app.size.height < 24
        if draw.random() < (0.5 if is_small else 0.01):
            await driver.resize(
                *draw.choice([(1, 1), (24, 80), (79, 24), (120, 40), (80, 24), (80, 24)])
            )
        self.screens.update(type(screen).__name__ for screen in driver.app.screen_stack[1:])

    def look(self) -> None:
        """Note the text on the screen."""
        self.texts.append(self._driver.text)


@pytest.fixture
def prepared(data: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Set a passphrase that is cheap to check, and two participants with short exercises."""
    monkeypatch.setattr(passphrase, "_COST", 16)
    Passphrase(data).set("quiet river and stone")
    with closing(connect(data)) as database:
        reaching = {"imu": "simulated", "attempts": 1, "reaches_per_attempt": 1}
        for code in ("P01", OTHER):
            participants.add(database, code)
            for task, parameters in (("keyboard", SHORT), ("reaching", reaching)):
                programmes.save(
                    database, code, task, programmes.Programme(dict(parameters)), after=0
                )
    return data


@pytest.mark.parametrize(
    ("number", "seed"),
    [
        (100, 1),
        *([] if QUICK else [pytest.param(STRINGS, seed, marks=pytest.mark.slow) for seed in SEEDS]),
    ],
)
@pytest.mark.timeout(max(180, STRINGS // 2))
async def test_no_string_leads_out_of_patient_mode(
    number: int, seed: int, prepared: Path, catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with open_app(prepared, catalogue, patient="P01") as driver:
        typist = Typist(driver, monkeypatch)
        for count, data in enumerate(strings(number, seed)):
            await typist.type(data)
            assert driver.app.is_running, data
            assert driver.app.patient == "P01"
            assert typist.screens <= ALLOWED, data
            if count % 25 == 0:
                typist.look()
        assert {"PatientScreen", "SessionScreen", "PassphraseScreen"} <= typist.screens
        assert not [text for text in typist.texts if OTHER in text or "Settings" in text]
    assert_whole(prepared, catalogue)


def assert_whole(data: Path, catalogue: Catalogue) -> None:
    """Replay every session: what its nodes derive must equal the record."""
    with closing(connect(data)) as database:
        assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        rows = sessions.listing(database, data)
        assert rows
        for row in rows:
            assert row["participant"] == "P01"
            kind = catalogue.task(row["task"])
            task = kind(build(kind.Parameters, row["parameters"]))
            theme = catalogue.theme(row["theme"], task.parameters.language)
            session = Session(task, theme, VirtualClock(10 * SECOND), row["seed"])
            session.replay(sessions.history(database, row["id"]))
            assert session.ended == (row["status"] in ("completed", "aborted", "discarded"))
