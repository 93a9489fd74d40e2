"""Enters a score of another instrument, such as the FMA-UE."""

from datetime import date
from typing import Any, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static

from sar_tui.drivers.login_name import login_name
from sar_tui.progress.instruments import INSTRUMENTS, Instrument, Score
from sar_tui.store import instrument_scores
from sar_tui.store.database import StoreError
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.choice import Choice

_BETWEEN = " · "


class InstrumentScoreScreen(DismissedOnce[bool], ModalScreen[bool]):
    """A short form; the result is True if the score was entered.

    Args:
        participant: whose score.
        instrument: the name of the one to begin with.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(False)", "Cancel", id="cancel"),
        Binding("down", "app.focus_next", "Next", show=False, id="down"),
        Binding("up", "app.focus_previous", "Previous", show=False, id="up"),
    ]
    AUTO_FOCUS = "Choice"

    app: Any

    def __init__(self, participant: str, instrument: str = "FMA-UE") -> None:
        super().__init__()
        self._participant = participant
        self._first = INSTRUMENTS[instrument]

    def compose(self) -> ComposeResult:
        with Vertical(id="instrument-score", classes="form"):
            yield Static(f"Score of {self._participant}", classes="headline", markup=False)
            yield Static("", id="problem", markup=False)
            instruments = Choice(
                [_title(each) for each in INSTRUMENTS.values()], _title(self._first)
            )
            instruments.border_title = "Instrument"
            yield instruments
            yield self._field("score", "Score", "")
            yield self._field("date", "Day it was measured", date.today().isoformat())
            yield self._field(
                "note", "Remark", "", "such as the goal of GAS, or the assessor; may be empty"
            )
            yield Static(
                "Enter opens the list of instruments, goes on from field to field, and saves "
                "after the last one. "
                "Tab: next field. Esc: cancel.",
                classes="muted",
            )

    @staticmethod
    def _field(name: str, title: str, value: str, hint: str = "") -> Input:
        made = Input(value, placeholder=hint, id=name, compact=True)
        made.border_title = title
        return made

    def on_mount(self) -> None:
        self._show_range()

    @property
    def _instrument(self) -> Instrument:
        return INSTRUMENTS[self.query_one(Choice).value.split(_BETWEEN)[0]]

    @on(Choice.Changed)
    def _chosen(self) -> None:
        self._show_range()
        self.query_one("#score").focus()

    def _show_range(self) -> None:
        """Show the range of the chosen instrument at its score, and what is wrong with a score
        outside of it.
        """
        chosen, field = self._instrument, self.query_one("#score", Input)
        unit = f" {chosen.unit}".rstrip()
        field.border_title = (
            f"Score, {chosen.lowest:g} to {chosen.highest:g}{unit}; {chosen.better} is better"
        )
        self._check_score()

    @on(Input.Changed, "#score")
    @on(Input.Changed, "#date")
    def _check_score(self) -> None:
        text, problem = self.query_one("#score", Input).value.strip(), self._replaced()
        if text:
            try:
                instrument_scores.check_score(self._instrument, _number(text))
            except StoreError as error:
                problem = str(error)
        self.query_one("#problem", Static).update(problem)

    def _replaced(self) -> str:
        """Return that a score of the same instrument and day would be replaced; empty if there is
        none.
        """
        day = self.query_one("#date", Input).value.strip()
        for each in instrument_scores.scores_of(self.app.database, self._participant):
            if (each.instrument, each.date) == (self._instrument.name, day):
                return f"This replaces {each.score:g} of the same day."
        return ""

    @on(Input.Submitted)
    def _entered(self, event: Input.Submitted) -> None:
        event.stop()
        if event.input.id != "note":
            self.focus_next()
            return
        score, day, note = (
            self.query_one(f"#{name}", Input).value for name in ("score", "date", "note")
        )
        try:
            entered = Score(self._instrument.name, day, _number(score), note)
            instrument_scores.add(
                self.app.database, self._participant, entered, author=login_name()
            )
        except StoreError as error:
            self.query_one("#problem", Static).update(str(error))
        else:
            self.dismiss(True)


def _title(instrument: Instrument) -> str:
    return f"{instrument.name}{_BETWEEN}{instrument.title}"


def _number(text: str) -> float:
    """Return a number, written with a decimal point or comma. Raises StoreError."""
    try:
        return float(text.strip().replace(",", "."))
    except ValueError:
        raise StoreError(
            f"The score must be a number, not {text.strip()!r}.", bad_input=True
        ) from None
