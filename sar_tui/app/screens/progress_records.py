"""Keys of the progress screen that enter, change and remove adverse events and scores of other
instruments.
"""

from collections.abc import Sequence
from typing import Any

from textual.screen import Screen

from sar_tui.model.language import Language
from sar_tui.progress.instruments import Score
from sar_tui.reports import record_parts
from sar_tui.reports.progress import Progress
from sar_tui.store.adverse_events import AdverseEvent
from sar_tui.store.database import StoreError

RECORDS = ("Events", "Instruments")
"""Parts of the screen that list them."""


class Records(Screen[None]):
    """The part of `ProgressScreen` for what is entered by hand; one row of each list is chosen."""

    app: Any
    _participant: str
    _found: Progress | None
    _tr: Language

    def __init__(self) -> None:
        super().__init__()
        self._records = dict.fromkeys(RECORDS, 0)

    @property
    def _part_name(self) -> str:
        raise NotImplementedError

    def _load(self) -> bool:
        raise NotImplementedError

    def _show(self) -> None:
        raise NotImplementedError

    def _shown_records(self) -> Sequence[AdverseEvent | Score]:
        """Return the rows of the list that is shown; none in other parts."""
        if self._found is None:
            return ()
        match self._part_name:
            case "Events":
                return self._found.events
            case "Instruments":
                return record_parts.scores(self._found)
        return ()

    def _count_records(self) -> int:
        return len(self._shown_records())

    @property
    def _chosen_record(self) -> int:
        return max(0, min(self._count_records() - 1, self._records[self._part_name]))

    def _choose_record(self, step: int) -> None:
        self._records[self._part_name] = max(
            0, min(self._count_records() - 1, self._chosen_record + step)
        )
        self._show()

    def _lines_of_records(self, size: tuple[int, int]) -> list[str]:
        assert self._found
        draw = (
            record_parts.events_part
            if self._part_name == "Events"
            else record_parts.instruments_part
        )
        return draw(self._found, size, self._chosen_record, self._tr)

    def action_add_record(self) -> None:
        """Open the form for a new event or score."""
        from datetime import date

        from sar_tui.app.screens.adverse_event import AdverseEventScreen
        from sar_tui.app.screens.instrument_score import InstrumentScoreScreen

        if self._part_name == "Events":
            self.app.push_screen(
                AdverseEventScreen([self._participant], date.today().isoformat()), self._entered
            )
            return
        assert self._found
        known = record_parts.scores(self._found)
        first = [known[self._chosen_record].instrument] if known else []
        self.app.push_screen(InstrumentScoreScreen(self._participant, *first), self._entered)

    def action_change_event(self) -> None:
        """Open the form for what is known now of the chosen event, such as its outcome."""
        from sar_tui.app.screens.adverse_event import AdverseEventScreen

        assert self._found
        event = self._found.events[self._chosen_record]
        self.app.push_screen(AdverseEventScreen([self._participant], event=event), self._entered)

    def action_remove_score(self) -> None:
        """Ask whether the chosen score was entered by mistake, and remove it then."""
        from sar_tui.app.screens.remove_score import RemoveScoreScreen
        from sar_tui.drivers.login_name import login_name
        from sar_tui.store import instrument_scores

        assert self._found
        score = record_parts.scores(self._found)[self._chosen_record]

        def remove(is_mistake: bool | None) -> None:
            if not is_mistake:
                return
            try:
                instrument_scores.remove(
                    self.app.database,
                    self._participant,
                    score.instrument,
                    score.date,
                    author=login_name(),
                )
            except StoreError as error:
                self.notify(str(error), severity="error", timeout=20)
            self._entered(True)

        self.app.push_screen(RemoveScoreScreen(score), remove)

    def _entered(self, is_changed: bool | None) -> None:
        """Show what was entered, and choose it: in the list, and in the charts it is marked in."""
        before = self._shown_records()
        if is_changed and self._load():
            new = [
                number for number, each in enumerate(self._shown_records()) if each not in before
            ]
            if new:
                self._records[self._part_name] = new[-1]
            self.refresh_bindings()
            self._show()
