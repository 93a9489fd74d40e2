"""The panel's screen in each bundled language: nothing that it draws stays English."""

from functools import cache
from itertools import cycle
from pathlib import Path
from typing import Any, get_args

import pytest
from msgspec.structs import replace
from rich.cells import cell_len

from sar_tui.link import discovery
from sar_tui.link.discovery import JoinableSession, folder_name
from sar_tui.link.peer import Connection
from sar_tui.loop import topics as t
from sar_tui.model import messages as m
from sar_tui.model.language import BUNDLED
from sar_tui.model.step import Step
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import NO_METRIC, Metric
from sar_tui.model.units import SECOND
from sar_tui.operator import keymap
from sar_tui.operator.app import ChooseScreen, WizardApp, panel_texts
from sar_tui.plugins import Catalogue
from sar_tui.store.interface_language import choose_interface_language
from tests.operator import panel_driver as b
from tests.settle import settle
from tests.translations import OTHERS, rooms, translated_in
from tests.untranslated import english_in

SMALL, LARGE = (80, 24), (120, 40)
THEIRS = "¡Ñu!"
"""A text that participants read, in the language of their session: here in none that has a
translation.
"""
_FRAMES = str.maketrans(dict.fromkeys("│┃", " "))
"""Borders, which stand between the rows of a text."""
WAITS: tuple[tuple[Any, Any, dict[str, Any]], ...] = (
    ("enter", "instructions", {}),
    ("enter", "attempt", {"until": 5}),
    ("start", "trial", {}),
    ("agent", "attempt", {}),
    ("answer", "answer", {}),
    (
        "step",
        "step",
        {"step": m.AskedStep(number=1, step=Step(name="x", text=THEIRS, kind="text"))},
    ),
    ("rest", "rest", {}),
    ("quiet", "trial", {"reason": "held"}),
    ("foreperiod", "trial", {}),
    ("storage", "trial", {}),
    ("response", "trial", {}),
    ("result", "trial", {}),
    ("sensor", "paused", {"reason": "sensor"}),
    ("nothing", "review", {}),
    *(("resume", "paused", {"reason": why}) for why in ("", "tired", "pain", "finished")),
    ("resume", "paused", {"reason": "interrupted"}),
    ("resume", "paused", {"reason": "storage"}),
)


class Seen:
    """Collects what the panel shows.

    Args:
        driver: of the panel.
    """

    def __init__(self, driver: b.PanelDriver) -> None:
        self.driver = driver
        self.lines: list[str] = []

    def look(self) -> None:
        """Add the rows that are on the screen, and all of them as one, as some texts take more than
        one row.
        """
        self.lines += [*self.driver.rows, " ".join(self.driver.rows).translate(_FRAMES)]

    async def receive(self, *events: Any) -> None:
        """Receive events of the link, and look."""
        await self.driver.receive(*events)
        self.look()

    async def publish(self, topic: Any, message: m.Message) -> None:
        """Publish a message of the session, and look."""
        await self.receive([b.frame(topic, message, self.driver.peer.now())])

    async def propose(self, *approvals: m.PendingApproval, **other: Any) -> None:
        """Show proposals with 4 s to decide, and look."""
        deadline = self.driver.peer.now() + 4 * SECOND
        timed = [
            each if each.deadline is None else replace(each, deadline=deadline)
            for each in approvals
        ]
        await self.publish(t.ARBITER_STATE, b.arbiter_state(*timed, **other))
        await self.advance(500)

    async def advance(self, ms: int) -> None:
        """Advance the session's clock, and look."""
        await self.driver.advance(ms)
        self.look()

    async def press(self, *keys: str) -> None:
        """Press keys, and look after each."""
        for key in keys:
            await self.driver.press(key)
            self.look()


def proposals(kind: str = "feedback", **other: Any) -> m.PendingApproval:
    """Return a proposal whose texts have no translation."""
    return b.approval("p1", kind=kind, **{"text": THEIRS, "spoken": THEIRS, **other})


async def attend(seen: Seen, theme: Theme) -> None:
    """Attend a session from its beginning to its end, with all that the panel can show."""
    driver = seen.driver
    seen.look()
    await seen.receive(Connection("connecting", "The session does not answer: it may be over."))
    await seen.receive(Connection("connected"), b.welcome(title=THEIRS))
    opened = m.OutputOpened(output="screen", address="screen", can=("show",))
    await seen.receive(
        [
            b.frame(t.THEME, m.ThemeApplied(theme=theme)),
            b.frame(t.OUTPUT, opened),
        ]
    )
    await seen.publish(t.PRESENCE, b.presence())
    await seen.publish(t.ARBITER_STATE, b.arbiter_state())
    for state in get_args(m.SensorState):
        await seen.publish(t.SENSOR, m.SensorChanged(state=state, at=b.START))
    for what, stage, other in WAITS:
        await seen.publish(t.WAITING, b.waiting(what, stage, **other))
    await seen.publish(t.WAITING, b.waiting("resume", "paused", reason="tired"))
    await seen.press("space")  # asks, as the participant has paused
    await seen.publish(t.COMMAND, m.SessionCommand(command="pause", actor="operator.ben"))
    await seen.publish(t.WAITING, b.waiting())
    await seen.publish(t.PROMPT, b.prompt(THEIRS))
    await seen.publish(t.TRIAL, b.trial(1, "f", 412))
    await seen.publish(t.ATTEMPT_ENDED, b.attempt(metric=498.2))
    await seen.publish(t.ATTEMPT_ENDED, b.attempt(attempt=3, goal=None, metric=None))
    await seen.publish(t.LEVEL, m.LevelChanged(previous=4, level=5, reason="operator"))
    await seen.receive(b.TRACE)
    for acting, spoken in ((False, ""), (True, THEIRS), (True, "")):
        current = b.action("a1", text="", spoken=spoken) if acting else None
        await seen.publish(t.ARBITER_STATE, b.arbiter_state(current=current))
        await seen.publish(t.ACTING, m.AgentActing(acting=acting))
    await decide(seen)
    await stop(seen)
    await seen.press("end", "escape", "t", "escape", "n", "escape")
    await watch(seen)
    await seen.press("q", "escape", "f1", "f1")
    for size in ((60, 20), SMALL):
        await driver.pilot.resize_terminal(*size)
        await settle(driver.app)
        seen.look()
    for why in ("The connection broke.", ""):
        await seen.receive(Connection("lost", why))
    for policy in ("silent", "drop"):
        await seen.receive(b.welcome(title=THEIRS, parameters={"operator_lost": policy}))
    await seen.receive(Connection("ended", "The session is over."))
    await seen.receive(Connection("ended"))
    await seen.receive(Connection("connected"), b.welcome(title=THEIRS))
    practice = b.welcome(title=THEIRS, parameters={"practice_attempts": 9}, metric=NO_METRIC)
    await seen.receive(practice)
    await seen.publish(t.WAITING, b.waiting())
    await seen.publish(t.ATTEMPT_ENDED, b.attempt())
    await seen.receive(b.welcome(title=THEIRS * 20, parameters={"practice_attempts": 9}))
    await seen.publish(t.LEVEL, m.LevelChanged(previous=4, level=5, reason="operator"))
    for status in get_args(m.EndStatus):
        await seen.publish(t.SESSION_ENDED, m.SessionEnded(status=status))


async def decide(seen: Seen) -> None:
    """See proposals of all kinds; edit one until it is too late."""
    valences, degrees, modes = (cycle(get_args(each)) for each in (m.Valence, m.Degree, m.Mode))
    for kind in get_args(m.Kind):
        approval = proposals(kind, valence=next(valences), degree=next(degrees))
        mode = next(modes)
        every = dict.fromkeys(b.MODES, mode)
        other = replace(approval, proposal=replace(approval.proposal, id="p2"))
        await seen.propose(replace(approval, mode=mode), other, modes=every)
    await seen.propose(modes=dict.fromkeys(b.MODES, "autonomous"))
    await seen.publish(t.WAITING, b.waiting("answer", "answer"))
    await seen.propose(replace(proposals(), otherwise="drop"))
    await seen.propose(replace(proposals(), deadline=None))
    level = replace(proposals("difficulty", text=""), level=5)
    await seen.propose(level, replace(b.approval("p2", text=THEIRS)))
    await seen.press("right", "e", "x", "escape")
    await seen.propose(proposals(text=THEIRS * 30))
    await seen.press("e")
    await seen.propose()
    await seen.press("escape")
    await seen.propose(proposals())
    await seen.press("e")
    await seen.advance(60_000)
    await seen.propose()
    await seen.press("escape")
    due = b.action("a2", text=THEIRS, due=seen.driver.peer.now() + 3 * SECOND)
    await seen.propose(queued=(due,))


async def stop(seen: Seen) -> None:
    """Stop the agent."""
    at = seen.driver.peer.now()
    await seen.publish(t.COMMAND, m.SessionCommand(command="stop", at=at, actor=b.ANNA))
    await seen.publish(t.STOPPED, m.OutputStopped(output="screen", asked=at, at=at + 2_000_000))
    failed = m.OutputReport(
        action="a1", output="speech", part="say", state="failed", at=0, detail=THEIRS
    )
    await seen.publish(t.ACTION, b.action("a3", text=THEIRS))
    await seen.publish(t.REPORT, failed)


async def watch(seen: Seen) -> None:
    """Share two participants with others, then only watch them."""
    two = {"A": "P01", "B": "P02"}
    for role in ("operator", "observer"):
        seen.driver.peer.role = role
        await seen.receive(b.welcome(role, title="", participants=two))
        await seen.publish(t.ARBITER_STATE, b.arbiter_state())
        await seen.publish(t.ATTEMPT_ENDED, b.attempt())
        await seen.publish(t.WAITING, b.waiting("resume", "paused"))
        await seen.publish(
            t.COMMAND, m.SessionCommand(command="pause", actor="participant", reason="tired")
        )
        await seen.publish(t.WAITING, b.waiting("resume", "paused", reason="tired"))
        for presence in (
            b.presence("joined", cara="observer"),
            b.presence("joined", cara="observer", dan="observer"),
            b.presence("baton", "operator.ben", ben="operator"),
            m.OperatorChanged(
                actor="operator.ben", state="left", operated=False, peers={b.ANNA: "operator"}
            ),
        ):
            await seen.publish(t.PRESENCE, presence)
            await seen.propose(proposals())
            await seen.propose()
        await seen.press("f1", "f1")


@cache
def texts_of_panel(code: str) -> dict[str, str]:
    """Return the translations of all texts that the panel can show, and of those that it has."""
    room = next(room for room in rooms(Catalogue()) if room.folder.name == "operator")
    tr = panel_texts(code)
    texts = {text: tr(text) for text in room.needed | translated_in(room)}
    headings = {text.upper(): tr(text).upper() for text in get_args(m.Kind)}
    return {**texts, **headings}


@pytest.mark.slow
@pytest.mark.parametrize("code", OTHERS)
async def test_nothing_that_the_panel_draws_stays_english(
    catalogue: Catalogue, tmp_path: Path, code: str
) -> None:
    choose_interface_language(tmp_path, code)
    async with b.open_panel(catalogue, tmp_path, size=SMALL, joins=False) as driver:
        seen = Seen(driver)
        await attend(seen, catalogue.theme("calm", code))
    assert english_in(seen.lines, texts_of_panel(code)) == []


@pytest.mark.slow
@pytest.mark.parametrize("code", OTHERS)
async def test_the_plot_of_a_wide_panel_is_in_another_language(
    catalogue: Catalogue, tmp_path: Path, code: str
) -> None:
    choose_interface_language(tmp_path, code)
    async with b.open_panel(catalogue, tmp_path, size=LARGE, joins=False) as driver:
        seen = Seen(driver)
        for metric in (NO_METRIC, Metric(THEIRS, "ms", "lower")):
            await seen.receive(Connection("connected"), b.welcome(title=THEIRS, metric=metric))
        for number, outcome in enumerate(("success", "failure", "none"), 2):
            await seen.publish(t.ATTEMPT_ENDED, b.attempt(attempt=number, outcome=outcome))
        await seen.receive(b.welcome(title=THEIRS, participants={"A": "P01", "B": "P02"}))
    tr = panel_texts(code)
    for text in ("This task has no result", "reached", "inaccurate", "level"):
        assert tr(text) in " ".join(seen.lines)
    assert tr("Attempts of {who}", who="P01") in " ".join(seen.lines)
    assert english_in(seen.lines, texts_of_panel(code)) == []


@pytest.mark.slow
@pytest.mark.parametrize("code", OTHERS)
async def test_the_choice_of_a_session_is_in_another_language(
    catalogue: Catalogue, tmp_path: Path, code: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    choose_interface_language(tmp_path, code)
    facts: dict[str, Any] = {"participants": ("P01", "P02"), "started": "2026-01-02T03:04:05+00:00"}
    here = JoinableSession("s1", THEIRS, "abcd", 1, data=folder_name(tmp_path), **facts)
    there = replace(here, session="s2", data="/elsewhere")
    found: list[JoinableSession] = []
    monkeypatch.setattr(discovery, "live_sessions", lambda: found)
    app = WizardApp(catalogue.theme("calm"), tmp_path, "anna")
    shown: list[str] = []
    async with app.run_test(size=SMALL):
        for sessions in ([], [there], [here, there]):
            found[:] = sessions
            await settle(app)
            assert isinstance(app.screen, ChooseScreen)
            app.screen.look_again()
            await settle(app)
            shown += [*b.rows_of(app), app.screen.help_text]
    tr = panel_texts(code)
    assert tr("Enter joins.") in " ".join(shown)
    assert tr("since {time}", time="2026-01-02") in " ".join(shown)
    assert english_in(shown, texts_of_panel(code)) == []


@pytest.mark.slow
@pytest.mark.parametrize("code", OTHERS)
@pytest.mark.parametrize(
    "text",
    [
        "[keys]\nskipp = 'y'",
        "[keys]\nskip = 'r'",
        "[keys]\nskip = 'hyperspace'",
        None,
    ],
)
def test_what_is_wrong_with_the_operators_file_is_told_in_another_language(
    catalogue: Catalogue, tmp_path: Path, code: str, text: str | None
) -> None:
    path = tmp_path / keymap.FILE
    if text is None:
        path.mkdir()
    else:
        path.write_text(text)
    file, problem = keymap.read(tmp_path, panel_texts(code))
    assert file == keymap.KeymapFile()
    assert keymap.FILE in problem
    assert english_in([problem], texts_of_panel(code)) == []


@pytest.mark.parametrize("code", BUNDLED)
def test_keys_fit_their_places_in_each_language(code: str) -> None:
    tr, file = panel_texts(code), keymap.KeymapFile()
    footer = keymap.footer(file, "", 78, tr, is_observer=False).plain.rstrip()
    assert cell_len(footer) <= 78
    for id in ("stop", "pause", "undo", "say", "keys"):
        assert keymap.key_label(id, file, tr) in footer
    sheet = keymap.help_sheet(file, tr, is_observer=False, has_protocol=True).plain
    assert "…" not in sheet.replace("1…0", "")
    assert max(map(cell_len, sheet.splitlines())) <= 76
    assert tr("Ctrl") + "-Z" in sheet


async def test_a_wide_footer_names_all_the_keys(catalogue: Catalogue, tmp_path: Path) -> None:
    async with b.open_panel(catalogue, tmp_path, size=LARGE) as driver:
        assert "r Repeat" in driver.rows[-1]
    async with b.open_panel(catalogue, tmp_path, size=SMALL) as driver:
        assert "r Repeat" not in driver.rows[-1]
        assert "Ctrl-Z Undo" in driver.rows[-1]
