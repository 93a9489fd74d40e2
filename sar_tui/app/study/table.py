"""The people of a study in a table: a row a person, a column a visit."""

from collections.abc import Iterator, Sequence
from typing import Any

from textual.app import ComposeResult
from textual.containers import Vertical
from textual.content import Content
from textual.events import Resize
from textual.widgets import Static
from textual.widgets.option_list import Option

from sar_tui.app.code_list import BESIDE, CodeList, code_cell, code_width
from sar_tui.app.study.words import cell_words
from sar_tui.model.language import Language, in_language
from sar_tui.study.ledger import ENDS
from sar_tui.study.plan import Study
from sar_tui.study.schedule import State
from sar_tui.study.status import PersonRow, VisitCell

_GAP, _WIDEST_GAP = 2, 8
"""Blanks between columns: the fewest, and the most where there is room."""
_LONGEST_NAME = 16
_SIGNS: dict[State, str] = {"done": "●", "due": "▸", "early": "·", "late": "»", "missed": "–"}
_LEFT, _PLAYING = "×", "◆"
_STYLES: dict[State, str] = {"due": "$accent", "late": "$warning"}


class StudyTable(Vertical):
    """Shows groups, and states of visits in words, or in signs where there is no room for words; of
    more visits than there is room for, those from the first on that somebody has to do.

    Groups are left out if they would take the room of words, or of visits.
    """

    app: Any

    def __init__(self, **how: Any) -> None:
        super().__init__(**how)
        self._plan: Study | None = None
        self._rows: dict[str, PersonRow] = {}

    def compose(self) -> ComposeResult:
        yield Static("", id="columns", markup=False)
        yield CodeList(id="people")
        yield Static("", id="legend", markup=False)

    def on_mount(self) -> None:
        self.watch(self.people, "sought", self._show_sought)

    def _show_sought(self) -> None:
        self.border_subtitle = self.people.find_words(self.app.tr("type to find"))

    @property
    def people(self) -> CodeList:
        """The rows."""
        return self.query_one(CodeList)

    def show(self, plan: Study, rows: Sequence[PersonRow], chosen: str | None) -> None:
        """Show people, with one of them chosen."""
        self._plan = plan
        self._rows = {row.participant: row for row in rows}
        count, tr = len(rows), self.app.tr
        self.border_title = tr("{count} people", count=count) if count > 1 else tr("People")
        self._draw(chosen)
        self._show_sought()

    def on_resize(self, event: Resize) -> None:
        """Fit the columns into another width."""
        if self._plan:
            self._draw(self.people.chosen)

    def _draw(self, chosen: str | None) -> None:
        assert self._plan
        tr, visits = self.app.tr, [visit.name for visit in self._plan.visits]
        columns = code_width(self._rows)
        room = self.content_size.width - BESIDE - columns
        groups = {code: row.group[:_LONGEST_NAME] for code, row in self._rows.items()}
        group = tr("Group")
        of_group = max(len(group), *map(len, groups.values())) if any(groups.values()) else 0
        words = {
            (row.participant, name): self._words(row, row.visits[name])
            for row in self._rows.values()
            for name in visits
        }
        titles = {name: name[:_LONGEST_NAME] for name in visits}
        widths = {
            name: max([len(titles[name]), *(len(words[code, name]) for code in self._rows)])
            for name in visits
        }
        is_in_words = sum(widths.values()) + _GAP * len(visits) <= room
        if not is_in_words:
            titles = {name: str(number) for number, name in enumerate(visits, 1)}
            words = {
                place: _sign(self._rows[place[0]], place[1]) if said else ""
                for place, said in words.items()
            }
            widths = dict.fromkeys(visits, 2)
            visits = self._fitting(visits, max(0, room // (2 + _GAP)))
        taken = sum(widths[name] + _GAP for name in visits)
        if of_group and taken + of_group + _GAP <= room:
            room -= of_group
        else:
            of_group = 0
        spare = room - sum(widths[name] for name in visits)
        gap = " " * max(
            _GAP, min(_WIDEST_GAP, spare // (len(visits) + bool(of_group)) if visits else 0)
        )
        names = [f"{titles[name]:<{widths[name]}}" for name in visits]
        beside = [f"{group:<{of_group}}"] if of_group else []
        heading = gap.join([" " * (columns + 1), *beside, *names])
        self.query_one("#columns", Static).update(heading.rstrip())
        legend = self.query_one("#legend", Static)
        legend.display = bool(self._rows) and not is_in_words
        legend.update(tr("● done  ◆ now  ▸ due  · not yet  » late  – missed  × left  ! deviation"))

        def row(code: str) -> Content:
            cells = [
                Content.styled(
                    f"{words[code, visit]:<{widths[visit]}}", self._style(self._rows[code], visit)
                )
                for visit in visits
            ]
            in_group = [Content(f"{groups[code]:<{of_group}}")] if of_group else []
            return Content(gap).join([code_cell(code, columns), *in_group, *cells])

        def lines(codes: Sequence[str]) -> Iterator[Option]:
            return (Option(row(code), id=code) for code in codes)

        self.people.list_people(dict.fromkeys(self._rows, ""), lines, chosen)

    def _fitting(self, visits: list[str], most: int) -> list[str]:
        """Return as many visits as there is room for, from the first on that is not over for all."""
        first = next(
            (
                at
                for at, name in enumerate(visits)
                if any(
                    not row.ended and row.visits[name].state not in ("done", "missed")
                    for row in self._rows.values()
                )
            ),
            0,
        )
        first = max(0, min(first, len(visits) - most))
        return visits[first : first + most]

    def _words(self, row: PersonRow, cell: VisitCell) -> str:
        """Return the state of a visit; of whoever has left, how it ended at the first that is not
        done.
        """
        tr: Language = self.app.tr
        if not row.ended or cell.state == "done":
            return cell_words(cell, self.app.today(), tr)
        left = next(each for each in row.visits.values() if each.state != "done")
        return in_language(ENDS.get(row.ended, row.ended), tr) if cell is left else ""

    def _style(self, row: PersonRow, visit: str) -> str:
        cell = row.visits[visit]
        if cell.playing:
            return "$success"
        if row.ended or cell.state in ("done", "missed", "open"):
            return "$text-muted"
        return _STYLES.get(cell.state, "")


def _sign(row: PersonRow, visit: str) -> str:
    cell = row.visits[visit]
    sign = _LEFT if row.ended and cell.state != "done" else _SIGNS.get(cell.state, " ")
    sign = _PLAYING if cell.playing else sign
    return f"{sign}{'!' if cell.deviated else ''}"
