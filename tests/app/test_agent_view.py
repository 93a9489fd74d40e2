"""The agent on a separate screen follows the messages of its session's link."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import msgspec
import pytest
from textual.widgets import Static

from sar_tui.app.agent.app import AgentApp
from sar_tui.link.peer import Connection, Frame, PeerListener
from sar_tui.loop.bus import Topic
from sar_tui.loop.clock import host_now
from sar_tui.loop.topics import ACTING, ACTION, CUE, HALT, REPORT, THEME, WAITING
from sar_tui.model.messages import (
    Action,
    AgentActing,
    CueGiven,
    Halt,
    Message,
    OutputReport,
    ThemeApplied,
    Waiting,
)
from sar_tui.model.theme import Theme
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.widgets.agent import Agent
from tests.link.test_node import WELCOME

BETWEEN = Waiting(what="enter", stage="attempt", attempt=1)
FOREPERIOD = Waiting(what="foreperiod", stage="trial", attempt=1, trial=1)
IN_A_TRIAL = Waiting(what="response", stage="trial", attempt=1, trial=1)


class Link:
    """Fake link to a session, and a fake voice of the browser."""

    name, role = "observer.agent-view", "observer"

    def __init__(self) -> None:
        self.spoken: list[tuple[str, ...]] = []
        self.closed = False
        self._seq = 0
        self._listener: PeerListener

    def join(self, listener: PeerListener, _: asyncio.AbstractEventLoop) -> "Link":
        self._listener = listener
        return self

    def welcome(self, **parameters: Any) -> None:
        self._listener(Connection("connected"))
        self._listener(
            msgspec.structs.replace(
                WELCOME, title="Keyboard reaction", name=self.name, parameters=parameters
            )
        )

    def deliver(
        self, topic: Topic[Any], message: Message, *, ago_s: float = 0, seq: int | None = None
    ) -> None:
        self._seq += 1
        self._listener(
            [Frame(seq or self._seq, self.now() - round(ago_s * SECOND), topic, message)]
        )

    def refuse(self, why: str) -> None:
        self._listener(Connection("connecting", why))

    def lose(self) -> None:
        self._listener(Connection("lost"))

    def end(self) -> None:
        self._listener(Connection("ended"))

    def now(self) -> int:
        return host_now()

    def send(self, topic: Topic[Any], message: Message) -> None:
        raise AssertionError("a view acts on nothing")

    def take_control(self) -> None:
        raise AssertionError("a view acts on nothing")

    def close(self, *, says_goodbye: bool = True) -> None:
        self.closed = True

    def say(self, text: str, language: str) -> None:
        self.spoken.append(("say", text, language))

    def hush(self) -> None:
        self.spoken.append(("hush",))


class Watcher:
    """Reads the view and lets time pass."""

    def __init__(self, app: AgentApp, link: Link, pilot: Any) -> None:
        self.app, self.link, self._pilot = app, link, pilot

    @property
    def moves(self) -> bool:
        return self.app.screen.query_one(Agent).is_moving

    async def see(self) -> str:
        await self._pilot.pause()
        return "\n".join(
            str(each.render()) for each in self.app.screen.query(Static) if each.display
        )


@asynccontextmanager
async def watching(theme: Theme, *, speaks: bool = False) -> AsyncIterator[Watcher]:
    link = Link()
    app = AgentApp(theme, link.join)
    if speaks:
        app.voice = link
    async with app.run_test(size=(60, 20)) as pilot:
        await pilot.pause()
        yield Watcher(app, link, pilot)
    assert link.closed


@pytest.fixture
async def watcher(calm: Theme) -> AsyncIterator[Watcher]:
    async with watching(calm) as watcher:
        yield watcher


@pytest.fixture
async def voiced(calm: Theme) -> AsyncIterator[Watcher]:
    """A view in a browser that has a voice."""
    async with watching(calm, speaks=True) as watcher:
        yield watcher


def said(text: str, **more: Any) -> Action:
    given: dict[str, Any] = {"id": "a1", "kind": "feedback", "face": "happy", "spoken": text}
    return Action(**(given | more), text=text, decision="accepted", actor="agent")


async def test_the_agent_sleeps_until_a_session_says_something(watcher: Watcher) -> None:
    assert "One moment…" in await watcher.see()
    watcher.link.welcome()
    assert "One moment…" not in await watcher.see()
    watcher.link.deliver(WAITING, BETWEEN)
    watcher.link.deliver(ACTION, said("Well done!"))
    seen = await watcher.see()
    assert "Well done!" in seen
    assert "◠   ◠" in seen


async def test_while_a_response_is_awaited_nothing_moves(watcher: Watcher) -> None:
    watcher.link.welcome()
    watcher.link.deliver(ACTION, said("Well done!", gesture="wave"))
    watcher.link.deliver(WAITING, IN_A_TRIAL)
    watcher.link.deliver(
        REPORT, OutputReport(action="a1", output="speech", part="say", state="started", at=0)
    )
    assert "Well done!" not in await watcher.see()
    assert not watcher.moves


async def test_a_view_that_joins_during_a_trial_shows_no_earlier_text(watcher: Watcher) -> None:
    """Retained topics and the last messages arrive in any order; their sequence numbers say which
    came first.
    """
    watcher.link.welcome()
    watcher.link.deliver(WAITING, IN_A_TRIAL, seq=20)
    watcher.link.deliver(ACTION, said("Well done!"), seq=12, ago_s=1)
    assert "Well done!" not in await watcher.see()


async def test_an_old_utterance_is_shown_but_not_spoken_again(voiced: Watcher) -> None:
    voiced.link.welcome(outputs=["screen"])
    voiced.link.spoken.clear()
    voiced.link.deliver(ACTION, said("Welcome back."), ago_s=10)
    assert "Welcome back." in await voiced.see()
    assert voiced.link.spoken == []


async def test_the_browsers_voice_speaks_the_sessions_language_and_moves_the_mouth(
    voiced: Watcher,
) -> None:
    voiced.link.welcome(outputs=["screen"], language="es")
    voiced.link.spoken.clear()
    voiced.link.deliver(ACTION, said("0,5 s", spoken="cero coma cinco segundos", face="speaking"))
    assert voiced.moves
    voiced.link.deliver(HALT, Halt(reason="stopped", asked=0))
    assert not voiced.moves
    assert voiced.link.spoken == [("say", "cero coma cinco segundos", "es"), ("hush",)]


@pytest.mark.parametrize(
    ("how", "report"),
    [
        ("lose", "Se ha perdido la conexión; vuelve sola."),
        ("end", "La sesión ha terminado. Gracias."),
    ],
)
async def test_it_sleeps_when_the_link_is_lost(voiced: Watcher, how: str, report: str) -> None:
    voiced.link.welcome(language="es")
    voiced.link.deliver(ACTION, said("Well done!"))
    voiced.link.spoken.clear()
    getattr(voiced.link, how)()
    seen = await voiced.see()
    assert report in seen
    assert "Well done!" not in seen
    assert voiced.link.spoken == [("hush",)]


async def test_a_filler_disappears_after_its_wait_and_feedback_stays(watcher: Watcher) -> None:
    watcher.link.welcome()
    watcher.link.deliver(ACTION, said("Just a moment, please.", kind="filler"))
    assert "Just a moment, please." in await watcher.see()
    watcher.link.deliver(WAITING, BETWEEN)
    assert "Just a moment, please." not in await watcher.see()
    watcher.link.deliver(ACTION, said("Well done!"))
    watcher.link.deliver(WAITING, BETWEEN)
    assert "Well done!" in await watcher.see()


async def test_it_looks_to_a_side_until_the_response(watcher: Watcher) -> None:
    watcher.link.welcome()
    watcher.link.deliver(WAITING, FOREPERIOD)
    ahead = await watcher.see()
    watcher.link.deliver(
        CUE, CueGiven(attempt=1, trial=1, presentation=1, side="left", gaze="left")
    )
    watcher.link.deliver(WAITING, IN_A_TRIAL)
    assert await watcher.see() != ahead
    watcher.link.deliver(WAITING, FOREPERIOD)
    watcher.link.deliver(WAITING, Waiting(what="quiet", stage="trial", attempt=1, trial=2))
    assert await watcher.see() == ahead


async def test_it_applies_the_sessions_theme(watcher: Watcher, catalogue: Catalogue) -> None:
    watcher.link.welcome()
    watcher.link.deliver(THEME, ThemeApplied(theme=catalogue.theme("playful")))
    await watcher.see()
    assert watcher.app.theme == "sar-playful"


async def test_a_voice_moves_the_mouth_until_an_end_that_may_be_reported_late(
    watcher: Watcher,
) -> None:
    watcher.link.welcome(outputs=["screen", "speech"])
    watcher.link.deliver(ACTION, said("Well done!", face="speaking"))
    voice: dict[str, Any] = {"action": "a1", "output": "speech", "part": "say", "at": 0}
    watcher.link.deliver(REPORT, OutputReport(**voice, state="started"))
    assert watcher.moves
    watcher.link.deliver(REPORT, OutputReport(**voice, state="done"), ago_s=10)
    assert not watcher.moves
    watcher.link.deliver(REPORT, OutputReport(**voice, state="started"))
    watcher.link.deliver(ACTING, AgentActing(acting=False))
    assert not watcher.moves
