"""Messages of a clinic to a person who trains at home, a form that it asks for, and the training that
it has seen.
"""

import sqlite3
from collections.abc import Sequence
from datetime import date, timedelta
from typing import TYPE_CHECKING, Any

from sar_tui.app.interview import Page
from sar_tui.model.language import Language
from sar_tui.model.step import Entry
from sar_tui.rules.scanning import Choice

if TYPE_CHECKING:
    from sar_tui.app.letters import Letters
    from sar_tui.records.kind import Kind
    from sar_tui.store.records import Record

NOT_RECEIVED = "Your results do not reach your therapist. Please call them."
"""Read by the participant if the clinic takes no letters from here."""
NOT_RECEIVED_WHY = "The clinic takes no letters from this computer. Ask it for a new invitation."
"""Read by the therapist."""
_WEEKDAYS = ("Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday")
_PLAIN = str.maketrans("–—“”„‘’", '--"""\'\'')
"""Characters that have a large shape, for those that have none."""
_WEEK = timedelta(days=7)


class Notices:
    """Pages of words that are read one after the other, each until Enter; an `Interview` that asks
    nothing.

    Args:
        title: who says it.
        pages: of words.
        tr: texts in the language of the participant.
        choices: for a switch, on each page.
        can_leave: Escape leaves them.

    Attributes:
        result: True once all were read; False if they were left.
    """

    theme = None
    step = None
    said_before = ""
    can_go_back = False

    def __init__(
        self,
        title: str,
        pages: Sequence[Page],
        tr: Language,
        choices: tuple[Choice, ...],
        *,
        can_leave: bool = False,
    ) -> None:
        self.title, self.tr, self.choices, self.can_leave = title, tr, choices, can_leave
        self._pages = pages
        self.entry = Entry()
        self.place = 0
        self.result = self.is_over = False

    @property
    def help_text(self) -> str:
        """The keys."""
        page = self._pages[self.place]
        return "\n".join(filter(None, (page.press, page.decline))) + "\n"

    def page(self, marked: Entry | None = None) -> Page:
        """Return the words."""
        where = ""
        if len(self._pages) > 1:
            number, total = self.place + 1, len(self._pages)
            where = self.tr("{number} of {total}", number=number, total=total)
        return self._pages[self.place]._replace(where=where)

    def only_chooses(self, key: str) -> bool:
        """Return False: nothing is chosen."""
        return False

    def press(self, key: str, character: str | None) -> None:
        """Handle a key."""
        if key == "enter" and self.place + 1 < len(self._pages):
            self.place += 1
        elif key == "enter":
            self.result = self.is_over = True
        elif key == "escape" and self.can_leave:
            self.is_over = True


class FromClinic:
    """Messages and wishes of the clinic for a person, and those that they have read since the program
    began.

    Args:
        app: has the ``database``.
        participant: the code.
        letters: of the data folder, which is a home.
    """

    def __init__(self, app: Any, participant: str, letters: "Letters") -> None:
        self._app = app
        self._participant = participant
        self._clinic = letters.clinic
        self._read: set[str] = set()
        self._put_off: set[str] = set()

    @property
    def _database(self) -> sqlite3.Connection:
        database: sqlite3.Connection = self._app.database
        return database

    # --- messages

    def unread(self) -> "list[Record]":
        """Return the messages that nobody has read yet, the oldest first."""
        from sar_tui.letterbox import status

        found = status.unread(self._database, self._participant)
        return [each for each in found if each.id not in self._read]

    def show(self, messages: "Sequence[Record]", tr: Language) -> Notices:
        """Return messages as pages."""
        instruction, press = (
            tr("A message from your therapist"),
            tr("Press Enter when you have read it."),
        )
        texts = [str(each.content.get("text", "")).translate(_PLAIN) for each in messages]
        pages = [Page(text, (), press, instruction=instruction) for text in texts]
        return Notices(self._clinic, pages, tr, (Choice(tr("I have read it"), ("enter",)),))

    def mark_read(self, messages: "Sequence[Record]") -> None:
        """Note that messages were read, so that the clinic hears of it.

        Raises:
            StoreError: it cannot be stored; they are shown again when the program is opened.
        """
        from sar_tui.letterbox import correspondents
        from sar_tui.store.database import transaction

        self._read.update(each.id for each in messages)
        with transaction(self._database) as database:
            if not self.unread():  # one that came meanwhile is shown first
                correspondents.mark_seen(database, self._participant)

    # --- a form

    def form(self) -> "Kind | None":
        """Return the form that the clinic asks for, unless it was put off; None if there is none."""
        from sar_tui.letterbox import status
        from sar_tui.store import forms

        name = status.requested_form(self._database, self._participant)
        return forms.form(name) if name and name not in self._put_off else None

    def offer(self, tr: Language) -> Notices:
        """Return the question whether the form is filled in now."""
        page = Page(
            tr("Your therapist would like to know how you are."),
            (tr("There are a few questions."),),
            tr("Press Enter to answer."),
            decline=tr("Press Esc to answer later."),
        )
        choices = Choice(tr("Answer"), ("enter",)), Choice(tr("Later"), ("escape",))
        return Notices(self._clinic, [page], tr, choices, can_leave=True)

    def put_off(self, kind: "Kind") -> None:
        """Offer a form no more until the program is opened again."""
        self._put_off.add(kind.name)

    # --- beside the exercises

    def lines(self, today: date, tr: Language) -> list[str]:
        """Return what the clinic has seen of the training, and when the next one is, if it is not
        today.
        """
        from sar_tui.letterbox import status

        clinic = status.clinic(self._database)
        days = status.training_days(self._database, self._participant)
        said = (_seen(clinic.seen if clinic else None, today, tr), _next(days, today, tr))
        return [text for text in said if text]

    @property
    def is_refused(self) -> bool:
        """True if the clinic takes no letters from here."""
        from sar_tui.letterbox import status

        clinic = status.clinic(self._database)
        return clinic is not None and clinic.state in ("revoked", "declined")


def _seen(day: date | None, today: date, tr: Language) -> str:
    if day == today:
        return tr("Your therapist has seen today's training.")
    if day is None or not timedelta() < today - day < _WEEK:
        return ""
    return tr("Your therapist has seen {day}'s training.", day=tr(_WEEKDAYS[day.weekday()]))


def _next(days: Sequence[str], today: date, tr: Language) -> str:
    """Return when the next training is; empty if it is today, or if no days are planned."""
    from sar_tui.letterbox.status import DAYS

    planned = [DAYS.index(day) for day in days]
    if not planned or today.weekday() in planned:
        return ""
    ahead = min((day - today.weekday()) % len(DAYS) for day in planned)
    if ahead == 1:
        return tr("Next training: tomorrow.")
    weekday = _WEEKDAYS[(today.weekday() + ahead) % len(_WEEKDAYS)]
    return tr("Next training: {day}.", day=tr(weekday))
