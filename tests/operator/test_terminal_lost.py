"""The panel proves that its operator's terminal is there, and says when it was not."""

from pathlib import Path

import pytest

from sar_tui.link.peer import Connection
from sar_tui.loop import topics as t
from sar_tui.model import messages as m
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.tui.terminal_probe import TerminalProbe
from tests.operator.panel_driver import ANNA, open_panel, welcome


async def test_an_answer_of_the_terminal_is_told_to_the_session(
    catalogue: Catalogue, tmp_path: Path
) -> None:
    async with open_panel(catalogue, tmp_path) as panel:
        assert panel.peer.terminal().silence is None
        panel.app.terminal_probe.answered()
        silence = panel.peer.terminal().silence
    assert silence is not None


@pytest.mark.parametrize(
    "was_told", [True, False], ids=["the panel knew that it was lost", "it did not yet"]
)
async def test_an_operator_who_is_back_reads_how_long_the_terminal_was_away(
    catalogue: Catalogue, tmp_path: Path, was_told: bool
) -> None:
    now = 1000 * SECOND
    async with open_panel(catalogue, tmp_path, size=(110, 30)) as panel:
        probe = panel.app.terminal_probe = TerminalProbe(lambda _: None, lambda: now)
        probe.answered()
        if was_told:
            await panel.receive(
                Connection("connecting", "The terminal of this panel does not answer.")
            )
        now += 34 * SECOND
        probe.answered()
        await panel.receive(*[Connection("connected")] * was_told, welcome())
        assert "This terminal did not answer for 34 s." in panel.text


async def test_an_absence_told_before_the_panel_has_joined_again_stays_in_sight(
    catalogue: Catalogue, tmp_path: Path
) -> None:
    now = 1000 * SECOND
    async with open_panel(catalogue, tmp_path, size=(80, 24)) as panel:
        probe = panel.app.terminal_probe = TerminalProbe(lambda _: None, lambda: now)
        probe.answered()
        await panel.join()
        now += 34 * SECOND
        probe.answered()
        panel.panel._drawn_at = 0
        panel.panel._tick()
        await panel.advance(200)
        await panel.receive(welcome())
        for state in ("joined", "baton"):
            await panel.advance(200)
            joined = m.OperatorChanged(
                actor=ANNA, state=state, operated=True, holder=ANNA, peers={ANNA: "operator"}
            )
            await panel.publish(t.PRESENCE, joined)
        assert panel.text.count("This terminal did not answer for 34 s.") == 1


async def test_an_operator_who_closes_the_panel_has_left_and_one_whose_terminal_hangs_up_is_lost(
    catalogue: Catalogue, tmp_path: Path
) -> None:
    said = []
    for is_gone in (False, True):
        async with open_panel(catalogue, tmp_path) as panel:
            if is_gone:
                panel.app.lose_terminal()
        said.append(panel.peer.says_goodbye)
    assert said == [True, False]
