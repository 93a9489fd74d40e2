"""Keys of the progress screen that enter, change and remove adverse events and scores of other
instruments.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from sar_tui.model.language import Language
from sar_tui.progress.instruments import Score
from sar_tui.reports import progress_parts
from sar_tui.store.adverse_events import AdverseEvent
from sar_tui.store.database import StoreError

if TYPE_CHECKING:
    from sar_tui.app.screens.progress import ProgressScreen

RECORDS = ("Events", "Instruments")
"""Parts of the screen that list them."""


class Records:
    """The part of `ProgressScreen` for what is entered by hand; one row of each list is chosen."""

    def __init__(self, screen: "ProgressScreen", participant: str, tr: Language) -> None:
        self._screen = screen
        self._participant = participant
        self._tr = tr
        self._chosen = dict.fromkeys(RECORDS, 0)

    def _shown_records(self) -> Sequence[AdverseEvent | Score]:
        """Return the rows of the list that is shown; none in other parts."""
        if self._screen.found is None:
            return ()
        match self._screen.part_name:
            case "Events":
                return self._screen.found.events
            case "Instruments":
                return progress_parts.scores(self._screen.found)
        return ()

    @property
    def count(self) -> int:
        """Number of rows of the list that is shown."""
        return len(self._shown_records())

    @property
    def _chosen_record(self) -> int:
        return max(0, min(self.count - 1, self._chosen[self._screen.part_name]))

    def choose(self, step: int) -> None:
        """Choose an earlier or later row."""
        self._chosen[self._screen.part_name] = max(
            0, min(self.count - 1, self._chosen_record + step)
        )
        self._screen.show()

    def lines(self, size: tuple[int, int]) -> list[str]:
        """Return the lines of the list."""
        assert self._screen.found
        draw = (
            progress_parts.events_part
            if self._screen.part_name == "Events"
            else progress_parts.instruments_part
        )
        return draw(self._screen.found, size, self._chosen_record, self._tr)

    def add(self) -> None:
        """Open the form for a new event or score."""
        from datetime import date

        from sar_tui.app.screens.adverse_event import AdverseEventScreen
        from sar_tui.app.screens.instrument_score import InstrumentScoreScreen

        if self._screen.part_name == "Events":
            self._screen.app.push_screen(
                AdverseEventScreen([self._participant], date.today().isoformat()), self._entered
            )
            return
        assert self._screen.found
        known = progress_parts.scores(self._screen.found)
        first = [known[self._chosen_record].instrument] if known else []
        self._screen.app.push_screen(
            InstrumentScoreScreen(self._participant, *first), self._entered
        )

    def change_event(self) -> None:
        """Open the form for what is known now of the chosen event, such as its outcome."""
        from sar_tui.app.screens.adverse_event import AdverseEventScreen

        assert self._screen.found
        event = self._screen.found.events[self._chosen_record]
        self._screen.app.push_screen(
            AdverseEventScreen([self._participant], event=event), self._entered
        )

    def remove_score(self) -> None:
        """Ask whether the chosen score was entered by mistake, and remove it then."""
        from sar_tui.app.screens.remove_score import RemoveScoreScreen
        from sar_tui.drivers.login_name import login_name
        from sar_tui.store import instrument_scores

        assert self._screen.found
        score = progress_parts.scores(self._screen.found)[self._chosen_record]

        def remove(is_mistake: bool | None) -> None:
            if not is_mistake:
                return
            try:
                instrument_scores.remove(
                    self._screen.app.database,
                    self._participant,
                    score.instrument,
                    score.date,
                    author=login_name(),
                )
            except StoreError as error:
                self._screen.notify(str(error), severity="error", timeout=20)
            self._entered(True)

        self._screen.app.push_screen(RemoveScoreScreen(score), remove)

    def _entered(self, is_changed: bool | None) -> None:
        """Show what was entered, and choose it: in the list, and in the charts it is marked in."""
        before = self._shown_records()
        if is_changed and self._screen.load():
            new = [
                number for number, each in enumerate(self._shown_records()) if each not in before
            ]
            if new:
                self._chosen[self._screen.part_name] = new[-1]
            self._screen.refresh_bindings()
            self._screen.show()
