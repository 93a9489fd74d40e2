"""The sessions of a participant, or of everyone, as results. One can be dismissed, or restored."""

from collections.abc import Sequence
from datetime import date
from typing import TYPE_CHECKING, Any, ClassVar

import msgspec
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.content import Content
from textual.events import Resize
from textual.widgets import Static
from textual.widgets.option_list import Option

from sar_tui.app.home.words import bars, day_words
from sar_tui.drivers.login_name import login_name
from sar_tui.model.language import Language, in_language
from sar_tui.store.database import StoreError
from sar_tui.widgets.lists import MarkedList, OptionList

if TYPE_CHECKING:
    from sar_tui.app.home.contents import Listed
    from sar_tui.model.messages import RecordChange
    from sar_tui.store.sessions import Row

_BESIDE = 4
"""Columns of a line's padding and the scroll bar."""


class SessionList(Vertical):
    """A table of sessions, newest first."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("delete,backspace", "dismiss_session", "Dismiss", id="dismiss-session"),
        Binding("delete,backspace", "take_back", "Take back", id="take-back"),
    ]

    app: Any

    def __init__(self, id: str) -> None:
        super().__init__(id=id)
        self._who: str | None = None
        self._listed: Listed | None = None

    def compose(self) -> ComposeResult:
        yield Static("", id="columns", markup=False)
        yield MarkedList(id="recent", markup=False)

    def on_mount(self) -> None:
        self.border_title = self.app.tr("Sessions")

    def show(self, participant: str | None) -> None:
        """List the sessions of a participant, or of everyone."""
        from sar_tui.app.home.contents import read_sessions

        chosen = self._recent.chosen if participant == self._who else None
        self._who = participant
        app, tr = self.app, self.app.tr
        self._listed = read_sessions(app.database, app.folder, app.catalogue, participant, tr)
        self.border_title = (
            tr("Sessions of {who}", who=participant) if participant else tr("Sessions of everyone")
        )
        self._draw(chosen)

    @property
    def _recent(self) -> MarkedList:
        return self.query_one("#recent", MarkedList)

    @property
    def offered(self) -> "Row | None":
        """The interrupted session that is offered."""
        return self._listed.offered if self._listed else None

    @property
    def offer(self) -> "tuple[date, int, object] | None":
        """Day, attempts done and attempts planned of the session that is offered."""
        if not self._listed or not self._listed.offered:
            return None
        line = self._listed.lines[self._listed.rows.index(self._listed.offered)]
        return (
            line.day,
            self._listed.offered["attempts"],
            self._listed.offered["parameters"].get("attempts", "?"),
        )

    @property
    def chosen(self) -> "Row | None":
        """The chosen session."""
        name = self._recent.chosen
        return (
            next((row for row in self._listed.rows if row["id"] == name), None)
            if self._listed
            else None
        )

    def enter_words(self) -> str:
        """Return what Enter does with the chosen session."""
        from sar_tui.app.home.contents import can_resume

        if (row := self.chosen) is None:
            return ""
        if can_resume(row):
            return str(self.app.tr("Press Enter to go on with this session."))
        return str(self.app.tr("Press Enter to look at this session."))

    def choose_offered(self) -> None:
        """Choose the session that is offered, if there is one."""
        if self.offered:
            self._recent.choose(self.offered["id"])

    def _draw(self, chosen: str | None) -> None:
        if self._listed is None:
            return
        rows, lines = self._listed.rows, self._listed.lines
        table = Table(
            lines,
            max(20, self.size.width - _BESIDE),
            self.app.today(),
            self.app.tr,
            names_who=self._who is None,
        )
        self.query_one("#columns", Static).update(table.heading if rows else "")
        recent = self._recent
        recent.clear_options()
        if rows:
            recent.add_options(
                [
                    Option(table.draw(line), id=row["id"])
                    for row, line in zip(rows, lines, strict=True)
                ]
            )
            recent.choose(chosen)
        else:
            recent.add_option(Option(self.app.tr("No session yet."), disabled=True))
        self.refresh_bindings()

    def on_resize(self, event: Resize) -> None:
        """Fit the lines into another width."""
        self._draw(self._recent.chosen)

    def on_descendant_focus(self) -> None:
        """Say how to leave the list while the cursor is in it."""
        self.border_subtitle = self.app.tr("Esc goes back")

    def on_descendant_blur(self) -> None:
        self.border_subtitle = ""

    # --- dismissing

    def on_option_list_option_highlighted(self, event: OptionList.OptionHighlighted) -> None:
        """Show the key that dismisses the chosen session, if it is interrupted."""
        self.refresh_bindings()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        from sar_tui.app.home.contents import can_resume

        row = self.chosen
        if action == "dismiss_session":
            return row is not None and can_resume(row)
        if action == "take_back":
            return (
                row is not None and row["status"] in ("dismissed", "discarded") and not row["site"]
            )
        return super().check_action(action, parameters)

    def action_dismiss_session(self) -> None:
        """Dismiss the chosen session, which nobody goes on with."""
        self._change("dismissed")

    def action_take_back(self) -> None:
        """Let the chosen session be resumed again, or count again."""
        self._change("restored")

    def _change(self, change: "RecordChange") -> None:
        from sar_tui.store.record_changes import change_status

        try:
            chosen = self._recent.chosen or ""
            change_status(self.app.database, self.app.folder, chosen, change, actor=login_name())
        except StoreError as error:
            self.notify(in_language(error, self.app.tr), severity="error", timeout=15)
        self.screen.refresh_contents()  # type: ignore[attr-defined]


ROOMY = 90
"""Columns from which on a table has room for more."""
_GAPS = ("  ", " ")
"""Blanks between columns, the first if there is room for them."""
_HEADINGS = {
    "day": "Date",
    "clock": "Time",
    "who": "Who",
    "task": "Task",
    "level": "Level",
    "result": "Result",
    "reached": "Reached",
    "pain": "Pain",
    "tired": "Tired",
    "levels": "Levels",
    "minutes": "Minutes",
}


class Line(msgspec.Struct, frozen=True):
    """A session: the cells of its line. ``levels`` are those of its attempts, ``pain`` and ``tired``
    the worst ratings, ``note`` stands at the end.
    """

    day: date
    clock: str
    who: str
    task: str
    levels: Sequence[int]
    result: str
    reached: str
    minutes: int
    note: str
    pain: str = ""
    tired: str = ""


class Table:
    """The table for a list of sessions.

    Args:
        lines: the sessions.
        width: columns that there is room for.
        today: the date.
        tr: the language.
        names_who: True if they are sessions of several participants.
    """

    def __init__(
        self, lines: Sequence[Line], width: int, today: date, tr: Language, *, names_who: bool
    ) -> None:
        self._lines, self._width, self._today, self._tr = lines, width, today, tr
        self._highest = max((level for line in lines for level in line.levels), default=1)
        is_roomy = width >= ROOMY
        columns = {"day": max([11, *(len(day_words(line.day, today, tr)) for line in lines)])}
        if is_roomy:
            columns["clock"] = 5
        if names_who:
            columns["who"] = 12 if is_roomy else 8
        if names_who or len({line.task for line in lines}) > 1:
            columns["task"] = 20 if is_roomy else 12
        if is_roomy or not names_who:
            columns |= {"level": 7 if is_roomy else 5, "result": 8 if is_roomy else 6}
        columns["reached"] = 8
        columns |= {name: 4 for name in ("pain", "tired") if any(getattr(x, name) for x in lines)}
        longest = max((len(line.levels) for line in lines), default=0)
        columns["levels"] = min(max(longest + 1, 7), 40 if is_roomy else 12)
        if is_roomy:
            columns["minutes"] = 7
        self._columns = {name: max(columns[name], len(tr(_HEADINGS[name]))) for name in columns}
        needed = sum(self._columns.values()) + max((len(line.note) for line in lines), default=0)
        wide, narrow = _GAPS
        is_wide = needed + len(wide) * len(columns) <= width
        self._gap = wide if is_wide else narrow

    @property
    def heading(self) -> str:
        """The names of the columns."""
        return self._gap.join(
            f"{self._tr(_HEADINGS[name]):<{width}}" for name, width in self._columns.items()
        ).rstrip()

    def draw(self, line: Line) -> Content:
        """Return the line of a session."""
        tr = self._tr
        cells = {
            "day": day_words(line.day, self._today, tr),
            "clock": line.clock,
            "who": line.who,
            "task": line.task,
            "level": _from_to(line.levels),
            "result": line.result,
            "reached": line.reached,
            "pain": line.pain.rjust(self._columns.get("pain", 0)),
            "tired": line.tired.rjust(self._columns.get("tired", 0)),
            "levels": bars(line.levels, self._highest, self._columns["levels"]),
            "minutes": tr("{minutes} min", minutes=line.minutes) if line.minutes else "",
        }
        columns = dict(self._columns)
        for name in ("minutes", "levels", "tired", "pain"):
            if sum(columns.values()) + len(columns) * len(self._gap) + len(line.note) > self._width:
                columns.pop(name, None)  # why a session stands out says more
        drawn = Content(self._gap).join(
            Content.styled(_fitted(cells[name], width), "$text-muted" if name == "levels" else "")
            for name, width in columns.items()
        )
        return (drawn + f"{self._gap}{line.note}").rstrip().truncate(self._width, ellipsis=True)


def _from_to(levels: Sequence[int]) -> str:
    if not levels:
        return ""
    return str(levels[0]) if levels[0] == levels[-1] else f"{levels[0]}→{levels[-1]}"


def _fitted(text: str, width: int) -> str:
    return f"{text[: width - 1]}…" if len(text) > width else f"{text:<{width}}"
