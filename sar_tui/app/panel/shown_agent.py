"""The agent as the participant sees it: the session's own widget, following the mirror."""

from sar_tui.app.panel.mirror import Agent as Seen
from sar_tui.app.panel.mirror import Mirror
from sar_tui.framework.clock import SECOND, Clock
from sar_tui.framework.theme import Theme
from sar_tui.widgets.agent import Agent

_FRESH = 2 * SECOND
"""A gesture that was asked for longer ago is over, or was never seen here."""


class ShownAgent:
    """Keeps an agent on the screen as the mirror tells it.

    Args:
        theme: is worn until the session's is known; the agent is not there before.
        clock: of its motion.
    """

    def __init__(self, theme: Theme, clock: Clock) -> None:
        self.widget = Agent(theme, clock, id="agent")
        self.widget.display = False
        self._theme: Theme | None = None
        self._seen = Seen()

    def show(self, mirror: Mirror, now: int) -> None:
        """Bring the agent up to what is known. ``now``: on the session's clock (ns)."""
        if mirror.theme is None:
            return
        if mirror.theme is not self._theme:
            self._theme = mirror.theme
            self.widget.wear(mirror.theme)
            self.widget.display = True
        seen, before = mirror.agent, self._seen
        self._seen = seen
        self._say(seen, before)
        if seen.still != before.still:
            self.widget.be_still()
        self._hold(mirror, before)
        action = seen.moves
        if action and action is not before.moves and now - action.decided < _FRESH:
            if action.gesture in mirror.theme.gestures:
                self.widget.gesture(mirror.theme.gestures[action.gesture])
            if action.gaze:
                self.widget.gaze(action.gaze)
        current = mirror.standing.current if mirror.standing else None
        self.widget.speaking(bool(mirror.acting and current and current.spoken and mirror.is_connected))

    def _hold(self, mirror: Mirror, before: Seen) -> None:
        """Stand still where the participant's does; and look to a side as it does, meanwhile."""
        cue = mirror.agent.cue
        if not mirror.is_quiet or (before.cue and before.cue is not cue):
            self.widget.release()
        if mirror.is_quiet:
            self.widget.hold()
        if cue and cue is not before.cue:
            self.widget.cue(cue.gaze, mirror.theme.gestures.get(cue.gesture) if mirror.theme else None)

    def _say(self, seen: Seen, before: Seen) -> None:
        if (seen.words, seen.more, seen.valence) == (before.words, before.more, before.valence):
            if seen.face != before.face:
                self.widget.look(seen.face)
        elif not seen.words:
            self.widget.clear(seen.face)
        else:
            self.widget.say(seen.words, seen.face, seen.valence)
            if seen.more:
                self.widget.say(seen.more, joins=True)
                self.widget.call_after_refresh(self._show_newest)

    def _show_newest(self) -> None:
        """There is less room than the participant has: of words that joined others, the last are seen."""
        self.widget.query_one(".words").scroll_end(animate=False, force=True)
