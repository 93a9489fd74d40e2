"""The screen of a participant who trains alone: one exercise, and a large Start."""

from typing import TYPE_CHECKING, Any, ClassVar, Literal

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Center, Vertical
from textual.screen import Screen
from textual.widgets import Button, Static

from sar_tui.app.screens.wellbeing import ALONE, TELL_OF_PAIN
from sar_tui.model.language import Language
from sar_tui.runs.patient_plan import PLAN_ERRORS, plan_exercise, unfinished
from sar_tui.store.database import StoreError
from sar_tui.tui.gc_control import end_loading
from sar_tui.tui.language import app_language, planned_language

if TYPE_CHECKING:
    from sar_tui.runs.plan import Plan


class PatientScreen(Screen[None]):
    """Shows the next exercise of the plan. Enter starts it; it can be skipped; nothing else can be
    reached from here.

    Args:
        participant: the code.
        exercises: names of the tasks, in order.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("enter,space", "start", show=False, id="start"),
        Binding("up,left", "app.focus_previous", show=False, id="previous"),
        Binding("down,right", "app.focus_next", show=False, id="next"),
    ]

    app: Any

    def __init__(self, participant: str, exercises: list[str]) -> None:
        super().__init__()
        self._participant = participant
        self._exercises = exercises
        self._at = 0
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
        yield Static(self._participant, id="who", markup=False)
        with Vertical(id="patient"):
            yield Static("", id="hello", markup=False)
            yield Static("", id="exercise", markup=False)
            yield Static("", id="trouble", markup=False)
            yield Center(Button("", id="go", variant="primary"))
            yield Center(Button("", id="skip", compact=True))
            yield Static("", id="how", markup=False)

    def on_mount(self) -> None:
        for button in self.query(Button):
            button.active_effect_duration = 0  # Textual ignores a second press meanwhile

    def on_screen_resume(self) -> None:
        end_loading()
        if self.app.patient:
            self.show_exercise()
        else:
            self.app.call_later(self.app.patient_mode.leave_screen)

    @property
    def _is_done(self) -> bool:
        return self._at >= len(self._exercises)

    @property
    def next_exercise(self) -> tuple[int, int] | None:
        """Number of the exercise after the present one, and of all; None after the last."""
        number, total = self._at + 2, len(self._exercises)
        return (number, total) if number <= total else None

    def show_exercise(self, trouble: bool = False) -> None:
        """Show the next exercise, or that all are done; after a trouble, ask to call the
        therapist.
        """
        if not self._is_done:
            try:
                self._plan = plan_exercise(
                    self.app.database,
                    self.app.catalogue,
                    self._participant,
                    self._exercises[self._at],
                )
                self.tr = planned_language(self._plan, self.app.catalogue)
                self.app.themes.use_planned(self._plan)
            except PLAN_ERRORS as error:
                self._plan, trouble = None, True
                self.app.patient_mode.note_trouble(str(error))
        self._write(trouble=trouble)

    def _write(self, *, trouble: bool) -> None:
        tr, plan = self.tr, self._plan
        several = len(self._exercises) > 1
        if self._is_done or self._rest:
            hello, exercise, go = (
                tr("That was everything. Well done!"),
                tr("You can rest now."),
                tr("Start again"),
            )
            if self._rest == "pain":
                hello, exercise = exercise, f"{tr(TELL_OF_PAIN)}\n{tr(ALONE)}"
            elif self._rest == "enough":
                hello = tr("That is enough for today. Well done!")
        else:
            place = tr(
                "Exercise {number} of {total}", number=self._at + 1, total=len(self._exercises)
            )
            hello, go = place if several else tr("Hello!"), tr("Start")
            attempts = plan.parameters.attempts if plan else 0
            count = tr("1 attempt") if attempts == 1 else tr("{count} attempts", count=attempts)
            exercise = f"{tr(plan.task.title)}\n{count}" if plan else ""
        texts = {
            "#hello": hello,
            "#exercise": exercise,
            "#trouble": tr("This does not work now. Please call your therapist.")
            if trouble
            else "",
            "#how": "" if self._rest == "pain" else tr("Press Enter to start."),
        }
        for name, text in texts.items():
            self.query_one(name, Static).update(text)
        self.query_one("#trouble").display = trouble
        self.query_one("#go", Button).label = go
        skip = self.query_one("#skip", Button)
        skip.label = tr("Skip this exercise")
        skip.display = several and not (self._is_done or self._rest)
        self.query_one("#go").focus()
        self.app.screen_keys.changed(self)

    @on(Button.Pressed, "#go")
    def action_start(self) -> None:
        """Go on with a session that was interrupted not long ago, else begin a new one."""
        if self._is_done or self._rest:
            self._at, self._rest = 0 if self._is_done else self._at, ""
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
            self.app.patient_mode.note_trouble(str(error))
            session = None
        self.app.begin_session(session or self._plan)

    def session_left(self, *, ended: bool, is_mistake: bool) -> None:
        """Go on to the next exercise after a session that ended; one that failed or was a mistake
        can be done again.
        """
        if ended and not is_mistake:
            self._at += 1
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
        self._at += 1
        self._rest = "enough" if self._is_done else ""
        self.show_exercise()

    @on(Button.Pressed, "#skip")
    def _skip(self) -> None:
        self._at += 1
        self.show_exercise()
