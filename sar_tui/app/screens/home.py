"""The first screen, the therapist's day: people by what they need, the card of the chosen one, and
their sessions.
"""

import functools
from collections.abc import Iterator
from datetime import date
from itertools import groupby
from typing import TYPE_CHECKING, Any, ClassVar

from textual import on
from textual.app import ComposeResult, SystemCommand
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.events import Resize
from textual.screen import Screen
from textual.widgets import Button, Static
from textual.widgets.option_list import Option

from sar_tui.app.home.card import ParticipantCard
from sar_tui.app.home.participant_list import ParticipantList
from sar_tui.app.home.session_list import SessionList
from sar_tui.app.home.words import weekday_words
from sar_tui.model.language import OWN_NAMES, Language, in_language, language
from sar_tui.plugins import Catalogue, PluginError, task_folder
from sar_tui.store.connection import timing_flags
from sar_tui.store.database import StoreError
from sar_tui.tui.key_line import KeyLine
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.lists import OptionList, PickList

if TYPE_CHECKING:
    from sar_tui.app.home.homes import Homes
    from sar_tui.loop.task import Task
    from sar_tui.store.programmes import Programme

_LOOK_SECONDS = 3.0
_HIGH = 40
"""Rows from which on the parts of the card are kept apart."""
_BLOCKS = 8
"""Most rows of the sentence in block letters."""
_FIRST_TASK = "keyboard"
"""The task that is chosen before anybody has chosen one, if it is there."""


class HomeScreen(Screen[None]):
    """The day: who needs a look, who is due, who has trained. Enter and Enter begin the next session
    of who trained last.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("right,down", "next", "Next list", show=False, id="next"),
        Binding("left,up", "previous", "Previous list", show=False, id="previous"),
        Binding("f2", "settings", "Settings", id="settings"),
        Binding("f4", "progress", "Progress", id="progress"),
        Binding("f6", "sessions", "Sessions", id="sessions"),
        Binding("f7", "study", "Study", id="study"),
        Binding("f8", "message", "Message", id="message"),
        Binding("f12", "patient_mode", "Patient mode", id="patient-mode"),
        Binding("f3", "operate", "Operator's panel", id="operate"),
        Binding("plus", "new_participant", "New participant", show=False, id="new-participant"),
        Binding("escape", "to_participants", "Who", show=False, id="to-participants"),
    ]

    app: Any
    HORIZONTAL_BREAKPOINTS = [(100, "-wide")]
    VERTICAL_BREAKPOINTS = [(30, "-tall")]

    def __init__(self) -> None:
        super().__init__()
        self._starting = Starting(self)
        self._is_filled = False
        self._can_operate = False
        self._studies: list[str] = []
        self._homes: dict[str, Homes] = {}
        self._day: date | None = None
        self._sentence = ""
        self._who: str | None = None
        self._theme_of: tuple[str, str] | None = None
        self._shown: tuple[str | None, str | None] | None = None

    @property
    def help_text(self) -> str:
        """Help on the day, and on finding and starting."""
        tr = self.app.tr
        paragraphs = (
            tr(
                "People who need a look come first: pain above their limit this week, an adverse "
                "event, a level that stayed for three sessions, a session interrupted or begun by "
                "mistake. A visit is due by *Days between visits* (F2)."
            ),
            tr(
                "Type part of a code to find a person, or a word such as pain. Enter and Enter "
                "again start. Level at goal: the one at which they just reach it. F6: Enter goes on "
                "with an interrupted session, Del dismisses it. + adds a person."
            ),
            *((tr("F7 shows the study: who is due, and what comes next."),) * bool(self._studies)),
            *(
                (
                    tr(
                        "People who train at home also need a look if letters from there are "
                        "missing or were refused, or if none came for a week. F8 writes a message "
                        "to the chosen one, and sets their days of training."
                    ),
                )
                * bool(self._homes)
            ),
        )
        return "\n\n".join(paragraphs) + "\n"

    def compose(self) -> ComposeResult:
        title = _title(self.app.today(), self.app.tr)
        yield Static(title, id="title", classes="top-bar", markup=False)
        yield Static("", id="sentence", classes="sentence", markup=False)
        with Horizontal(id="day"):
            yield ParticipantList(id="participant")
            with Vertical(id="person"):
                yield ParticipantCard(id="card")
                yield SessionList(id="sessions")
        yield KeyLine(id="key")
        yield KeyFooter(show_command_palette=False, optional=("patient_mode",))

    def on_resize(self, event: Resize) -> None:
        """Leave more air where there are rows to spare."""
        self.set_class(event.size.height >= _HIGH, "-high")
        self._show_sentence()

    # --- filling

    async def fill(self, chosen: str | None = None) -> None:
        """Fill the screen, with a participant chosen; called once its empty frame is shown, because
        its contents take a moment.
        """
        await self.query_one(ParticipantCard).open()
        self._is_filled = True
        list_tasks(self._tasks, self.app.catalogue, self.app.tr)
        self.app.themes.load()
        self._themes.add_options(
            [Option(self.app.themes.title(name), id=name) for name in self.app.themes.known]
        )
        self._themes.highlighted = 0
        self._tasks.choose(_FIRST_TASK)
        self._list_participants(chosen)
        self._look_again()
        self._note_look(self._who)
        self.app.tell_troubles()

    def on_mount(self) -> None:
        self.set_interval(_LOOK_SECONDS, self._look_again)

    def on_screen_resume(self) -> None:
        self.app.aloud.close()
        if self._is_filled:
            self.refresh_contents()
            self._look_again()
            self._note_look(self._who)
        if self.focused is None:
            self._participants.focus()

    def refresh_contents(self) -> None:
        """Read everything that is shown anew."""
        self.app.check_database()
        self._list_participants()

    def _list_participants(self, chosen: str | None = None) -> None:
        from sar_tui.app.home.contents import read_day
        from sar_tui.store import participants, studies

        self._studies = studies.names(self.app.database)
        chosen = chosen or self._participants.chosen or participants.last_used(self.app.database)
        self._day = self.app.today()
        self._read_homes()
        day = read_day(self.app.database, self.app.folder, self._day, self.app.tr, self._homes)
        self._participants.fill(day.entries, chosen)
        self._show_title(self._day)
        self._sentence = day.sentence
        self.set_class(not day.entries, "-empty")
        self._show_sentence()
        self._show_participant(anew=True)
        self.refresh_bindings()

    def _show_sentence(self) -> None:
        """Show the sentence of the day; as large as there is room for, if nobody is listed."""
        lines: list[str] = []
        if self._participants.is_empty:
            from sar_tui.tui.heading import in_blocks, is_roomy

            width, height = self.app.size
            lines = in_blocks(self._sentence, width, _BLOCKS) if is_roomy(width, height) else []
        self.query_one("#sentence", Static).update("\n".join(lines or [self._sentence]))

    def _show_title(self, today: date) -> None:
        """Show the day, and if the people are invented."""
        from sar_tui.store.sessions import is_demonstration

        tr = self.app.tr
        title = _title(today, tr)
        if is_demonstration(self.app.database):
            said = [_date(today, tr), "·", tr("Demonstration: invented people.")]
            said += [] if self.app.is_kept else [tr("Nothing here is kept.")]
            title = " ".join(said)
        self.query_one("#title", Static).update(title)

    def _show_participant(self, *, anew: bool = False) -> None:
        """Show the chosen participant: their last task, their card and their sessions, if it is
        another one.
        """
        who = self._participants.code
        is_another, self._who = who != self._who, who
        if who and is_another:
            from sar_tui.store import participants

            self._tasks.choose(participants.last_task(self.app.database, who) or self._tasks.chosen)
        if is_another or anew:
            self.query_one(SessionList).show(who)
        self._show_card(anew=anew)

    def _show_card(self, *, anew: bool = False) -> None:
        """Show the card of the chosen participant and task, and the theme of their programme, if it
        is another one.
        """
        who, name = self._who, self._tasks.chosen
        if (who, name) == self._shown and not anew:
            return
        self._shown = (who, name)
        card = self.query_one(ParticipantCard)
        if not who:
            card.show_nobody(is_first=self._participants.is_empty)
            return
        if not name:
            card.show_problem(who, self.app.tr("No task can be loaded. `sar-tui tasks` says why."))
            return
        from sar_tui.app.home.contents import read_card
        from sar_tui.app.home.words import offer_words

        today = self.app.today()
        try:
            task = self.app.catalogue.task(name)
        except PluginError as error:  # it was removed or edited meanwhile
            card.show_problem(who, in_language(error, self.app.tr))
            return
        app, tr = self.app, self.app.tr
        contents = read_card(app.database, app.folder, app.catalogue, who, task, today, tr)
        entry, offer = self._participants.entry, self.query_one(SessionList).offer
        card.show(
            who,
            language(tr.code, task_folder(task))(task.title),
            contents,
            look=entry.look if entry else (),
            offer=offer_words(*offer, today, tr) if offer else "",
            study=self._study_words(who),
            at_home=self._homes[who].in_full(today, tr) if who in self._homes else "",
        )
        self._choose_saved_theme(who, name)

    def _study_words(self, who: str) -> str:
        """Return what is due for a participant in a study; empty without a study."""
        if not self._studies:
            return ""
        from sar_tui.app.study.words import due_in_studies

        return due_in_studies(self.app.database, self._studies, who, self.app.today(), self.app.tr)

    def _choose_saved_theme(self, who: str, task: str) -> None:
        """Choose the theme saved with a participant's settings; a choice by hand stays."""
        from sar_tui.store import programmes

        if (who, task) != self._theme_of:
            self._theme_of = (who, task)
            saved = programmes.newest(self.app.database, who, task).theme
            if saved in [option.id for option in self._themes.options]:
                self._themes.choose(saved)

    # --- choosing

    @property
    def _participants(self) -> ParticipantList:
        return self.query_one(ParticipantList)

    @property
    def _tasks(self) -> PickList:
        return self.query_one("#task", PickList)

    @property
    def _themes(self) -> PickList:
        return self.query_one("#theme", PickList)

    @on(OptionList.OptionHighlighted, "#participant")
    def _participant_chosen(self) -> None:
        before = self._who
        self._show_participant()
        self._show_key()
        if self._who != before:
            self._note_look(before)
            self._note_look(self._who)
            self.refresh_bindings()

    @on(OptionList.OptionHighlighted, "#task")
    def _task_chosen(self) -> None:
        self._show_card()

    @on(OptionList.OptionHighlighted, "#theme")
    def _theme_chosen(self) -> None:
        if theme := self._themes.chosen:
            self.app.themes.use_named(theme)

    @on(OptionList.OptionSelected, "#participant")
    def _participant_entered(self, event: OptionList.OptionSelected) -> None:
        if self._participants.is_new(event.option):
            self._add_participant()
        else:
            self.query_one("#start").focus()

    @on(OptionList.OptionSelected, "#task, #theme")
    def _go_to_next(self) -> None:
        self.action_next()

    @on(OptionList.OptionSelected, "#recent")
    def _session_entered(self, event: OptionList.OptionSelected) -> None:
        from sar_tui.app.home.contents import can_resume
        from sar_tui.app.screens.past_session import PastSessionScreen
        from sar_tui.store import sessions

        try:
            row = sessions.find(self.app.database, self.app.folder, event.option.id or "")
        except StoreError as error:
            self.notify(in_language(error, self.app.tr), severity="error", timeout=15)
            return
        if can_resume(row):
            self.app.begin_session(row["id"])
        else:
            self.app.push_screen(PastSessionScreen(row))

    def _add_participant(self) -> None:
        from sar_tui.app.screens.new_participant import NewParticipantScreen

        def added(code: str | None) -> None:
            if code:
                self._list_participants(code)
                self._tasks.focus()

        self.app.push_screen(NewParticipantScreen(), added)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "operate":
            return self._can_operate
        if action == "study":
            return bool(self._studies)
        if action == "message":
            return self._who in self._homes and self._homes[self._who].can_be_written_to
        if action == "sessions" and self.focused is not None and self.focused.id == "recent":
            return False
        return super().check_action(action, parameters)

    # --- actions

    def action_next(self) -> None:
        """Focus the next list."""
        self.focus_next()

    def action_previous(self) -> None:
        """Focus the previous list."""
        self.focus_previous()

    def action_to_participants(self) -> None:
        """Focus the list of participants."""
        self.remove_class("-listing")
        self._participants.focus()

    def action_sessions(self) -> None:
        """Focus the sessions, with the one chosen that is offered. In a small window they take the
        place of the day.
        """
        self.add_class("-listing")
        self.query_one(SessionList).choose_offered()
        self.query_one("#recent").focus()

    def action_new_participant(self) -> None:
        """Choose the line that adds a participant, and ask for a code."""
        self.action_to_participants()
        self._participants.choose_new()
        self._add_participant()

    def commands(self) -> Iterator[SystemCommand]:
        """Yield what can be done here, for the command palette."""
        tr = self.app.tr
        yield SystemCommand(
            tr("New participant"), tr("Add a person by a code"), self.action_new_participant
        )
        for action, title, help in (
            ("settings", tr("Settings"), tr("What the chosen person trains, how much, how hard")),
            ("progress", tr("Progress"), tr("How the chosen person has done over weeks")),
            ("sessions", tr("Sessions"), tr("Those of the chosen person: look, go on, dismiss")),
            ("study", tr("Study"), tr("Who is due in a study, and what comes next")),
            ("message", tr("Message"), tr("To the chosen person, who trains at home")),
            ("patient_mode", tr("Patient mode"), tr("Let the chosen person train alone")),
            ("operate", tr("Operator's panel"), tr("Join a session that is under way")),
        ):
            if self.check_action(action, ()):
                yield SystemCommand(title, help, getattr(self, f"action_{action}"))
        for code, name in OWN_NAMES.items():
            yield SystemCommand(
                tr("Language: {name}", name=name),
                tr("The language of the screens for therapists"),
                functools.partial(self._use_language, code),
            )

    async def _use_language(self, code: str) -> None:
        """Show the therapist's screens in a language, from now on in this data folder."""
        self.app.use_language(code)
        chosen = self._who
        self._who = self._theme_of = self._shown = None
        self._is_filled = False
        await self.recompose()
        await self.fill(chosen)
        self._participants.focus()

    # --- the key row

    def on_descendant_focus(self) -> None:
        """Say what Enter does where the focus is."""
        self._show_key()

    @on(OptionList.OptionHighlighted, "#recent")
    def _show_key(self) -> None:
        """Say what Enter does now."""
        if self._is_filled:
            self.query_one("#key", KeyLine).show(self._enter_words(), "Enter")

    def _enter_words(self) -> str:
        tr: Language = self.app.tr
        focused = self.focused.id if self.focused is not None else None
        who = self._participants.code
        if focused == "participant":
            if who:
                return tr("Press Enter twice to start a session of {who}.", who=who)
            return tr("Press Enter to add a participant.")
        if focused == "start":
            return tr("Press Enter to start a session of {who}.", who=who)
        if focused in ("task", "theme"):
            return tr("Press Enter to go on.")
        if focused == "recent":
            return self.query_one(SessionList).enter_words()
        return ""

    @on(Button.Pressed, "#start")
    def _start(self) -> None:
        if chosen := self._participant_and_task():
            who, task = chosen
            self._starting.start(task, who, self._themes.chosen)

    async def action_patient_mode(self) -> None:
        """Let the chosen participant train alone."""
        if self.app.is_web:
            self.notify(
                self.app.tr("Patient mode needs a terminal: a session cannot run in a browser."),
                severity="warning",
            )
        elif who := self._participants.code:
            try:
                await self.app.patient_mode.begin(who)
            except StoreError as error:
                self.notify(in_language(error, self.app.tr), severity="warning", timeout=15)
        else:
            self._ask_for_participant()

    def _ask_for_participant(self) -> None:
        self.notify(self.app.tr("Choose or add a participant first."), severity="warning")

    def action_settings(self) -> None:
        """Open the therapist's settings."""
        from sar_tui.app.screens.settings import SettingsScreen

        if chosen := self._participant_and_task():
            self.app.push_screen(SettingsScreen(*chosen))

    def action_study(self) -> None:
        """Open the study, with the chosen participant if they are in it."""
        from sar_tui.app.screens.study import StudyScreen

        self.app.push_screen(StudyScreen(self._studies, self._participants.code or ""))

    def action_progress(self) -> None:
        """Open the participant's progress in the task."""
        from sar_tui.app.screens.progress import ProgressScreen

        if chosen := self._participant_and_task():
            self.app.push_screen(ProgressScreen(*chosen))

    def action_message(self) -> None:
        """Write a message to the chosen participant, who trains at home."""
        from sar_tui.app.screens.message_home import MessageScreen

        def written(is_written: bool | None) -> None:
            if is_written:
                self.app.exchange_letters()

        if self._who:
            self.app.push_screen(MessageScreen(self._who), written)

    def _participant_and_task(self) -> "tuple[str, type[Task]] | None":
        who, name = self._participants.code, self._tasks.chosen
        if not who or not name:
            self._ask_for_participant()
            self._participants.focus()
            return None
        try:
            return who, self.app.catalogue.task(name)
        except PluginError as error:  # it was removed or edited meanwhile
            self.notify(in_language(error, self.app.tr), severity="warning", timeout=15)
            return None

    # --- people who train at home

    def _read_homes(self) -> None:
        """Read what is known of the computers at home, if this is a clinic that has some."""
        if self.app.letters.role != "clinic":
            return
        from sar_tui.app.home.homes import read_homes

        self._homes = read_homes(self.app.database)

    def letters_came(self) -> None:
        """Show what has come. Nobody may be here to look at it."""
        if self._is_filled:
            self.refresh_contents()

    def _note_look(self, who: str | None) -> None:
        """Note that a therapist looks at a person's card, so that their computer at home can say
        so.
        """
        if who not in self._homes:
            return
        from sar_tui.letterbox import correspondents
        from sar_tui.store.database import transaction

        try:
            with transaction(self.app.database) as database:
                is_news = correspondents.mark_seen(database, who)
        except StoreError as error:
            self.notify(in_language(error, self.app.tr), severity="warning", timeout=15)
            return
        if is_news:
            self.app.exchange_letters()

    # --- while nobody presses a key: another day, and the operator's panel of a session to join

    def _look_again(self) -> None:
        """Read the day anew if it is another one, and see if a session of this data folder can be
        joined.
        """
        from sar_tui.link.discovery import joinable_sessions
        from sar_tui.link.errors import LinkError

        if not self.is_current or not self._is_filled:
            return
        if self._day != self.app.today():  # it was left open over night
            self.refresh_contents()
        try:
            can_operate = bool(joinable_sessions(self.app.folder))
        except LinkError:
            can_operate = False
        if can_operate != self._can_operate:
            self._can_operate = can_operate
            self.refresh_bindings()

    def action_operate(self) -> None:
        """Choose a session, and open its panel."""
        from sar_tui.link.discovery import JoinableSession, joinable_sessions
        from sar_tui.operator.app import ChooseScreen, own_name, panel, panel_texts

        folder, tr = self.app.folder, panel_texts(self.app.tr.code)

        def chosen(live: JoinableSession | None) -> None:
            if live is not None:
                theme = next(iter(self.app.themes.known.values()))
                opened = panel(live, own_name(), "operator", theme, folder, tr, self.app.protocol)
                self.app.push_screen(opened, left)

        def left(why: str | None) -> None:
            if why:
                self.notify(why, severity="warning", timeout=15)

        found = joinable_sessions(folder)
        if len(found) == 1:
            chosen(found[0])
        else:
            self.app.push_screen(ChooseScreen(folder, tr), chosen)


def _title(today: date, tr: Language) -> str:
    """Return the program's name, the day, and what makes timing less exact in this terminal."""
    title = _date(today, tr)
    if flags := timing_flags():
        inside = tr(
            "inside {programs}: reaction times are less exact",
            programs=f" {tr('and')} ".join(flags),
        )
        title += f" · {inside}"
    return title


def _date(today: date, tr: Language) -> str:
    return f"sar-tui · {weekday_words(today, tr)}"


def list_tasks(tasks: PickList, catalogue: Catalogue, tr: Language) -> None:
    """List each task below a heading of what it trains; those that do not load are last.

    Where no task says what it trains there are no headings. The chosen one says what is done in it.
    """
    known: list[tuple[str, str, str]] = []
    broken = []
    for name in catalogue.task_names():
        try:
            task = catalogue.task(name)
        except PluginError:
            said = tr("{task} (does not load)", task=name)
            broken.append(Option(said, id=name, disabled=True))
        else:
            own = language(tr.code, task_folder(task))
            title = own(task.title)
            known.append((own(task.trains) if task.trains else "", title, name))
            tasks.summaries[name] = (title, own(task.summary))
    known.sort(key=lambda task: (not task[0], *task))
    options = []
    for trains, group in groupby(known, key=lambda task: task[0]):
        if known[0][0]:
            options.append(
                Option(Content.styled(trains or tr("Others"), "$text-muted"), disabled=True)
            )
        options += [Option(title, id=name) for _, title, name in group]
    tasks.add_options([*options, *broken])


# --- starting a session


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

        tr: Language = self._screen.app.tr
        saved = programmes.newest(self._screen.app.database, codes[0], task.name)
        theme = theme or saved.theme
        try:
            plan = make_plan(self._screen.app.catalogue, task, codes, saved=saved, theme=theme)
            if (text := left_out_text(plan)) != self._left_out:
                self._left_out = text
                if text:
                    self._screen.notify(
                        f"{in_language(text, tr)} {tr('Press START again to begin without it.')}",
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
                tr(
                    "The settings of {who} do not fit: {why}",
                    who=codes[0],
                    why=in_language(error, tr),
                ),
                severity="warning",
                timeout=15,
            )
        except StoreError as error:
            self._screen.notify(in_language(error, tr), severity="error", timeout=15)
            self._screen.refresh_contents()  # opens a database anew that was removed
        except (PluginError, Failed) as error:
            self._screen.notify(in_language(error, tr), severity="warning", timeout=15)
        else:
            self._screen.app.begin_session(plan)

    def _save_theme(
        self, participant: str, task: str, saved: "Programme", theme: str
    ) -> "Programme":
        """Return the next version of a programme, which has another theme."""
        from sar_tui.drivers.login_name import login_name
        from sar_tui.store import programmes

        self._screen.app.letters.check_programme()
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
