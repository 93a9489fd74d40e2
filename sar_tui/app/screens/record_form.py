"""The form for a record of any kind, made from its declaration."""

from collections.abc import Sequence
from datetime import date
from typing import Any, ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static

from sar_tui.drivers.login_name import login_name
from sar_tui.model.language import in_language
from sar_tui.records.kind import Field, Kind, RecordError, Value
from sar_tui.rules.declaration import show
from sar_tui.store import participants, records
from sar_tui.store.database import StoreError
from sar_tui.store.records import Record
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.choice import Choice
from sar_tui.widgets.language import language_of

_BETWEEN = " · "
_WHO, _DATE = "participant", "date"
_BETTER = {"": "", "higher": "higher is better", "lower": "lower is better"}


class RecordForm(DismissedOnce[bool | Kind], ModalScreen[bool | Kind]):
    """A short form; the result is True if something was recorded, or the form that the participant
    is to fill in.

    Args:
        kinds: kinds to choose from; the first, which is no form, is chosen to begin with.
        codes: the participants; of several, one is named.
        at: the date to begin with; empty for today.
        session: the session that it belongs to; None if that follows from the date.
        known: the record to be corrected; None for a new one.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss(False)", "Cancel", id="cancel"),
        Binding("down", "app.focus_next", "Next", show=False, id="down"),
        Binding("up", "app.focus_previous", "Previous", show=False, id="up"),
    ]

    app: Any

    def __init__(
        self,
        kinds: Sequence[Kind],
        codes: Sequence[str],
        at: str = "",
        session: str | None = None,
        known: Record | None = None,
    ) -> None:
        super().__init__()
        self._of_kinds = kinds
        self._kind = kinds[0]
        self._codes = codes
        self._at = known.at if known else at or date.today().isoformat()
        self._session = session
        self._known = known

    @property
    def help_text(self) -> str:
        """Help on the fields."""
        return self.tr(
            "Fill in the fields from top to bottom; Up and Down go from one to the next. A value "
            "that cannot be is told at once. What is not known yet may be added later: choose the "
            "record on the screen of progress, and press Enter."
        )

    def compose(self) -> ComposeResult:
        tr = self.tr = language_of(self.app)
        self._kinds = {self._title(kind): kind for kind in self._of_kinds}
        with Vertical(id="record-form", classes="form"):
            yield Static(self._headline, classes="headline", markup=False)
            yield Static("", id="problem", markup=False)
            if len(self._kinds) > 1:
                choice = Choice(list(self._kinds), self._title(self._kind))
                choice.border_title = tr("Kind")
                yield choice
            if len(self._codes) > 1:
                yield _input(_WHO, tr("Participant"), self._codes[0])
            yield _input(_DATE, tr(self._kind.when), self._at)
            yield from self._fields()
            hint = tr("Enter goes on, and records after the last field. Esc: cancel.")
            yield Static(hint, classes="muted", markup=False)

    def _title(self, kind: Kind) -> str:
        """Return the name and the title of a kind, as the list has them."""
        return f"{kind.name}{_BETWEEN}{self.tr(kind.title)}"

    @property
    def _headline(self) -> str:
        tr, title = self.tr, self.tr(self._kind.title)
        if self._known:
            return tr("{kind}: what is known now", kind=title)
        if len(self._kinds) > 1:
            title = tr("Record")
        return tr("{kind} of {who}", kind=title, who=self._codes[0]) if self._is_alone else title

    @property
    def _is_alone(self) -> bool:
        return len(self._codes) == 1

    def _fields(self) -> list[Input]:
        known = self._known.content if self._known else {}
        return [
            _input(
                field.name,
                self._with_range(field),
                self._typed(field, known.get(field.name, "")),
                self.tr(field.hint),
            )
            for field in self._kind.fields
        ]

    def _typed(self, field: Field, value: Value) -> str:
        """Return a known value as a person would type it."""
        if isinstance(value, str):
            return self.tr(value) if field.type == "choice" else value
        return self.tr.figures(show(value))

    def _with_range(self, field: Field) -> str:
        """Return the title of a field with its range, and the direction of a score."""
        parts = [self.tr(field.title), field.range_in(self.tr)]
        titled = ", ".join(part for part in parts if part)
        better = self.tr(_BETTER[field.better])
        return f"{titled}; {better}" if better else titled

    def on_mount(self) -> None:
        """Focus the list of kinds, or the first field that is empty."""
        if len(self._kinds) > 1:
            self.query_one(Choice).focus()
            return
        fields = list(self.query(Input))
        empty = [field for field in fields if not field.value] or fields
        last = self._known is not None
        empty[-1 if last else 0].focus()

    @on(Choice.Changed)
    async def _chosen(self) -> None:
        """Show the fields of another kind; a form is handed over to the participant."""
        self._kind = self._kinds[self.query_one(Choice).value]
        if self._kind.form:
            self.dismiss(self._kind)
            return
        await self.query(Input).exclude(f"#{_WHO}").exclude(f"#{_DATE}").remove()
        form = self.query_one("#record-form")
        date_field = self.query_one(f"#{_DATE}", Input)
        date_field.border_title = self.tr(self._kind.when)
        await form.mount_all(self._fields(), after=date_field)
        self.query_one(f"#{self._kind.fields[0].name}").focus()

    @on(Input.Changed)
    def _check(self, event: Input.Changed) -> None:
        """Say at once what is wrong with a value, or what it would replace."""
        problem = self._replaced()
        if event.input.value and event.input.id not in (_WHO, _DATE):
            try:
                self._kind.field(str(event.input.id)).read(event.input.value, self.tr)
            except RecordError as error:
                problem = in_language(error, self.tr)
        self.query_one("#problem", Static).update(problem)

    def _replaced(self) -> str:
        """Return that a record of the same kind and day would be replaced; empty if there is
        none.
        """
        if not self._kind.once_a_day or self._known:
            return ""
        day = self.query_one(f"#{_DATE}", Input).value.strip()
        same = records.listing(
            self.app.database, kinds=(self._kind.name,), participant=self._codes[0]
        )
        if replaced := next((each for each in same if each.day == day), None):
            first = next(iter(replaced.content.values()), "")
            return self.tr("This replaces {value} of the same day.", value=show(first))
        return ""

    @on(Input.Submitted)
    def _entered(self, event: Input.Submitted) -> None:
        event.stop()
        if event.input.id != self._kind.fields[-1].name:
            self.focus_next()
            return
        given = {str(field.id): field.value for field in self.query(Input)}
        try:
            self._save(given.pop(_WHO, self._codes[0]), given.pop(_DATE), given)
        except StoreError as error:
            self.query_one("#problem", Static).update(in_language(error, self.tr))
            self.query_one("#record-form").scroll_home(animate=False)
        else:
            self.dismiss(True)

    def _save(self, who: str, at: str, given: dict[str, Any]) -> None:
        database, author = self.app.database, login_name()
        if self._known:
            records.correct(database, self._known.id, given, at=at, author=author, tr=self.tr)
            return
        code = participants.check_code(who)
        if code not in self._codes:
            raise StoreError(self.tr("{who} did not take part in this session.", who=code))
        records.add(
            database,
            self._kind,
            code,
            at,
            given,
            session=self._session,
            author=author,
            tr=self.tr,
        )


class RemoveRecord(DismissedOnce[bool], ModalScreen[bool]):
    """Asks whether a record was entered by mistake; the result is True to remove it."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("enter", "dismiss(True)", "Remove", id="remove"),
        Binding("escape", "dismiss(False)", "Keep", id="keep"),
    ]

    def __init__(self, record: Record) -> None:
        super().__init__()
        self._record = record

    def compose(self) -> ComposeResult:
        """Say what is removed, and that the database keeps it."""
        tr, record = language_of(self.app), self._record
        about = tr(
            "{kind} {value} of {date} then no longer counts. The database keeps it, with your "
            "login name and the time.",
            kind=record.kind,
            value=show(next(iter(record.content.values()), "")),
            date=record.at,
        )
        with Vertical(classes="dialog"):
            yield Static(tr("Entered by mistake?"), classes="headline", markup=False)
            yield Static(f"{about}\n", markup=False)
            hint = tr("Enter removes it, Esc keeps it.")
            yield Static(hint, classes="muted", markup=False)


def _input(name: str, title: str, value: str = "", hint: str = "") -> Input:
    made = Input(value, placeholder=hint, id=name, compact=True)
    made.border_title = title
    return made
