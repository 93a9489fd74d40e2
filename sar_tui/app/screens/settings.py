"""Settings: the therapist's form, made from the task's declaration, with difficulty first."""

import asyncio
import functools
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from textual import on, work
from textual.app import ComposeResult, SystemCommand
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.events import Resize
from textual.widgets import Static
from textual.widgets.option_list import Option

from sar_tui.app.settings.preview import PreviewPane, Previews, sparkline
from sar_tui.app.settings.rules import Picture, RuleField, rules
from sar_tui.drivers.login_name import login_name
from sar_tui.loop.task import Task
from sar_tui.model.language import Language, in_language, joined, language
from sar_tui.model.theme import Theme
from sar_tui.plugin_calls import PLUGIN_ERRORS, describe
from sar_tui.plugins import DEFAULT_THEME, PluginError, task_folder
from sar_tui.rules.declaration import COMMON, Field, ParameterError, show, translated
from sar_tui.rules.parameters import (
    TaskParameters,
    build,
    changed,
    grouped,
    usable,
)
from sar_tui.rules.policies import BY_CHOICE, DIFFICULTY, without_effect
from sar_tui.rules.scanning import MOST, interval_ms
from sar_tui.runs.plan import Failed, check_outputs, set_up
from sar_tui.runs.preview import Preview
from sar_tui.store import programmes, sessions
from sar_tui.store.database import StoreError
from sar_tui.store.programmes import Programme
from sar_tui.theme_folder import languages
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.key_line import KeyLine
from sar_tui.tui.language import app_language
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.lists import MarkedList, OptionList
from sar_tui.widgets.parameter_field import CHANGED, UNSAVED, ParameterField

if TYPE_CHECKING:
    from sar_tui.progress.lines import SessionResults
    from sar_tui.runs.start_level import Start

_RULE = "difficulty_policy"
"""The setting that chooses a rule of difficulty. Its group comes first."""
_FIRST = (_RULE, "start_from", "start_level")
"""The first settings of that group."""
_START = "start_from"
"""The setting that chooses where a session starts."""
_LEVELS = ("start_level", "min_level", "max_level")
"""Parameters that are levels: their help says what the level is."""
_GOAL = ("threshold", "neutral_band", "min_accuracy")
"""Settings of the goal, which each rule uses."""
_EXAMPLE = tuple(level for level in range(1, 6) for _ in range(4))
"""Levels of the picture of a list of levels, as long as none is given."""
_COUNT = 4
"""Columns for the number of settings that differ."""
_NAMED = 4
"""Most settings that are named in a message."""
_PAUSE_S = 0.15
"""Seconds without a change after which a preview is played."""
_BESIDE = 130
"""Columns from which the preview stands beside the fields."""
_TALL = 40
"""Rows from which all rules are always shown, with their sentences."""


class SettingsScreen(DismissedOnce[None]):
    """Groups at the left; the fields of one group; below them, or beside, a preview of what they
    lead to. Beside it stands what the focused field means, too.

    Leaving saves nothing and asks nothing: unsaved values are kept while the program runs, and are
    there again when the settings of this person and task are opened.
    """

    AUTO_FOCUS = "RuleList"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "leave", "Back", id="leave"),
        Binding("tab", "app.focus_next", "Next field", id="next-field"),
        Binding("ctrl+s", "save", "Save", show=False, id="save"),
        Binding("slash,f3", "find", "Find", id="find"),
        Binding("ctrl+r", "reset", "Reset", show=False, id="reset"),
        Binding("f5", "versions", "Versions", id="versions"),
        Binding("f6", "presets", "Presets", id="presets"),
        Binding("f7", "discard", "Discard", show=False, id="discard"),
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
        self._previews: Previews | None = None
        self._set_aside: dict[str, object] = {}
        self._may_quit = False
        self._unplayable: set[str] = set()
        self._by_rule: dict[str, TaskParameters | None] = {}
        """The present parameters with each rule in place of the chosen one."""

    @functools.cached_property
    def tr(self) -> Language:
        """The language of the app, with the task's own texts."""
        code = self.app.tr.code
        own = language(code, COMMON, task_folder(self._motor_task))
        return app_language(code, own.texts)

    @property
    def help_text(self) -> str:
        """Help on the rules, the preview, the signs and saving."""
        tr = self.tr
        paragraphs = (
            tr(
                "First choose how the exercise follows the person: look at a rule with the "
                "arrows, and choose it with Enter. Below are only the settings that this rule "
                "uses."
            ),
            tr(
                "The preview is a simulation of 20 attempts. It plays anew after each change: ● "
                "the goal is reached, ○ it is not. Nothing of it is stored."
            ),
            self._about_numbers,
            tr(
                "◆ differs from what is saved, ● from the default, ! must be corrected. Page "
                "Down and Page Up go from group to group. / finds a setting by a word (F3 where "
                "a text is typed). Ctrl-R resets a setting; on a group, all its settings."
            ),
            tr(
                "Ctrl-S saves a new version, and asks why. Esc leaves without saving; F2 brings "
                "your changes back until you leave the program. F7 takes them away, and brings "
                "them back. F5 shows the earlier versions."
            ),
        )
        return "\n\n".join(paragraphs) + "\n"

    @property
    def _about_numbers(self) -> str:
        return self.tr(
            "Beside each rule are the levels of its attempts, and how many goals are reached. More "
            "goals reached is not better: a rule that follows the person makes it harder "
            "until about as many are reached as it aims at."
        )

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Show the key that discards changes if there are some, or if some were discarded."""
        if action == "discard":
            return bool(self._fields) and bool(self._unsaved() or self._set_aside)
        return super().check_action(action, parameters)

    def commands(self) -> Iterator[SystemCommand]:
        """Yield what the palette offers on this screen."""
        tr = self.tr
        yield SystemCommand(tr("Save"), tr("As a new version, with a reason"), self.action_save)
        yield SystemCommand(tr("Find"), tr("A setting by a word"), self.action_find)
        yield SystemCommand(tr("Versions"), tr("Look back, compare, go back"), self.action_versions)
        yield SystemCommand(tr("Presets"), tr("Fill in an exercise"), self.action_presets)
        yield SystemCommand(
            tr("Reset all"), tr("All settings to their defaults"), self.action_reset_all
        )
        if self.check_action("discard", ()):
            yield SystemCommand(
                tr("Discard"), tr("Take unsaved changes away, or back"), self.action_discard
            )
        for at, panel in enumerate(self._panels):
            yield SystemCommand(
                panel.title, panel.sentence, functools.partial(self._go_to_group, at)
            )

    def compose(self) -> ComposeResult:
        tr = self.tr
        self._make_fields()
        with Horizontal(id="top", classes="top-bar"):
            title = tr("{who}, {task}: settings", who=self._participant, task=self._title)
            yield Static(title, id="who", markup=False)
            yield Static("", id="version", markup=False)
        with Horizontal(id="form"):
            groups = (Option(panel.title) for panel in self._panels)
            yield MarkedList(*groups, id="groups", markup=False, compact=True)
            with Vertical(id="work"):
                with Vertical(id="fields"):
                    yield Static("", id="sentence", classes="sentence", markup=False)
                    yield from self._panels
                with Vertical(id="outcome"):
                    yield PreviewPane(self._participant, tr, id="preview")
                    yield Static("", id="note", markup=False)
        yield KeyLine(id="key")
        yield KeyFooter(show_command_palette=False, optional=("quit",))

    @property
    def _title(self) -> str:
        return self.tr(self._motor_task.title)

    def _make_fields(self) -> None:
        """Make the fields with the saved values, and those that were left unsaved."""
        saved, tr = self._programme.parameters, self.tr
        draft = self.app.settings_drafts.get(self._draft_key, {})
        known = {"language": self._languages(), "outputs": _outputs()}
        for heading, declared in grouped(self._motor_task.Parameters).items():
            made: list[ParameterField] = []
            for field in sorted(declared, key=_rank):
                own = translated(field, tr)
                before = saved.get(field.name, field.default)
                value = draft.get(field.name, before)
                made.append(
                    RuleField(own, value, before, tr)
                    if field.name == _RULE
                    else ParameterField(own, value, before, known.get(field.name, ()), tr)
                )
            self._fields += made
            title = tr(heading) if heading else self._title
            more = tr("more settings ↓")
            self._panels.append(FieldPanel(title, self._sentence_of(heading), made, more))
        self._panels.sort(key=lambda panel: self._rule not in panel.fields)

    @property
    def _rule(self) -> RuleField:
        return next(widget for widget in self._fields if isinstance(widget, RuleField))

    def _sentence_of(self, heading: str) -> str:
        tr = self.tr
        return {
            "": tr("What does the exercise ask for?"),
            "Session": tr("How much is done in a session?"),
            "Limits": tr("How much is enough?"),
            "Difficulty": tr("When does it get harder or easier for {who}?", who=self._participant),
            "Feedback": tr("What is said about results, and when?"),
            "Access": tr("How does the person answer and read?"),
            "Agent": tr("How does the agent appear?"),
            "Operator": tr("What does an operator decide?"),
            "Timing": tr("How long are the waits?"),
        }.get(heading) or tr(heading)

    async def on_mount(self) -> None:
        self._fit()
        await self._show_group(0)
        await self._check()
        self._tell_strange_values()
        self._is_of_clinic()
        if unsaved := self._unsaved():
            self.app.clear_notifications()  # that they were not saved
            back = self.tr("Back, and not saved: {names}.", names=self._named(unsaved))
            self.notify(f"{back} {self.tr('F7 discards that.')}")

    def _tell_strange_values(self) -> None:
        if gone := self._programme.parameters.keys() - {
            widget.field.name for widget in self._fields
        }:
            told = self.tr(
                "These settings do not exist any more: {names}.", names=", ".join(sorted(gone))
            )
            self.notify(told, severity="warning", timeout=15)

    def on_resize(self, event: Resize) -> None:
        """Put the preview beside the fields if there is room."""
        self._fit()
        self.call_after_refresh(self._place_key)

    def _fit(self) -> None:
        columns, rows = self.app.size
        self.set_class(columns >= _BESIDE, "-beside")
        self.set_class(rows >= _TALL, "-tall")
        self._rule.use_size(rows < _TALL)
        for widget in self._fields:
            widget.put_note_elsewhere(columns >= _BESIDE)
        self._show_preview_if_it_belongs()

    # --- values

    def _values(self) -> dict[str, object]:
        return {widget.field.name: widget.value for widget in self._fields}

    def _unsaved(self) -> dict[str, object]:
        """Return the values that differ from the saved ones."""
        return {widget.field.name: widget.value for widget in self._fields if widget.is_unsaved}

    def _named(self, values: Iterable[str]) -> str:
        """Return the titles of some settings: the first ones, if there are many."""
        names = set(values)
        titles = [widget.field.title for widget in self._fields if widget.field.name in names]
        more = ["…"] if len(titles) > _NAMED else []
        return ", ".join([*titles[:_NAMED], *more])

    def _fill(self, values: Mapping[str, object]) -> None:
        """Put values into their fields."""
        for widget in self._fields:
            if widget.field.name in values:
                widget.set_value(values[widget.field.name])

    @on(ParameterField.Changed)
    async def _check(self) -> None:
        """Check each value, and all of them together, because valid values may conflict."""
        self._may_quit = False
        self._by_rule = {}
        problems, unused = self._problems(), self._unused()
        for widget in self._fields:
            name = widget.field.name
            widget.more = "" if name in problems else self._level(widget) or self._scanning(widget)
            widget.show_problem(problems.get(name, ""), unused.get(name, ""))
        self.set_class(bool(self._rule.problem), "-no-rule")  # which leaves room to say why
        self._count()
        self._show_key()
        self._show_note()
        self.refresh_bindings()
        self._play_preview()

    def _show_key(self) -> None:
        """Show the one thing to do."""
        tr, key = self.tr, self.query_one("#key", KeyLine)
        to_fix = sum(bool(widget.problem) for widget in self._fields)
        unsaved = len(self._unsaved())
        if self.query_one("#groups").has_focus:
            key.show(self._about_group(), "Enter")
        elif self._rule.looked_at != show(self._rule.value):
            key.show(tr("Enter chooses this rule."), "Enter")
        elif to_fix:
            key.show(tr("Ctrl-S goes to what must be corrected (!)."), tr("Ctrl-S"))
        elif unsaved:
            saves = tr("Ctrl-S saves what you changed.")
            leaves = tr("Esc leaves without; F2 brings it back.")
            key.show(f"{saves} {leaves}", tr("Ctrl-S"))
        elif self._rule.has_focus_within:
            key.show(tr("Press ↑ ↓ to look at a rule, Enter to choose it."), "↑ ↓")
        else:
            key.show(tr("Esc goes back."), "Esc")
        self._place_key()
        version = self._programme.version
        name = tr("version {number}", number=version) if version else tr("defaults")
        saved = tr("saved") if version else ""
        changes = tr("{sign} {count} not saved", sign=UNSAVED, count=unsaved) if unsaved else saved
        where = "   ".join(filter(None, (changes, name)))
        self.query_one("#version", Static).update(where)

    def _place_key(self) -> None:
        """Put the key below the fields, in the middle; in that of the window if it is too long."""
        key, left = self.query_one("#key", KeyLine), self.query_one("#groups").outer_size.width
        has_room = len(key.text) + left < self.app.size.width
        key.styles.padding = (0, 0, 0, left if has_room else 0)

    def _about_group(self) -> str:
        """Say what Enter does on a group, and what the sign beside it means."""
        tr, panel = self.tr, self._panels[self._group]
        meanings = {
            "!": tr("to correct"),
            UNSAVED: tr("not saved"),
            CHANGED: tr("not the default"),
        }
        goes = tr("Enter goes to {group}.", group=panel.title)
        summary = panel.summary
        return f"{goes} {summary} {meanings[summary[0]]}." if summary else goes

    def on_descendant_focus(self) -> None:
        self._show_key()
        self._show_note()

    def _show_note(self) -> None:
        """Show what the focused field means, if there is room beside."""
        note = Content("")
        if self._rule.has_focus_within:
            note = self._about_rule
        for widget in self._fields:
            if widget.has_focus_within and widget is not self._rule:
                note = Content.assemble((widget.field.title, "bold"), "\n", widget.note)
        self.query_one("#note", Static).update(note)

    @property
    def _about_rule(self) -> Content:
        """The meaning of the numbers beside the rules, and of the goal that they share."""
        goal = (
            Content.assemble((widget.field.title, "bold"), f"  {widget.field.help}")
            for widget in self._fields
            if widget.field.name in _GOAL and widget.display
        )
        return Content("\n\n").join([Content(self._about_numbers), *goal])

    def _problems(self) -> dict[str, str]:
        try:
            parameters = build(self._motor_task.Parameters, self._values())
            if seats := self._motor_task.sensor_seats(parameters):
                from sar_tui.runs.sensors import check_sensors

                check_sensors(parameters, seats)
            check_outputs(parameters)
        except ParameterError as error:
            told = {name: in_language(why, self.tr) for name, why in error.problems.items()}
            for widget in self._fields:
                if problem := told.get(widget.field.name):
                    told[widget.field.name] = widget.explained(problem)
            return told
        return self._language_problem(parameters.language)

    def _unused(self) -> dict[str, str]:
        """Return the settings that have no effect beside others, each with the choices that use
        it.
        """
        found = without_effect(self._values())
        if "start_level" not in found and (start := self._start()) and start.from_results:
            found["start_level"] = self._fixed_start
        return found

    @property
    def _fixed_start(self) -> str:
        """The choice with which the start level is always that of the setting, in words."""
        return self.tr("fixed level")

    def _start(self) -> "Start | None":
        """Return where the next session starts; None if that cannot be said."""
        from sar_tui.runs.start_level import start_after

        try:
            parameters = build(self._motor_task.Parameters, self._values())
            return start_after(set_up(self._motor_task, parameters), self._results)
        except (Failed, ParameterError):
            return None

    @functools.cached_property
    def _results(self) -> "list[SessionResults]":
        """The person's newest sessions of the task."""
        from sar_tui.runs.start_level import LOOKED_AT
        from sar_tui.store.results import newest_of

        return list(
            newest_of(self.app.database, self._participant, self._motor_task.name, LOOKED_AT)
        )

    def _language_problem(self, language: str) -> dict[str, str]:
        """Return a problem if the participant's theme has no phrases in this language: a session
        would be refused.
        """
        known = self._languages()
        if not known or language.partition("-")[0] in {name.partition("-")[0] for name in known}:
            return {}
        told = self.tr(
            "The theme {theme} has no phrases in {language}; it has: {known}. Choose one of these, "
            "or give the theme a file phrases.{language}.toml.",
            theme=self._programme.theme,
            language=language,
            known=", ".join(known),
        )
        return {"language": told}

    def _languages(self) -> tuple[str, ...]:
        """Return the languages of the theme; none if the theme is gone, as another must be chosen
        anyway.
        """
        try:
            return languages(self.app.catalogue.theme_folder(self._programme.theme))
        except PluginError:
            return ()

    # --- groups

    @property
    def _group(self) -> int:
        return self.query_one("#groups", OptionList).highlighted or 0

    async def _show_group(self, at: int) -> None:
        for index, panel in enumerate(self._panels):
            await panel.show(index == at)
        self.query_one("#groups", OptionList).highlighted = at
        self.query_one("#sentence", Static).update(self._panels[at].sentence)
        self._show_preview_if_it_belongs()
        self._show_key()

    @property
    def _rule_is_shown(self) -> bool:
        """True if the group with the rules is shown."""
        return self._rule in self._panels[self._group].fields

    def _show_preview_if_it_belongs(self) -> None:
        """Show the preview, in a small window only with difficulty and the task's own settings."""
        belongs = self._rule_is_shown or self._panels[self._group].title == self._title
        self.query_one("#preview", PreviewPane).display = belongs or self.has_class("-beside")
        self._play_preview()

    @on(OptionList.OptionHighlighted, "#groups")
    async def _group_highlighted(self, event: OptionList.OptionHighlighted) -> None:
        await self._show_group(event.option_index)

    @on(OptionList.OptionSelected, "#groups")
    def _group_selected(self, event: OptionList.OptionSelected) -> None:
        self._panels[event.option_index].focus_first()

    def _count(self) -> None:
        """Show beside each group how many of its settings must be corrected, or differ."""
        groups = self.query_one("#groups", OptionList)
        width = max(len(panel.title) for panel in self._panels)
        for at, panel in enumerate(self._panels):
            style = "$warning" if panel.summary.startswith("!") else "$accent"
            line = Content.assemble(f"{panel.title:{width}} ", (f"{panel.summary:{_COUNT}}", style))
            groups.replace_option_prompt_at_index(at, line)

    def _level(self, field: ParameterField) -> str:
        """Return what the level of a field is: "Level 5: asdfjkl;"; empty for other fields."""
        if field.field.name not in _LEVELS:
            return ""
        try:
            task = self._motor_task(build(self._motor_task.Parameters, self._values()))
            level = min(int(show(field.value)), task.levels)
            name = task.level_name(level)
        except (ParameterError, *PLUGIN_ERRORS):
            return ""
        return self.tr("Level {level}: {name}", level=level, name=name) if name else ""

    def _scanning(self, field: ParameterField) -> str:
        """Return the scan interval that follows the person, where they have a switch."""
        values = self._values()
        is_found = values["switch"] == "one" and show(values["scan_interval_ms"]).strip() == "0"
        if field.field.name != "scan_interval_ms" or not is_found:
            return ""
        return self.tr("It is {ms} ms now.", ms=interval_ms(self._press_times))

    @functools.cached_property
    def _press_times(self) -> list[float]:
        """Press times of the person's switch."""
        return sessions.press_times(self.app.database, self._participant, MOST)

    # --- the preview

    @on(RuleField.LookedAt)
    def _look_at_rule(self) -> None:
        self._show_key()
        self._play_preview()

    @work(exclusive=True, group="preview", exit_on_error=False)
    async def _play_preview(self) -> None:
        """Play a preview of the rule that is looked at, if it is shown, and then the pictures of
        all rules.
        """
        pane, rule = self.query_one("#preview", PreviewPane), self._rule.looked_at
        if not pane.display:
            return
        if self._with_rule(rule) is None:
            pane.tell(self.tr("Correct what is marked ! to see it."))
            return
        if not self._show_played(rule):
            await asyncio.sleep(_PAUSE_S)
            pane.tell(self.tr("One moment…"))
            await self._play(rule)
        if self._rule.is_open and self._rule_is_shown:
            for name in [name for name in DIFFICULTY if name not in self._unplayable]:
                await self._play(name)

    def _with_rule(self, rule: str) -> TaskParameters | None:
        """Return the parameters with a rule; None if they have a problem."""
        if rule not in self._by_rule:
            values = {**self._values(), _RULE: rule}
            if self._is_example(rule):
                values["level_sequence"] = _EXAMPLE
            try:
                self._by_rule[rule] = build(self._motor_task.Parameters, values)
            except ParameterError:
                self._by_rule[rule] = None
        return self._by_rule[rule]

    def _is_example(self, rule: str) -> bool:
        """Return True for a list of levels that is empty, so that an example is played. If it is
        chosen, it must be filled in.
        """
        values = self._values()
        return rule == "sequence" != values[_RULE] and not show(values["level_sequence"])

    async def _play(self, rule: str) -> bool:
        """Play a rule, and show what came of it; return False if it cannot be played."""
        parameters = self._with_rule(rule)
        if parameters is None:
            return False
        previews = self._previews = self._previews or self._new_previews()
        try:
            await previews.play(parameters)
        except PLUGIN_ERRORS as error:
            self._unplayable.add(rule)
            if rule == self._rule.looked_at:
                why = (
                    in_language(error, self.tr)
                    if isinstance(error, Failed | StoreError)
                    else describe(error)
                )
                told = self.tr("It cannot be played: {why}", why=why)
                self.query_one("#preview", PreviewPane).tell(told)
            return False
        self._show_played(rule)
        return True

    def _new_previews(self) -> Previews:
        return Previews(self._motor_task, self._results, self._theme)

    def _theme(self) -> Theme:
        """Return the theme that is played with: its words do not matter."""
        theme: Theme = self.app.catalogue.theme(DEFAULT_THEME, Language().code)
        return theme

    def _show_played(self, rule: str) -> bool:
        """Show what was played: the preview of the rule that is looked at, and a picture of each
        rule. Return False if the rule was not played with these settings.
        """
        previews = self._previews
        if previews is None or previews.stand_in is None:
            return False
        found = {
            name: preview
            for name in DIFFICULTY
            if (parameters := self._with_rule(name)) and (preview := previews.kept(parameters))
        }
        highest = max((preview.highest for preview in found.values()), default=1)
        self._rule.show_pictures(
            {
                name: Picture(
                    sparkline(preview, highest), self._levels(preview), self._reached(preview)
                )
                for name, preview in found.items()
            }
        )
        looked_at = self._rule.looked_at
        if looked_at in found:
            title = rules(self.tr)[looked_at].title
            if self._is_example(looked_at):
                title = self.tr("{rule}, for example", rule=title)
            self.query_one("#preview", PreviewPane).show(
                title, found[looked_at], previews.stand_in, highest
            )
        return rule in found

    def _levels(self, preview: Preview) -> str:
        levels = [each.level for each in preview.attempts]
        low, high = min(levels), max(levels)
        return str(low) if low == high else self.tr("{low} to {high}", low=low, high=high)

    def _reached(self, preview: Preview) -> str:
        reached, count = preview.reached, preview.with_goal
        return self.tr("{reached} of {count}", reached=reached, count=count) if count else ""

    # --- going to a setting

    def action_group(self, step: int) -> None:
        """Go to the first field of the next or previous group."""
        self._go_to_group((self._group + step) % len(self._panels))

    @work(exclusive=True, group="go")
    async def _go_to_group(self, at: int) -> None:
        await self._show_group(at)
        self._panels[at].focus_first()

    @work(exclusive=True, group="go")
    async def _go_to(self, name: str) -> None:
        """Put the cursor into a field; if it has no effect now, into the choice that gives it
        one.
        """
        for at, panel in enumerate(self._panels):
            for widget in panel.fields:
                if widget.field.name != name:
                    continue
                if not widget.display:
                    told = self.tr(
                        "{title} is used by another choice: {rules}.",
                        title=widget.field.title,
                        rules=widget.used_by,
                    )
                    self.notify(told)
                    is_start = widget.used_by == self._fixed_start
                    self._go_to(_START if is_start else _choice_of(widget.used_by))
                    return
                await self._show_group(at)
                widget.focus_editor()

    def action_find(self) -> None:
        """Find a setting by a word, and go to it."""
        from sar_tui.app.screens.settings_dialogs import FindSettingScreen

        def found(name: str | None) -> None:
            if name:
                self._go_to(name)

        declared = [widget.field for widget in self._fields]
        self.app.push_screen(FindSettingScreen(declared, self._title, self.tr), found)

    # --- saving

    def action_save(self) -> None:
        """Ask for a reason, and save the settings if all are valid and some differ."""
        if problems := self._problems():
            self._go_to(next(iter(problems)))
            return
        parameters = build(self._motor_task.Parameters, self._values())
        self._ask_and_save(Programme(changed(parameters), self._programme.theme))

    def _ask_and_save(self, wanted: Programme, what: str = "") -> None:
        """Show what changes, ask for a reason, and save; nothing if nothing changes.

        Args:
            wanted: to be saved.
            what: stands before the reason: "Back to version 2".
        """
        from sar_tui.app.screens.settings_dialogs import Reason, SaveReasonScreen
        from sar_tui.app.settings.versions import compared

        made = compared(self._motor_task, self._programme, wanted, self.tr)
        if not made:
            self._show_key()  # which says that everything is saved
            return
        if self._is_of_clinic():
            return

        async def answered(given: Reason | None) -> None:
            if given:
                reason = ": ".join(filter(None, (what, given.reason)))
                await self._save(wanted, reason, given.author)

        warning, self._warning = self._warning, ""
        asked = SaveReasonScreen(made, login_name(), warning, self.tr, what)
        self.app.push_screen(asked, answered)

    def _is_of_clinic(self) -> bool:
        """Return True, and say so, if the programme is changed at the clinic only."""
        try:
            self.app.letters.check_programme()
        except StoreError as error:
            self.notify(in_language(error, self.tr), severity="warning", timeout=15)
            return True
        return False

    async def _save(self, wanted: Programme, reason: str, author: str) -> None:
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
            self.app.exchange_letters()
        except programmes.Superseded as error:
            self._warning = in_language(error, self.tr)
            mine = self._unsaved()
            self._use_programme(error.newest)
            self._fill(mine)
            again = self.tr(
                "Save again to see what differs from it, and to put yours on top of it."
            )
            self.notify(f"{self._warning} {again}", severity="warning", timeout=30)
            await self._check()
            return
        except StoreError as error:
            told = f"{self.tr('Not saved.')} {in_language(error, self.tr)}"
            self.notify(told, severity="error", timeout=15)
            return
        mine = self._unsaved()
        self._use_programme(self._programme)
        now = {widget.field.name: show(widget.saved) for widget in self._fields}
        self._set_aside = {name: value for name, value in mine.items() if show(value) != now[name]}
        await self._check()
        saved = self.tr("Saved: version {number}.", number=self._programme.version)
        self.notify(f"{saved} {self._next_start()}")
        if self._set_aside:
            self._tell_discarded(self._set_aside)

    def _use_programme(self, programme: Programme) -> None:
        """Put the values of another saved version into the fields."""
        self._programme = programme
        for widget in self._fields:
            widget.saved = programme.parameters.get(widget.field.name, widget.field.default)
            widget.set_value(widget.saved)

    def _next_start(self) -> str:
        """Say where the next session starts, and why."""
        from sar_tui.runs.start_level import start_after

        try:
            parameters = build(self._motor_task.Parameters, self._values())
            task = set_up(self._motor_task, parameters)
            start = start_after(task, self._results)
        except (Failed, ParameterError) as error:
            return in_language(error, self.tr)
        why = f" ({self.tr(start.why)})" if start.why else ""
        return self.tr("The next session starts at level {level}{why}.", level=start.level, why=why)

    # --- earlier versions

    def action_versions(self) -> None:
        """Show the versions; go back to the one that is chosen there."""
        from sar_tui.app.settings.versions import VersionsScreen

        known = programmes.versions(self.app.database, self._participant, self._motor_task.name)

        def chosen(version: Programme | None) -> None:
            if version is not None:
                self._bring_back(version)

        self.app.push_screen(
            VersionsScreen(self._participant, self._motor_task, known, self.tr), chosen
        )

    def _bring_back(self, version: Programme) -> None:
        """Save the settings of an earlier version as a new one. Changes that were not saved can be
        brought back afterwards.
        """
        kept, left_out = usable(self._motor_task.Parameters, version.parameters)
        if left_out:
            self.notify(
                in_language(joined(left_out.values()), self.tr), severity="warning", timeout=15
            )
        self._ask_and_save(
            Programme(kept, version.theme),
            self.tr("Back to version {number}", number=version.version),
        )

    # --- presets, defaults, leaving

    def action_presets(self) -> None:
        """Fill in the values of a preset. Nothing is saved."""
        from sar_tui.app.screens.settings_dialogs import ChoosePresetScreen
        from sar_tui.runs.programme_file import ProgrammeFile, applied, files, find, not_applied

        presets: dict[str, ProgrammeFile] = {}
        for name in files(self.app.folder, self._motor_task):
            try:
                presets[name] = find(self.app.folder, self._motor_task, name)
            except StoreError as error:
                self.notify(in_language(error, self.tr), severity="warning", timeout=15)

        async def chosen(name: str | None) -> None:
            if name:
                self._fill(applied(self._motor_task, presets[name], self._values()))
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
                name: self.tr(preset.summary) if preset.summary else self.tr("one of your own")
                for name, preset in presets.items()
            }
            self.app.push_screen(ChoosePresetScreen(summaries, self.tr), chosen)
        else:
            self.notify(self.tr("The task {task} has no presets.", task=self._title))

    async def action_reset(self) -> None:
        """Reset the focused field to its default, or all fields of the focused group."""
        is_group = self.query_one("#groups").has_focus
        for panel in self._panels:
            for widget in panel.fields:
                if widget.has_focus_within or (is_group and panel is self._panels[self._group]):
                    widget.reset()
        await self._check()

    async def action_reset_all(self) -> None:
        """Reset all settings to their defaults. Nothing is saved."""
        for widget in self._fields:
            widget.reset()
        await self._check()

    async def action_discard(self) -> None:
        """Take the unsaved changes away; pressed again, bring them back."""
        self.app.clear_notifications()  # that they were not saved, or were discarded
        if unsaved := self._unsaved():
            self._set_aside = unsaved
            self._fill({widget.field.name: widget.saved for widget in self._fields})
            self._tell_discarded(unsaved)
        elif self._set_aside:
            self._fill(self._set_aside)
            self._set_aside = {}
        await self._check()

    def _tell_discarded(self, names: Iterable[str]) -> None:
        told = self.tr("Discarded: {names}.", names=self._named(names))
        self.notify(f"{told} {self.tr('F7 brings that back.')}")

    @property
    def _draft_key(self) -> tuple[str, str]:
        return self._participant, self._motor_task.name

    def action_leave(self) -> None:
        """Go back. Unsaved changes are kept while the program runs."""
        self.app.settings_drafts.pop(self._draft_key, None)
        if unsaved := self._unsaved():
            self.app.settings_drafts[self._draft_key] = unsaved
            told = self.tr("Not saved: {names}.", names=self._named(unsaved))
            again = self.tr("F2 brings that back.")
            self.app.notify(f"{told} {again}", timeout=10)
        self.dismiss()

    def may_quit(self) -> bool:
        """Return True if nothing is unsaved; else ask for a second press."""
        if self._may_quit or not (unsaved := self._unsaved()):
            return True
        self._may_quit = True
        told = self.tr("Not saved: {names}.", names=self._named(unsaved))
        again = self.tr("Ctrl-S saves it; Ctrl-Q again leaves without.")
        self.notify(f"{told} {again}", severity="warning")
        return False


def _rank(field: Field) -> int:
    """Return the place of a setting in its group: the rule of difficulty, where it starts, then
    those that a rule alone uses, then the other levels, then all others.
    """
    if field.name in _FIRST:
        return _FIRST.index(field.name)
    of_rules = (policy.settings.__struct_fields__ for policy in DIFFICULTY.values())
    if any(field.name in names for names in of_rules):
        return len(_FIRST)
    return len(_FIRST) + (1 if field.name in _LEVELS else 2)


def _choice_of(policies: str) -> str:
    """Return the setting that chooses among some policies."""
    first = policies.partition(" ")[0]
    return next(choice for choice, known in BY_CHOICE.items() if first in known)


def _outputs() -> tuple[str, ...]:
    """Return the outputs that need nothing after their name."""
    from sar_tui.outputs.outputs import output_names

    known = output_names()
    return tuple(name for name in ("screen", "speech", "tones", "servo") if name in known)


class FieldPanel(VerticalScroll, can_focus=False, inherit_bindings=False):
    """Fields, which are mounted when the panel is first shown. Page keys are left to the screen.

    Args:
        title: in the list of groups.
        sentence: above the fields.
        fields: of the group.
        more: stands below them if there are more.
    """

    DEFAULT_CSS = """
    FieldPanel {
        display: none; height: 1fr; border-bottom: blank; border-subtitle-align: left;
        border-subtitle-color: $text-muted;
    }
    """

    def __init__(
        self, title: str, sentence: str, fields: Iterable[ParameterField], more: str
    ) -> None:
        super().__init__()
        self.title = title
        self.sentence = sentence
        self.fields = tuple(fields)
        self._more = more

    def compose(self) -> ComposeResult:
        """Compose nothing: see `show`."""
        return iter(())

    async def show(self, shown: bool) -> None:
        """Show the fields, or hide them."""
        if shown and self.fields and not self.fields[0].is_attached:
            await self.mount(*self.fields)
        self.display = shown

    def focus_first(self) -> None:
        """Focus the first field that is shown."""
        first = next((field for field in self.fields if field.display), None)
        if first:
            first.focus_editor()

    @property
    def summary(self) -> str:
        """Number of fields that have problems ("! 2"), are not saved ("◆ 1") or differ from their
        defaults ("● 3"); else empty.
        """
        counts = (
            ("!", sum(bool(field.problem) for field in self.fields)),
            (UNSAVED, sum(field.is_unsaved for field in self.fields)),
            (CHANGED, sum(field.is_changed for field in self.fields)),
        )
        return next((f"{sign} {count}" for sign, count in counts if count), "")

    def watch_scroll_y(self, old_value: float, new_value: float) -> None:
        super().watch_scroll_y(old_value, new_value)
        self._tell_more()

    def watch_virtual_size(self) -> None:
        self.on_resize()

    def on_resize(self) -> None:
        """Keep the focused field in view in a smaller window, and where fields above it change."""
        self._tell_more()
        for field in self.fields:
            if field.has_focus_within:
                self.call_after_refresh(field.scroll_visible, animate=False, immediate=True)

    def _tell_more(self) -> None:
        """Say below the fields if there are more."""
        self.border_subtitle = self._more if self.scroll_y < self.max_scroll_y else ""
