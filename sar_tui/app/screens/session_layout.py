"""The parts of a session's screen: its top line, the widgets in the middle, the agent, and the
progress below.
"""

import functools

from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.widgets import ContentSwitcher, Static

from sar_tui.app.agent.screen_base import AgentScreen
from sar_tui.app.live import LiveSession
from sar_tui.app.screens.large_message import is_roomy
from sar_tui.app.screens.mark_keys import MarkKeys
from sar_tui.app.screens.message_panel import MessagePanel
from sar_tui.app.screens.pause import PauseMenu
from sar_tui.app.screens.summary import Summary
from sar_tui.model.messages import Waiting
from sar_tui.plugins import task_folder
from sar_tui.widgets.big_prompt import BigPrompt
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.progress_line import ProgressLine
from sar_tui.widgets.prompt_pictures import Pictures


class LayoutScreen(AgentScreen):
    """The part of a session's screen that holds its widgets, and shows one of them in the
    middle.
    """

    def __init__(self, live: LiveSession) -> None:
        super().__init__(live)
        self._waiting: Waiting | None = None
        self._shown: str | None = "message"
        self._position = ""
        self._agent_seat = ""

    @functools.cached_property
    def _marks(self) -> MarkKeys:
        """Keys of the therapist's marks."""
        session = self._live.run.session
        return MarkKeys(session.task.marks, self.tr, lambda: session.trial_mark)

    @functools.cached_property
    def _pictures(self) -> Pictures | None:
        """The pictures of the task; None if it draws its prompts itself, or if none can be shown
        here.
        """
        if self.app.picture_way is None or self._live.view.draws_prompts:
            return None
        folder = task_folder(type(self._live.run.session.task))
        return Pictures(folder, self.app.picture_way, self.app.write_to_terminal)

    def on_unmount(self) -> None:
        if self._pictures:
            self._pictures.close()

    def compose(self) -> ComposeResult:
        session = self._live.run.session
        with Horizontal(id="top"):
            codes = ", ".join(self._live.run.participants.values())
            yield Static(f"{self.tr(session.task.title)} · {codes}", id="task", markup=False)
            yield from self.compose_voice()
            yield Static("", id="where", markup=False)
        yield Static("", id="above")
        with ContentSwitcher(initial="message", id="stage"):
            yield MessagePanel(id="message")
            yield BigPrompt(id="prompt", draw=self._live.view.prompt_lines, pictures=self._pictures)
            yield PauseMenu(id="menu")
            yield Summary(
                session.task.metric, self._live.view.facts, for_participant=True, id="summary"
            )
        yield from self.compose_agent()
        with Horizontal(id="progress"):
            yield ProgressLine(id="trials")
            yield ProgressLine(id="attempts")
        yield KeyFooter()

    def on_resize(self) -> None:
        """Give the pause menu more room in a large window."""
        self.set_class(is_roomy(*self.app.size), "roomy")

    def _seat_agent(self, where: str) -> None:
        """Let the agent speak from the middle, ``between`` two attempts or ``drawn`` above a
        drawing; else from below.

        In a ``pause`` it is silent above the menu.
        """
        if where != self._agent_seat:
            self._agent_seat, stage = where, self.query_one("#stage")
            between = where in ("between", "pause")
            self.update_classes(
                {"middle": bool(where), "between": between, "pausing": where == "pause"}
            )
            if where:
                self.move_child(self.agent, before=stage)
            else:
                self.move_child(self.agent, after=stage)

    def _stage(self, name: str | None) -> None:
        """Show one widget in the middle of the screen, or none."""
        self._shown = name
        if name != "message":
            self._seat_agent("pause" if name == "menu" and self.agent.display else "")
        self.query_one("#stage", ContentSwitcher).current = name
        menu = self.query_one(PauseMenu)
        self.set_focus(menu if name == "menu" else None)
        summary = name == "summary"
        self.query_one("#progress").display = not summary
        self.refresh_bindings()

    def _show_position(self, waiting: Waiting) -> None:
        """Show attempt and level in the corner, and the progress at the bottom."""
        # after the last attempt: there is no next level to show
        is_over = waiting.trial > waiting.trials
        self._show_attempts(waiting.attempt - (not is_over))
        if not is_over:
            self._position = (
                f"{waiting.attempt_name.capitalize()} · "
                f"{self.tr('level {level}', level=waiting.level)}"
            )
        parts = (self._marks.text, "" if self._marks.asks else self._position)
        self.query_one("#where", Static).update(" · ".join(filter(None, parts)))

    def _show_attempts(self, done: int) -> None:
        """Show the number of attempts done; practice attempts are counted separately."""
        parameters = self._live.run.session.task.parameters
        done -= self._waiting.restarts if self._waiting else 0
        kind, total = "Practice", parameters.practice_attempts
        if done >= total:
            kind, total, done = "Attempts", parameters.attempts, done - total
        self.query_one("#attempts", ProgressLine).show(self.tr(kind), done, total)

    def _show_trials(self, done: int) -> None:
        total = self._waiting.trials if self._waiting else 0
        self.query_one("#trials", ProgressLine).show(
            self.tr(self._live.run.session.task.trials), done, total
        )
