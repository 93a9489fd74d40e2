"""Changes that a therapist makes in a pause: level, goal, feedback, and a note."""

from typing import Any, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static
from textual.widgets.option_list import Option

from sar_tui.app.live import LiveSession
from sar_tui.app.screens.waiting_text import marks_text
from sar_tui.loop.attempts import FEEDBACK_EVERY, GOAL, adjustable, with_setting
from sar_tui.loop.bus import Record
from sar_tui.loop.clock import Handle
from sar_tui.loop.topics import COMMAND, NOTE_ADDED, SETTING
from sar_tui.model.language import in_language
from sar_tui.model.messages import NoteAdded, SessionCommand, SettingChanged, Waiting
from sar_tui.model.results_for_people import goal_text
from sar_tui.model.visible_text import visible
from sar_tui.rules.declaration import Field, ParameterError
from sar_tui.rules.parameters import fields
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.language import language_of
from sar_tui.widgets.lists import OptionList

ACTOR = "therapist"
_LONGEST_NOTE = 1000


class AdjustScreen(DismissedOnce[bool | None], ModalScreen[bool | None]):
    """Lists the changes; each is recorded like an operator's act, and holds from the next attempt
    on. The result is True if the session is to be left, and gone on with later.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "back", "Back", id="back"),
        Binding("ctrl+z", "undo", "Take back", id="undo", priority=True),
    ]

    app: Any

    def __init__(self, live: LiveSession) -> None:
        super().__init__()
        self._live = live
        self._asked = ""
        self._has_gone_on = False
        self._timer: Handle | None = None
        self._settings = adjustable(live.session.task)

    def compose(self) -> ComposeResult:
        self.tr = language_of(self.app)
        with Vertical(id="adjust"):
            yield Static(self.tr("For the therapist"), classes="headline", markup=False)
            yield Static(self.tr("Changes apply from the next attempt on."), markup=False)
            if not self.app.patient and (marks := marks_text(self._live.session.task, self.tr)):
                yield Static(marks, classes="muted", markup=False)
            choices = OptionList(id="changes", markup=False)
            yield choices
            yield Static("", id="asked", markup=False)
            yield Input(id="value", max_length=_LONGEST_NOTE)
            yield Static("", id="problem", markup=False)
            yield Static("", id="undo", classes="muted", markup=False)

    def on_mount(self) -> None:
        self.query_one(Input).display = False
        self._list_changes()
        self._live.session.bus.tap(self._heard)

    def on_unmount(self) -> None:
        self._live.session.bus.untap(self._heard)
        self._stop_timer()

    def on_screen_resume(self) -> None:
        """Close after another screen covered this one while the session went on."""
        if self._has_gone_on:
            self.dismiss()

    def _heard(self, cascade: list[Record]) -> None:
        """Show the changes that have been made, here or by an operator."""
        if not self.is_attached:
            return
        if any(
            isinstance(each.message, Waiting) and each.message.stage != "paused" for each in cascade
        ):
            self._has_gone_on = True  # by an operator: the participant must see the screen below
            self.dismiss()
        elif any(record.topic in (COMMAND, SETTING, NOTE_ADDED) for record in cascade):
            self._list_changes()
            self._offer_undo()

    def _offer_undo(self) -> None:
        """Name the key that takes back the last change, until it is too late."""
        if not self.is_attached:
            return
        self._stop_timer()
        done = self._live.session.undoable(ACTOR)
        if done:
            self._timer = self._live.clock.call_at(done.until + 1, self._offer_undo)
        text = self.tr("Ctrl-Z takes the last change back.") if done else ""
        self.query_one("#undo", Static).update(text)

    def _stop_timer(self) -> None:
        if self._timer:
            self._timer.cancel()
            self._timer = None

    def action_undo(self) -> None:
        """Take back the last change."""
        self.query_one("#problem", Static).update("")
        self._live.undo(ACTOR)

    def _list_changes(self) -> None:
        choices, tr, next_ = (
            self.query_one("#changes", OptionList),
            self.tr,
            self._live.session.next_attempt,
        )
        chosen = choices.highlighted_option.id if choices.highlighted_option else None
        choices.border_title = tr("level {level}", level=next_.level).capitalize()
        if next_.is_level_held:
            choices.border_title += f" · {tr('held')}"
        rest = [Option(tr("End the rest"), id="end rest")] if self._live.session.is_resting else []
        choices.clear_options()
        choices.add_options(
            [
                *rest,
                Option(tr("Level up"), id="up", disabled=next_.level >= next_.highest),
                Option(tr("Level down"), id="down", disabled=next_.level <= next_.lowest),
                Option(tr("Let the level change again"), id="release")
                if next_.is_level_held
                else Option(tr("Hold the level"), id="hold"),
                *(
                    Option(self._setting(name, next_.settings[name]), id=name)
                    for name in self._settings
                ),
                Option(tr("Write a note"), id="note"),
                Option(tr("Stop, and go on later"), id="leave"),
                Option(tr("Back"), id="back"),
            ]
        )
        places = [option.id for option in choices.options]
        same = {"hold": "release", "release": "hold"}.get(chosen or "", chosen)
        at = next((places.index(name) for name in (chosen, same) if name in places), 0)
        enabled = [index for index, option in enumerate(choices.options) if not option.disabled]
        choices.highlighted = at if at in enabled else enabled[0]

    def _setting(self, name: str, value: float) -> str:
        if name == GOAL:
            return self.tr("Goal: {goal}", goal=self._goal_text(value))
        if value == 1:
            return self.tr("Feedback: after every attempt")
        return self.tr("Feedback: after every {count} attempts", count=int(value))

    @on(OptionList.OptionSelected, "#changes")
    def _chosen(self, event: OptionList.OptionSelected) -> None:
        event.stop()
        level = self._live.session.next_attempt.level
        match event.option.id:
            case "up" | "down" as way:
                self._command("level", level + (1 if way == "up" else -1))
            case "end rest":
                self._command("skip", reason="rest")
                self._command("resume")
            case "hold":
                self._command("hold")
            case "release":
                self._command("release")
            case "leave":
                self.dismiss(True)
            case "back":
                self.action_back()
            case asked:
                self._ask(asked or "")

    # --- the goal, whose times are in seconds here

    @property
    def _goal(self) -> Field:
        return next(
            field for field in fields(self._live.session.task.Parameters) if field.name == GOAL
        )

    @property
    def _is_goal_time(self) -> bool:
        return (self._goal.unit or self._live.session.task.metric.unit) == "ms"

    @property
    def _goal_unit(self) -> str:
        return "s" if self._is_goal_time else self._goal.unit or self._live.session.task.metric.unit

    def _goal_text(self, value: float) -> str:
        metric = self._live.session.task.metric
        if self._is_goal_time and metric.unit == "ms":
            return goal_text(metric, value, self.tr)
        return self.tr.figures(f"{value / self._stored_size(GOAL):g} {self._goal_unit}".rstrip())

    def _stored_size(self, name: str) -> int:
        """Return the stored value of 1 in the field."""
        return 1000 if name == GOAL and self._is_goal_time else 1

    def _stored(self, text: str) -> str:
        """Return a typed value as it is stored."""
        try:
            number = float(text.replace(",", "."))
        except ValueError:
            return text
        return (
            text
            if self._stored_size(self._asked) == 1
            else f"{number * self._stored_size(self._asked):.10g}"
        )

    def _problem(self, error: str) -> str:
        """Return why a value is refused, in the unit of the field."""
        if self._stored_size(self._asked) == 1:
            return error
        low, high = (
            (bound or 0) / self._stored_size(GOAL) for bound in (self._goal.ge, self._goal.le)
        )
        return self.tr(
            "The goal is a number of seconds, {low} to {high}.", low=f"{low:g}", high=f"{high:g}"
        )

    def _command(self, command: str, value: int | None = None, reason: str = "") -> None:
        act = SessionCommand(command=command, actor=ACTOR, value=value, reason=reason)  # type: ignore[arg-type]
        self._live.operate(act)

    # --- a value or a note

    def _ask(self, what: str) -> None:
        """Open the field for a setting or a note."""
        self._asked = what
        texts = {
            GOAL: "The new goal",
            FEEDBACK_EVERY: "Feedback after every … attempts",
            "note": "The note",
        }
        unit = f" ({self._goal_unit})" if what == GOAL else ""
        self.query_one("#asked", Static).update(f"{self.tr(texts[what])}{unit}")
        now = self._live.session.next_attempt.settings
        value = self.query_one(Input)
        value.value = f"{now[what] / self._stored_size(what):g}" if what in now else ""
        value.display = True
        value.focus()

    @on(Input.Submitted)
    def _entered(self, event: Input.Submitted) -> None:
        event.stop()
        text, bus = event.value.strip(), self._live.session.bus
        if text and self._asked == "note":
            bus.post(
                NOTE_ADDED, NoteAdded(text=visible(text), actor=ACTOR, at=self._live.clock.now())
            )
        elif text:
            try:
                changed = with_setting(
                    self._live.session.task.parameters, self._asked, self._stored(text)
                )
            except ParameterError as error:
                self.query_one("#problem", Static).update(
                    self._problem(in_language(error, self.tr))
                )
                return
            value = getattr(changed, self._asked)
            bus.post(
                SETTING,
                SettingChanged(
                    name=self._asked, value=value, actor=ACTOR, at=self._live.clock.now()
                ),
            )
        self._close_field()
        if text and self._asked == "note":
            self.query_one("#problem", Static).update(self.tr("The note is kept."))

    def _close_field(self) -> None:
        value = self.query_one(Input)
        value.value, value.display = "", False
        for name in ("#asked", "#problem"):
            self.query_one(name, Static).update("")
        self.query_one("#changes").focus()

    def action_back(self) -> None:
        """Close the field, else the screen."""
        if self.query_one(Input).display:
            self._close_field()
        else:
            self.dismiss()
