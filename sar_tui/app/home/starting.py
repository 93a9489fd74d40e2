"""The beginning of a session from the first screen: its plan from the programme, and what speaks
against it.
"""

from typing import TYPE_CHECKING

from sar_tui.plugins import PluginError
from sar_tui.store.database import StoreError

if TYPE_CHECKING:
    from sar_tui.app.screens.home import HomeScreen
    from sar_tui.loop.task import Task
    from sar_tui.store.programmes import Programme


class Starting:
    """Begins sessions from the first screen, which stays below them."""

    def __init__(self, screen: "HomeScreen") -> None:
        self._screen = screen
        self._left_out = ""

    def start(self, task: "type[Task]", who: str, theme: str | None) -> None:
        """Begin a session, in a task for two after asking who sits on the right."""
        if len(task.seats) == 1:
            self._begin(task, theme, who)
            return
        from sar_tui.app.screens.new_participant import SecondParticipantScreen

        def second_chosen(code: str | None) -> None:
            if code:
                self._begin(task, theme, who, code)

        self._screen.app.push_screen(SecondParticipantScreen(who), second_chosen)

    def _begin(self, task: "type[Task]", theme: str | None, *codes: str) -> None:
        """Plan the session from the first participant's programme, save another theme in it, and
        begin.

        If the programme cannot be used in full, say so first; a second press begins without the
        rest.
        """
        from sar_tui.rules.declaration import ParameterError
        from sar_tui.runs.plan import Failed, left_out_text, make_plan
        from sar_tui.store import programmes

        saved = programmes.newest(self._screen.app.database, codes[0], task.name)
        theme = theme or saved.theme
        try:
            plan = make_plan(self._screen.app.catalogue, task, codes, saved=saved, theme=theme)
            if (text := left_out_text(plan)) != self._left_out:
                self._left_out = text
                if text:
                    self._screen.notify(
                        f"{text} Press START again to begin without it.",
                        severity="warning",
                        timeout=30,
                    )
                    return
            if theme != saved.theme:
                saved = self._save_theme(codes[0], task.name, saved, theme)
                plan = make_plan(
                    self._screen.app.catalogue, task, codes, saved=saved, seed=plan.seed
                )
        except ParameterError as error:
            self._screen.notify(
                f"The settings of {codes[0]} do not fit: {error}", severity="warning", timeout=15
            )
        except StoreError as error:
            self._screen.notify(str(error), severity="error", timeout=15)
            self._screen.refresh_contents()  # opens a database anew that was removed
        except (PluginError, Failed) as error:
            self._screen.notify(str(error), severity="warning", timeout=15)
        else:
            self._screen.app.begin_session(plan)

    def _save_theme(
        self, participant: str, task: str, saved: "Programme", theme: str
    ) -> "Programme":
        """Return the next version of a programme, which has another theme."""
        from sar_tui.drivers.login_name import login_name
        from sar_tui.store import programmes

        changed = programmes.Programme(saved.parameters, theme)
        reason = f"Theme {theme} was chosen on the first screen."
        return programmes.save(
            self._screen.app.database,
            participant,
            task,
            changed,
            after=saved.version,
            author=login_name(),
            reason=reason,
        )
