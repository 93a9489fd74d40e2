"""Settings: the therapist's form, made from the task's declaration."""

from typing import Any, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, VerticalScroll
from textual.screen import Screen
from textual.widgets import Button, Footer, Static

from sar_tui.framework.parameters import ParameterError, build, changed, fields
from sar_tui.framework.task import Task
from sar_tui.plugins import PluginError
from sar_tui.runs import check_outputs
from sar_tui.store import participants
from sar_tui.store.database import StoreError
from sar_tui.theme_folder import languages
from sar_tui.widgets.parameter_field import ParameterField


class SettingsScreen(Screen[None]):
    """One field for each parameter; kept for this participant, and used by their next session."""

    help_text = (
        "Each setting says what it means, its unit, and what it may be.\n"
        "A dot marks what differs from the default. Nothing is kept until you save.\n"
    )
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+s", "save", "Save", id="save"),
        Binding("ctrl+r", "reset", "Reset this", id="reset"),
        Binding("escape", "leave", "Back", id="leave"),
        Binding("down", "app.focus_next", "Next", show=False, id="down"),
        Binding("up", "app.focus_previous", "Previous", show=False, id="up"),
    ]

    app: Any

    def __init__(self, participant: str, task: type[Task]) -> None:
        super().__init__()
        self._participant = participant
        self._motor_task = task

    def compose(self) -> ComposeResult:
        kept = participants.settings(self.app.database, self._participant, self._motor_task.name)
        self._theme = kept.theme
        yield Static(f"Settings of {self._participant} for {self._motor_task.title}", id="top", markup=False)
        with VerticalScroll(id="form", can_focus=False):
            for field in fields(self._motor_task.Parameters):
                yield ParameterField(field, kept.parameters.get(field.name, field.default))
        with Horizontal(id="buttons"):
            yield Static("", id="status", markup=False)
            yield Button("Save", id="save", variant="primary", compact=True)
            yield Button("Reset all", id="reset-all", compact=True)
            yield Button("Back", id="back", compact=True)
        yield Footer()

    def on_mount(self) -> None:
        self._saved = self._values()

    def _values(self) -> dict[str, object]:
        return {widget.field.name: widget.value for widget in self.query(ParameterField)}

    @on(ParameterField.Changed)
    def _check(self) -> None:
        """Each by itself, and all together: settings that are each right may not go together."""
        problems = self._problems()
        for widget in self.query(ParameterField):
            widget.tell(problems.get(widget.field.name, ""))
        unsaved = "not saved" if self._values() != self._saved else ""
        self.query_one("#status", Static).update(f"{len(problems)} to mend" if problems else unsaved)

    def _problems(self) -> dict[str, str]:
        try:
            parameters = build(self._motor_task.Parameters, self._values())
            if self._motor_task.sensors:
                from sar_tui.sensing import check_sensor

                check_sensor(parameters)
            check_outputs(parameters)
        except ParameterError as error:
            return error.problems
        return self._language_problem(parameters.language)

    def _language_problem(self, language: str) -> dict[str, str]:
        """A language that the participant's theme has nothing of: a session would be refused."""
        try:
            known = languages(self.app.catalogue.theme_folder(self._theme))
        except PluginError:
            return {}  # the theme is gone, and another has to be chosen anyway
        if language.partition("-")[0] in {name.partition("-")[0] for name in known}:
            return {}
        has = f"The theme {self._theme} has no {language}; it has: {', '.join(known)}."
        return {"language": f"{has} Type one of these, or give the theme a file phrases.{language}.toml."}

    @on(Button.Pressed, "#save")
    def action_save(self) -> None:
        """Keep the settings, if they can be."""
        if problems := self._problems():
            name = next(iter(problems))
            self.query_one(f"#parameter-{name}").query_one("Input, Select").focus()
            return
        parameters = build(self._motor_task.Parameters, self._values())
        theme = participants.settings(self.app.database, self._participant, self._motor_task.name).theme
        kept = participants.Settings(changed(parameters), theme)
        try:
            participants.save_settings(self.app.database, self._participant, self._motor_task.name, kept)
        except StoreError as error:
            self.query_one("#status", Static).update("not saved")
            self.notify(str(error), severity="error", timeout=15)
            return
        self._saved = self._values()
        self.query_one("#status", Static).update(f"saved for {self._participant}")

    def action_reset(self) -> None:
        """Put back the default of the field that has the focus."""
        for widget in self.query(ParameterField):
            if widget.has_focus_within:
                widget.reset()

    @on(Button.Pressed, "#reset-all")
    def _reset_all(self) -> None:
        for widget in self.query(ParameterField):
            widget.reset()

    @on(Button.Pressed, "#back")
    def action_leave(self) -> None:
        """Go back; ask for a second press if something was not saved."""
        if self._values() == self._saved:
            self.dismiss()
        else:
            self._saved = self._values()
            self.notify("Not saved yet. Save with Ctrl-S, or go back once more to leave it.", severity="warning")
