"""The end of the app: the question before it, what is still written, and the lines that it leaves
in the terminal.
"""

import asyncio
import contextlib
import functools
import os
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from sar_tui.app.ending import EndingApp
from sar_tui.app.exit_message import exit_message

if TYPE_CHECKING:
    from sar_tui.app.live import LiveSession
    from sar_tui.app.screens.leave import Leaving

_UNNOTICED_SECONDS = 0.3
"""Longest wait for the disk at the end before the screen says so."""


class LeavingApp(EndingApp):
    """The part of the app that ends it, once the session is written."""

    _is_leaving = False

    async def action_quit(self) -> None:
        """Ctrl-Q: exit; during a session, ask first, because a participant may have pressed it by
        mistake.

        In patient mode a session is paused, and nothing else happens.
        """
        if self.patient:
            self.pause_session()
            return
        from sar_tui.app.screens.leave import LeaveScreen

        session = self._open.run.session if self._open else None
        if session is None or session.ended or session.broken:
            await super().action_quit()
        elif not any(isinstance(screen, LeaveScreen) for screen in self.screen_stack):
            in_trial = getattr(self.screen, "is_in_trial", False)
            answered = functools.partial(self._left_or_went_on, was_in_trial=in_trial)
            can_save = all(getattr(screen, "can_save", True) for screen in self.screen_stack)
            may_be_mistake = self._open is not None and self._open.in_first_attempt
            question = LeaveScreen(can_save=can_save, may_be_mistake=may_be_mistake)
            # mounted: the next key of a burst is its own
            await self.push_screen(question, answered)

    def action_interrupt(self) -> None:
        """Ctrl-C: exit; in patient mode as Ctrl-Q."""
        if self.patient:
            self.pause_session()
        else:
            super().action_interrupt()

    def _left_or_went_on(self, how: "Leaving | None", *, was_in_trial: bool) -> None:
        """Exit; or go on with the trial that the question has paused."""
        from sar_tui.loop.session_phase import LEFT
        from sar_tui.model.messages import SessionCommand

        if how in ("leave", "mistake"):
            if self._open:
                self._open.is_mistake = how == "mistake"
            if was_in_trial and self._open:
                self._open.operate(SessionCommand(command="pause", reason=LEFT))
            self.exit()
        elif was_in_trial and self._open:
            self._open.operate(SessionCommand(command="resume"))

    def exit(self, *args: Any, **how: Any) -> None:
        """Exit, once the session is written. Until then the screen stays, so that nobody sees an
        empty terminal.
        """
        if self._is_leaving:
            return
        if self._open:
            self._open.stop(self)
            if not self._open.is_written(_UNNOTICED_SECONDS):
                self._is_leaving = True
                self.run_worker(
                    self._exit_once_written(self._open, args, how), name="exit", group="exit"
                )
                return
        super().exit(*args, **how)

    async def _exit_once_written(
        self, live: "LiveSession", args: Sequence[Any], how: dict[str, Any]
    ) -> None:
        from sar_tui.app.live import LAST_WRITE_SECONDS
        from sar_tui.app.screens.saving import SavingScreen

        self.push_screen(SavingScreen())
        await asyncio.to_thread(live.is_written, LAST_WRITE_SECONDS)
        super().exit(*args, **how)

    def exit_lines(self, code: int) -> list[str]:
        """Return the lines to leave in the terminal."""
        tasks = self.catalogue.extra_tasks
        one = self.is_for_one_session
        lines = exit_message(
            code, self.failure, self.live, self.folder, tasks, names_ended_session=one
        )
        troubles = self._troubles if self.patient else ()  # nobody was there to be told
        trouble = self.live.trouble if self.live and not self.patient else ""
        return [*lines, *troubles, *filter(None, (self.pending_notice, trouble))]

    def abandon(self, plugin: str) -> None:
        """End the program at once. For another thread, while this app's own hangs in the code of a
        plug-in.
        """
        if self._open:
            self._open.write_rest()
        with contextlib.suppress(Exception):  # the terminal may be gone
            if self._driver:
                self._driver.stop_application_mode()
                self._driver.close()
        self.failure = (
            f"The {plugin} does not return from its own code. All earlier trials are kept."
        )
        for line in self.exit_lines(1):
            with contextlib.suppress(OSError):
                print(line, file=sys.__stderr__, flush=True)
        os._exit(1)
