"""Progress of a participant in a task over sessions, for the therapist."""

import functools
import sqlite3
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any, ClassVar

from textual import work
from textual.app import ComposeResult, SystemCommand
from textual.binding import Binding, BindingType
from textual.color import Color
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.screen import ModalScreen
from textual.widget import Widget
from textual.widgets import Static

from sar_tui.app.screens.record_form import RecordForm, RemoveRecord
from sar_tui.drivers.login_name import login_name
from sar_tui.loop.task import Task
from sar_tui.model.contrast import contrast
from sar_tui.model.language import BUNDLED, OWN_NAMES, Language, in_language
from sar_tui.model.line_breaks import balanced
from sar_tui.plugins import PluginError
from sar_tui.records.kind import Kind, kinds
from sar_tui.reports import progress_parts as parts
from sar_tui.reports import progress_words
from sar_tui.reports.charts import BAND, BARS, CHOSEN, LIMIT, POINT, RULE, Role
from sar_tui.reports.progress import LineProgress, Progress, compare, progress
from sar_tui.reports.progress_glossary import GLOSSARY, explained
from sar_tui.reports.progress_headline import headline, sessions_text
from sar_tui.reports.progress_timeline import TextRow
from sar_tui.reports.wellbeing import advice
from sar_tui.rules.declaration import ParameterError
from sar_tui.store import records, wellbeing
from sar_tui.store.database import StoreError, explain
from sar_tui.store.forms import Occasion
from sar_tui.store.people_events import check_included
from sar_tui.store.records import Record
from sar_tui.store.results import sessions_of
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.heading import Heading
from sar_tui.tui.key_line import KeyLine
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.language import language_of

_SENTENCE = 72
"""Columns of the sentence."""
_PAGE = 10
"""Sessions that Page Up and Page Down go back and on."""
_FOR_LISTS, _FOR_HALVES = 100, 156
"""Columns of the window from which lists stand beside the picture, and have half of it."""
_LISTS = 42
"""Columns of the lists in a narrower window."""
_FOR_DAYS = 36
"""Rows of the window from which the days stand below the sessions."""
_BOX = 2, 4
"""Rows and columns of the border of a list."""
_OUTLOOKS = {"improving": "Improving", "steady": "Steady", "behind": "Behind"}
"""Words of the sentence that are explained."""
_OPTIONAL_KEYS = ("note", "page", "add_record", "other_settings")
"""Keys that the footer leaves out, the first ones first, where there is no room."""
NONE_YET = "No attempt has been finished yet. A adds an event, or a score of another test."


class ProgressScreen(DismissedOnce[None]):
    """A sentence, a picture of the sessions over their dates, and lists. A figure and a session are
    chosen; Enter explains the figure.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,f4", "leave", "Back", id="back"),
        Binding("enter", "open", "Explain", show=False, id="explain"),
        Binding("tab", "figure(1)", "Next view", id="next-figure"),
        Binding("shift+tab", "figure(-1)", "Previous figure", show=False, id="previous-figure"),
        Binding("right", "choose(1)", "Session", key_display="←→", id="next-session"),
        Binding("left", "choose(-1)", "Previous session", show=False, id="previous-session"),
        Binding("down", "go_down(1)", "Down", show=False, id="down"),
        Binding("up", "go_down(-1)", "Up", show=False, id="up"),
        Binding("pagedown", f"go_down({_PAGE})", "Ten on", show=False, id="sessions-on"),
        Binding("pageup", f"go_down(-{_PAGE})", "Ten back", show=False, id="sessions-back"),
        Binding("home", "choose_end(0)", "First session", show=False, id="first-session"),
        Binding("end", "choose_end(-1)", "Last session", show=False, id="last-session"),
        Binding("c", "compare", "Compare", id="compare"),
        Binding("s", "other_settings", "Other chart", id="other-settings"),
        Binding("a", "add_record", "Add", id="add-record"),
        Binding(
            "delete,backspace", "remove_record", "Remove", key_display="Del", id="remove-record"
        ),
        Binding("h", "page", "Print page", id="page"),
        Binding("n", "note", "Note", id="note"),
        Binding("ctrl+q", "app.quit", "Quit", show=False, priority=True, id="quit-here"),
    ]

    VERTICAL_BREAKPOINTS = [(36, "-tall")]
    app: Any

    def __init__(self, participant: str, task: type[Task]) -> None:
        super().__init__()
        self._participant = participant
        self._motor_task = task
        self.found: Progress | None = None
        self._problem = ""
        self._figure = "verdict"
        self._figures: list[str] = []
        self._line = 0
        self._chosen = 0
        self._marked: str | None = None
        self._record: int | None = None
        self._rows: dict[str, int] = {}

    @functools.cached_property
    def tr(self) -> Language:
        """The language of the app, with the texts of reports and of the task."""
        spoken: Language = self.app.tr
        return spoken.including(progress_words.words(spoken.code, self._motor_task).texts)

    @property
    def help_text(self) -> str:
        """Help on the sentence, the picture, and the keys."""
        tr = self.tr
        paragraphs = (
            tr(
                "The sentence says how this person does in this task. The picture shows why: the "
                "level at goal of each session, and below it, on the same dates, the minutes, "
                "pain and tiredness."
            ),
            tr(
                "Tab: choose a figure, from the sentence to the records. Enter: what it is, how "
                "it is computed, its source. Left and Right: choose a session."
            ),
            tr(
                "C: compare the chosen session with another. S: sessions with other settings, "
                "which are never in the same picture. N: a note to paste into a record. H: a page "
                "with charts to print. A: add an adverse event, or a score of another test. Among "
                "the records, Enter corrects one, and Del removes one that was entered by mistake."
            ),
            tr("These are training measures. They are no diagnosis."),
        )
        return "\n\n".join(paragraphs) + "\n"

    def compose(self) -> ComposeResult:
        with Horizontal(id="top", classes="top-bar"):
            yield Static(self._title(None), id="who", markup=False)
            yield Static("", id="where", markup=False)
        yield Heading("", id="sentence")
        yield Static("", id="told", classes="needs-a-look", markup=False)
        with Horizontal(id="body"):
            yield _Drawing(self._draw, id="picture")
            with Vertical(id="right"):
                yield self._box("records")
                yield self._box("sessions")
                yield self._box("days")
        yield Static("", id="chosen", classes="small", markup=False)
        yield KeyLine()
        yield KeyFooter(show_command_palette=False, optional=_OPTIONAL_KEYS)

    def _box(self, name: str) -> "_Drawing":
        """Return a list with a border."""
        return _Drawing(functools.partial(self._draw_list, name), id=name, classes="list")

    def on_mount(self) -> None:
        self.call_after_refresh(self._read)

    def _read(self) -> None:
        """Read the sessions once the empty screen is shown: a thousand of them take a moment."""
        if self.load():
            assert self.found
            self._show_line(len(self.found.lines) - 1)
        else:
            self.show()

    def load(self) -> bool:
        """Read all that is shown, and return True; say why if it cannot be read."""
        find = {self._motor_task.name: self._motor_task}.get
        try:
            database = self.app.database
            check_included(database, self._participant)
            sessions = list(
                sessions_of(
                    database, self._participant, self._motor_task.name, folder=self.app.folder
                )
            )
            self.found = progress(
                self._participant,
                sessions,
                find,
                records.listing(database, participant=self._participant),
                today=self.app.today(),
                ratings=wellbeing.history(database, self._participant),
            )
        except (StoreError, sqlite3.Error) as error:
            why = error if isinstance(error, StoreError) else explain(error)
            self._problem = self.tr(
                "The sessions cannot be read: {why}", why=in_language(why, self.tr)
            )
            return False
        return True

    @property
    def _shown_line(self) -> LineProgress | None:
        return self.found.lines[self._line] if self.found and self.found.lines else None

    def _show_line(self, number: int) -> None:
        """Show one of the person's lines, with its last session chosen."""
        assert self.found
        self._line = number
        line = self._shown_line
        self._figures = parts.figures(self.found, line)
        self._chosen, self._marked = len(line.sessions) - 1 if line else 0, None
        self.refresh_bindings()
        self.show()

    @property
    def figure(self) -> str:
        """The chosen figure, as in the glossary; empty before the sessions are read."""
        names = self._figures
        return self._figure if self._figure in names else names[0] if names else ""

    @property
    def _beside(self) -> list[str]:
        """The lists that stand beside the picture."""
        if self._shown_line is None or self.size.width < _FOR_LISTS:
            return []
        has_days = self.size.height >= _FOR_DAYS and "days" in self._figures
        return ["records", "sessions", *(["days"] if has_days else [])]

    @property
    def _lists_width(self) -> int:
        width = self.size.width
        return width // 2 if width >= _FOR_HALVES else _LISTS

    @property
    def _hidden(self) -> list[str]:
        """The lists that are shown only where they are chosen."""
        return [name for name in parts.LISTS if name in self._figures and name not in self._beside]

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        line = self._shown_line
        has_sessions = line is not None and len(line.sessions) > 1
        is_of_records = self.figure == "records" and bool(self._listed)
        enabled = {
            "figure": len(self._figures) > 1,
            "open": bool(self.figure),
            "other_settings": self.found is not None and len(self.found.lines) > 1,
            "compare": has_sessions,
            "choose": has_sessions and not is_of_records,
            "go_down": has_sessions or is_of_records,
            "choose_end": has_sessions or is_of_records,
            "add_record": self.found is not None,
            "remove_record": is_of_records,
            "note": line is not None,
            "page": line is not None,
        }
        return enabled[action] if action in enabled else super().check_action(action, parameters)

    # --- what is shown

    def on_resize(self) -> None:
        self.refresh_bindings()
        if self.found:
            self.call_after_refresh(self.show)

    def show(self) -> None:
        """Draw everything anew."""
        line = self._shown_line
        self.query_one("#who", Static).update(self._title(line))
        self.query_one("#where", Static).update(self._where(line))
        self.query_one(Heading).show(self._sentence(line))
        told = [f"! {text}" for text in advice(self.found.tell, self.tr)] if self.found else []
        self.query_one("#told", Static).update("\n".join(told))
        self.query_one("#told").display = bool(told)
        self._place_lists()
        about = self._about(line) if line and self.found else ""
        self.query_one("#chosen", Static).update(about)
        self.query_one("#chosen").display = bool(about)
        self.query_one(KeyLine).show(self._key(), self.tr("Enter"))
        for drawing in self.query(_Drawing):
            drawing.refresh()

    def _place_lists(self) -> None:
        """Show the lists that have a place, with as many rows as they need."""
        beside, right = self._beside, self.query_one("#right")
        right.display = bool(beside)
        right.styles.width = self._lists_width
        for box in self.query(".list"):
            box.display = box.id in beside
            box.set_class(box.id == self.figure, "-chosen")
        if beside:
            columns = self._lists_width - _BOX[1]
            self._rows = {
                name: len(self._list(name, (columns, self.size.height))) - 1 + _BOX[0]
                for name in beside
            }
            self.query_one("#records").styles.height = self._rows["records"]
            self.query_one("#sessions").styles.max_height = self._rows["sessions"]
            self.query_one("#days").styles.min_height = self._rows.get("days", 0)
            self.call_after_refresh(self._fit_lists)

    def _fit_lists(self) -> None:
        """Let the days have the rows that the sessions do not need."""
        beside, sessions = self._beside, self.query_one("#sessions")
        if "days" in beside:
            others = self._rows["records"] + self._rows["days"]
            room = self.query_one("#right").size.height - others
            sessions.styles.height = max(_BOX[0] + 2, min(self._rows["sessions"], room))
        else:
            sessions.styles.height = "1fr"
        self.call_after_refresh(self._name_lists)

    def _name_lists(self) -> None:
        """Give each list its title, with the part of it that its place has room for."""
        for name in self._beside:
            box = self.query_one(f"#{name}")
            columns, rows = box.content_size
            box.border_title = self._list(name, (columns, rows + 1))[0].text

    def _title(self, line: LineProgress | None) -> str:
        """Return who and what, with as many settings as there is room for."""
        if line is None:
            return f"{self._participant} · {self.tr(self._motor_task.title)}"
        room = self.size.width - len(self._where(line)) - 4
        parts = [self._participant, *progress_words.heading(line, self.tr).split(" · ")]
        while len(parts) > 2 and len(" · ".join(parts)) > room:
            parts.pop()
        return " · ".join(parts)

    def _where(self, line: LineProgress | None) -> str:
        if line is None or self.found is None:
            return ""
        count, said = len(self.found.lines), sessions_text(len(line.sessions), self.tr)
        if count == 1:
            return said
        return self.tr(
            "{sessions} · {number} of {count}",
            sessions=said,
            number=count - self._line,
            count=count,
        )

    def _sentence(self, line: LineProgress | None) -> str:
        if self.found is None:
            return self._problem
        text = headline(self.found, line, self.tr).text if line else self.tr(NONE_YET)
        return balanced(text, max(_SMALLEST[0], min(self.size.width - 4, _SENTENCE)))

    def _key(self) -> str:
        if not self.figure:
            return ""
        if self.figure == "records" and self._listed:
            return self.tr("Press Enter to correct this record.")
        line = self._shown_line
        if self.figure == "verdict" and self.found and line:
            word = self.tr(_OUTLOOKS.get(headline(self.found, line, self.tr).outlook, ""))
            if not word:
                return self.tr("Press Enter to see why.")
            return self.tr('Press Enter to see why it says "{word}".', word=word)
        title = self.tr(GLOSSARY[self.figure].title)
        return self.tr('Press Enter to see what "{figure}" means.', figure=title)

    def _draw(self, columns: int, rows: int) -> Content:
        """Draw the picture, or the chosen list if it has no other place."""
        line, size = self._shown_line, (columns, rows)
        if self.found is None:
            return Content("" if self._problem else self.tr("Reading the sessions …"))
        if line is None or self.figure in self._hidden:
            return colored(self._list(self.figure, size), self.figure)
        drawn = parts.picture(
            line,
            size,
            self.figure,
            self._chosen,
            self.tr,
            self._marked,
            is_shaded=self._is_shaded,
        )
        return colored(drawn, self.figure, chart_colors(self.app.theme_variables))

    @property
    def _is_shaded(self) -> bool:
        """True if the terminal shows shades: it has more than 16 colours, and none is asked for."""
        return not self.app.no_color and self.app.console.color_system in _SHADED

    def _draw_list(self, name: str, columns: int, rows: int) -> Content:
        """Draw a list that has a border, whose title is there."""
        if self.found is None or name not in self._beside:
            return Content("")
        return colored(self._list(name, (columns, rows + 1))[1:], self.figure)

    def _list(self, name: str, size: tuple[int, int]) -> list[TextRow]:
        assert self.found
        return parts.listed(
            name,
            self.found,
            self._shown_line,
            size,
            self.tr,
            chosen=self._chosen,
            marked=self._marked,
            record=self._chosen_record,
            is_chosen=name == self.figure,
        )

    def _about(self, line: LineProgress) -> str:
        """Return the chosen session in words, or its comparison with the marked one."""
        assert self.found
        if self.figure in self._hidden and self.figure != "sessions":
            return ""
        chosen = line.sessions[self._chosen]
        width = self.size.width - 4
        said = [
            parts.session_text(line, chosen, self.found.today, self.tr, width, self.figure),
        ]
        if self._marked == chosen.session:
            hint = self.tr(
                "Left and Right: choose the session to compare it with. Esc: no comparison."
            )
            said += parts.wrapped([hint], width)
        elif self._marked and (comparison := compare(self.found, self._marked, chosen.session)):
            compared = self.tr(
                "{first} and {second}: {comparison}",
                first=self._day(comparison.earlier.began),
                second=self._day(comparison.later.began),
                comparison=progress_words.compared(line, comparison, self.tr),
            )
            said += parts.wrapped([compared], width)
        return f"{parts.CURSOR} " + "\n  ".join(said)

    def _day(self, stamp: str) -> str:
        assert self.found
        return progress_words.short_day(stamp, self.found.today, self.tr)

    # --- keys

    def commands(self) -> Iterator[SystemCommand]:
        """Yield what can be done here, for the command palette."""
        tr = self.tr
        for name in self._figures:
            yield SystemCommand(
                tr(GLOSSARY[name].title),
                tr("Choose this figure"),
                functools.partial(self.choose_figure, name),
            )
        for action, title, help in (
            ("compare", tr("Compare"), tr("Compare the chosen session with another")),
            ("other_settings", tr("Other chart"), tr("Sessions with other settings")),
            ("add_record", tr("Add"), tr("An adverse event, or a score of another test")),
            ("note", tr("Note"), tr("A paragraph to paste into a record")),
            ("page", tr("Print page"), tr("A page with charts, to print")),
        ):
            if self.check_action(action, ()):
                yield SystemCommand(title, help, getattr(self, f"action_{action}"))

    def choose_figure(self, name: str) -> None:
        """Choose a figure by its name in the glossary."""
        self._figure = name
        self.refresh_bindings()
        self.show()

    def action_figure(self, step: int) -> None:
        """Choose the next figure, or the previous one."""
        names = self._figures
        self.choose_figure(names[(names.index(self.figure) + step) % len(names)])

    def action_open(self) -> None:
        """Explain the chosen figure; of records, correct the chosen one."""
        if self.figure == "records" and self._listed:
            self.action_correct_record()
        elif self.figure:
            self.app.push_screen(ExplanationScreen(self.figure, self._explained))

    def _explained(self, name: str) -> tuple[Sequence[str], Sequence[str]]:
        """Return what a figure says of this person, and its explanation."""
        assert self.found
        own = parts.of_person(name, self.found, self._shown_line, self._chosen, self.tr)
        return own, explained(name, self.tr)

    def action_choose(self, step: int) -> None:
        """Choose an earlier or later session."""
        if line := self._shown_line:
            self._chosen = max(0, min(len(line.sessions) - 1, self._chosen + step))
            self.show()

    def action_go_down(self, step: int) -> None:
        """Choose an earlier or later session; among the records, a record. The newest ones are at
        the top.
        """
        if self.figure == "records" and self._listed:
            self._choose_record(-step)
        else:
            self.action_choose(-step)

    def action_choose_end(self, session: int) -> None:
        """Choose the first or the last session; among the records, a record."""
        count = max(len(self._listed), len(line.sessions) if (line := self._shown_line) else 0)
        self.action_go_down(-count if session else count)

    def action_other_settings(self) -> None:
        """Show the sessions that had other settings."""
        if self._shown_line:
            assert self.found
            self._show_line((self._line - 1) % len(self.found.lines))

    def action_compare(self) -> None:
        """Mark the chosen session, to compare it with others; or end the comparison."""
        if line := self._shown_line:
            chosen = line.sessions[self._chosen].session
            self._marked = None if self._marked == chosen else chosen
            self.show()

    def action_leave(self) -> None:
        """End a comparison, or go back."""
        if self._marked:
            self._marked = None
            self.show()
        else:
            self.dismiss()

    # --- records

    @property
    def _listed(self) -> list[Record]:
        return self.found.records if self.found else []

    @property
    def _chosen_record(self) -> int:
        """Number of the chosen record; the newest one before any is chosen."""
        last = len(self._listed) - 1
        return last if self._record is None else max(0, min(last, self._record))

    def _choose_record(self, step: int) -> None:
        self._record = max(0, min(len(self._listed) - 1, self._chosen_record + step))
        self.show()

    def action_add_record(self) -> None:
        """Open the form for a new record, of the kind that is chosen in the list."""
        entered = [kind for kind in kinds().values() if _can_be_added(kind)]
        chosen = self._listed[self._chosen_record].kind if self._listed else ""
        entered.sort(key=lambda kind: (kind.form is not None, kind.name != chosen))

        def closed(ended: bool | Kind | None) -> None:
            if isinstance(ended, Kind):
                self._fill(ended)
            else:
                self._entered(ended)

        self.app.push_screen(RecordForm(entered, [self._participant]), closed)

    def _fill(self, form: Kind) -> None:
        """Let the participant fill in a form."""
        try:
            occasion = Occasion(self._participant)
            self.app.fill_form(form, occasion, lambda _: self._entered(True))
        except (StoreError, PluginError, ParameterError) as error:
            self.notify(in_language(error, self.tr), severity="error", timeout=20)

    def action_correct_record(self) -> None:
        """Open the form for what is known now of the chosen record, such as its outcome."""
        record = self._listed[self._chosen_record]
        kind = self._kind_of(record)
        if kind and kind.form:
            said = self.tr("A form is the participant's own: A has it filled in once more.")
            self.notify(said, timeout=12)
        elif kind:
            form = RecordForm([kind], [self._participant], known=record)
            self.app.push_screen(form, self._entered)

    def action_remove_record(self) -> None:
        """Ask whether the chosen record was entered by mistake, and remove it then."""
        record = self._listed[self._chosen_record]

        def remove(is_mistake: bool | None) -> None:
            if not is_mistake:
                return
            try:
                records.correct(self.app.database, record.id, {}, removed=True, author=login_name())
            except StoreError as error:
                self.notify(in_language(error, self.tr), severity="error", timeout=20)
            self._entered(True)

        self.app.push_screen(RemoveRecord(record), remove)

    def _kind_of(self, record: Record) -> Kind | None:
        """Return the kind of a record; say so if it is not declared here."""
        try:
            return records.kind_of(record.kind)
        except StoreError as error:
            self.notify(in_language(error, self.tr), severity="error", timeout=20)
            return None

    def _entered(self, is_changed: bool | None) -> None:
        """Show what was entered, and choose it: in the list, and in the charts it is marked in."""
        before = self._listed
        if is_changed and self.load():
            new = [number for number, each in enumerate(self._listed) if each not in before]
            if new:
                self._figure, self._record = "records", new[-1]
            assert self.found
            self._figures = parts.figures(self.found, self._shown_line)
            self.refresh_bindings()
            self.show()

    # --- what leaves the program

    def action_note(self) -> None:
        """Show a paragraph to paste into a record."""

        line, found = self._shown_line, self.found
        if line and found:

            def text(language: str) -> str:
                tr = progress_words.words(language, self._motor_task)
                return "\n\n".join(
                    [
                        progress_words.note(self._participant, line, tr),
                        *progress_words.after_notes(found, tr),
                    ]
                )

            self.app.push_screen(ProgressNoteScreen(text, self.tr.code))

    def action_page(self) -> None:
        """Write a page with charts into the data folder."""
        if self.found:
            self.notify(self.tr("Drawing the page …"), timeout=3)
            self._write_page(self.found)

    @work(thread=True, exclusive=True, group="page")
    def _write_page(self, found: Progress) -> None:
        from sar_tui.drivers.files import unused, write_private
        from sar_tui.reports.charts import ChartsMissing
        from sar_tui.reports.progress_page import page

        find: Callable[[str], type[Task] | None] = {self._motor_task.name: self._motor_task}.get
        name = f"progress-{self._participant}-{self._motor_task.name}"
        try:
            text = page(found, find, self.tr.code)
            path = unused(self.app.folder / f"{name}.html")
            write_private(path, text)
        except ChartsMissing as error:
            self.app.call_from_thread(
                self.notify, in_language(error, self.tr), severity="warning", timeout=20
            )
        except OSError as error:
            why = str(error.strerror or error)
            said = self.tr("The page cannot be written: {why}.", why=why)
            self.app.call_from_thread(self.notify, said, severity="error", timeout=20)
        else:
            said = self.tr("It is written. Open it in a browser, which can also print it:")
            self.app.call_from_thread(self.notify, f"{said}\n{path}", timeout=12)


_SHADED = ("256", "truecolor")
"""Names of Rich for colours that have shades."""


def _can_be_added(kind: Kind) -> bool:
    """Return True if a therapist enters such records, or if it is a form that can be filled in."""
    if kind.form:
        return not kind.why_unusable
    return kind.entered_by == "therapist" and kind.group != "home"


_OF_CHARTS = {
    POINT: "$accent",
    CHOSEN: "$accent",
    **dict.fromkeys((BAND, LIMIT, RULE), "$text-muted"),
}
_PARTS: dict[Role, tuple[str, float]] = {
    "point": ("accent", 1.0),
    "band": ("accent", 0.45),  # or more, for its contrast
    "area": ("foreground", 0.13),
    "line": ("foreground", 0.6),
    "label": ("foreground", 0.75),
    "ground": ("background", 1.0),
}
"""Colours of the parts of a chart: one of the theme, and how much of it is on the background."""
_LEAST_CONTRAST = 3.0
"""Contrast of a band with the area behind it (WCAG 2.2, 1.4.11)."""
_OF_BARS = dict.fromkeys(BARS, "$text-muted")
_COLORS = {
    "level": _OF_CHARTS,
    "result": _OF_CHARTS,
    **dict.fromkeys(("dose", "correct", "quality"), _OF_BARS),
    "": {parts.CURSOR: "$accent"},
}
"""Colours of characters by the figure of their row."""
_NAME, _CHOSEN_NAME, _LOOK = "bold", "$background on $accent bold", "$warning bold"
_CHOSEN_ROW = "bold on $accent 35%"


def chart_colors(theme: Mapping[str, str]) -> dict[str, str]:
    """Return the colours of the parts of a chart, given those of the theme."""
    ground = Color.parse(theme["background"])

    def mixed(name: str, share: float) -> str:
        return ground.blend(Color.parse(theme[name]), share).hex

    colors: dict[str, str] = {part: mixed(name, share) for part, (name, share) in _PARTS.items()}
    name, share = _PARTS["band"]
    while share < 1.0 and contrast(colors["band"], colors["area"]) < _LEAST_CONTRAST:
        share += 0.05
        colors["band"] = mixed(name, share)
    return colors


def colored(
    rows: Sequence[TextRow], figure: str, chart: Mapping[str, str] | None = None
) -> Content:
    """Return rows with the characters of charts in their colours, the names of figures in bold, and
    the name of the chosen figure like a cursor.

    Args:
        rows: to draw.
        figure: the chosen one.
        chart: colours of the parts of a chart.
    """
    return Content("\n").join(
        _colored(row, chart or {}, is_chosen=row.figure == figure) for row in rows
    )


def _colored(row: TextRow, chart: Mapping[str, str], *, is_chosen: bool) -> Content:
    pieces: list[str | tuple[str, str]] = []
    if row.name:
        pieces.append((row.text[: row.name], _CHOSEN_NAME if is_chosen else _NAME))
    colors = _COLORS.get(row.figure, {})
    for style, run in groupby(row.text[row.name :], lambda character: colors.get(character, "")):
        pieces.append(("".join(run), style))
    content = Content.assemble(*pieces)
    for first, last in row.looks:
        content = content.stylize(_LOOK, first, last)
    for part in row.runs:
        shown, behind = chart.get(part.shown, ""), chart.get(part.behind, "")
        style = f"{shown} on {behind}" if behind else shown
        content = content.stylize(style.strip(), part.first, part.last)
    return content.stylize(_CHOSEN_ROW) if row.is_chosen else content


_SMALLEST = (30, 4)
"""Columns and rows for which something is drawn: a smaller window shows a part of it."""


class _Drawing(Widget):
    """Text that is drawn to fit its place, given the columns and rows of it."""

    def __init__(self, draw: Callable[[int, int], Content], id: str, classes: str = "") -> None:
        super().__init__(id=id, classes=classes)
        self._drawn = draw

    def render(self) -> Content:
        columns, rows = self.content_size
        return self._drawn(max(_SMALLEST[0], columns), max(_SMALLEST[1], rows))


# --- the explanation of a figure


_AROUND = 8
"""Rows of the window that the text of an explanation leaves free."""


class ExplanationScreen(DismissedOnce[None], ModalScreen[None]):
    """Explains a figure: what it says of this person, what it is, how it is computed, and its
    source. Arrows go on to the other figures.

    Args:
        name: of the figure, as in the glossary.
        text: returns the sentences on this person, and the explanation, given the name of a figure.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("right,tab", "turn(1)", "Next figure", id="next-figure"),
        Binding("left,shift+tab", "turn(-1)", "Previous figure", id="previous-figure"),
        Binding("escape,enter", "dismiss", "Close", id="close"),
    ]

    app: Any

    def __init__(
        self, name: str, text: Callable[[str], tuple[Sequence[str], Sequence[str]]]
    ) -> None:
        super().__init__()
        self._figure_name = name
        self._text = text

    def compose(self) -> ComposeResult:
        tr = language_of(self.app)
        with Vertical(classes="dialog", id="explanation"):
            yield Static("", classes="headline", id="headline", markup=False)
            with VerticalScroll(can_focus=True):
                yield Static("", id="of-person", markup=False)
                yield Static("", id="paragraph", markup=False)
            yield Static(
                tr("←→: the other figures. Up and Down scroll. Esc closes."),
                classes="muted",
                markup=False,
            )

    def _show(self) -> None:
        own, general = self._text(self._figure_name)
        tr = language_of(self.app)
        title = tr(GLOSSARY[self._figure_name].title)
        self.query_one("#headline", Static).update(title)
        self.query_one("#of-person", Static).update("\n".join(own))
        self.query_one("#of-person").display = bool(own)
        self.query_one("#paragraph", Static).update("\n\n".join(general))
        scroll = self.query_one(VerticalScroll)
        scroll.styles.max_height = max(3, self.size.height - _AROUND)
        scroll.scroll_home(animate=False)

    def on_resize(self) -> None:
        self._show()

    def action_turn(self, step: int) -> None:
        """Explain another figure."""
        names = list(GLOSSARY)
        self._figure_name = names[(names.index(self._figure_name) + step) % len(names)]
        self._show()


# --- the note


class ProgressNoteScreen(DismissedOnce[None], ModalScreen[None]):
    """Shows the paragraph in a language, and puts it into the clipboard of terminals that allow it
    (OSC 52).

    Args:
        text: returns the paragraph in a language, given its code.
        code: of the language to begin with.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("tab,l", "language", "Language", id="language"),
        Binding("escape,enter", "dismiss", "Close", id="close"),
    ]

    app: Any

    def __init__(self, text: Callable[[str], str], code: str) -> None:
        super().__init__()
        self._text = text
        self._language = code

    def compose(self) -> ComposeResult:
        tr = language_of(self.app)
        hints = (
            tr(
                "It is in the clipboard now, if your terminal allows that. If not, select it with "
                "the mouse (often with Shift), or use `sar-tui progress CODE --note`."
            ),
            tr("Tab: the next language. Up and Down scroll. Esc closes."),
        )
        with Vertical(classes="dialog", id="progress-note"):
            yield Static("", classes="headline", id="headline")
            with VerticalScroll(can_focus=True):
                yield Static("", id="paragraph", markup=False)
            yield Static("\n\n".join(hints), classes="muted", markup=False)

    def on_mount(self) -> None:
        self._show()

    def _show(self) -> None:
        tr, text = language_of(self.app), self._text(self._language)
        heading = tr("Note: {language}", language=OWN_NAMES[self._language])
        self.query_one("#headline", Static).update(heading)
        self.query_one("#paragraph", Static).update(text)
        self.app.copy_to_clipboard(text)

    def action_language(self) -> None:
        """Show the note in the next language."""
        codes = list(BUNDLED)
        self._language = codes[(codes.index(self._language) + 1) % len(codes)]
        self._show()
