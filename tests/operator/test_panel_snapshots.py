"""Snapshots of the panel as plain text, in each theme, at 80 by 24, 100 by 30 and 140 by 45.

They are stored in ``snapshots/``. Redraw them with ``SAR_TUI_UPDATE_SNAPSHOTS=1``, then look at the
changes.
"""

from pathlib import Path

import pytest

from sar_tui.link.peer import Connection
from sar_tui.loop import topics as t
from sar_tui.model import messages as m
from sar_tui.plugins import Catalogue
from tests.album import Album
from tests.examples import first
from tests.operator import panel_driver as b

FOLDER = Path(__file__).parent / "snapshots"
SMALL, LARGE, LARGEST = (80, 24), (100, 30), (140, 45)
KINDS = (
    ("calm", SMALL),
    ("calm", LARGE),
    ("calm", LARGEST),
    ("high-contrast", SMALL),
    ("playful", LARGE),
)
VIEWS = ("joining", "prompt", "proposals", "editing", "modes", "two-participants", "lost", "keys")


@pytest.mark.parametrize("kind", first(2, reversed(KINDS)))
async def test_the_panel_matches_its_snapshots(
    kind: tuple[str, tuple[int, int]], tmp_path: Path, catalogue: Catalogue
) -> None:
    theme, size = kind
    album = Album(FOLDER, f"{theme}.{size[0]}x{size[1]}", size)
    async with b.open_panel(catalogue, tmp_path, theme, size, joins=False) as driver:
        album.take("joining", driver)
        await driver.join()
        attached = m.SensorChanged(state="attached", at=b.START)
        await driver.receive(
            [
                b.frame(t.SENSOR, attached),
                b.frame(t.PROMPT, b.prompt()),
                b.frame(t.WAITING, b.waiting()),
            ],
            b.TRACE,
        )
        album.take("prompt", driver)
        await driver.publish(t.WAITING, b.waiting("answer", "answer"))
        wave = b.approval(
            "p2", ms=6000, kind="gesture", text="", spoken="", gesture="wave", valence=None
        )
        await driver.propose(b.approval(), wave)
        album.take("proposals", driver)
        await driver.press("e", "!")
        album.take("editing", driver)
        await driver.press("escape", "o")
        album.take("modes", driver)
        await driver.receive(Connection("lost", "The connection broke."))
        album.take("lost", driver)
        await driver.press("f1")
        album.take("keys", driver)
        await driver.press("f1", "escape")
        await driver.join(participants={"A": "P01", "B": "P02"})
        others = [
            b.frame(t.TRIAL, b.trial(n, "k", 380 + 40 * n, correct=n != 3, seat="B"))
            for n in range(1, 6)
        ]
        note = m.NoteAdded(text="P02 coughs", actor="operator.ben", at=b.START)
        stop = m.SessionCommand(command="stop", at=b.START)
        watcher = b.presence("joined", "observer.cara", ben="operator", cara="observer")
        await driver.receive([*others, b.frame(t.PRESENCE, watcher)])
        opened = m.OutputOpened(output="screen", address="screen", can=("show",))
        stopped = m.OutputStopped(output="screen", asked=b.START, at=b.START + 2_000_000)
        said = (b.frame(t.COMMAND, stop), b.frame(t.STOPPED, stopped), b.frame(t.NOTE_ADDED, note))
        await driver.receive([b.frame(t.OUTPUT, opened), *said])
        album.take("two-participants", driver)
    assert set(album.taken) == set(VIEWS)
    album.check()


def test_no_snapshot_is_left_over() -> None:
    names = {f"{view}.{theme}.{w}x{h}.txt" for view in VIEWS for theme, (w, h) in KINDS}
    assert {path.name for path in FOLDER.iterdir()} == names
