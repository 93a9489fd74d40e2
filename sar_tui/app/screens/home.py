"""The first screen: participant, task, theme, and the recent sessions."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.screen import Screen
from textual.widgets import Button, Static
from textual.widgets.option_list import Option

from sar_tui.plugins import PluginError
from sar_tui.store.connection import timing_flags
from sar_tui.store.database import StoreError
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.option_list import OptionList

if TYPE_CHECKING:  # loaded when the lists are filled: the empty screen is shown before
    from sar_tui.framework.task import Task
    from sar_tui.store.programmes import Programme
    from sar_tui.store.sessions import Row

_NEW = "+"
_LOOK_SECONDS = 3.0


class HomeScreen(Screen[None]):
    """Three lists to choose from, a button to start, and the recent sessions. Arrows and Enter are enough."""

    help_text = (
        "Choose who takes part, the task and the theme; then Start.\n"
        "The arrows move within and between lists, Enter chooses.\n\n"
        "A task for two asks next who sits on the right.\n\n"
        "Enter resumes an interrupted session. Delete dismisses one that nobody goes on with: nothing of it is lost, "
        "and Delete takes that back.\n\n"
        "Participants are codes, never names.\n"
    )
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("right,down", "next", "Next list", show=False, id="next"),
        Binding("left,up", "previous", "Previous list", show=False, id="previous"),
        Binding("f2", "settings", "Settings (therapist)", id="settings"),
        Binding("f12", "patient_mode", "Patient mode", id="patient-mode"),
        Binding("f3", "operate", "Operator's panel", id="operate"),
        Binding("delete,backspace", "dismiss_session", "Dismiss", id="dismiss-session"),
        Binding("delete,backspace", "take_back", "Take back", id="take-back"),
    ]

    app: Any

    def __init__(self) -> None:
        super().__init__()
        self._theme_of: tuple[str, str] | None = None
        self._can_operate = False
        self._left_out = ""
        self._is_filled = False
        self._recent: dict[str, Row] = {}

    def compose(self) -> ComposeResult:
        yield Static(_title(), id="title", markup=False)
        with Horizontal(id="choices"):
            for name, title in (("participant", "Who"), ("task", "Task"), ("theme", "Theme")):
                choices = OptionList(id=name, classes="choice", markup=False)
                choices.border_title = title
                yield choices
        with Horizontal(id="buttons"):
            yield Static("", id="about", markup=False)
            yield Button("Start", id="start", variant="primary", compact=True)
            yield Button("Settings", id="settings", compact=True)
        with Vertical(id="recent-box"):
            recent = OptionList(id="recent", markup=False)
            recent.border_title = "Recent sessions"
            recent.border_subtitle = "Enter opens"
            yield recent
        yield KeyFooter()

    def on_mount(self) -> None:
        self.query_one("#participant").border_subtitle = "arrows and Enter"

    def fill(self) -> None:
        """Fill the lists; called once the empty screen is shown, because reading their contents takes a moment."""
        self._is_filled = True
        tasks = self.query_one("#task", OptionList)
        for name in self.app.catalogue.task_names():
            try:
                tasks.add_option(Option(self.app.catalogue.task(name).title, id=name))
            except PluginError:
                tasks.add_option(Option(f"{name} (does not load)", id=name, disabled=True))
        tasks.action_first()  # that loads
        self._list_participants()
        self._list_themes()
        self._list_recent()
        self.look_for_sessions()
        self.set_interval(_LOOK_SECONDS, self.look_for_sessions)
        self.app.tell_troubles()

    def _list_themes(self) -> None:
        self.app.load_themes()
        themes = self.query_one("#theme", OptionList)
        themes.add_options([Option(theme.title, id=name) for name, theme in self.app.themes.items()])
        themes.highlighted = 0
        self._theme_of = None
        self._show_saved_theme()

    def on_screen_resume(self) -> None:
        if self._is_filled:
            self.app.check_database()
            self._list_participants()
            self._list_recent()
            self.look_for_sessions()
        if self.focused is None:
            self.query_one("#participant").focus()

    # --- the lists ---------------------------------------------------------------------------------------

    def _list_participants(self, chosen: str | None = None) -> None:
        from sar_tui.store import participants

        people = self.query_one("#participant", OptionList)
        chosen = chosen or self._chosen("participant") or participants.last_used(self.app.database)
        codes = participants.codes(self.app.database)
        people.clear_options()
        people.add_options([Option(code, id=code) for code in codes])
        people.add_option(Option("+ New participant", id=_NEW))
        people.highlighted = codes.index(chosen) if chosen in codes else 0

    def _list_recent(self) -> None:
        from sar_tui.store import sessions, wellbeing

        recent, chosen = self.query_one("#recent", OptionList), self._chosen("recent")
        rows = sessions.listing(self.app.database, self.app.folder, limit=30)
        felt = wellbeing.by_session(self.app.database, [row["id"] for row in rows])
        self._recent = {row["id"]: row for row in rows}
        recent.clear_options()
        recent.add_options([Option(_line(row, felt.get(row["id"], [])), id=row["id"]) for row in rows])
        if rows:
            recent.highlighted = list(self._recent).index(chosen) if chosen in self._recent else 0
        else:
            recent.add_option(Option("None yet.", disabled=True))

    def _chosen(self, name: str) -> str | None:
        choices = self.query_one(f"#{name}", OptionList)
        if choices.highlighted is None:
            return None
        chosen = choices.get_option_at_index(choices.highlighted).id
        return None if chosen == _NEW else chosen

    @on(OptionList.OptionHighlighted)
    def _chose(self) -> None:
        """Say what Start will do, and apply the chosen theme."""
        if theme := self._chosen("theme"):
            self.app.use_theme(theme)
        who, task = self._chosen("participant"), self._chosen("task")
        about = f"{who}: {self.app.catalogue.task(task).title}" if who and task else "Choose or add a participant."
        self.query_one("#about", Static).update(about)

    @on(OptionList.OptionHighlighted, "#participant, #task")
    def _show_saved_theme(self) -> None:
        """Select the theme saved with a participant's settings; a choice by hand stays."""
        from sar_tui.store import programmes

        who, task = self._chosen("participant"), self._chosen("task")
        if who and task and (who, task) != self._theme_of:
            self._theme_of = (who, task)
            saved = programmes.newest(self.app.database, who, task).theme
            themes = self.query_one("#theme", OptionList)
            if saved in (names := [option.id for option in themes.options]):
                themes.highlighted = names.index(saved)

    @on(OptionList.OptionSelected, "#participant")
    def _participant_selected(self, event: OptionList.OptionSelected) -> None:
        if event.option.id == _NEW:
            self._add_participant()
        else:
            self.action_next()

    @on(OptionList.OptionSelected, "#task, #theme")
    def _go_to_next(self) -> None:
        self.action_next()

    def _add_participant(self) -> None:
        from sar_tui.app.screens.new_participant import NewParticipantScreen

        def added(code: str | None) -> None:
            if code:
                self._list_participants(code)
                self.query_one("#task").focus()

        self.app.push_screen(NewParticipantScreen(), added)

    @on(OptionList.OptionSelected, "#recent")
    def _recent_selected(self, event: OptionList.OptionSelected) -> None:
        from sar_tui.app.screens.past_session import PastSessionScreen
        from sar_tui.store import sessions

        try:
            row = sessions.find(self.app.database, self.app.folder, event.option.id or "")
        except StoreError as error:
            self.notify(str(error), severity="error", timeout=15)
            return
        if _can_resume(row):
            self.app.begin_session(row["id"])
        else:
            self.app.push_screen(PastSessionScreen(row))

    @on(OptionList.OptionHighlighted, "#recent")
    def _offer_dismissal(self) -> None:
        """Show the key that dismisses the highlighted session, if it is interrupted."""
        self.refresh_bindings()

    def action_dismiss_session(self) -> None:
        """Dismiss the highlighted session, which nobody goes on with."""
        from sar_tui.store import dismissal

        self._change_recent(lambda session: dismissal.dismiss(self.app.database, self.app.folder, session))

    def action_take_back(self) -> None:
        """Let the highlighted session be resumed again."""
        from sar_tui.store import dismissal

        self._change_recent(lambda session: dismissal.take_back(self.app.database, session))

    def _change_recent(self, change: Callable[[str], None]) -> None:
        try:
            change(self._chosen("recent") or "")
        except StoreError as error:
            self.notify(str(error), severity="error", timeout=15)
        self._list_recent()

    # --- the operator's panel -----------------------------------------------------------------------------

    def look_for_sessions(self) -> None:
        """Offer the panel while a session on this machine can be joined."""
        from sar_tui.link.discovery import live_sessions
        from sar_tui.link.errors import LinkError

        if not self.is_current:
            return
        try:
            can_operate = bool(live_sessions())
        except LinkError:
            can_operate = False
        if can_operate != self._can_operate:
            self._can_operate = can_operate
            self.refresh_bindings()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        match action:
            case "operate":
                return self._can_operate
            case "dismiss_session" | "take_back":
                row = self._recent.get(self._chosen("recent") or "") if self._recent else None
                if row is None or not self.query_one("#recent").has_focus:
                    return False
                return _can_resume(row) if action == "dismiss_session" else row["status"] == "dismissed"
        return super().check_action(action, parameters)

    def action_operate(self) -> None:
        """Choose a session, and open its panel."""
        from sar_tui.link.discovery import JoinableSession, live_sessions
        from sar_tui.operator.session_picker import ChooseScreen, own_name, panel

        def chosen(live: JoinableSession | None) -> None:
            if live is not None:
                theme = next(iter(self.app.themes.values()))
                self.app.push_screen(panel(live, own_name(), "operator", theme, self.app.folder), left)

        def left(why: str | None) -> None:
            if why:
                self.notify(why, severity="warning", timeout=15)

        found = live_sessions()
        if len(found) == 1:
            chosen(found[0])
        else:
            self.app.push_screen(ChooseScreen(), chosen)

    # --- actions ---------------------------------------------------------------------------------

    def action_next(self) -> None:
        """Focus the next list."""
        self.focus_next()

    def action_previous(self) -> None:
        """Focus the previous list."""
        self.focus_previous()

    @on(Button.Pressed, "#start")
    def _start(self) -> None:
        if (chosen := self._participant_and_task()) is None:
            return
        who, task = chosen
        if len(task.seats) == 1:
            self._begin(task, who)
            return
        from sar_tui.app.screens.second_participant import SecondParticipantScreen

        def second_chosen(code: str | None) -> None:
            if code:
                self._begin(task, who, code)

        self.app.push_screen(SecondParticipantScreen(who), second_chosen)

    def _begin(self, task: "type[Task]", *codes: str) -> None:
        """Plan the session from the first participant's programme, save another theme in it, and begin.

        If the programme cannot be used in full, say so first; a second press begins without the rest.
        """
        from sar_tui.framework.declaration import ParameterError
        from sar_tui.runs.plan import Failed, left_out_text, make_plan
        from sar_tui.store import programmes

        saved = programmes.newest(self.app.database, codes[0], task.name)
        theme = self._chosen("theme") or saved.theme
        try:
            plan = make_plan(self.app.catalogue, task, codes, saved=saved, theme=theme)
            if (text := left_out_text(plan)) != self._left_out:
                self._left_out = text
                if text:
                    self.notify(f"{text} Press Start again to begin without it.", severity="warning", timeout=30)
                    return
            if theme != saved.theme:
                saved = self._save_theme(codes[0], task.name, saved, theme)
                plan = make_plan(self.app.catalogue, task, codes, saved=saved, seed=plan.seed)
        except ParameterError as error:
            self.notify(f"The settings of {codes[0]} do not fit: {error}", severity="warning", timeout=15)
        except StoreError as error:
            self.notify(str(error), severity="error", timeout=15)
            self.on_screen_resume()  # opens a database anew that was removed
        except (PluginError, Failed) as error:
            self.notify(str(error), severity="warning", timeout=15)
        else:
            self.app.begin_session(plan)

    def _save_theme(self, participant: str, task: str, saved: "Programme", theme: str) -> "Programme":
        """Return the next version of a programme, which has another theme."""
        from sar_tui.drivers.login_name import login_name
        from sar_tui.store import programmes

        changed = programmes.Programme(saved.parameters, theme)
        reason = f"Theme {theme} was chosen on the first screen."
        return programmes.save(
            self.app.database, participant, task, changed, after=saved.version, author=login_name(), reason=reason
        )

    async def action_patient_mode(self) -> None:
        """Let the chosen participant train alone."""
        if self.app.is_web:
            self.notify("Patient mode needs a terminal: a session cannot run in a browser.", severity="warning")
        elif who := self._chosen("participant"):
            try:
                await self.app.begin_patient_mode(who)
            except StoreError as error:
                self.notify(str(error), severity="warning", timeout=15)
        else:
            self.notify("Choose or add a participant first.", severity="warning")

    @on(Button.Pressed, "#settings")
    def action_settings(self) -> None:
        """Open the therapist's settings."""
        from sar_tui.app.screens.settings import SettingsScreen

        if chosen := self._participant_and_task():
            self.app.push_screen(SettingsScreen(*chosen))

    def _participant_and_task(self) -> "tuple[str, type[Task]] | None":
        who, name = self._chosen("participant"), self._chosen("task")
        if not who or not name:
            self.notify("Choose or add a participant first.", severity="warning")
            self.query_one("#participant").focus()
            return None
        return who, self.app.catalogue.task(name)


def _title() -> str:
    """Return the program's name, and what makes timing less exact in this terminal."""
    flags = timing_flags()
    return "sar-tui" + (f"   (inside {' and '.join(flags)}: reaction times are less exact)" if flags else "")


def _can_resume(row: "Row") -> bool:
    return bool(row["status"] == "interrupted" and row["mode"] == "live")


def _line(row: "Row", felt: "list[Row]") -> str:
    """Return a session as a line: start, participants, task, attempts, status, pain and tiredness."""
    from sar_tui.reports.wellbeing import marks
    from sar_tui.store import sessions

    when = sessions.local_time(row["started_at"])
    done = f"{row['attempts']} of {row['parameters'].get('attempts', '?')}"
    how = "interrupted: Enter resumes" if _can_resume(row) else row["status"]
    kind = "" if row["mode"] == "live" else f" ({row['mode']})"
    pain = f" · {told}" if (told := marks(felt)) else ""
    return f"{when}  {sessions.participant_codes(row):<8} {row['task']:<10} {done:>9}  {how}{kind}{pain}"
