"""The dialog in which a therapist writes to a person who trains at home."""

from datetime import UTC, date, datetime
from typing import TYPE_CHECKING, Any, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static

from sar_tui.app.home.words import DAYS, day_words
from sar_tui.drivers.login_name import login_name
from sar_tui.letterbox import post, status
from sar_tui.letterbox.status import LastMessage
from sar_tui.model.language import in_language
from sar_tui.store.database import StoreError
from sar_tui.tui.dismissed_once import DismissedOnce

if TYPE_CHECKING:
    from sar_tui.model.language import Language

_TOO_LONG = 120
"""Characters of the last message that are shown."""


class MessageScreen(DismissedOnce[bool], ModalScreen[bool]):
    """Asks for a message and for days of training; its result is True if something was written.

    Args:
        participant: the code.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(False)", "Cancel", id="cancel"),
        Binding("down", "app.focus_next", "Next", show=False, id="down"),
        Binding("up", "app.focus_previous", "Previous", show=False, id="up"),
    ]

    app: Any

    def __init__(self, participant: str) -> None:
        super().__init__()
        self._participant = participant
        self._days = ""

    def compose(self) -> ComposeResult:
        tr: Language = self.app.tr
        planned = status.training_days(self.app.database, self._participant)
        self._days = " ".join(tr(DAYS[status.DAYS.index(day)]) for day in planned)
        example = ", ".join(tr(DAYS[day]) for day in (0, 2, 4))
        last = status.last_message(self.app.database, self._participant)
        with Vertical(classes="dialog"):
            yield Static(
                tr("Message to {who}", who=self._participant), classes="headline", markup=False
            )
            yield Static(
                tr("They read it in large print before they train. At most {count} characters.",
                   count=post.LONGEST_MESSAGE), markup=False,
            )  # fmt: skip
            yield Input(max_length=post.LONGEST_MESSAGE, id="message")
            yield Static(tr("Days of training, such as {days}:", days=example), markup=False)
            yield Input(self._days, id="days", compact=True)
            yield Static("", id="problem", markup=False)
            if last:
                said = _last_words(last, self.app.today(), tr)
                yield Static(said, id="last-message", markup=False)
            yield Static(tr("Enter sends, Esc cancels."), classes="muted")

    @on(Input.Submitted)
    def _send(self) -> None:
        text = self.query_one("#message", Input).value.strip()
        days = self.query_one("#days", Input).value.replace(",", " ")
        are_new = bool(days.strip()) and days.split() != self._days.split()
        if not text and not are_new:
            self.query_one("#problem", Static).update(self.app.tr("Write a message first."))
            return
        database, author = self.app.database, login_name()
        try:
            if are_new:  # first: a mistake there must not send the message
                named = in_english(days.split(), self.app.tr)
                post.plan_days(database, self._participant, named, author=author)
                self._days = days
            if text:
                post.write_message(database, self._participant, text, author=author)
        except StoreError as error:
            self.query_one("#problem", Static).update(in_language(error, self.app.tr))
            return
        self.dismiss(True)


def in_english(days: list[str], tr: "Language") -> list[str]:
    """Return days of the week as they are stored, of those that are named in a language."""
    known = {tr(name).casefold(): day for name, day in zip(DAYS, status.DAYS, strict=True)}
    return [known.get(day.casefold().strip("."), day) for day in days]


def _last_words(last: LastMessage, today: date, tr: "Language") -> str:
    """Return the last message, and what became of it."""
    written = _local(last.written_at)
    if last.read_at:
        read = _local(last.read_at)
        became = tr("They have read it: heard {day} {clock}.",
                    day=day_words(read.date(), today, tr), clock=f"{read:%H:%M}")  # fmt: skip
    elif last.has_arrived:
        became = tr("It has arrived, and is not read yet.")
    else:
        became = tr("It has not arrived yet.")
    day = day_words(written.date(), today, tr)
    text = last.text if len(last.text) <= _TOO_LONG else f"{last.text[:_TOO_LONG]}…"
    head = tr("The last one, {day}: {text}", day=day, text=f"“{text}”")
    return f"{head}\n{became}"


def _local(at: str) -> datetime:
    """Return a stored time as the clock here shows it."""
    stored = datetime.fromisoformat(at)
    return (stored if stored.tzinfo else stored.replace(tzinfo=UTC)).astimezone()
