"""The agent as the participant sees it: the session's widget, driven by the session state."""

from textual.geometry import Size
from textual.widget import Widget

from sar_tui.loop.agent_state import AgentState
from sar_tui.loop.clock import Clock
from sar_tui.model.theme import Theme
from sar_tui.model.units import SECOND
from sar_tui.operator.session_state import SessionState
from sar_tui.operator.text_charts import wrap
from sar_tui.widgets.agent import Agent
from sar_tui.widgets.robot import WIDTH

_MARGINS = 3
"""Columns beside the drawing and beside the text."""
_FRESH = 2 * SECOND
"""A gesture requested longer ago is over, or was never shown here."""


class AgentMirror:
    """Keeps the agent on the screen in step with the session state.

    Args:
        theme: until the session's is known; the agent is hidden until then.
        clock: drives its motion.
    """

    def __init__(self, theme: Theme, clock: Clock) -> None:
        self.widget = Agent(theme, clock, id="agent")
        self.widget.display = False
        self._theme: Theme | None = None
        self._shown = AgentState()
        self._shown_text: tuple[str, str] = ("", "")

    def show(self, state: SessionState, now: int) -> None:
        """Bring the agent up to date. ``now``: session clock (ns)."""
        if state.theme is None:
            return
        if state.theme is not self._theme:
            self._theme = state.theme
            self.widget.apply_theme(state.theme)
            self.widget.display = True
        agent, before = state.agent, self._shown
        self._shown = agent
        self._show_text(agent, before)
        if agent.halts != before.halts:
            self.widget.be_still()
        self._hold_still(state, before)
        action = agent.moves
        if action and action is not before.moves and now - action.decided < _FRESH:
            if action.gesture in state.theme.gestures:
                self.widget.gesture(state.theme.gestures[action.gesture])
            if action.gaze:
                self.widget.gaze(action.gaze)
        self.widget.speaking(agent.is_speaking and state.is_connected)

    def _hold_still(self, state: SessionState, before: AgentState) -> None:
        """Keep still while the participant's agent does, and show its cue."""
        cue = state.agent.cue
        if not state.is_quiet or (before.cue and before.cue is not cue):
            self.widget.release()
        if state.is_quiet:
            self.widget.hold()
        if cue and cue is not before.cue:
            self.widget.cue(
                cue.gaze, state.theme.gestures.get(cue.gesture) if state.theme else None
            )

    def _show_text(self, agent: AgentState, before: AgentState) -> None:
        text = self._fit_text(agent)
        if text == self._shown_text and agent.valence == before.valence:
            if agent.face != before.face:
                self.widget.look(agent.face)
            return
        self._shown_text = text
        words, more = text
        if not words:
            self.widget.clear(agent.face)
            return
        self.widget.say(words, agent.face, agent.valence)
        if more:
            self.widget.say(more, joins=True)

    def _fit_text(self, agent: AgentState) -> tuple[str, str]:
        """Return the text that fits here, where there is less size: of joined texts, the end is
        shown.
        """
        parent = self.widget.parent
        size = parent.content_size if isinstance(parent, Widget) else Size(0, 0)
        width = size.width - WIDTH - _MARGINS
        if width <= 0 or not agent.words:  # nothing has been laid out yet
            return agent.words, agent.more
        more, most = wrap(agent.more, width, len(agent.more)), max(2, size.height - 2)
        if len(more) > most:
            more = ["…", *more[1 - most :]]
        words = wrap(agent.words, width, size.height - (len(more) + 1 if more else 0))
        return "\n".join(words), "\n".join(more)
