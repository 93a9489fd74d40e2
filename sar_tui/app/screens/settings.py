"""Settings: the therapist's form, made from the task's declaration."""

from typing import Any, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, VerticalScroll
from textual.screen import Screen
from textual.widgets import Button, Static

from sar_tui.drivers.login_name import login_name
from sar_tui.framework.declaration import ParameterError, show
from sar_tui.framework.parameters import build, changed, current_values, grouped
from sar_tui.framework.task import Task
from sar_tui.plugins import PluginError
from sar_tui.runs.plan import check_outputs
from sar_tui.store import programmes
from sar_tui.store.database import StoreError
from sar_tui.theme_folder import languages
from sar_tui.widgets.field_group import FieldGroup
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.parameter_field import ParameterField

_FOLDED = ("Operator", "Timing")
"""Headings that are folded at first, because few sessions need them."""


class _Form(VerticalScroll, can_focus=False, inherit_bindings=False):
    """The headings and their fields. Page keys are left to the screen, which moves by headings."""

    def on_resize(self) -> None:
        """Keep the focused field or heading in view in a smaller window."""
        if (focused := self.screen.focused) and self in focused.ancestors:
            shown = next((each for each in focused.ancestors if isinstance(each, ParameterField)), focused)
            self.call_after_refresh(shown.scroll_visible, animate=False, immediate=True)


class SettingsScreen(Screen[None]):
    """One field for each parameter, under headings; saved for this participant's next sessions."""

    help_text = (
        "Each setting shows its meaning, its unit and the values it may have. "
        "A dot marks a value that differs from the default. Nothing is saved until you save.\n\n"
        "Page Down and Page Up go from heading to heading. Enter opens a heading, or folds it; "
        "Ctrl-R on a heading resets all under it.\n"
    )
    AUTO_FOCUS = "ParameterField Input, ParameterField Choice"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+s", "save", "Save", id="save"),
        Binding("ctrl+r", "reset", "Reset this", id="reset"),
        Binding("escape", "leave", "Back", id="leave"),
        Binding("down", "app.focus_next", "Next", show=False, id="down"),
        Binding("up", "app.focus_previous", "Previous", show=False, id="up"),
        Binding("pagedown", "heading(1)", "Next heading", show=False, id="next-heading"),
        Binding("pageup", "heading(-1)", "Previous heading", show=False, id="previous-heading"),
    ]

    app: Any

    def __init__(self, participant: str, task: type[Task]) -> None:
        super().__init__()
        self._participant = participant
        self._motor_task = task
        self._groups: list[FieldGroup] = []
        self._fields: list[ParameterField] = []

    def compose(self) -> ComposeResult:
        self._programme = kept = programmes.newest(self.app.database, self._participant, self._motor_task.name)
        yield Static(f"Settings of {self._participant} for {self._motor_task.title}", id="top", markup=False)
        with _Form(id="form"):
            values = current_values(self._motor_task.Parameters, kept.parameters)
            for heading, fields in grouped(self._motor_task.Parameters).items():
                made = [ParameterField(field, values.get(field.name, field.default)) for field in fields]
                self._fields += made
                self._groups.append(FieldGroup(heading or self._motor_task.title, made, folded=heading in _FOLDED))
            yield from self._groups
        self._saved = self._shown()
        with Horizontal(id="buttons"):
            yield Static("", id="status", markup=False)
            yield Button("Save", id="save", variant="primary", compact=True)
            yield Button("Reset all", id="reset-all", compact=True)
            yield Button("Back", id="back", compact=True)
        yield KeyFooter()

    async def on_mount(self) -> None:
        await self._check()

    def _values(self) -> dict[str, object]:
        return {widget.field.name: widget.value for widget in self._fields}

    def _shown(self) -> list[str]:
        return [show(widget.value) for widget in self._fields]

    @on(ParameterField.Changed)
    async def _check(self) -> None:
        """Check each value, and all of them together, because valid values may conflict."""
        problems = self._problems()
        for widget in self._fields:
            widget.show_problem(problems.get(widget.field.name, ""))
        for group in self._groups:
            await group.update()
        unsaved = "not saved" if self._shown() != self._saved else ""
        self.query_one("#status", Static).update(f"{len(problems)} to fix" if problems else unsaved)

    def _problems(self) -> dict[str, str]:
        try:
            parameters = build(self._motor_task.Parameters, self._values())
            if seats := self._motor_task.sensor_seats(parameters):
                from sar_tui.runs.sensors import check_sensors

                check_sensors(parameters, seats)
            check_outputs(parameters)
        except ParameterError as error:
            return error.problems
        return self._language_problem(parameters.language)

    def _language_problem(self, language: str) -> dict[str, str]:
        """Return a problem if the participant's theme has no phrases in this language: a session would be refused."""
        try:
            known = languages(self.app.catalogue.theme_folder(self._programme.theme))
        except PluginError:
            return {}  # the theme is gone, so another must be chosen anyway
        if language.partition("-")[0] in {name.partition("-")[0] for name in known}:
            return {}
        has = f"The theme {self._programme.theme} has no phrases in {language}; it has: {', '.join(known)}."
        return {"language": f"{has} Type one of these, or give the theme a file phrases.{language}.toml."}

    @on(Button.Pressed, "#save")
    async def action_save(self) -> None:
        """Save the settings if all are valid."""
        if problems := self._problems():
            await self._go_to(next(iter(problems)))
            return
        parameters = build(self._motor_task.Parameters, self._values())
        kept = programmes.Programme(changed(parameters), self._programme.theme)
        after = self._programme.version
        try:
            self._programme = programmes.save(
                self.app.database, self._participant, self._motor_task.name, kept, after=after, author=login_name()
            )
        except programmes.Superseded as error:
            self._programme = error.newest
            self.notify(f"{error} Save again to put yours on top of it.", severity="warning", timeout=30)
            return
        except StoreError as error:
            self.query_one("#status", Static).update("not saved")
            self.notify(str(error), severity="error", timeout=15)
            return
        self._saved = self._shown()
        self.query_one("#status", Static).update(f"saved for {self._participant}")

    async def _go_to(self, name: str) -> None:
        """Put the cursor into a field, and unfold its heading."""
        for group in self._groups:
            for widget in group.fields:
                if widget.field.name == name:
                    await group.fold(False)
                    self.call_after_refresh(widget.focus_editor)

    def action_heading(self, step: int) -> None:
        """Go to the next heading; or back to the focused field's own heading, and from there to the previous one."""
        end = len(self._groups)
        here = next((at for at, group in enumerate(self._groups) if group.has_focus_within), end)
        if step < 0 and here < end and not self._groups[here].heading.has_focus:
            step = 0
        self._groups[max(0, min(here + step, end - 1))].go_to()

    async def action_reset(self) -> None:
        """Reset the focused field to its default, or all fields under the focused heading."""
        for group in self._groups:
            for widget in group.fields:
                if widget.has_focus_within or group.heading.has_focus:
                    widget.reset()
        await self._check()

    @on(Button.Pressed, "#reset-all")
    async def _reset_all(self) -> None:
        for widget in self._fields:
            widget.reset()
        await self._check()

    @on(Button.Pressed, "#back")
    def action_leave(self) -> None:
        """Go back; ask for a second press if there are unsaved changes."""
        if self.may_quit():
            self.dismiss()

    def may_quit(self) -> bool:
        """Return True if nothing is unsaved, or the changes may be discarded; else ask for a second press."""
        if self._shown() == self._saved:
            return True
        self._saved = self._shown()
        self.notify("Not saved. Save with Ctrl-S, or leave again to discard the changes.", severity="warning")
        return False
