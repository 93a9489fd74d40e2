"""The screen of a study: who is due, and what Enter begins for the chosen person."""

import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import suppress
from datetime import datetime
from typing import Any, ClassVar

from textual import on
from textual.app import ComposeResult, SystemCommand
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static

from sar_tui.app.code_list import CodeList
from sar_tui.app.study.commands import StudyCommands
from sar_tui.app.study.table import StudyTable
from sar_tui.app.study.words import about, dated, deviations, key_words, present, sentence
from sar_tui.drivers.login_name import login_name
from sar_tui.model.language import Language, in_language
from sar_tui.plugins import PluginError
from sar_tui.rules.declaration import ParameterError
from sar_tui.runs.plan import Failed
from sar_tui.store.database import StoreError
from sar_tui.store.programmes import LONGEST_TEXT
from sar_tui.store.records import Record
from sar_tui.study import ledger, next_block
from sar_tui.study.allocation import AllocationError
from sar_tui.study.enrolment import draws_of
from sar_tui.study.ledger import Frozen
from sar_tui.study.next_block import NeedsReason, Person
from sar_tui.study.plan import PlanError, Study
from sar_tui.study.schedule import Next, numbers
from sar_tui.study.secret import key_file
from sar_tui.study.status import PersonRow, as_of, grid
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.heading import Heading, most_rows
from sar_tui.tui.key_line import KeyLine
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.language import language_of
from sar_tui.widgets.lists import OptionList

_LOOK_SECONDS = 3.0


class StudyScreen(DismissedOnce[None]):
    """Shows who of a study is due, and begins the next block of the chosen person.

    Args:
        names: of the studies; that of the chosen person is shown, else the last one.
        who: code of the person that is chosen to begin with; empty for whoever is due.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss", "Back", id="back"),
        Binding("tab", "other_study", "Other study", id="other-study"),
    ]

    app: Any
    HORIZONTAL_BREAKPOINTS = [(100, "-wide")]
    VERTICAL_BREAKPOINTS = [(30, "-tall")]

    def __init__(self, names: Sequence[str], who: str = "") -> None:
        super().__init__()
        self._names = list(names)
        self._study = self._names[-1]
        self._who = who
        self._theme = ""
        self._frozen: Frozen | None = None
        self._rows: Sequence[PersonRow] = ()
        self._problem = ""
        self._about = ""
        self._shown: object = None
        self._read_at: object = None

    @property
    def help_text(self) -> str:
        """Help on the table, and on what Enter does."""
        tr = self.app.tr
        paragraphs = (
            tr(
                "A row for each person, a column for each visit. Enter begins what the plan has "
                "next for the chosen person. Type part of a code to find a person."
            ),
            tr(
                "On another day than the plan's, Enter asks why, and the reason is recorded as a "
                "deviation (!). A blind study shows neutral codes only."
            ),
        )
        return "\n\n".join(paragraphs) + "\n"

    def compose(self) -> ComposeResult:
        with Horizontal(id="top", classes="top-bar"):
            yield Static("", id="who", markup=False)
            yield Static("", id="where", markup=False)
        yield Heading(id="sentence")
        yield StudyTable(id="table")
        yield Static("", id="about", markup=False)
        yield KeyLine(id="key")
        yield KeyFooter()

    def on_mount(self) -> None:
        self._theme = self.app.themes.used
        if self._who:
            self._study = self._study_of(self._who) or self._study
        self.query_one(CodeList).focus()
        self.set_interval(_LOOK_SECONDS, self._look_again)

    def _study_of(self, who: str) -> str:
        """Return the newest study in which a person is; empty if they are in none."""
        for name in reversed(self._names):
            if ledger.enrolments(self.app.database, name, who):
                return name
        return ""

    def on_screen_resume(self) -> None:
        """Show what is due, also after a session."""
        self.app.aloud.close()
        self.refresh_contents()

    def therapist_is_back(self) -> None:
        """Go back to the theme that there was before a session."""
        with suppress(PluginError):
            if self.app.themes.used != self._theme:
                self.app.themes.use_named(self._theme)

    def refresh_contents(self) -> None:
        """Read everything that is shown anew."""
        self.app.check_database()
        self._shown = None
        self._read()

    def _look_again(self) -> None:
        """Show what another window has changed, or another day."""
        with suppress(sqlite3.Error):  # another program writes, or the disk is gone for a moment
            if self.is_current and self._state != self._read_at:
                self._read()

    @property
    def _state(self) -> tuple[object, ...]:
        """A value that changes when another program writes to the database, the key comes or goes,
        or the day changes.
        """
        (version,) = self.app.database.execute("PRAGMA data_version").fetchone()
        return version, key_file(self._study).exists(), self.app.today()

    @property
    def _now(self) -> datetime:
        """The present, on the day of the app."""
        return present(self.app.today())

    # --- what is shown

    def _read(self) -> None:
        """Read the study, and show it if it has changed."""
        database, tr = self.app.database, self.app.tr
        key, self._read_at = key_file(self._study), self._state
        try:
            frozen = ledger.find(database, self._study)
            people = ledger.people(database, frozen)
            rows = grid(frozen, people, key, as_of(frozen, people, self._now))
        except (StoreError, PlanError) as error:  # another program has written it
            self._frozen, self._problem = None, in_language(error, tr)
            self._show_person()
            return
        problem = ""
        if frozen.mode == "simulated":
            problem = tr("This is a rehearsal with simulated people: nobody trains in it.")
        else:
            try:
                draws_of(frozen, key)
            except AllocationError as error:
                problem = in_language(error, tr)
        shown = (frozen.plan.version, rows, problem, self.app.today())
        if shown == self._shown:
            return
        self._shown = shown
        self._frozen, self._rows, self._problem = frozen, rows, problem
        self._show(frozen.plan)

    def _show(self, plan: Study) -> None:
        tr, rows = self.app.tr, self._rows
        title = tr("Study {study}", study=plan.name)
        named = f"{title} · {plan.title}" if plan.title else title
        self.query_one("#who", Static).update(named)
        made = sum(cell.state == "done" for row in rows for cell in row.visits.values())
        of = sum(len(row.visits) for row in rows)
        done = tr("{count} of {of} visits done", count=made, of=of) if rows else ""
        self.query_one("#where", Static).update(done)
        said = sentence(plan, rows, self.app.today(), tr)
        self.query_one("#sentence", Heading).show(said, most_rows(self.app.size))
        self.query_one(StudyTable).show(plan, rows, self._chosen(plan))
        self._show_person()

    def _chosen(self, plan: Study) -> str | None:
        """The chosen person; to begin with, who was chosen before this screen and has something to
        do, or who is due.
        """
        if chosen := self.query_one(CodeList).chosen:
            return chosen
        states = {
            row.participant: cell.state for row in self._rows if (cell := row.next_visit(plan))
        }
        if self._who in states:
            return self._who
        due = (who for state in ("due", "late") for who in states if states[who] == state)
        return next(due, None)

    @on(OptionList.OptionHighlighted)
    def _show_person(self) -> None:
        """Say what is to be known of the chosen person, and what Enter begins."""
        who, tr = self.query_one(CodeList).chosen, self.app.tr
        said, key = self._problem, ""
        if self._frozen and not self._rows:
            said = tr(
                "To enrol the first person: {how}",
                how=self._commands.command("study enrol", "P01", "--new"),
            )
        elif self._frozen and who and not self._problem:
            said, key = self._words_of(self._frozen, who)
        self._about = said
        self.query_one("#about", Static).update(said)
        self.query_one("#about").set_class(bool(self._problem), "needs-a-look")
        self.query_one("#key", KeyLine).show(key, "Enter")

    def _words_of(self, frozen: Frozen, who: str) -> tuple[str, str]:
        """Return what is to be known of a person, and what Enter does."""
        tr, database = self.app.tr, self.app.database
        key = ""
        try:
            one, found, said = self._offered(frozen, who)
        except (StoreError, AllocationError) as error:
            said = self._why(error)
        else:
            visit, block = numbers(one.frozen.plan, one.items, found.item)
            what = found.item.block.form or one.names.conditions[found.item.condition]
            key = key_words(who, visit, block, what, found, tr)
        people = ledger.people(database, frozen, who)
        differs = deviations([each for one in people for each in one.deviations], tr)
        return "\n".join(filter(None, (said, differs))), key

    def _offered(self, frozen: Frozen, who: str) -> tuple[Person, Next, str]:
        """Return the next block of a person, with what is to be known of it.

        Raises:
            StoreError, AllocationError: there is none.
        """
        database = self.app.database
        one = next_block.person(database, frozen, who, key_file(self._study))
        try:
            found = next_block.due(database, one, self._now)
        except NeedsReason as needed:
            return one, needed.found, dated(needed, self.app.tr)
        return one, found, about(who, found, self.app.today(), self.app.tr)

    @property
    def _commands(self) -> StudyCommands:
        """Commands on this study."""
        return StudyCommands(self.app.folder, self.app.catalogue.extra_tasks, self._study)

    def _why(self, error: Exception) -> str:
        """Return what an error says, with the command that it names on a line of its own."""
        return self._commands.complete(dated(error, self.app.tr))

    # --- several studies

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        if action == "other_study":
            return len(self._names) > 1
        return super().check_action(action, parameters)

    def action_other_study(self) -> None:
        """Show the study that was frozen before this one, after the first the last."""
        self._study = self._names[self._names.index(self._study) - 1]
        self.query_one(CodeList).clear_options()
        self.refresh_contents()

    def commands(self) -> Iterator[SystemCommand]:
        """Yield what can be done here, for the command palette."""
        tr = self.app.tr
        if self.check_action("other_study", ()):
            yield SystemCommand(
                tr("Other study"), tr("Another study of this database"), self.action_other_study
            )

    # --- beginning

    @on(OptionList.OptionSelected)
    def _entered(self, event: OptionList.OptionSelected) -> None:
        if self._problem:
            self._tell(self._problem)
        elif self._frozen and event.option.id:
            self._begin(self._frozen, event.option.id)

    def _begin(self, frozen: Frozen, who: str, reason: str = "") -> None:
        """Begin the next block of a person, after asking why if it differs from the plan."""
        app, tr = self.app, self.app.tr
        try:
            one = next_block.person(app.database, frozen, who, key_file(self._study))
            found = next_block.due(app.database, one, self._now, reason=reason)
            if found.item.block.form:
                self._fill_form(one, found, reason)
            else:
                self._begin_session(one, found, reason)
        except NeedsReason as needed:

            def answered(why: str | None) -> None:
                if why:
                    self._begin(frozen, who, why)

            app.push_screen(ReasonScreen(dated(needed, tr)), answered)
        except (StoreError, AllocationError, PluginError, ParameterError, Failed) as error:
            self._tell(self._why(error))

    def _begin_session(self, one: Person, found: Next, reason: str) -> None:
        """Begin the session of a block, or go on with the one that was cut off.

        Raises:
            StoreError, PluginError, ParameterError, Failed: it cannot begin.
        """
        app = self.app
        database = app.database
        what = found.resume or next_block.plan_of(database, app.catalogue, one, found)
        if not app.is_web:  # no session begins there
            next_block.note_deviations(
                database, one, found, reason, author=login_name(), now=self._now
            )
        app.begin_session(what)

    def _fill_form(self, one: Person, found: Next, reason: str) -> None:
        """Let the person fill in a form, and record that it is done.

        Raises:
            StoreError, PluginError, ParameterError: it cannot begin.
        """
        from sar_tui.store import forms

        app, database = self.app, self.app.database

        def filled(record: Record | None) -> None:
            if record and forms.is_complete(record):
                next_block.note_form(database, one, found, record.id, author=login_name())
            else:
                kept = app.tr("The answers are kept. Today the form goes on where it was left.")
                self.notify(kept, markup=False)
            self.refresh_contents()

        kind = forms.form(found.item.block.form)
        next_block.note_deviations(database, one, found, reason, author=login_name(), now=self._now)
        app.fill_form(kind, forms.Occasion(one.enrolled.participant), filled)

    def _tell(self, text: str) -> None:
        """Say why nothing begins, unless the screen says it already, or now that it is read anew."""
        self.refresh_contents()
        if text in self._about:
            self.app.bell()
        else:
            self.notify(text, severity="warning", timeout=15, markup=False)


class ReasonScreen(DismissedOnce[str | None], ModalScreen[str | None]):
    """Asks why a block differs from the plan; its result is the reason, or None if it is not to
    begin.

    Args:
        what: differs, in a sentence.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(None)", "Cancel", id="cancel")
    ]

    def __init__(self, what: str) -> None:
        super().__init__()
        self._what = what

    def compose(self) -> ComposeResult:
        tr: Language = language_of(self.app)
        with Vertical(classes="dialog"):
            yield Static(tr("Why not as planned?"), classes="headline", markup=False)
            yield Static(self._what, markup=False)
            yield Input(
                placeholder=tr("such as: away next week"), max_length=LONGEST_TEXT, id="reason"
            )
            yield Static("", id="problem", markup=False)
            hint = tr("Enter begins, and records the reason. Esc: nothing begins.")
            yield Static(hint, classes="muted", markup=False)

    @on(Input.Submitted)
    def _given(self, event: Input.Submitted) -> None:
        if reason := event.value.strip():
            self.dismiss(reason)
        else:
            tr = language_of(self.app)
            self.query_one("#problem", Static).update(tr("A few words are enough."))
