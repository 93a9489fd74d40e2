"""Strip of the panel with the proposal to decide on, or the text that the operator types."""

from collections.abc import Callable

from rich.cells import cell_len
from textual import events
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.content import Content, Span

from sar_tui.model.language import ENGLISH, Language
from sar_tui.model.messages import Action, PendingApproval, Proposal
from sar_tui.model.units import SECOND
from sar_tui.operator import status_view
from sar_tui.operator.commands import Commands, takes_valence
from sar_tui.operator.event_text import short_name
from sar_tui.operator.keymap import KEY_COMMANDS, KeymapFile, key_label, key_name
from sar_tui.operator.palette import CONTROLLED_KINDS, MODES
from sar_tui.operator.phrases import MAX_TEXT, addressee
from sar_tui.operator.session_state import SessionState
from sar_tui.operator.text_charts import Piece, bar, cut, two_lines
from sar_tui.operator.widgets import CachedStatic, TypedInput

_TONES = {"positive": "$success", "neutral": "$neutral", "negative": "$warning"}
_SIMPLE = ("approve", "veto", "edit")
_DECISION_KEYS = ("approve", "veto", "edit", "positive", "neutral", "negative")


class ProposalStrip(Vertical):
    """One proposal with its time and keys; the others; and, while something is typed, the text
    field.

    Args:
        file: the operator's keys.
        tr: language of the panel.

    Attributes:
        edited: the proposal whose text is typed, if one is edited.
    """

    def __init__(self, file: KeymapFile, tr: Language = ENGLISH) -> None:
        super().__init__()
        self.tr = tr
        self._file = file
        self._is_tall = False
        self._label = ""
        self._then: Callable[[str, int], bool] | None = None
        self.edited: PendingApproval | None = None
        self._time_given: dict[str, int] = {}
        self._titles = ("", "")

    def compose(self) -> ComposeResult:
        yield CachedStatic("proposal")
        yield CachedStatic("decision-keys")
        with Horizontal(id="entry"):
            yield CachedStatic("entry-label", fits_content=True)
            yield TypedInput(id="entry-text", compact=True, select_on_focus=False)
        yield CachedStatic("others")

    # --- typing

    @property
    def is_typing(self) -> bool:
        """True while the text field is open."""
        return self._then is not None

    @property
    def typed(self) -> str:
        """The text in the field."""
        return self._entry.value

    @property
    def overflows(self) -> bool:
        """True if the typed text is longer than the text field."""
        return self.is_typing and len(self.typed) >= self._entry.content_size.width

    def open_entry(
        self,
        label: str,
        text: str,
        then: Callable[[str, int], bool],
        max_length: int = MAX_TEXT,
        edited: PendingApproval | None = None,
    ) -> None:
        """Open the text field.

        Args:
            label: text in front of it.
            text: initial content.
            then: called with the text and the time stamp of Enter; returns True if the field can be
                closed.
            max_length: longest text, in characters.
            edited: the proposal that is edited.
        """
        self._then, self.edited, self._label = then, edited, label
        self.add_class("typing")
        entry = self._entry
        entry.max_length, entry.value = max_length, text
        entry.cursor_position = len(text)
        self.screen.set_focus(entry)  # now, because the next key may have been read already

    def close_entry(self) -> None:
        """Close the text field."""
        self._then, self.edited, self._label = None, None, ""
        self.remove_class("typing")
        self.screen.set_focus(None)

    def type(self, event: events.Key | events.Paste) -> bool:
        """Type a key or pasted text; return False if the key types nothing."""
        if isinstance(event, events.Paste):
            self._entry.put(next(iter(event.text.splitlines()), ""))
        elif event.is_printable and event.character:
            self._entry.put(event.character)
        else:
            return False
        return True

    def submit(self, at: int) -> None:
        """Hand on what was typed. ``at``: time stamp of Enter."""
        then, text = self._then, self.typed.strip()
        if then and text and then(text, at):
            self.close_entry()

    @property
    def _entry(self) -> TypedInput:
        return self.query_one(TypedInput)

    # --- drawing

    def draw(
        self, chosen: PendingApproval | None, commands: Commands, now: int, *, is_tall: bool
    ) -> bool:
        """Draw the proposal that keys apply to, or why there is none. Return False while a text is
        edited whose proposal no longer waits: it is not meant for the next.

        Args:
            chosen: the proposal that keys apply to.
            commands: the operator's.
            now: session clock (ns).
            is_tall: the window has a line for the other proposals.
        """
        loss = status_view.link_loss(commands.state)
        self.set_class(chosen is not None, "pending")
        self.set_class(bool(loss), "alarm")
        self._is_tall = is_tall
        edited = self.edited
        if edited and edited.proposal.id not in {each.proposal.id for each in commands.pending}:
            self._draw_expired_edit(edited, commands, now)
            return False
        if chosen is None:
            self._draw_empty(commands.state, loss, now)
        else:
            self._draw_proposal(chosen, commands, now)
        return True

    @property
    def _width(self) -> int:
        return self.query_one("#proposal").content_size.width

    def _draw_empty(self, state: SessionState, loss: str, now: int) -> None:
        """Draw why nothing waits. ``loss``: the notice while the link is down."""
        leave_key = key_label("close", self._file, self.tr)
        self._put("proposal", nothing_pending(state, loss, now, self._width, leave_key))
        self._put("decision-keys", Content(""))
        self._put("entry-label", Content(self._label))
        self._put("others", Content(""))
        heading = self.tr("Connection" if loss else "Proposals")
        self._frame(heading, self._subtitle(state))

    def _draw_proposal(self, approval: PendingApproval, commands: Commands, now: int) -> None:
        """Draw a proposal that waits."""
        state, pending, width, id = (
            commands.state,
            commands.pending,
            self._width,
            approval.proposal.id,
        )
        self._time_given = {
            each.proposal.id: self._time_given.get(each.proposal.id, each.deadline - now)
            for each in pending
            if each.deadline is not None
        }
        self._put("proposal", body(approval, now, self._time_given.get(id), width, self.tr))
        keys = decision_keys(self._file, self.tr, has_words=takes_valence(approval))
        keys = control_hint(state, self._file) if commands.refusal() else keys
        sent = commands.log.deciding(id)
        self._put("decision-keys", Content(f"{sent} …") if sent else keys)
        self._put("entry-label", Content(self._label))
        others = other_proposals(pending, approval, now, width, self.tr)
        self._put("others", Content(others))
        to = addressee(state, approval.proposal.seat) if approval.level is None else ""
        heading = title(approval, pending.index(approval) + 1, len(pending), to, self.tr)
        self._frame(heading, self._subtitle(state, "" if self._label else others))

    def _draw_expired_edit(self, edited: PendingApproval, commands: Commands, now: int) -> None:
        """Draw the proposal whose text is edited although it no longer waits."""
        tr, is_late = self.tr, edited.deadline is not None and edited.deadline <= now
        why = tr("time is up" if is_late else "no longer pending")
        label = tr("Time is up:" if is_late else "No longer pending:")
        others = other_proposals(commands.pending, None, now, self._width, tr)
        self._put("proposal", expired_edit(edited, self._width, tr))
        self._put("entry-label", Content(label, [Span(0, len(label), "$warning bold")]))
        self._put("others", Content(others))
        self._frame(
            f"{tr(edited.proposal.kind).upper()} · {why}", self._subtitle(commands.state, others)
        )

    def _subtitle(self, state: SessionState, others: str = "") -> str:
        """Return the other proposals if they have no line of their own, else how to send typed
        text, else the modes.
        """
        if others and not self._is_tall:
            return cut(others, self._width - 4)
        if self._label:
            return self.tr("Enter sends, Esc cancels")
        return mode_summary(state, self._width - 4)

    def _frame(self, title: str, subtitle: str) -> None:
        """Set the border's texts; as `Content`, because they may hold brackets."""
        if self._titles != (title, subtitle):
            self._titles = title, subtitle
            self.border_title, self.border_subtitle = Content(title), Content(subtitle)

    def _put(self, name: str, content: Content) -> None:
        self.query_one(f"#{name}", CachedStatic).show(content)


def title(
    approval: PendingApproval, number: int, count: int, to: str, tr: Language = ENGLISH
) -> str:
    """Return a proposal's title: kind, addressee, valence, mode, changes, and its number if there
    are several.
    """
    proposal = approval.proposal
    parts = [
        tr(proposal.kind).upper() + to,
        *(tr(word) for word in (proposal.valence, proposal.degree) if word),
        tr(approval.mode),
    ]
    parts += [proposal.evidence] if proposal.evidence else []
    parts += [tr("{number} of {total}", number=number, total=count)] if count > 1 else []
    return " · ".join(parts)


def proposal_text(proposal: Proposal | Action, level: int | None, tr: Language = ENGLISH) -> str:
    """Return a proposal as it would be said or done."""
    if level is not None:
        what = proposal.text or tr("Level {level}", level=level)
        return tr("{what}, from the next attempt on", what=what)
    if text := proposal.text or proposal.spoken:
        before, _, after = tr("“{text}”").partition("{text}")
        return f"{before}{text}{after}"  # as the participant reads it, with its decimal sign
    return f"[{(proposal.gesture or proposal.tone or proposal.face).replace('_', ' ')}]"


_THEN = {"act": "acts by itself in {seconds} s", "drop": "is dropped in {seconds} s"}


def time_left(approval: PendingApproval, now: int, tr: Language = ENGLISH) -> str:
    """Return the time left to decide, and what happens then."""
    if approval.deadline is None:
        return tr("waits for you until the next attempt begins")
    seconds = max(0, approval.deadline - now) / SECOND
    if seconds == 0:
        return tr("time is up")
    return tr(_THEN[approval.otherwise], seconds=f"{seconds:.1f}")


def body(
    approval: PendingApproval, now: int, given: int | None, width: int, tr: Language = ENGLISH
) -> Content:
    """Return the text and the remaining time.

    Args:
        approval: the proposal.
        now: session clock (ns).
        given: time to decide when it was first seen (ns).
        width: length of a line, in characters.
        tr: language of the panel.
    """
    words = two_lines(proposal_text(approval.proposal, approval.level, tr), width)
    time = time_left(approval, now, tr)
    style = f"{_TONES.get(approval.proposal.valence or '', '$foreground')} bold"
    parts: list[Piece] = [(words, style), ("\n", "")]
    if approval.deadline is None or not given:
        return Content.assemble(*parts, (time, "$accent bold"))
    longest = cell_len(tr(_THEN[approval.otherwise], seconds="100.0"))
    full, empty = bar((approval.deadline - now) / given, width - longest - 2)
    urgent = "$warning" if approval.deadline - now < SECOND else "$accent"
    return Content.assemble(
        *parts, (full, urgent), (empty, "$text-muted"), (f"  {time}", f"{urgent} bold")
    )


def decision_keys(file: KeymapFile, tr: Language, *, has_words: bool) -> Content:
    """Return the keys that decide."""
    parts: list[Piece] = []
    for command in KEY_COMMANDS:
        if command.id in _DECISION_KEYS and (has_words or command.id in _SIMPLE):
            style = "bold reverse" if command.id == "approve" else "bold"
            key = key_name(file.keys_of(command)[0], tr)
            parts += [
                (f" {key} ", f"$accent {style}"),
                (f" {tr(command.label)} " if command.id in _SIMPLE else "", ""),
            ]
    parts.append((f" {tr('other face, same words')}", "") if has_words else ("", ""))
    return Content.assemble(*parts)


def control_hint(state: SessionState, file: KeymapFile) -> Content:
    """Return the text shown instead of those keys to an operator without control, or an
    observer.
    """
    tr = state.tr
    if state.welcome and state.welcome.role == "observer":
        return Content.assemble((tr("You are an observer."), "$text-muted"))
    name, key = short_name(state.holder), key_label("control", file, tr)
    hint = tr("{name} decides; {key} takes control.", name=name, key=key)
    return Content.assemble((hint, "$text-muted"))


def expired_edit(approval: PendingApproval, width: int, tr: Language) -> Content:
    """Return a proposal that is edited but no longer pending, and what can be done with the
    text.
    """
    has_words = approval.level is None and approval.proposal.text
    what = tr("Enter twice says it anyway, Esc discards it." if has_words else "Esc discards it.")
    words = two_lines(proposal_text(approval.proposal, approval.level, tr), width)
    return Content.assemble(
        (words, "$text-muted"),
        ("\n", ""),
        (cut(f"{tr('Nothing was sent.')} {what}", width), "$warning bold"),
    )


def nothing_pending(
    state: SessionState, loss: str, now: int, width: int, leave_key: str
) -> Content:
    """Return why nothing is pending: no proposal, no link, or the end of the session."""
    tr = state.tr
    if state.ended:
        over = tr("The session is over. {key} leaves.", key=leave_key)
        report = tr("For the report: {command}", command="sar-tui report wizard last")
        return Content.assemble((over, "bold"), (f" {report}", "$text-muted"))
    if loss:
        return Content.assemble((two_lines(loss, width), "$warning bold"))
    if state.arbiter is None:
        return Content.assemble((tr("Proposals are not known yet."), "$text-muted"))
    if (action := state.scheduled) and action.due > now:
        decided = tr("Nothing is pending. The {kind} is decided:", kind=tr(action.kind))
        words = two_lines(f"{decided} {proposal_text(action, None, tr)}", width)
        due = tr("goes out in {seconds} s", seconds=f"{(action.due - now) / SECOND:.1f}")
        return Content.assemble((words, ""), (f"\n{due}", "$accent bold"))
    if all(mode == "autonomous" for mode in state.arbiter.modes.values()):
        text = tr("Nothing is pending: the agent decides everything by itself.")
    elif state.has_control:
        text = tr("Nothing is pending for you.")
    elif state.holder:
        text = tr("Nothing is pending for {name}.", name=short_name(state.holder))
    else:
        text = tr("Nothing is pending for an operator.")
    return Content.assemble((text, "$text-muted"))


def other_proposals(
    pending: tuple[PendingApproval, ...],
    chosen: PendingApproval | None,
    now: int,
    width: int,
    tr: Language,
) -> str:
    """Return the other proposals with their times, on one line."""
    others = [
        f"{_time(each, now)}{tr(each.proposal.kind)} {proposal_text(each.proposal, each.level, tr)}"
        for each in pending
        if each is not chosen
    ]
    return cut(f"{tr('Also pending:')} {' · '.join(others)}", width) if others else ""


def _time(approval: PendingApproval, now: int) -> str:
    return "" if approval.deadline is None else f"{max(0, approval.deadline - now) / SECOND:.0f} s "


def mode_summary(state: SessionState, width: int) -> str:
    """Return the kinds of action by mode, without those that the agent decides by itself."""
    tr = state.tr
    if state.arbiter is None:
        return tr("modes not known yet")
    of = state.arbiter.modes
    kinds = {
        mode: [tr(kind) for kind in CONTROLLED_KINDS if of.get(kind) == mode] for mode in MODES
    }
    listed = [f"{tr(mode)}: {', '.join(kinds[mode])}" for mode in MODES[1:] if kinds[mode]]
    others = tr("the rest: autonomous" if listed else "all: autonomous")
    rest = [others] if kinds["autonomous"] else []
    return cut(" · ".join((*listed, *rest)), width)
