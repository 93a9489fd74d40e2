"""Progress of a participant in a task over sessions, for the therapist."""

import sqlite3
from collections.abc import Callable
from typing import Any, ClassVar

from textual import work
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.screen import ModalScreen
from textual.widgets import Static

from sar_tui.app.screens.record_form import RecordForm, RemoveRecord
from sar_tui.drivers.login_name import login_name
from sar_tui.loop.task import Task
from sar_tui.model.language import BUNDLED
from sar_tui.records.kind import Kind, kinds
from sar_tui.reports import progress_parts as parts
from sar_tui.reports import progress_words
from sar_tui.reports.charts import AREA, BAND, CHOSEN, POINT, RULE
from sar_tui.reports.progress import LineProgress, Progress, compare, progress
from sar_tui.reports.wellbeing import advice
from sar_tui.store import records, wellbeing
from sar_tui.store.database import StoreError, explain
from sar_tui.store.records import Record
from sar_tui.store.results import sessions_of
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.key_footer import KeyFooter

_PARTS = ("Level", "Results", "Sessions", "Dose", "Records")
_OF_SESSIONS = ("Level", "Results", "Sessions")
"""Parts in which a session is chosen; with the list of sessions beside it, also the dose."""
_PAGE = 10
"""Sessions that Page Up and Page Down go back and on."""
_WIDE = 130
"""Columns from which the sessions are shown beside the other parts."""
_TABLE = 86
"""Columns of the table of sessions where it is beside another part."""
_HEADING_AND_KEYS = 3
"""Rows above and below the parts."""
NONE_YET = (
    "No attempt has been finished yet. Adverse events and scores of other tests can be entered "
    "under Records."
)


class ProgressScreen(DismissedOnce[None]):
    """A chart of the sessions and what can be said of them, in parts; one session is chosen in all
    of them.
    """

    help_text = (
        "Progress shows in the level, not in the results: the program makes the task harder when "
        "it goes well. The "
        "level at goal is the level at which this person would just reach the goal; its band says "
        "how well it is "
        "known. Sessions inside the shaded area do not differ by more than noise and practice.\n\n"
        "Left and Right: the parts. Up and Down: choose a session. C marks it, and compares it "
        "with the next that you "
        "choose. N: a note to paste into a record. H writes a page with charts to print.\n\n"
        "Sessions with other settings are never in one chart: S shows those.\n\n"
        "Records lists adverse events, scores of other tests and what else is entered by hand: A "
        "adds one, Enter corrects the chosen one, such as its outcome, and Del removes one that "
        "was entered by mistake.\n\n"
        "These are training measures. They are no diagnosis.\n"
    )
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,f4", "leave", "Back", id="back"),
        Binding("right", "part(1)", "Part", key_display="←→", id="next-part"),
        Binding("tab", "part(1)", "Part", show=False, id="next-part-by-tab"),
        Binding("left,shift+tab", "part(-1)", "Previous part", show=False, id="previous-part"),
        Binding("down", "choose(1)", "Next session", show=False, id="next-session"),
        Binding("up", "choose(-1)", "Previous session", show=False, id="previous-session"),
        Binding("pagedown", f"choose({_PAGE})", "Ten on", show=False, id="sessions-on"),
        Binding("pageup", f"choose(-{_PAGE})", "Ten back", show=False, id="sessions-back"),
        Binding("home", "choose_end(0)", "First session", show=False, id="first-session"),
        Binding("end", "choose_end(-1)", "Last session", show=False, id="last-session"),
        Binding("a", "add_record", "Add", id="add-record"),
        Binding("enter", "correct_record", "Correct", id="correct-record"),
        Binding(
            "delete,backspace", "remove_record", "Remove", key_display="Del", id="remove-record"
        ),
        Binding("c", "compare", "Compare", id="compare"),
        Binding("s", "other_settings", "Charts", id="other-settings"),
        Binding("n", "note", "Note", id="note"),
        Binding("h", "page", "Page", id="page"),
    ]

    app: Any

    def __init__(self, participant: str, task: type[Task]) -> None:
        super().__init__()
        self._participant = participant
        self._motor_task = task
        self.found: Progress | None = None
        self._part = 0
        self._line = 0
        self._chosen = 0
        self._marked: str | None = None
        self._record = 0
        self._tr = progress_words.words("en", task)

    def compose(self) -> ComposeResult:
        yield Static(f"{self._participant} · {self._motor_task.title}", id="top", markup=False)
        yield Static("", id="parts")
        with Horizontal(id="body"):
            yield Static("Reading the sessions …", id="part")
            beside = Static("", id="beside")
            beside.display = False
            yield beside
        yield Static("", id="chosen", markup=False)
        yield KeyFooter(show_command_palette=False)

    def on_mount(self) -> None:
        self.call_after_refresh(self._read)

    def _read(self) -> None:
        """Read the sessions once the empty screen is shown: a thousand of them take a moment."""
        if self.load():
            assert self.found
            self._line = len(self.found.lines) - 1
            self._chosen = len(line.sessions) - 1 if (line := self._shown_line) else 0
            self.refresh_bindings()
            self.show()

    def load(self) -> bool:
        """Read all that is shown, and return True; say why if it cannot be read."""
        find = {self._motor_task.name: self._motor_task}.get
        try:
            database = self.app.database
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
                ratings=wellbeing.history(database, self._participant),
            )
        except (StoreError, sqlite3.Error) as error:
            self.query_one("#part", Static).update(
                Content(
                    "The sessions cannot be read: "
                    f"{error if isinstance(error, StoreError) else explain(error)}"
                )
            )
            return False
        return True

    @property
    def _shown_line(self) -> LineProgress | None:
        return self.found.lines[self._line] if self.found and self.found.lines else None

    @property
    def part_name(self) -> str:
        """The part that is shown."""
        return _PARTS[self._part]

    @property
    def _shows_sessions(self) -> bool:
        """True if a session can be chosen: one is marked in a chart, or in the list of sessions."""
        return self.part_name in _OF_SESSIONS or (
            self.part_name == "Dose" and self.size.width >= _WIDE
        )

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        line, listed = self._shown_line, len(self._listed)
        has_sessions = line is not None and len(line.sessions) > 1 and self._shows_sessions
        enabled = {
            "other_settings": self._shows_sessions
            and self.found is not None
            and len(self.found.lines) > 1,
            "compare": has_sessions,
            "choose": has_sessions or listed > 1,
            "choose_end": has_sessions or listed > 1,
            "add_record": self.found is not None and self.part_name == "Records",
            "correct_record": listed > 0,
            "remove_record": listed > 0,
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
        assert self.found
        line = self._shown_line
        self.query_one("#top", Static).update(self._title(line))
        named = [
            (f"[{name}]", "$accent bold") if n == self._part else f" {name} "
            for n, name in enumerate(_PARTS)
        ]
        self.query_one("#parts", Static).update(Content.assemble(*named))
        is_wide = self.size.width >= _WIDE and line is not None and self._shows_sessions
        beside, part = self.query_one("#beside", Static), self.query_one("#part", Static)
        beside.display = is_wide
        about = self._about_chosen(line) if line and self._shows_sessions else ""
        self.query_one("#chosen", Static).update(about)
        self.query_one("#chosen").display = bool(about)
        full, height = (
            self.size.width,
            self.size.height - _HEADING_AND_KEYS - len(about.splitlines()),
        )
        sides = (full - _TABLE, _TABLE) if self.part_name != "Sessions" else (_TABLE, full - _TABLE)
        beside.styles.width = sides[1]
        width = (sides[0] if is_wide else full) - 2
        part.update(colored(self._lines_of_part((width, height))))
        if is_wide and line:
            size = (sides[1] - 2, height)
            if self.part_name == "Sessions":
                beside.update(
                    colored(parts.level_part(line, size, self._chosen, self._tr, self._marked))
                )
            else:
                beside.update(
                    colored(parts.sessions_part(line, size, self._chosen, self._tr, self._marked))
                )

    def _title(self, line: LineProgress | None) -> str:
        if line is None:
            return f"{self._participant} · {self._motor_task.title}"
        count = len(self.found.lines) if self.found else 1
        number = f"{count - self._line} of {count} · " if count > 1 else ""
        return f"{self._participant} · {number}{progress_words.heading(line, self._tr)}"

    def _lines_of_part(self, size: tuple[int, int]) -> list[str]:
        assert self.found
        line, tr = self._shown_line, self._tr
        match self.part_name:
            case "Dose":
                return parts.dose_part(self.found, size, tr)
            case "Records":
                return parts.records_part(self.found, size, self._chosen_record, tr)
            case _ if line is None:
                return parts.wrapped([NONE_YET], size[0])
            case "Level":
                said = [f"! {text}" for text in advice(self.found.tell)]
                return parts.level_part(line, size, self._chosen, tr, self._marked, said)
            case "Results":
                return parts.results_part(line, size, self._chosen, tr, self._marked)
            case _:
                return parts.sessions_part(line, size, self._chosen, tr, self._marked)

    def _about_chosen(self, line: LineProgress) -> str:
        """Return the chosen session in words, or its comparison with the marked one."""
        assert self.found
        chosen = line.sessions[self._chosen]
        when, felt = parts.session_text(line, chosen, self._tr)
        if self._marked == chosen.session:
            felt = "Up and Down: choose the session to compare it with. Esc: no comparison."
        elif self._marked and (comparison := compare(self.found, self._marked, chosen.session)):
            days = [
                progress_words.day(each.began) for each in (comparison.earlier, comparison.later)
            ]
            felt = f"{days[0]} and {days[1]}: {progress_words.compared(line, comparison, self._tr)}"
        return "\n".join(
            [f"{parts.CURSOR} {when}", *parts.wrapped([felt], self.size.width - 4, indent="  ")]
        )

    # --- keys

    def action_part(self, step: int) -> None:
        """Show another part."""
        self._part = (self._part + step) % len(_PARTS)
        self.refresh_bindings()
        if self.found:
            self.show()

    def action_choose(self, step: int) -> None:
        """Choose an earlier or later session, or record."""
        if self.part_name == "Records":
            self._choose_record(step)
        elif line := self._shown_line:
            self._chosen = max(0, min(len(line.sessions) - 1, self._chosen + step))
            self.show()

    def action_choose_end(self, session: int) -> None:
        """Choose the first or the last session, or record."""
        if self.part_name == "Records":
            self._choose_record(-len(self._listed) if session == 0 else len(self._listed))
        elif line := self._shown_line:
            self._chosen = session % len(line.sessions)
            self.show()

    def action_other_settings(self) -> None:
        """Show the sessions that had other settings."""
        if line := self._shown_line:
            assert self.found
            self._line = (self._line - 1) % len(self.found.lines)
            line = self.found.lines[self._line]
            self._chosen, self._marked = len(line.sessions) - 1, None
            self.refresh_bindings()
            self.show()

    def action_compare(self) -> None:
        """Mark the chosen session, to compare it with others; or end the comparison."""
        if line := self._shown_line:
            chosen = line.sessions[self._chosen].session
            self._marked = None if self._marked == chosen else chosen
            self.show()

    def action_leave(self) -> None:
        """End a comparison, or go back."""
        if self._marked and self._shows_sessions:
            self._marked = None
            self.show()
        else:
            self.dismiss()

    # --- records

    @property
    def _listed(self) -> list[Record]:
        """The records in the list that is shown; none in other parts."""
        is_shown = self.found is not None and self.part_name == "Records"
        return self.found.records if self.found and is_shown else []

    @property
    def _chosen_record(self) -> int:
        return max(0, min(len(self._listed) - 1, self._record))

    def _choose_record(self, step: int) -> None:
        self._record = max(0, min(len(self._listed) - 1, self._chosen_record + step))
        self.show()

    def action_add_record(self) -> None:
        """Open the form for a new record, of the kind that is chosen in the list."""
        entered = [kind for kind in kinds().values() if kind.entered_by == "therapist"]
        if listed := self._listed:
            chosen = listed[self._chosen_record].kind
            entered.sort(key=lambda kind: kind.name != chosen)
        self.app.push_screen(RecordForm(entered, [self._participant]), self._entered)

    def action_correct_record(self) -> None:
        """Open the form for what is known now of the chosen record, such as its outcome."""
        record = self._listed[self._chosen_record]
        if kind := self._kind_of(record):
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
                self.notify(str(error), severity="error", timeout=20)
            self._entered(True)

        self.app.push_screen(RemoveRecord(record), remove)

    def _kind_of(self, record: Record) -> Kind | None:
        """Return the kind of a record; say so if it is not declared here."""
        try:
            return records.kind_of(record.kind)
        except StoreError as error:
            self.notify(str(error), severity="error", timeout=20)
            return None

    def _entered(self, is_changed: bool | None) -> None:
        """Show what was entered, and choose it: in the list, and in the charts it is marked in."""
        before = self._listed
        if is_changed and self.load():
            new = [number for number, each in enumerate(self._listed) if each not in before]
            if new:
                self._record = new[-1]
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

            self.app.push_screen(ProgressNoteScreen(text))

    def action_page(self) -> None:
        """Write a page with charts into the data folder."""
        if self.found:
            self.notify("Drawing the page …", timeout=3)
            self._write_page(self.found)

    @work(thread=True, exclusive=True, group="page")
    def _write_page(self, found: Progress) -> None:
        from sar_tui.drivers.files import unused, write_private
        from sar_tui.reports.charts import ChartsMissing
        from sar_tui.reports.progress_page import page

        find: Callable[[str], type[Task] | None] = {self._motor_task.name: self._motor_task}.get
        name = f"progress-{self._participant}-{self._motor_task.name}"
        try:
            text = page(found, find, "en")
            path = unused(self.app.folder / f"{name}.html")
            write_private(path, text)
        except ChartsMissing as error:
            self.app.call_from_thread(self.notify, str(error), severity="warning", timeout=20)
        except OSError as error:
            said = f"The page cannot be written: {error.strerror or error}."
            self.app.call_from_thread(self.notify, said, severity="error", timeout=20)
        else:
            said = f"{path} is written. Open it in a browser, which can also print it."
            self.app.call_from_thread(self.notify, said, timeout=12)


_COLORS = {
    POINT: "$accent",
    BAND: "$text-muted",
    AREA: "$border",
    RULE: "$text-muted",
    CHOSEN: "$accent",
}


def colored(lines: list[str]) -> Content:
    """Return lines of text, with the characters of charts in their colours."""
    pieces: list[str | tuple[str, str]] = []
    for line in lines:
        for character in f"{line}\n":
            style = _COLORS.get(character, "")
            last = pieces[-1] if pieces else None
            if isinstance(last, tuple) and last[1] == style:
                pieces[-1] = (last[0] + character, style)
            else:
                pieces.append((character, style))
    return Content.assemble(*pieces)


# --- the note


class ProgressNoteScreen(DismissedOnce[None], ModalScreen[None]):
    """Shows the paragraph in a language, and puts it into the clipboard of terminals that allow it
    (OSC 52).

    Args:
        text: returns the paragraph in a language, given its code.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("tab,l", "language", "Language", id="language"),
        Binding("escape,enter", "dismiss", "Close", id="close"),
    ]

    app: Any

    def __init__(self, text: Callable[[str], str]) -> None:
        super().__init__()
        self._text = text
        self._language = "en"

    def compose(self) -> ComposeResult:
        with Vertical(classes="dialog", id="progress-note"):
            yield Static("", classes="headline", id="headline")
            with VerticalScroll(can_focus=True):
                yield Static("", id="paragraph", markup=False)
            yield Static(
                "It is in the clipboard now, if your terminal allows that. If not, select it with "
                "the mouse (often "
                "with Shift), or use `sar-tui progress CODE --note`.\n\n"
                "Tab: the next language. Up and Down scroll. Esc closes.",
                classes="muted",
                markup=False,
            )

    def on_mount(self) -> None:
        self._show()

    def _show(self) -> None:
        text = self._text(self._language)
        self.query_one("#headline", Static).update(f"Note in {BUNDLED[self._language]}")
        self.query_one("#paragraph", Static).update(text)
        self.app.copy_to_clipboard(text)

    def action_language(self) -> None:
        """Show the note in the next language."""
        codes = list(BUNDLED)
        self._language = codes[(codes.index(self._language) + 1) % len(codes)]
        self._show()
