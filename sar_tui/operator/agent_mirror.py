"""The agent as the participant sees it: the session's widget, driven by the session state."""

from textual.geometry import Size
from textual.widget import Widget

from sar_tui.framework.agent_state import AgentState
from sar_tui.framework.clock import SECOND, Clock
from sar_tui.framework.theme import Theme
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
        clock: of its motion.
    """

    def __init__(self, theme: Theme, clock: Clock) -> None:
        self.widget = Agent(theme, clock, id="agent")
        self.widget.display = False
        self._theme: Theme | None = None
        self._seen = AgentState()
        self._said: tuple[str, str] = ("", "")

    def show(self, state: SessionState, now: int) -> None:
        """Bring the agent up to date. ``now``: session clock (ns)."""
        if state.theme is None:
            return
        if state.theme is not self._theme:
            self._theme = state.theme
            self.widget.wear(state.theme)
            self.widget.display = True
        seen, before = state.agent, self._seen
        self._seen = seen
        self._say(seen, before)
        if seen.halts != before.halts:
            self.widget.be_still()
        self._hold(state, before)
        action = seen.moves
        if action and action is not before.moves and now - action.decided < _FRESH:
            if action.gesture in state.theme.gestures:
                self.widget.gesture(state.theme.gestures[action.gesture])
            if action.gaze:
                self.widget.gaze(action.gaze)
        self.widget.speaking(seen.is_speaking and state.is_connected)

    def _hold(self, state: SessionState, before: AgentState) -> None:
        """Keep still while the participant's agent does, and show its cue."""
        cue = state.agent.cue
        if not state.is_quiet or (before.cue and before.cue is not cue):
            self.widget.release()
        if state.is_quiet:
            self.widget.hold()
        if cue and cue is not before.cue:
            self.widget.cue(cue.gaze, state.theme.gestures.get(cue.gesture) if state.theme else None)

    def _say(self, seen: AgentState, before: AgentState) -> None:
        said = self._fitted(seen)
        if said == self._said and seen.valence == before.valence:
            if seen.face != before.face:
                self.widget.look(seen.face)
            return
        self._said = said
        words, more = said
        if not words:
            self.widget.clear(seen.face)
            return
        self.widget.say(words, seen.face, seen.valence)
        if more:
            self.widget.say(more, joins=True)

    def _fitted(self, seen: AgentState) -> tuple[str, str]:
        """Return the text that fits here, where there is less room: of joined texts, the end is shown."""
        around = self.widget.parent
        room = around.content_size if isinstance(around, Widget) else Size(0, 0)
        width = room.width - WIDTH - _MARGINS
        if width <= 0 or not seen.words:  # nothing has been laid out yet
            return seen.words, seen.more
        more, most = wrap(seen.more, width, len(seen.more)), max(2, room.height - 2)
        if len(more) > most:
            more = ["…", *more[1 - most :]]
        words = wrap(seen.words, width, room.height - (len(more) + 1 if more else 0))
        return "\n".join(words), "\n".join(more)
