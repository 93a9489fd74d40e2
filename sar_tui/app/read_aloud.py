"""Reads the participant's screens aloud: each sentence in order, once, until a key interrupts it."""

import asyncio
import contextlib
import re
from collections import deque
from typing import TYPE_CHECKING, Any

from sar_tui.model.language import Language

if TYPE_CHECKING:  # loaded with a session
    from sar_tui.app.app import SarTui
    from sar_tui.loop.clock import Clock
    from sar_tui.loop.session import Session
    from sar_tui.model.messages import Action, AgentActing, AttemptStarted
    from sar_tui.model.theme import Theme
    from sar_tui.outputs.output import Output, Report
    from sar_tui.rules.parameters import TaskParameters
    from sar_tui.runs.plan import Plan

REPEAT_KEY = "f9"
_SHARE = re.compile(r"\b(\d+)\s*/\s*(\d+)\b")
_DECIMAL = re.compile(r"(?<![\w.,])(\d+)[.,](\d{1,4})(?![\d.,]*\d)")
_CODE = re.compile(r"\b(?!F(?:[1-9]|1[0-2])\b)([A-Z]{1,3})(\d+)\b")
"""Letters and figures, such as the code of a participant; not the name of a function key."""
_REMEMBERED = 4
"""Utterances of the agent whose sentences are not read again."""


def is_wanted(parameters: "TaskParameters") -> bool:
    """Return True if the screens of a session are read aloud."""
    return parameters.read_aloud and "speech" in parameters.outputs


def open_voice(where: str) -> "Output":
    """Return a voice of the app's own, which speaks beside that of the agent."""
    from sar_tui.outputs.sound.mixer import Sound
    from sar_tui.outputs.speech import Speech

    return Speech(Sound(where))


class ReadAloud:
    """Speaks what a screen declares as its ``sentences``.

    A screen calls ``read`` when it has changed: in the same place only what is new is said. The
    voice is silent while the agent speaks, does not say again what the agent has just said, and is
    stopped before each trial. Nothing waits for it, and nothing of it is recorded.

    Args:
        app: shows the screens.
        clock: for tests: a clock that is advanced by hand.
    """

    def __init__(self, app: "SarTui", clock: "Clock | None" = None) -> None:
        self._app = app
        self._clock = clock
        self._voice: Output | None = None
        self._where = ""
        self._tr = Language()
        self._place: tuple[Any, object] | None = None
        self._told: tuple[str, ...] = ()
        self._left: deque[str] = deque()
        self._saying = ""
        self._number = 0
        self._agent_acts = False
        self._said_by_agent: deque[str] = deque(maxlen=_REMEMBERED)

    # --- on and off

    @property
    def is_on(self) -> bool:
        """True while screens are read aloud."""
        return self._voice is not None

    def use(self, parameters: "TaskParameters", theme: "Theme", tr: Language) -> None:
        """Read aloud as a session's settings say, with the voice and the language of its theme."""
        if not is_wanted(parameters):
            self.close()
            return
        self._tr = tr
        if self._voice is not None and self._where == parameters.speech:
            self._voice.apply_theme(theme)
            return
        self.close()
        from sar_tui.loop.clock import LiveClock

        voice = open_voice(parameters.speech)
        voice.open(theme, self._clock or LiveClock(asyncio.get_running_loop()), self._receive)
        self._voice, self._where = voice, parameters.speech

    def use_planned(self, plan: "Plan", tr: Language) -> None:
        """Read aloud as the settings of a planned session say, if its theme can be read."""
        from sar_tui.plugins import PluginError

        with contextlib.suppress(PluginError):
            theme = self._app.catalogue.theme(plan.theme, plan.parameters.language)
            self.use(plan.parameters, theme, tr)

    def follow(self, session: "Session") -> None:
        """Follow the agent of a session: it is never interrupted, and has the first word."""
        if not self.is_on:
            return
        from sar_tui.loop import topics

        self._agent_acts = session.is_agent_acting
        session.bus.subscribe(topics.ACTION, self._agent_said)
        session.bus.subscribe(topics.ACTING, self._agent_acted)
        session.bus.subscribe(topics.ATTEMPT_STARTED, self._attempt_started)

    def leave(self) -> None:
        """Forget the agent of a session that is closed."""
        self._agent_acts = False
        self._said_by_agent.clear()

    def close(self) -> None:
        """Be silent, and close the voice."""
        self.stop()
        self.leave()
        self._place, self._told = None, ()
        if self._voice is not None:
            self._voice.close()
            self._voice = None

    # --- what is read

    def read(self, screen: Any, place: object = None) -> None:
        """Speak the sentences of a screen.

        Args:
            screen: has ``sentences``.
            place: tells one appearance of the screen from the next; in the same place only
                sentences that were not there before are spoken.
        """
        is_seen = screen is self._app.screen
        if not (self.is_on and is_seen):
            return
        found, here = tuple(screen.sentences), (screen, place)
        if here != self._place:
            self.stop()
            self._told = ()
        elif self._saying and self._saying not in found:
            self._hush()  # another choice is marked
        waits = [part for part in found if part in self._left or part not in self._told]
        self._place, self._told = here, found
        self._say(waits)

    def read_more(self) -> None:
        """Speak what is new on the screen that was read last, such as another choice."""
        if self._place is not None:
            self.read(*self._place)

    def repeat(self) -> None:
        """Speak all sentences of the screen again."""
        screen: Any = self._app.screen
        found = list(getattr(screen, "sentences", ()))
        if self.is_on and found:
            self.stop()
            self._said_by_agent.clear()
            self._say(found)

    def stop(self) -> None:
        """Be silent: a key was pressed, or a trial begins."""
        self._left.clear()
        self._hush()

    def _hush(self) -> None:
        if self._saying and self._voice is not None:
            self._voice.stop()
        self._saying = ""

    def _say(self, found: list[str]) -> None:
        self._left = deque(found)
        if found:
            self._app.call_after_refresh(self._go_on)

    def _go_on(self) -> None:
        """Speak the next sentence, unless one is under way or the agent acts."""
        if self._voice is None or self._saying or self._agent_acts:
            return
        while self._left:
            sentence = self._left.popleft()
            if any(same_words(sentence, said) for said in self._said_by_agent):
                continue
            self._number += 1
            self._saying = sentence
            self._voice.say(self._action, in_words(sentence, self._tr))
            return

    @property
    def _action(self) -> str:
        return f"read-{self._number}"

    def _receive(self, report: "Report") -> None:
        """Follow the voice. Called from any thread."""
        if report.state != "started":
            self._app.call_later(self._over, report.action)

    def _over(self, action: str) -> None:
        if self._saying and action == self._action:
            self._saying = ""
            self._go_on()

    # --- the agent

    def _agent_said(self, action: "Action") -> None:
        if action.spoken or action.text:
            self._said_by_agent.append(f"{action.text}\n{action.spoken}")

    def _attempt_started(self, _: "AttemptStarted") -> None:
        self._said_by_agent.clear()

    def _agent_acted(self, acting: "AgentActing") -> None:
        """Stop while the agent acts; then begin the interrupted sentence again."""
        self._agent_acts = acting.acting
        if not acting.acting:
            self._go_on()
        elif self._saying:
            left = [self._saying, *self._left]
            self.stop()
            self._left.extend(left)


# --- words


def in_words(sentence: str, tr: Language) -> str:
    """Return a sentence as a voice is to read it.

    Decimals, shares and codes become words: "zero point four three" for 0.43, "2 of 10" for 2/10,
    "P zero one" for P01. Whole numbers stay: each voice reads them in its own language.
    """
    text = _SHARE.sub(
        lambda found: tr("{part} of {whole}", part=found[1], whole=found[2]), sentence
    )
    text = _CODE.sub(lambda found: f"{' '.join(found[1])} {_digits(found[2], tr)}", text)
    text = _DECIMAL.sub(
        lambda found: f"{_whole(found[1], tr)} {tr('point')} {_digits(found[2], tr)}", text
    )
    return " ".join(text.replace(" · ", ", ").split())


def _whole(figures: str, tr: Language) -> str:
    return _digits(figures, tr) if len(figures) == 1 else figures


def _digits(figures: str, tr: Language) -> str:
    words = (
        tr("zero"),
        tr("one"),
        tr("two"),
        tr("three"),
        tr("four"),
        tr("five"),
        tr("six"),
        tr("seven"),
        tr("eight"),
        tr("nine"),
    )
    return " ".join(words[int(figure)] for figure in figures)


def same_words(one: str, other: str) -> bool:
    """Return True if one text has the words of another in it, whatever stands between them."""
    return _words(one) in _words(other)


def _words(text: str) -> str:
    words = re.findall(r"[^\W_]+", text.casefold())
    return f" {' '.join(words)} "
