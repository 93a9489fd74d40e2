"""Settings: the therapist's form, made from the task's declaration."""

import functools
from collections.abc import Iterable
from typing import Any, ClassVar

from textual import on, work
from textual.app import ComposeResult
from textual.binding import ActiveBinding, Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widgets import Button, Static
from textual.widgets.option_list import Option

from sar_tui.drivers.login_name import login_name
from sar_tui.loop.task import Task
from sar_tui.model.language import Language, language
from sar_tui.plugin_calls import PLUGIN_ERRORS
from sar_tui.plugins import PluginError, task_folder
from sar_tui.rules.declaration import COMMON, ParameterError, show, translated
from sar_tui.rules.parameters import (
    TaskParameters,
    build,
    changed,
    changes,
    grouped,
)
from sar_tui.rules.policies import without_effect
from sar_tui.runs.plan import Failed, check_outputs, set_up
from sar_tui.store import programmes
from sar_tui.store.database import StoreError
from sar_tui.store.programmes import Programme
from sar_tui.theme_folder import languages
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.language import app_language
from sar_tui.tui.language import translated as translated_keys
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.lists import OptionList
from sar_tui.widgets.parameter_field import ParameterField

_LEVELS = ("start_level", "min_level", "max_level")
"""Parameters that are levels: their help says what the level is."""
_COUNT = 4
"""Columns for the number of settings that differ."""
_HELP = (
    "The groups at the left count the settings that differ from the defaults (●) or must be fixed "
    "(!). A setting "
    "marked – has no effect with the rule that is chosen. Below the fields: what the focused one "
    "means, and the values "
    "it may have.",
    "Page Down and Page Up go from group to group, the arrows from field to field. / finds a "
    "setting by a word (F3 "
    "where a text is typed). Ctrl-R resets a setting; on a group, all its settings.",
    "Nothing is saved until you save, with a reason: the next session then runs with the new "
    "version. Earlier versions "
    "are kept.",
)


class SettingsScreen(DismissedOnce[None]):
    """Groups at the left, the fields of one group at the right, the help of the focused field
    below.
    """

    AUTO_FOCUS = "ParameterField Input, ParameterField Choice"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+s", "save", "Save", id="save"),
        Binding("slash,f3", "find", "Find", id="find"),
        Binding("ctrl+r", "reset", "Reset", id="reset"),
        Binding("escape", "leave", "Back", show=False, id="leave"),
        Binding("down", "app.focus_next", "Next", show=False, id="down"),
        Binding("up", "app.focus_previous", "Previous", show=False, id="up"),
        Binding("pagedown", "group(1)", "Next group", show=False, priority=True, id="next-group"),
        Binding(
            "pageup", "group(-1)", "Previous group", show=False, priority=True, id="previous-group"
        ),
    ]

    app: Any

    def __init__(self, participant: str, task: type[Task]) -> None:
        super().__init__()
        self._participant = participant
        self._motor_task = task
        self._programme = programmes.newest(
            self.app.database, self._participant, self._motor_task.name
        )
        self._panels: list[FieldPanel] = []
        self._fields: list[ParameterField] = []
        self._warning = ""

    @functools.cached_property
    def tr(self) -> Language:
        """The language of the saved sessions: the form is in it, too."""
        code = str(self._programme.parameters.get("language", Language().code))
        own = language(code, COMMON, task_folder(self._motor_task))
        return app_language(code, own.texts)

    @property
    def help_text(self) -> str:
        """Help on the marks, the keys and saving."""
        return "\n\n".join(self.tr(paragraph) for paragraph in _HELP) + "\n"

    @property
    def active_bindings(self) -> dict[str, ActiveBinding]:
        return translated_keys(super().active_bindings, self.tr)

    def compose(self) -> ComposeResult:
        parameters, tr = self._motor_task.Parameters, self.tr
        values = self._programme.parameters
        known = {"language": self._languages(), "outputs": _outputs()}
        for heading, declared in grouped(parameters).items():
            made = [
                ParameterField(
                    translated(field, tr),
                    values.get(field.name, field.default),
                    known.get(field.name, ()),
                    tr,
                )
                for field in declared
            ]
            self._fields += made
            self._panels.append(
                FieldPanel(tr(heading) if heading else tr(self._motor_task.title), made)
            )
        self._saved = self._shown()
        yield Static(self._title(), id="top", markup=False)
        with Horizontal(id="form"):
            yield OptionList(
                *(Option(panel.title) for panel in self._panels),
                id="groups",
                markup=False,
                compact=True,
            )
            with Vertical(id="fields"):
                yield from self._panels
                yield Static("", id="meaning", markup=False)
        with Horizontal(id="buttons"):
            yield Static("", id="status", markup=False)
            yield Button(tr("Save"), id="save", variant="primary", compact=True)
            yield Button(tr("Preset"), id="preset", compact=True)
            yield Button(tr("Reset all"), id="reset-all", compact=True)
            yield Button(tr("Back"), id="back", compact=True)
        yield KeyFooter()

    async def on_mount(self) -> None:
        await self._show_group(0)
        await self._check()
        if gone := self._programme.parameters.keys() - {
            widget.field.name for widget in self._fields
        }:
            names = ", ".join(sorted(gone))
            self.notify(
                f"These settings do not exist any more: {names}.", severity="warning", timeout=15
            )

    def _title(self) -> str:
        version = self._programme.version
        saved = self.tr("version {number}", number=version) if version else self.tr("defaults")
        title = self.tr(self._motor_task.title)
        return self.tr(
            "Settings of {who} for {task}: {saved}", who=self._participant, task=title, saved=saved
        )

    # --- values

    def _values(self) -> dict[str, object]:
        return {widget.field.name: widget.value for widget in self._fields}

    def _shown(self) -> list[str]:
        return [show(widget.value) for widget in self._fields]

    @on(ParameterField.Changed)
    async def _check(self) -> None:
        """Check each value, and all of them together, because valid values may conflict."""
        problems, unused = self._problems(), without_effect(self._values())
        for widget in self._fields:
            widget.show_problem(
                problems.get(widget.field.name, ""), unused.get(widget.field.name, "")
            )
        self._count()
        self._show_help()
        unsaved = self.tr("not saved") if self._shown() != self._saved else ""
        wrong = self.tr("{count} to fix", count=len(problems))
        self.query_one("#status", Static).update(wrong if problems else unsaved)

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
        """Return a problem if the participant's theme has no phrases in this language: a session
        would be refused.
        """
        known = self._languages()
        if not known or language.partition("-")[0] in {name.partition("-")[0] for name in known}:
            return {}
        has = (
            f"The theme {self._programme.theme} has no phrases in {language}; it has: "
            f"{', '.join(known)}."
        )
        return {
            "language": f"{has} Choose one of these, or give the theme a file "
            f"phrases.{language}.toml."
        }

    def _languages(self) -> tuple[str, ...]:
        """Return the languages of the theme; none if the theme is gone, as another must be chosen
        anyway.
        """
        try:
            return languages(self.app.catalogue.theme_folder(self._programme.theme))
        except PluginError:
            return ()

    # --- groups and help

    @property
    def _group(self) -> int:
        return self.query_one("#groups", OptionList).highlighted or 0

    async def _show_group(self, at: int) -> None:
        for index, panel in enumerate(self._panels):
            await panel.show(index == at)
        self.query_one("#groups", OptionList).highlighted = at

    @on(OptionList.OptionHighlighted, "#groups")
    async def _group_highlighted(self, event: OptionList.OptionHighlighted) -> None:
        await self._show_group(event.option_index)
        self._show_help()

    @on(OptionList.OptionSelected, "#groups")
    def _group_selected(self, event: OptionList.OptionSelected) -> None:
        self._panels[event.option_index].fields[0].focus_editor()

    def _count(self) -> None:
        """Show beside each group how many of its settings differ, or must be fixed."""
        groups = self.query_one("#groups", OptionList)
        width = max(len(panel.title) for panel in self._panels)
        for at, panel in enumerate(self._panels):
            style = "$warning" if panel.summary.startswith("!") else "$accent"
            line = Content.assemble(f"{panel.title:{width}} ", (f"{panel.summary:{_COUNT}}", style))
            groups.replace_option_prompt_at_index(at, line)

    @on(ParameterField.Focused)
    def _show_help(self) -> None:
        """Show what the focused field means; without one, what the group holds."""
        focused = next((widget for widget in self._fields if widget.has_focus_within), None)
        panel = self._panels[self._group]
        text = self.tr("{count} settings. Enter goes to them.", count=len(panel.fields))
        if focused:
            text = " ".join(filter(None, (focused.note, self._level(focused))))
        self.query_one("#meaning", Static).update(text)

    def _level(self, field: ParameterField) -> str:
        """Return what the level of a field is: "Level 5: asdfjkl;"; empty for other fields."""
        if field.field.name not in _LEVELS or field.problem:
            return ""
        try:
            task = self._motor_task(build(self._motor_task.Parameters, self._values()))
            level = min(int(show(field.value)), task.levels)
            name = task.level_name(level)
        except (ParameterError, *PLUGIN_ERRORS):
            return ""
        return self.tr("Level {level}: {name}", level=level, name=name) if name else ""

    def action_group(self, step: int) -> None:
        """Go to the first field of the next or previous group."""
        self._go_to_group((self._group + step) % len(self._panels))

    @work(exclusive=True, group="go")
    async def _go_to_group(self, at: int) -> None:
        await self._show_group(at)
        self._panels[at].fields[0].focus_editor()

    @work(exclusive=True, group="go")
    async def _go_to(self, name: str) -> None:
        """Put the cursor into a field."""
        for at, panel in enumerate(self._panels):
            for widget in panel.fields:
                if widget.field.name == name:
                    await self._show_group(at)
                    widget.focus_editor()

    def action_find(self) -> None:
        """Find a setting by a word, and go to it."""
        from sar_tui.app.screens.settings_dialogs import FindSettingScreen

        def found(name: str | None) -> None:
            if name:
                self._go_to(name)

        declared = [widget.field for widget in self._fields]
        self.app.push_screen(
            FindSettingScreen(declared, self.tr(self._motor_task.title), self.tr), found
        )

    # --- saving

    @on(Button.Pressed, "#save")
    def action_save(self) -> None:
        """Ask for a reason, and save the settings if all are valid and some differ."""
        if problems := self._problems():
            self._go_to(next(iter(problems)))
            return
        parameters = build(self._motor_task.Parameters, self._values())
        wanted = changed(parameters)
        made = changes(self._motor_task.Parameters, self._programme.parameters, wanted, self.tr)
        if not made:
            self.query_one("#status", Static).update(self.tr("nothing has changed"))
            return
        from sar_tui.app.screens.settings_dialogs import Reason, SaveReasonScreen

        def answered(reason: Reason | None) -> None:
            if reason:
                self._save(parameters, reason.reason, reason.author)

        warning, self._warning = self._warning, ""
        asked = SaveReasonScreen([change.text for change in made], login_name(), warning, self.tr)
        self.app.push_screen(asked, answered)

    def _save(self, parameters: TaskParameters, reason: str, author: str) -> None:
        status = self.query_one("#status", Static)
        wanted = Programme(changed(parameters), self._programme.theme)
        try:
            self._programme = programmes.save(
                self.app.database,
                self._participant,
                self._motor_task.name,
                wanted,
                after=self._programme.version,
                author=author,
                reason=reason,
            )
        except programmes.Superseded as error:
            self._warning = str(error)
            self._programme = error.newest
            status.update(self.tr("not saved"))
            again = self.tr(
                "Save again to see what differs from it, and to put yours on top of it."
            )
            self.notify(f"{error} {again}", severity="warning", timeout=30)
            return
        except StoreError as error:
            status.update(self.tr("not saved"))
            self.notify(str(error), severity="error", timeout=15)
            return
        self._saved = self._shown()
        self.query_one("#top", Static).update(self._title())
        status.update(self.tr("saved: version {number}", number=self._programme.version))
        self.query_one("#meaning", Static).update(self._next_start(parameters))

    def _next_start(self, parameters: TaskParameters) -> str:
        """Say where the next session starts, and why."""
        from sar_tui.runs.start_level import LOOKED_AT, start_after
        from sar_tui.store.results import newest_of

        try:
            task = set_up(self._motor_task, parameters)
            start = start_after(
                task, newest_of(self.app.database, self._participant, task.name, LOOKED_AT)
            )
        except Failed as error:
            return str(error)
        why = f" ({self.tr(start.why)})" if start.why else ""
        return self.tr("The next session starts at level {level}{why}.", level=start.level, why=why)

    # --- presets, defaults, leaving

    @on(Button.Pressed, "#preset")
    def _choose_preset(self) -> None:
        """Fill in the values of a preset. Nothing is saved."""
        from sar_tui.app.screens.settings_dialogs import ChoosePresetScreen
        from sar_tui.runs.programme_file import ProgrammeFile, applied, files, find, not_applied

        presets: dict[str, ProgrammeFile] = {}
        for name in files(self.app.folder, self._motor_task):
            try:
                presets[name] = find(self.app.folder, self._motor_task, name)
            except StoreError as error:
                self.notify(str(error), severity="warning", timeout=15)

        async def chosen(name: str | None) -> None:
            if name:
                values = applied(self._motor_task, presets[name], self._values())
                for widget in self._fields:
                    widget.set_value(values[widget.field.name])
                await self._check()
                if stay := not_applied(self._motor_task, presets[name]):
                    names = ", ".join(translated(field, self.tr).title for field in stay)
                    told = self.tr(
                        "The preset also names what belongs to the person or the place, and "
                        "stays: {names}.",
                        names=names,
                    )
                    self.notify(told, severity="warning", timeout=15)

        if presets:
            summaries = {
                name: preset.summary or self.tr("one of your own")
                for name, preset in presets.items()
            }
            self.app.push_screen(ChoosePresetScreen(summaries, self.tr), chosen)
        else:
            self.notify(
                self.tr("The task {task} has no presets.", task=self.tr(self._motor_task.title))
            )

    async def action_reset(self) -> None:
        """Reset the focused field to its default, or all fields of the focused group."""
        is_group = self.query_one("#groups").has_focus
        for panel in self._panels:
            for widget in panel.fields:
                if widget.has_focus_within or (is_group and panel is self._panels[self._group]):
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
        """Return True if nothing is unsaved, or the changes may be discarded; else ask for a second
        press.
        """
        if self._shown() == self._saved:
            return True
        self._saved = self._shown()
        warning = self.tr("Not saved. Save with Ctrl-S, or leave again to discard the changes.")
        self.notify(warning, severity="warning")
        return False


def _outputs() -> tuple[str, ...]:
    """Return the outputs that need nothing after their name."""
    from sar_tui.outputs.outputs import output_names

    known = output_names()
    return tuple(name for name in ("screen", "speech", "tones", "servo") if name in known)


class FieldPanel(VerticalScroll, can_focus=False, inherit_bindings=False):
    """Fields, which are mounted when the panel is first shown. Page keys are left to the screen.

    Args:
        title: of the heading.
        fields: under it.
    """

    DEFAULT_CSS = "FieldPanel { display: none; height: 1fr; }"

    def __init__(self, title: str, fields: Iterable[ParameterField]) -> None:
        super().__init__()
        self.title = title
        self.fields = tuple(fields)

    def compose(self) -> ComposeResult:
        """Compose nothing: see `show`."""
        return iter(())

    async def show(self, shown: bool) -> None:
        """Show the fields, or hide them."""
        if shown and self.fields and not self.fields[0].is_attached:
            await self.mount(*self.fields)
        self.display = shown

    @property
    def summary(self) -> str:
        """Number of fields that have problems ("! 2") or differ from their defaults ("● 3"); else
        empty.
        """
        if wrong := sum(bool(field.problem) for field in self.fields):
            return f"! {wrong}"
        differing = sum(field.is_changed for field in self.fields)
        return f"● {differing}" if differing else ""

    def on_resize(self) -> None:
        """Keep the focused field in view in a smaller window."""
        for field in self.fields:
            if field.has_focus_within:
                self.call_after_refresh(field.scroll_visible, animate=False, immediate=True)
