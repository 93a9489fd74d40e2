"""Texts of themes, tasks, operators and sessions are drawn visibly by all three apps."""

from pathlib import Path
from typing import Any

import msgspec
from rich.segment import Segment
from rich.style import Style
from textual.color import Color

from sar_tui.app.agent.app import AgentApp
from sar_tui.loop import topics as t
from sar_tui.loop.task import Task
from sar_tui.model import messages as m
from sar_tui.model.theme import Theme
from sar_tui.model.trial_types import Metric, Result, Situation, Stimulus, Trial
from sar_tui.plugins import Catalogue
from sar_tui.tui.base_app import BaseApp, VisibleLines
from tests.app.app_driver import OpenApp, plan
from tests.app.test_agent_view import BETWEEN, Link, said
from tests.hostile import HOSTILE, leaks
from tests.operator.panel_driver import approval, frame, open_panel, proposal
from tests.settle import settle

TEXT = f"{HOSTILE}[/b][red"
"""A hostile text, which is no valid markup either."""
BEGINNING = "␛]0;owned"
"""The beginning of that text as it is drawn. Textual itself removes the bell after it."""


def drawn(app: BaseApp) -> str:
    """Return what the app sends to the terminal, without colours. Fails if a terminal would obey
    any of it.
    """
    lines = [strip.text for strip in app.screen._compositor.render_strips()]
    assert leaks("\n".join(lines)) == []
    assert {len(line) for line in lines if line.isascii()} <= {app.size.width}
    return "\n".join(lines)


class Hostile(Task):
    """A task with such texts everywhere."""

    name = "hostile"
    title = TEXT
    summary = TEXT
    metric = Metric("reaction_time", TEXT, "lower", improved=TEXT, worsened=TEXT)

    @property
    def trials_per_attempt(self) -> int:
        return 1

    def instructions(self) -> str:
        return f"Press the key.\n{TEXT}"

    def goal(self, level: int) -> str:
        return TEXT

    def stimulus(self, situation: Situation) -> Stimulus:
        return Stimulus("j", "j", f"Press:{TEXT}j", glyph=TEXT, hint=TEXT)

    def perceived(self, trial: Trial, percept: Any) -> Result:
        latency = trial.latency_ms(percept.at)
        return Result(
            response=percept.key, correct=True, response_at=percept.at, value=latency, remark=TEXT
        )


async def test_a_session_draws_a_tasks_texts_and_notifications_visibly(
    opened: OpenApp, catalogue: Catalogue
) -> None:
    planned = plan(catalogue, catalogue.task("keyboard"))
    parameters = msgspec.structs.replace(Hostile.Parameters(), attempts=1)
    hostile = msgspec.structs.replace(planned, task=Hostile, parameters=parameters)
    async with opened(hostile, size=(120, 40)) as driver:
        assert BEGINNING in drawn(driver.app)
        await driver.press("enter")
        assert BEGINNING in drawn(driver.app)
        await driver.begin()
        assert "␛" in drawn(driver.app)
        await driver.wait(400)
        await driver.press("j")
        await driver.wait(3000)
        drawn(driver.app)
        await driver.press("escape", "f1")
        before = drawn(driver.app).count(BEGINNING)
        driver.app.notify(TEXT, title=TEXT)
        await driver.settle()
        assert drawn(driver.app).count(BEGINNING) == before + 2


async def test_the_panel_draws_the_link_visibly(data: Path, catalogue: Catalogue) -> None:
    async with open_panel(catalogue, data, joins=False, size=(120, 40)) as panel:
        await panel.join(title=TEXT, participants={"A": TEXT}, unit=TEXT)
        await panel.publish(t.NOTE_ADDED, m.NoteAdded(actor=f"operator.{TEXT}", text=TEXT))
        await panel.propose(approval(text=TEXT, spoken=TEXT))
        assert drawn(panel.app).count(BEGINNING) >= 3
        said_now = msgspec.structs.asdict(proposal(text=TEXT)) | {
            "decision": "accepted",
            "actor": TEXT,
        }
        numbers = dict.fromkeys(("attempt", "trial", "presentation", "level", "choices"), 1)
        shown = {"stimulus": TEXT, "expected": "f", "text": TEXT, "glyph": TEXT, "timeout": 3}
        prompt = m.Prompt(**numbers, **shown)  # type: ignore[arg-type]
        await panel.receive([frame(t.ACTION, m.Action(**said_now)), frame(t.PROMPT, prompt)])
        assert BEGINNING in drawn(panel.app)


async def test_the_agents_own_screen_draws_its_text_visibly(calm: Theme) -> None:
    link = Link()
    app = AgentApp(calm, link.join)
    async with app.run_test(size=(80, 24)):
        await settle(app)
        link.welcome()
        link.deliver(t.WAITING, BETWEEN)
        link.deliver(t.ACTION, said(TEXT))
        await settle(app)
        assert BEGINNING in drawn(app)


# --- the filter


def test_a_line_with_signs_keeps_its_width_and_its_colours() -> None:
    bold = Style(bold=True)
    line = [Segment("│"), Segment("a\x1b[2J\x07b ", bold), Segment("  "), Segment("│")]
    assert VisibleLines().apply(line, Color(0, 0, 0)) == [
        Segment("│"),
        Segment("a␛[2J␇b", bold),
        Segment(" "),
        Segment("│"),
    ]
    assert VisibleLines().apply([Segment("a\x1bbc")], Color(0, 0, 0)) == [Segment("a␛b")], (
        "without spaces, it is cut"
    )


def test_a_line_without_them_is_left_alone() -> None:
    line = [Segment("👩\u200d👧 ñ", None), Segment("\x1b[2J", None, [(1,)])]  # type: ignore[list-item]
    assert VisibleLines().apply(line, Color(0, 0, 0)) is line
