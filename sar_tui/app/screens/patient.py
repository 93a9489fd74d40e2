"""The screen of a participant who trains alone: the plan of the day, and a large Start."""

import re
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Center, Horizontal, Vertical
from textual.screen import Screen
from textual.widgets import Button, Static

from sar_tui.app.wellbeing_interview import ALONE, TELL_OF_PAIN
from sar_tui.model.language import Language, in_language, language
from sar_tui.model.spoken_text import sentences
from sar_tui.plugins import PluginError, task_folder
from sar_tui.rules.scanning import Choice
from sar_tui.runs.patient_plan import (
    PLAN_ERRORS,
    Exercise,
    day_plan,
    exercises,
    plan_exercise,
    unfinished,
)
from sar_tui.store.database import StoreError
from sar_tui.store.forms import Occasion
from sar_tui.tui.gc_control import end_loading
from sar_tui.tui.heading import Heading, most_rows
from sar_tui.tui.key_line import KeyLine
from sar_tui.tui.language import app_language, planned_language

if TYPE_CHECKING:
    from sar_tui.app.at_home import FromClinic
    from sar_tui.records.kind import Kind
    from sar_tui.runs.plan import Plan
    from sar_tui.store.records import Record

_GREETINGS = ((12, "Good morning"), (18, "Good afternoon"), (24, "Good evening"))
"""Greetings, each with the hour until which it is said."""
_DONE, _NEXT, _LATER = "✓", "▸", " "
_GAP = re.compile(r"(?<=\S) {2,}")


class PatientScreen(Screen[None]):
    """Greets, and shows the plan of the day. Enter starts the next exercise; it can be skipped;
    nothing else can be reached from here.

    Args:
        participant: the code.
        exercises: names of the tasks, in order.
        from_clinic: what comes from the clinic; None if the participant does not train at home.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("enter,space", "start", show=False, id="start"),
        Binding("up,left", "app.focus_previous", show=False, id="previous"),
        Binding("down,right", "app.focus_next", show=False, id="next"),
    ]

    app: Any

    def __init__(
        self, participant: str, exercises: list[str], from_clinic: "FromClinic | None" = None
    ) -> None:
        super().__init__()
        self._participant = participant
        self._from_clinic = from_clinic
        self._is_reading = False
        """A message, or a form, is on top of this screen."""
        self._exercises = [Exercise(name) for name in exercises]
        self._at = 0
        self._has_begun = False
        self._begins_again = False
        """All was done, and the participant does it again: what is done is not passed over."""
        self._rest: Literal["", "pain", "enough"] = ""
        """Why the participant had better rest, although there are exercises left."""
        self._plan: Plan | None = None
        self.tr: Language = app_language("en")

    @property
    def help_text(self) -> str:
        """The two things that can be done here."""
        tr = self.tr
        return f"{tr('Press Enter to start the exercise.')}\n{tr('The arrow down and Enter skip it.')}\n"

    @property
    def active_bindings(self) -> dict[str, Any]:
        """No keys for the help: all that is needed is said on the screen."""
        return {
            key: active
            for key, active in super().active_bindings.items()
            if active.binding.id in ("previous", "next")
        }

    def compose(self) -> ComposeResult:
        with Horizontal(classes="top-bar"):
            yield Static(self._participant, id="who", markup=False)
            yield Static("", id="where", markup=False)
        with Vertical(id="patient"):
            yield Heading(id="hello")
            yield Center(Static("", id="day", markup=False))
            yield Static("", id="exercise", classes="body", markup=False)
            yield Static("", id="trouble", classes="body", markup=False)
            yield Center(Button("", id="go", variant="primary"))
            yield Center(Button("", id="skip", compact=True))
            yield Static("", id="clinic", classes="small", markup=False)
        yield KeyLine(grows=True)

    def on_mount(self) -> None:
        for button in self.query(Button):
            button.active_effect_duration = 0  # Textual ignores a second press meanwhile

    def on_screen_resume(self) -> None:
        end_loading()
        if self.app.patient:
            self.show_exercise()
        else:
            self.app.call_later(self.app.patient_mode.leave_screen)

    # --- where in the plan of the day one is

    def _read_day(self) -> None:
        """Read what is done today; begin with what is not, also after the programme has changed."""
        app, before = self.app, [exercise.name for exercise in self._exercises]
        names = before
        if self._from_clinic:
            names = exercises(app.database, app.folder, app.catalogue, self._participant)
        self._exercises = day_plan(app.database, app.folder, self._participant, names, app.today())
        if not self._has_begun or names != before:
            self._at, self._has_begun = self._open_from(0), True

    def _open_from(self, index: int) -> int:
        """Return the index of the next exercise that is to be done; the number of all if there is
        none.
        """
        for at in range(index, len(self._exercises)):
            if self._begins_again or not self._exercises[at].is_done:
                return at
        return len(self._exercises)

    def _go_on(self) -> None:
        """Go on to the next exercise."""
        self._at = self._open_from(self._at + 1)

    @property
    def switch_choices(self) -> tuple[Choice, ...]:
        """The buttons, for a switch; to start after everything is done takes a second choice."""
        buttons = [button for button in self.query(Button) if button.display]
        asks = self._present is None or self._rest
        return tuple(
            Choice(label := str(button.label), ("enter",), f"{label}?" if asks else "")
            for button in buttons
        )

    def mark(self, at: int, _: Choice) -> None:
        """Focus a button."""
        self.set_focus([button for button in self.query(Button) if button.display][at])

    @property
    def _present(self) -> Exercise | None:
        """The exercise that is next; None if all are done."""
        return self._exercises[self._at] if self._at < len(self._exercises) else None

    @property
    def next_exercise(self) -> tuple[int, int] | None:
        """Number of the exercise after the present one, and of all; None after the last."""
        number, total = self._open_from(self._at + 1) + 1, len(self._exercises)
        return (number, total) if number <= total else None

    # --- what is shown

    def show_exercise(self, trouble: bool = False) -> None:
        """Show the next exercise, or that all are done; after a trouble, ask to call the
        therapist.
        """
        try:
            self._read_day()
            if present := self._present:
                self._plan = plan_exercise(
                    self.app.database,
                    self.app.catalogue,
                    self._participant,
                    present.name,
                    is_known=present.is_known,
                )
                self.tr = planned_language(self._plan, self.app.catalogue)
                self.app.themes.use_planned(self._plan)
                self.app.aloud.use_planned(self._plan, self.tr)
        except PLAN_ERRORS as error:
            self._plan, trouble = None, True
            self.app.patient_mode.note_trouble(in_language(error, self.app.tr))
        self._write(trouble=trouble)
        if self._from_clinic:
            self.call_after_refresh(self._show_what_came)

    def on_resize(self) -> None:
        heading = self.query_one("#hello", Heading)
        heading.show(heading.text, most_rows(self.app.size))

    def _write(self, *, trouble: bool) -> None:
        tr, total = self.tr, len(self._exercises)
        is_over = self._present is None or bool(self._rest)
        is_praise = is_over and self._rest != "pain"
        heading = self.query_one("#hello", Heading)
        heading.set_classes("well-done" if is_praise else "sentence")
        heading.show(self._hello())
        where = ""
        if total > 1 and not is_over:
            where = tr("Exercise {number} of {total}", number=self._at + 1, total=total)
        texts = {
            "#where": where,
            "#day": "" if is_over or total == 1 else self._day_in_words(),
            "#exercise": self._words(),
            "#trouble": tr("This does not work now. Please call your therapist.")
            if trouble
            else "",
            "#clinic": "",
        }
        if self._from_clinic:
            self._add_from_clinic(texts, self._from_clinic)
        for name, text in texts.items():
            part = self.query_one(name, Static)
            part.update(text)
            part.display = bool(text)
        self.query_one("#go", Button).label = tr("Start again") if is_over else tr("Start")
        skip = self.query_one("#skip", Button)
        skip.label = tr("Skip this exercise")
        skip.display = total > 1 and not is_over
        self.query_one(KeyLine).show(
            "" if self._rest == "pain" else tr("Press Enter to start."), tr("Enter")
        )
        self.query_one("#go").focus()
        self.app.screen_keys.changed(self)
        if self._plan:
            self.app.use_switch(self._plan.parameters, self._plan.participants)
        self.app.look_for_choices()
        self.app.aloud.read(self, (self._at, self._rest, trouble))

    @property
    def sentences(self) -> list[str]:
        """The screen in sentences; of its buttons the one that is chosen."""
        shown = (
            self.query_one(f"#{name}", Static)
            for name in ("where", "day", "exercise", "trouble", "clinic")
        )
        texts = [str(part.content) for part in shown if part.display]
        day = [_GAP.sub(", ", text.replace(_NEXT, "").replace(_DONE, "")) for text in texts]
        chosen = self.focused
        return sentences(
            self.query_one("#hello", Heading).text,
            *day,
            self.query_one(KeyLine).text,
            str(chosen.label) if isinstance(chosen, Button) else "",
        )

    def on_descendant_focus(self) -> None:
        self.app.aloud.read_more()

    def _hello(self) -> str:
        tr = self.tr
        if self._rest == "pain":
            return tr("You can rest now.")
        if self._rest == "enough":
            return tr("That is enough for today. Well done!")
        if self._present is None:
            return tr("That was everything. Well done!")
        hour = self.app.hour()
        return next(tr(greeting) for until, greeting in _GREETINGS if hour < until)

    def _words(self) -> str:
        """Return what there is to say below the greeting: the exercise, how long, or to rest."""
        tr = self.tr
        if self._rest == "pain":
            return f"{tr(TELL_OF_PAIN)}\n{tr(ALONE)}"
        if self._rest or self._present is None:
            rest = tr("You can rest now.")
            return f"{rest}\n{tr('You can close this window.')}" if self._from_clinic else rest
        if len(self._exercises) > 1:
            return self._together()
        parts = [tr(self._plan.task.title)] if self._plan else []
        return "\n".join([*parts, self._how_long(self._present) or self._attempts()])

    def _together(self) -> str:
        """Return how long all that is still to be done takes, if that is known of each."""
        to_do = [one for one in self._exercises if not one.is_done]
        minutes = [one.minutes for one in to_do if one.minutes is not None]
        if len(to_do) < 2 or len(minutes) < len(to_do):
            return ""
        return self.tr("Together about {count} minutes", count=max(2, round(sum(minutes))))

    def _how_long(self, exercise: Exercise) -> str:
        """Return about how long an exercise takes; empty if that is not known."""
        if exercise.minutes is None:
            return ""
        minutes = max(1, round(exercise.minutes))
        tr = self.tr
        return tr("About 1 minute") if minutes == 1 else tr("About {count} minutes", count=minutes)

    def _attempts(self) -> str:
        tr, attempts = self.tr, self._plan.parameters.attempts if self._plan else 0
        return tr("1 attempt") if attempts == 1 else tr("{count} attempts", count=attempts)

    def _day_in_words(self) -> str:
        """Return the exercises below each other, with a mark for what is done and what is next."""
        rows = []
        for index, exercise in enumerate(self._exercises):
            is_next, how_long = index == self._at, self._how_long(exercise)
            mark = _NEXT if is_next else _DONE if exercise.is_done else _LATER
            if is_next:
                how_long = how_long or self._attempts()
            elif exercise.is_done:
                how_long = self.tr("done")
            rows.append((f"{mark} {self._title(exercise)}", how_long))
        width = max(len(title) for title, _ in rows)
        return "\n".join(f"{title.ljust(width)}   {more}".rstrip() for title, more in rows)

    def _title(self, exercise: Exercise) -> str:
        """Return the title of a task in the language of the screen; its name if it does not load."""
        try:
            task = self.app.catalogue.task(exercise.name)
        except PluginError:
            return exercise.name
        return language(self.tr.code, task_folder(task))(task.title)

    # --- what can be done

    @on(Button.Pressed, "#go")
    def action_start(self) -> None:
        """Go on with a session that was interrupted not long ago, else begin a new one."""
        if self._present is None or self._rest:
            if self._present is None:
                self._at, self._begins_again = 0, True
            self._rest = ""
            self.show_exercise()
            return
        if self._plan is None:
            self.show_exercise()
            return
        try:
            session = unfinished(
                self.app.database, self.app.folder, self._participant, self._plan.task.name
            )
        except StoreError as error:
            self.app.patient_mode.note_trouble(in_language(error, self.app.tr))
            session = None
        self.app.begin_session(session or self._plan)

    def session_left(self, *, ended: bool, is_mistake: bool) -> None:
        """Go on to the next exercise after a session that ended; one that failed or was a mistake
        can be done again.
        """
        if ended and not is_mistake:
            self._go_on()
        self.show_exercise(trouble=not ended)

    def cannot_begin(self, *, resumed: bool) -> None:
        """Say so; a session that cannot go on gives way to a new one."""
        if resumed and self._plan:
            self.app.begin_session(self._plan)
        else:
            self.show_exercise(trouble=True)

    def stopped_by_pain(self) -> None:
        """Let a participant rest who is in too much pain to begin, or to go on with the next
        exercise.
        """
        self._rest = "pain"
        self.show_exercise()

    def enough_today(self) -> None:
        """Go on to the next exercise, as enough was done of this one; after the last, let the
        participant rest.
        """
        self._go_on()
        self._rest = "enough" if self._present is None else ""
        self.show_exercise()

    @on(Button.Pressed, "#skip")
    def _skip(self) -> None:
        self._go_on()
        self.show_exercise()

    # --- what comes from the clinic

    def _add_from_clinic(self, texts: dict[str, str], clinic: "FromClinic") -> None:
        """Add what the clinic has seen, and that its letters do not go through."""
        from sar_tui.app.at_home import NOT_RECEIVED, NOT_RECEIVED_WHY

        try:
            if clinic.is_refused:
                self.app.patient_mode.note_trouble(self.app.tr(NOT_RECEIVED_WHY))
                texts["#trouble"] = texts["#trouble"] or self.tr(NOT_RECEIVED)
            else:
                texts["#clinic"] = "\n".join(clinic.lines(self.app.today(), self.tr))
        except StoreError as error:
            self.app.patient_mode.note_trouble(in_language(error, self.app.tr))

    def letters_came(self) -> None:
        """Show what has changed; the button that is chosen stays."""
        if not self.app.patient:
            return
        chosen = self.focused
        self.show_exercise()
        if chosen is not None and chosen.display:
            chosen.focus()

    def _show_what_came(self) -> None:
        """Show messages that nobody has read, then offer the form that the clinic asks for, unless
        something else is under way.
        """
        app, clinic = self.app, self._from_clinic
        is_free = app.patient and self.is_current and app.open_session is None
        if clinic is None or self._is_reading or not is_free:
            return
        try:
            if messages := clinic.unread():
                self._show_messages(clinic, messages)
            elif kind := clinic.form():
                self._offer_form(clinic, kind)
        except StoreError as error:
            app.patient_mode.note_trouble(in_language(error, app.tr))

    def _show_messages(self, clinic: "FromClinic", messages: "list[Record]") -> None:
        from sar_tui.app.screens.questions import LetterScreen

        def read(_: bool | None) -> None:
            self._is_reading = False
            if not self.app.patient:  # the therapist has closed it
                return
            try:
                clinic.mark_read(messages)
            except StoreError as error:
                self.app.patient_mode.note_trouble(in_language(error, self.app.tr))
            self.app.exchange_letters()
            self.call_after_refresh(self._show_what_came)

        self._is_reading = True
        self.app.push_screen(LetterScreen(clinic.show(messages, self.tr)), read)

    def _offer_form(self, clinic: "FromClinic", kind: "Kind") -> None:
        from sar_tui.app.screens.questions import QuestionScreen

        def answered(wants: bool | None) -> None:
            self._is_reading = False
            clinic.put_off(kind)  # also if it is left before its end
            if not (wants and self.app.patient):
                return
            try:
                self.app.fill_form(kind, Occasion(self._participant), filled)
            except PLAN_ERRORS as error:
                self.app.patient_mode.note_trouble(in_language(error, self.app.tr))

        def filled(_: object) -> None:
            self.app.exchange_letters()

        self._is_reading = True
        self.app.push_screen(QuestionScreen(clinic.offer(self.tr)), answered)
