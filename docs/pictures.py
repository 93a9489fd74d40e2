"""Draws the pictures of the documentation from the app itself: ``python -m docs.pictures``."""

import asyncio
import re
import tempfile
from pathlib import Path

from sar_tui.app.app import SarTui
from sar_tui.framework.clock import MS, SECOND, VirtualClock
from sar_tui.framework.parameters import build
from sar_tui.plugins import Catalogue
from sar_tui.runs import Plan, simulate
from sar_tui.simulation.person import PEOPLE

IMAGES = Path(__file__).parent / "images"


def _save(app: SarTui, name: str) -> None:
    """Keep the screen as an SVG that fetches no font from anywhere."""
    svg = re.sub(r"@font-face\s*\{.*?\}", "", app.export_screenshot(title="sar-tui"), flags=re.DOTALL)
    (IMAGES / f"{name}.svg").write_text(svg.replace("Fira Code", "monospace"))


async def _draw() -> None:
    catalogue = Catalogue()
    keyboard = catalogue.task("keyboard")
    clock = VirtualClock(SECOND)
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder)
        done = simulate(
            Plan(keyboard, build(keyboard.Parameters, {}), "calm", "P01", 1, "simulated"),
            PEOPLE["average"],
            data,
            catalogue,
        )
        app = SarTui(data, catalogue, Plan(keyboard, build(keyboard.Parameters, {}), "calm", "P01", 3), clock)
        async with app.run_test(size=(80, 24)) as pilot:
            await _settle(pilot, clock)
            await pilot.press("enter")
            await _settle(pilot, clock)
            await pilot.press("enter")
            await _settle(pilot, clock)
            for _ in range(60):
                clock.advance(50 * MS)
                await pilot.pause()
                if "Press:" in app.export_screenshot().replace("&#160;", " "):
                    break
            _save(app, "prompt")
        await _draw_agent(data, catalogue)
        await _draw_reaching(data, catalogue)
        past = SarTui(data, catalogue)
        async with past.run_test(size=(80, 24)) as pilot:
            await pilot.pause()
            _save(past, "home")
            from sar_tui.app.screens.past_session import PastSessionScreen
            from sar_tui.store import sessions

            past.push_screen(PastSessionScreen(sessions.find(past.database, data, done)))
            await pilot.pause()
            await pilot.pause()
            _save(past, "summary")


async def _draw_agent(data: Path, catalogue: Catalogue) -> None:
    """The agent, in the middle of its gesture after an attempt that went very well."""
    keyboard = catalogue.task("keyboard")
    parameters = build(keyboard.Parameters, {"prompts_per_attempt": 1})
    clock = VirtualClock(SECOND)
    app = SarTui(data, catalogue, Plan(keyboard, parameters, "calm", "P03", 3), clock)
    async with app.run_test(size=(80, 24)) as pilot:
        for key in ("enter", "enter"):
            await _settle(pilot, clock)
            await pilot.press(key)
        shown = None
        while not (shown := re.search(r"Press: (\S)", app.export_screenshot().replace("&#160;", " "))):
            clock.advance(50 * MS)
            await pilot.pause()
        clock.advance(400 * MS)
        await pilot.press(shown[1])
        for _ in range(10):
            clock.advance(50 * MS)
            await pilot.pause()
        _save(app, "agent")


async def _draw_reaching(data: Path, catalogue: Catalogue) -> None:
    """The sensor check with a test reach, and the screen after a reach."""
    reaching = catalogue.task("reaching")
    parameters = build(reaching.Parameters, {"imu": "simulated:steady"})
    clock = VirtualClock(SECOND)
    app = SarTui(data, catalogue, Plan(reaching, parameters, "calm", "P02", 3), clock)
    async with app.run_test(size=(80, 24)) as pilot:

        async def do(key: str, wait_ms: int) -> None:
            await pilot.press(key)
            for _ in range(wait_ms // 50):
                clock.advance(50 * MS)
                await pilot.pause()

        await _settle(pilot, clock)
        await do("t", 6000)
        _save(app, "sensor-check")
        for key, wait_ms in (("enter", 500), ("enter", 500), ("enter", 500), ("space", 3000), ("space", 2000)):
            await do(key, wait_ms)
        _save(app, "reaching")


async def _settle(pilot: object, clock: VirtualClock) -> None:
    for _ in range(3):
        clock.advance(100 * MS)
        await pilot.pause()  # type: ignore[attr-defined]


if __name__ == "__main__":
    IMAGES.mkdir(exist_ok=True)
    asyncio.run(_draw())
