"""The end of the app: the question before it, what is still written, and the lines that it leaves
in the terminal.
"""

import asyncio
import contextlib
import functools
import os
import sys
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, ClassVar, Literal, cast

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.screen import ModalScreen
from textual.widgets import Static
from textual.widgets.option_list import Option

from sar_tui.app.command_line import command_line
from sar_tui.model.language import Language
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.exit_codes import INTERRUPTED
from sar_tui.widgets.language import language_of
from sar_tui.widgets.lists import OptionList, menu_sentences

if TYPE_CHECKING:
    from sar_tui.app.app import SarTui
    from sar_tui.app.live import LiveSession

UNSAVED = (
    "The session's last messages could not be written to the disk; all earlier trials are safe."
)
_UNNOTICED_SECONDS = 0.3
"""Longest wait for the disk at the end before the screen says so."""

Answer = Literal["go on", "leave", "mistake"]
"""To go on; to leave the session for now; to leave it, as it was started by mistake."""


class Leaving:
    """Ends the app, once its session is written.

    Args:
        app: is ended.
    """

    def __init__(self, app: "SarTui") -> None:
        self._app = app
        self._is_under_way = False

    # --- the question

    async def ask(self) -> bool:
        """Ask before a session is left, because a participant may have pressed the key by mistake.

        Returns False if there is nothing to ask: no session is under way.
        """
        app, live = self._app, self._app.open_session
        session = live.session if live else None
        if live is None or session is None or session.ended or session.broken:
            return False
        if not any(isinstance(screen, LeaveScreen) for screen in app.screen_stack):
            in_trial = getattr(app.screen, "is_in_trial", False)
            can_save = all(getattr(screen, "can_save", True) for screen in app.screen_stack)
            question = LeaveScreen(can_save=can_save, may_be_mistake=live.in_first_attempt)
            answered = functools.partial(self._answered, was_in_trial=in_trial)
            # mounted: the next key of a burst is its own
            await app.push_screen(question, answered)
        return True

    def _answered(self, answer: Answer | None, *, was_in_trial: bool) -> None:
        """Exit; or go on with the trial that the question has paused."""
        from sar_tui.loop.session_phase import LEFT
        from sar_tui.model.messages import SessionCommand

        live = self._app.open_session
        if answer in ("leave", "mistake"):
            if live:
                live.is_mistake = answer == "mistake"
            if was_in_trial and live:
                live.operate(SessionCommand(command="pause", reason=LEFT))
            self._app.exit()
        elif was_in_trial and live:
            live.operate(SessionCommand(command="resume"))

    # --- the last messages

    def leave(self, exit_app: Callable[[], None]) -> None:
        """Exit, once the session is written. Until then the screen stays, so that nobody sees an
        empty terminal.
        """
        if self._is_under_way:
            return
        live = self._app.open_session
        if live:
            live.stop(self._app)
            if not live.is_written(_UNNOTICED_SECONDS):
                self._is_under_way = True
                self._app.run_worker(
                    self._leave_once_written(live, exit_app), name="exit", group="exit"
                )
                return
        exit_app()

    async def _leave_once_written(self, live: "LiveSession", exit_app: Callable[[], None]) -> None:
        from sar_tui.app.live import LAST_WRITE_SECONDS

        self._app.push_screen(SavingScreen())
        await asyncio.to_thread(live.is_written, LAST_WRITE_SECONDS)
        exit_app()

    def abandon(self, plugin: str) -> None:
        """End the program at once. For another thread, while the app's own hangs in the code of a
        plug-in.
        """
        app = self._app
        if app.open_session:
            app.open_session.write_rest()
        with contextlib.suppress(Exception):  # the terminal may be gone
            if app._driver:
                app._driver.stop_application_mode()
                app._driver.close()
        app.failure = app.tr(
            "The {plugin} does not return from its own code. All earlier trials are kept.",
            plugin=plugin,
        )
        for line in self.lines(1):
            with contextlib.suppress(OSError):
                print(line, file=sys.__stderr__, flush=True)
        os._exit(1)

    # --- the lines in the terminal

    def lines(self, code: int) -> list[str]:
        """Return the lines to leave in the terminal: what became of the session, and the command to
        get back to it.
        """
        app = self._app
        untold = app.patient_mode.troubles if app.patient else ()  # nobody was there to be told
        unsaved = (
            app.tr("Not saved: changes to the settings of {who} for {task}.", who=who, task=task)
            for who, task in app.settings_drafts
        )
        said = (*self._exit_message(code), *unsaved, *untold, app.themes.pending_notice)
        return [text for text in dict.fromkeys(said) if text]

    def _exit_message(self, code: int) -> Iterator[str]:
        live, tr = self._app.live, self._app.tr
        if self._app.failure:
            yield self._app.failure
        if code == INTERRUPTED:
            yield tr("Stopped with Ctrl-C.")
        if not self._app.is_kept:
            yield tr("The demonstration is over. Nothing of it was kept.")
            return
        if live:
            yield from lines_about(
                live, self._command, tr, is_for_one_session=self._app.is_for_one_session
            )

    def _command(self, name: str, *session: str) -> str:
        return command_line(self._app.folder, self._app.catalogue.extra_tasks, name, *session)


def lines_about(
    live: "LiveSession", command: Callable[..., str], tr: Language, *, is_for_one_session: bool
) -> Iterator[str]:
    """Return what became of a session that is closed, and the commands to get back to it.

    Args:
        live: the session.
        command: returns a command with the folders in use, as `command_line`.
        tr: the language.
        is_for_one_session: True if the program was started for this session alone.
    """
    id = live.run.id
    if live.rescued:
        back = tr("Bring it back into the database: {command}", command=command("rescue"))
        yield f"{live.rescued} {back}"
    if live.trouble:
        yield live.trouble
    if live.is_mistake and not live.trouble:
        yield tr(
            "The session does not count, as it was started by mistake. It is kept: in sar-tui, "
            "F6 and Del restore it."
        )
    elif not live.session.ended and not live.session.broken:
        if live.study:
            yield tr("The session is kept. It goes on with:")
            yield f"  {command('study next', live.codes['A'], '--study', live.study)}"
        else:
            yield tr("The session is kept. Resume it: {command}", command=command("resume", id))
    elif is_for_one_session:
        yield tr("The session is kept. Look at it: {command}", command=command("show", id))
        if live.can_be_joined:
            yield tr("What operators did: {command}", command=command("report wizard", id))
    if live.unsaved:
        yield tr(UNSAVED)


class LeaveScreen(DismissedOnce[Answer], ModalScreen[Answer]):
    """Asks whether to leave the session; the result says how. To go on is chosen at first.

    Args:
        can_save: False if the disk cannot be written to.
        may_be_mistake: True in the first attempt, when the session may have been started by
            mistake.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss('go on')", "Go on", id="go-on")
    ]

    def __init__(self, *, can_save: bool = True, may_be_mistake: bool = False) -> None:
        super().__init__()
        self._can_save = can_save
        self._may_be_mistake = may_be_mistake

    def compose(self) -> ComposeResult:
        tr = language_of(self.app)
        kept = tr("What you did is kept. You can go on with this session later.")
        if not self._can_save:
            kept = tr("Your last answer may not be saved yet. If you leave now, it may be lost.")
        menu = OptionList(
            Option(f"{kept}\n", disabled=True),
            Option(tr("Go on"), id="go on"),
            Option(tr("Yes, leave"), id="leave"),
            *(
                [Option(tr("It was started by mistake"), id="mistake")]
                if self._may_be_mistake and self._can_save
                else []
            ),
            id="leave",
            markup=False,
        )
        menu.border_title = tr("Leave now?")
        menu.border_subtitle = tr("arrows to choose, Enter to confirm")
        menu.highlighted = 1
        yield menu

    @property
    def sentences(self) -> list[str]:
        """The question in sentences, and the answer that is marked."""
        return menu_sentences(self.query_one(OptionList))

    def on_option_list_option_highlighted(self) -> None:
        self.app.aloud.read(self)  # type: ignore[attr-defined]

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        event.stop()
        self.dismiss(cast(Answer, event.option.id))


class SavingScreen(ModalScreen[None]):
    """Covers the session while its last messages are written. No key does anything."""

    def compose(self) -> ComposeResult:
        tr = language_of(self.app)
        yield Static(
            f"{tr('One moment…')}\n\n{tr('Your results are being saved.')}",
            id="saving",
            markup=False,
        )
